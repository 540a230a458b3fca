"""Contact between meshes of one's own that do not match."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import plica

_MESHING = "meshing" in plica.build_info()["modules"]

SCENE = """
[mesh]
file = "own.msh"
unit = "1 mm"
layers = { flying = 1, held = 2 }
surfaces = { front = 11, facing = 12, wall = 13 }
[tissue.flying]
E = "20 kPa"
nu = 0.3
[tissue.held]
E = "20 kPa"
nu = 0.3
[supports]
fixed = ["wall"]
[contact]
multipliers = {}
first = "front"
second = "facing"
airway = "triangulated"
[initial.velocity]
flying = [1, 0.5, 0]
[time]
step = "50 us"
duration = "2.5 ms"
[output]
checkpoint_every = "1 ms"
"""


@pytest.fixture
def scene(tmp_path: Path) -> plica.Scene:
    """A block of 3 x 4 x 4 hexahedra that flies at one of 2 x 5 x 5, in a mesh file."""
    sizes = {"flying": ((-6.0, 1.0, 1.0), (3, 4, 4)), "held": ((0.2, 0.0, 0.0), (2, 5, 5))}
    flying, held = (
        plica.Block(corner=corner, size=(6.0, 6.0, 6.0) if name == "flying" else (6.0, 8.0, 8.0), divisions=n)
        for name, (corner, n) in sizes.items()
    )
    both = plica.build_mesh(plica.Blocks(blocks={"flying": flying, "held": held}))
    layer = np.asarray(both.cell_layer) + 1
    named = [np.asarray(both.surfaces[name]) for name in ("flying.x_max", "held.x_min", "held.x_max")]
    labels = [layer, *(np.full(len(faces), 11 + k) for k, faces in enumerate(named))]
    mesh = meshio.Mesh(
        np.asarray(both.points),
        [("tetra", np.asarray(both.cells)), *(("triangle", faces) for faces in named)],
        cell_data={"gmsh:physical": labels, "gmsh:geometrical": labels},
    )
    mesh.write(tmp_path / "own.msh", file_format="gmsh22")
    (tmp_path / "scene.toml").write_text(SCENE)
    return plica.Scene.load(tmp_path / "scene.toml")


def test_meshes_that_do_not_match_are_reported_for_the_triangulated_airway(scene: plica.Scene) -> None:
    text = scene.text().replace('airway = "triangulated"', 'airway = "matched"')
    with pytest.raises(plica.SceneError, match=r'must have one partner .* airway = "triangulated"\.$'):
        plica.build_simulation(plica.Scene.from_text(text))


@pytest.mark.skipif(_MESHING, reason="this build has the module")
def test_a_build_without_the_triangulations_says_so_in_one_sentence(scene: plica.Scene) -> None:
    assert "meshing" in plica.build_info()["absent"]
    with pytest.raises(
        plica.SceneError, match=r"no module meshing.* the GPL\. .*: PLICA_GPL=ON pip install \.$"
    ):
        plica.build_simulation(scene)


@pytest.mark.skipif(not _MESHING, reason="this build has no CGAL triangulations: PLICA_GPL=ON")
def test_a_mesh_file_whose_surfaces_do_not_match_collides(scene: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(scene, tmp_path / "run", progress=False)
    data = run.waveforms
    assert np.max(data["contact_rows"]) > 10
    first, second = (np.asarray(data[f"contact_force_{side}"]) for side in ("first", "second"))
    assert np.abs(first + second).max() <= 1e-12 * np.abs(first).max()
    assert np.all(first[:, 0] <= 0)  # the flying block is pushed back
    assert np.min(data["deepest_gap"]) > -2e-8  # of edges of 1.5 mm


@pytest.mark.skipif(not _MESHING, reason="this build has no CGAL triangulations: PLICA_GPL=ON")
def test_a_simulation_continues_from_a_state_as_it_did(scene: plica.Scene) -> None:
    whole, resumed = plica.build_simulation(scene), plica.build_simulation(scene)
    whole.advance(15)
    resumed.restore(whole.state())
    whole.advance(20)
    resumed.advance(20)
    assert np.array_equal(whole.displacement, resumed.displacement)
    assert np.any(whole.contact_force)
