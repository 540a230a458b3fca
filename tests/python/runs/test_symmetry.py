"""Half or a quarter of a symmetric scene beside all of it, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import csr_array

import plica
from plica import _engine
from plica.errors import InvalidInput, SceneError
from plica.measures.run.cautions import one_sided_errors
from plica.runs.build import build_simulation, fixed_components
from plica.scene.mesh.build import build_mesh

PLANES = {"half": (0,), "quarter": (0, 1)}
Floats = NDArray[np.float64]


@pytest.fixture
def voice(phonating: plica.Scene) -> plica.Scene:
    """A larynx of 672 nodes whose folds collide from step 4 on; gaps are held to 1e-9 of an edge."""
    larynx = plica.Larynx(larynx="coarse", options=plica.LarynxOptions(size="2 mm", growth=0.6, around=24))
    return phonating.replace({"mesh": larynx, "contact.tolerance": 1e-9, "solver.tolerance": 1e-13})


def folding(points: Floats, planes: tuple[int, ...]) -> tuple[csr_array, NDArray[np.int64]]:
    """S of u = S q by brute force, and the nodes of the part."""
    part = np.flatnonzero((points[:, planes] >= -1e-12).all(axis=1))
    image = points.copy()
    image[:, planes] = np.abs(image[:, planes])
    own = np.array([np.argmin(((points[part] - x) ** 2).sum(axis=1)) for x in image])
    sign = np.ones_like(points)
    sign[:, planes] = np.where(points[:, planes] < -1e-12, -1, 1)
    rows = np.arange(points.size)
    columns = (3 * own[:, None] + np.arange(3)).ravel()
    return csr_array((sign.ravel(), (rows, columns)), shape=(points.size, 3 * len(part))), part


def held_in_part(scene: plica.Scene, mesh: _engine.TetMesh, planes: tuple[int, ...]) -> NDArray[np.bool_]:
    points = np.asarray(mesh.points)
    _, part = folding(points, planes)
    held = np.array(fixed_components(scene, mesh))[part]
    held[:, planes] |= np.abs(points[part][:, planes]) < 1e-12
    return held.ravel()


def matrices(simulation: _engine.Simulation) -> list[csr_array]:
    found = []
    for given in (simulation.mass, simulation.stiffness, simulation.viscosity):
        assert given is not None
        found.append(csr_array(given, shape=(len(given[2]) - 1,) * 2))
    return found


def furthest(found: dict[str, Any], expected: dict[str, Any], name: str) -> float:
    return float(np.abs(found[name] - expected[name]).max() / np.abs(expected[name]).max())


@pytest.mark.parametrize("symmetry", PLANES)
@pytest.mark.parametrize("surface_mass", ["kept", "redistributed"])
@pytest.mark.parametrize("order", [1, 2])
def test_matrices_of_a_symmetric_scene_are_those_of_all_nodes(
    phonating: plica.Scene, symmetry: str, order: int, surface_mass: str
) -> None:
    """Tissue, fibres, mass: the part's matrices, unfolded, are those that are assembled without symmetry."""
    scene = phonating.replace({"mesh.order": order, "contact.surface_mass": surface_mass})
    mesh = build_mesh(scene.mesh)
    whole = matrices(build_simulation(scene, mesh))
    unfolded = matrices(build_simulation(scene.replace({"symmetry": symmetry}), mesh))
    for expected, found in zip(whole, unfolded, strict=True):
        assert found.shape == (3 * len(mesh.points),) * 2
        assert abs(found - expected).max() < 1e-12 * abs(expected).max()


@pytest.mark.parametrize("symmetry", PLANES)
def test_the_images_of_the_part_are_all_nodes(phonating: plica.Scene, symmetry: str) -> None:
    """By a matching of nodes of the test's own."""
    scene = phonating.replace({"symmetry": symmetry})
    simulation = build_simulation(scene)
    points = np.asarray(build_mesh(scene.mesh).points)
    images = simulation.images
    assert images is not None
    S, part = folding(points, PLANES[symmetry])
    assert np.array_equal(images[0], part)
    assert np.array_equal(np.unique(images), np.arange(len(points)))
    assert len(images) == 2 ** len(PLANES[symmetry])
    for copy, nodes in enumerate(images):
        sign = [-1.0 if axis in PLANES[symmetry] and copy >> axis & 1 else 1.0 for axis in range(3)]
        np.testing.assert_allclose(points[nodes], points[part] * sign, rtol=0, atol=1e-12)
    q = np.asarray(simulation.state()["displacement"])
    assert q.size == 3 * len(part)
    simulation.advance(1)
    q = np.asarray(simulation.state()["displacement"])
    assert np.any(q)
    np.testing.assert_array_equal(np.asarray(simulation.displacement).ravel(), S @ q)
    assert build_simulation(phonating).images is None


@pytest.mark.parametrize("symmetry", PLANES)
def test_what_a_plane_holds_beside_the_supports_has_mass_to_give(
    phonating: plica.Scene, symmetry: str
) -> None:
    """Nodes in x = 0, held in y and z by the scene and in x by the plane: in the whole they move."""
    mesh = build_mesh(phonating.mesh)
    points = np.asarray(mesh.points)
    surface = np.unique(mesh.surfaces["airway_left"])
    crossing = surface[np.abs(points[surface, 0]) < 1e-12]
    assert (~np.isin(crossing, mesh.node_sets["wall"])).any()
    held = remade(mesh, node_sets=mesh.node_sets | {"seam": crossing})
    scene = phonating.replace(
        {
            "contact.surface_mass": "redistributed",
            "supports": {"fixed": ["wall"], "components": {"seam": "yz"}},
        }
    )
    S, _ = folding(points, PLANES[symmetry])
    free = ~held_in_part(scene, held, PLANES[symmetry])
    M = matrices(build_simulation(scene, held))[0]
    m = matrices(build_simulation(scene.replace({"symmetry": symmetry}), held))[0]
    expected, found = ((S.T @ one @ S)[free][:, free] for one in (M, m))
    assert abs(found - expected).max() < 1e-12 * abs(expected).max()


@pytest.mark.parametrize("symmetry", PLANES)
def test_a_voice_through_contact_is_that_of_the_whole(voice: plica.Scene, symmetry: str) -> None:
    """To the tolerances of solver and contact, which the collisions make some hundred times larger."""
    mesh = build_mesh(voice.mesh)
    full, part = (build_simulation(voice.replace({"symmetry": s}), mesh) for s in (None, symmetry))
    expected, found = full.advance(40), part.advance(40)
    assert (expected["contact_rows"] > 0).sum() > 5
    np.testing.assert_array_equal(found["contact_rows"] > 0, expected["contact_rows"] > 0)
    for name in (
        "minimum_area",
        "flow",
        "kinetic_energy",
        "elastic_energy",
        "contact_area",
        "contact_length",
    ):
        assert furthest(found, expected, name) < 1e-8, name
    assert furthest(found, expected, "contact_force_first") < 1e-7
    u, v = np.asarray(full.displacement), np.asarray(part.displacement)
    assert np.abs(u - v).max() < 1e-8 * np.abs(u).max()
    energy = (found["kinetic_energy"] + found["elastic_energy"]).max()
    assert np.abs(found["energy_balance_error"]).max() < 1e-11 * energy


EXACT: dict[str, Any] = {
    "saddle": {"multipliers": {"solver": "saddle"}},
    "gmres": {"multipliers": {"solver": "gmres"}},
    "weighted": {"multipliers": {"position": "weighted"}},
    "augmented": {"augmented": {}},
    "massless": {"multipliers": {}, "surface_mass": "redistributed"},
}
ONE_SIDED: dict[str, Any] = {
    "penalty": {"penalty": {"stiffness": "50 N/m"}},
    "mortar": {"multipliers": {}, "faces": "mortar", "tolerance": 1e-8},
    "friction": {"multipliers": {}, "friction": 0.3, "tolerance": 1e-8},
}
WAVES = ("minimum_area", "elastic_energy", "contact_force_first")


def simulated(scene: plica.Scene, symmetry: str | None, steps: int = 20) -> tuple[dict[str, Any], Floats]:
    simulation = build_simulation(scene.replace({"symmetry": symmetry}))
    return simulation.advance(steps), np.array(simulation.displacement)


@pytest.mark.parametrize("contact", EXACT)
def test_contact_without_a_side_is_that_of_the_whole(voice: plica.Scene, contact: str) -> None:
    """A closed gap is the same from either side; to what the method's own iterations leave."""
    scene = voice.replace({"contact": EXACT[contact]})
    expected, _ = simulated(scene, None)
    found, _ = simulated(scene, "quarter")
    assert expected["contact_rows"].max() > 0
    for name in WAVES:
        assert furthest(found, expected, name) < 1e-5, name


@pytest.mark.parametrize("contact", ONE_SIDED)
def test_contact_that_has_a_side_loses_what_is_not_symmetric_in_it(voice: plica.Scene, contact: str) -> None:
    """Slaves of one fold make a whole larynx lean to one side; a half does not, and a quarter is the half."""
    scene = voice.replace({"contact": ONE_SIDED[contact]})
    whole, u = simulated(scene, None)
    half, of_half = simulated(scene, "half")
    quarter, _ = simulated(scene, "quarter")
    x = np.asarray(build_mesh(scene.mesh).points)
    image = np.array([np.argmin(((x - p) ** 2).sum(axis=1)) for p in x * (-1, 1, 1)])
    leaning = np.abs(u[image] * (-1, 1, 1) - u).max()
    np.testing.assert_array_equal(of_half[image] * (-1, 1, 1), of_half)
    assert 0 < np.abs(of_half - u).max() < leaning
    assert whole["contact_rows"].max() > 0
    for name in WAVES:
        assert furthest(quarter, half, name) < 1e-6, name  # gaps are closed to 1e-5 edges


@pytest.mark.parametrize("contact", one_sided_errors)
def test_a_quarter_is_off_by_as_much_as_its_caution_says(voice: plica.Scene, contact: str) -> None:
    scene = voice.replace({"contact": (ONE_SIDED | {"volume_penalty": {"volume_penalty": {}}})[contact]})
    whole, quarter = (simulated(scene, symmetry)[0] for symmetry in (None, "quarter"))
    impulses = [np.abs(found["contact_force_first"][:, 0]).sum() for found in (whole, quarter)]
    off = (furthest(quarter, whole, "flow"), abs(impulses[1] / impulses[0] - 1))
    for share, percent in zip(off, one_sided_errors[contact], strict=True):
        assert percent / 1.5 < 100 * share < 1.5 * percent


def test_frequencies_of_the_part_are_the_symmetric_ones_of_the_whole(phonating: plica.Scene) -> None:
    mesh = build_mesh(phonating.mesh)
    free = ~np.array(fixed_components(phonating, mesh)).ravel()
    M, K, _ = (A[free][:, free].toarray() for A in matrices(build_simulation(phonating, mesh)))
    squares, shapes = eigh(K, M, subset_by_index=(0, 39))
    S, _ = folding(np.asarray(mesh.points), (0, 1))
    full = np.zeros((len(free), 40))
    full[free] = shapes
    count = np.asarray(abs(S).sum(axis=0)).ravel()
    even = S @ ((S.T @ full) / count[:, None])
    symmetric = np.abs(even - full).max(axis=0) < 1e-6 * np.abs(full).max(axis=0)
    own = ~held_in_part(phonating, mesh, (0, 1))
    part = build_simulation(phonating.replace({"symmetry": "quarter"}), mesh)
    m, k, _ = ((S.T @ A @ S)[own][:, own].toarray() for A in matrices(part))
    assert symmetric.sum() > 4
    assert not symmetric.all()
    expected = squares[symmetric]
    np.testing.assert_allclose(eigh(k, m, eigvals_only=True)[: len(expected)], expected, rtol=1e-8)


def test_loads_and_weight_move_the_part_as_they_move_the_whole(phonating: plica.Scene) -> None:
    loads = [{"surface": "airway", "traction": (0, 0, "50 Pa"), "frequency": "100 Hz"}]
    changes = {"contact": None, "airflow": None, "gravity": (0, 0, -9.81), "loads": loads}
    scene = phonating.replace({"solver.tolerance": 1e-13, **changes})
    mesh = build_mesh(scene.mesh)
    full, part = build_simulation(scene, mesh), build_simulation(scene.replace({"symmetry": "quarter"}), mesh)
    pull = np.zeros_like(np.asarray(mesh.points))
    pull[:, 0] = 1e-3 * np.asarray(mesh.points)[:, 0]
    for simulation in (full, part):
        simulation.set_external_force(pull)
    expected, found = full.advance(20), part.advance(20)
    assert furthest(found, expected, "elastic_energy") < 1e-9
    for name in ("displacement", "velocity", "acceleration"):
        u = np.asarray(getattr(full, name))
        assert np.abs(np.asarray(getattr(part, name)) - u).max() < 1e-8 * np.abs(u).max(), name


@pytest.mark.parametrize("threads", [1, 2])
def test_a_restored_part_continues_bit_for_bit_with_any_number_of_threads(
    phonating: plica.Scene, threads: int
) -> None:
    scene = phonating.replace({"symmetry": "quarter"})
    waves = build_simulation(scene).advance(40)
    before = _engine.threads()
    _engine.set_threads(threads)
    try:
        first, second = build_simulation(scene), build_simulation(scene)
        first.advance(25)
        second.restore(first.state())
        rest = second.advance(15)
    finally:
        _engine.set_threads(before)
    for name, values in rest.items():
        np.testing.assert_array_equal(values, waves[name][25:], err_msg=name)


def test_a_symmetric_run_that_continues_is_that_of_one_piece(phonating: plica.Scene, tmp_path: Path) -> None:
    scene = phonating.replace({"symmetry": "quarter"})
    plica.run(scene.replace({"time.duration": "1 ms"}), tmp_path / "two", progress=False)
    two = plica.run(scene, tmp_path / "two", resume=True, progress=False)
    one = plica.run(scene, tmp_path / "one", progress=False)
    for name in ("flow", "minimum_area", "elastic_energy"):
        np.testing.assert_array_equal(two[name], one[name], err_msg=name)
    np.testing.assert_array_equal(two.displacement, one.displacement)


def test_a_run_of_a_quarter_stores_the_whole(voice: plica.Scene, tmp_path: Path) -> None:
    scene = voice.replace({"time.duration": "1 ms"})
    full = plica.run(scene, tmp_path / "full", progress=False)
    quarter = scene.replace({"symmetry": "quarter"})
    part = plica.run(quarter, tmp_path / "part", progress=False)
    assert part.scene == quarter
    np.testing.assert_allclose(part["minimum_area"], full["minimum_area"], rtol=1e-8)
    u, v = (np.array(run.fields["displacement"][-1]) for run in (full, part))
    np.testing.assert_allclose(v, u, atol=1e-6 * np.abs(u).max())


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "weight to one side": (
        {"gravity": (1.0, 0, 0)},
        r"the weight \(N\) at node .* mirrored in the plane x = 0",
    ),
    "a push to one side": (
        {"initial": {"velocity": {"body": (0.1, 0.0, 0.0)}}},
        r"the initial velocity \(m/s\) at node .* mirrored in the plane x = 0",
    ),
    "massless surfaces of free folds": (
        {"contact.surface_mass": "redistributed", "supports": plica.Supports(components={"wall": "z"})},
        r'= "redistributed" and a body, that of node \d+, that its supports let \w+ without strain',
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_not_symmetric_is_refused(phonating: plica.Scene, case: str) -> None:
    changes, message = REFUSED[case]
    with pytest.raises(SceneError, match=message):
        build_simulation(phonating.replace({"symmetry": "quarter", **changes}))


def test_tissue_that_differs_between_the_folds_is_refused(phonating: plica.Scene) -> None:
    scene = phonating.replace({"tissue.cover.left": {"E": "0.8 kPa"}, "symmetry": "half"})
    with pytest.raises(SceneError, match=r"tissue .* at \(-.* is not the mirror image of .* at \("):
        build_simulation(scene)


def remade(mesh: _engine.TetMesh, **changes: Any) -> _engine.TetMesh:
    names = ("points", "cells", "cell_layer", "cell_side", "layer_names", "surfaces", "node_sets")
    return _engine.TetMesh(**({name: getattr(mesh, name) for name in names} | changes))


def test_a_node_out_of_place_is_refused(phonating: plica.Scene) -> None:
    mesh = build_mesh(phonating.mesh)
    x = np.array(mesh.points)
    x[np.argmin(((x - (8e-3, 3e-3, 0)) ** 2).sum(axis=1)), 2] += 1e-6
    with pytest.raises(
        SceneError, match=r"symmetry: node .* has no node at its mirror image in the plane x = 0"
    ):
        build_simulation(phonating.replace({"symmetry": "half"}), remade(mesh, points=x))


def test_a_support_in_front_alone_is_refused(phonating: plica.Scene) -> None:
    mesh = build_mesh(phonating.mesh)
    x = np.asarray(mesh.points)
    front = np.flatnonzero((x[:, 1] > 4e-3) & (np.abs(x[:, 0]) < 3e-3)).astype(np.int32)
    held = remade(mesh, node_sets={**mesh.node_sets, "front": front})
    scene = phonating.replace({"supports.fixed": ("wall", "front")})
    build_simulation(scene.replace({"symmetry": "half"}), held)
    with pytest.raises(SceneError, match=r"symmetry: node .* held along x as its mirror image is"):
        build_simulation(scene.replace({"symmetry": "quarter"}), held)


def test_a_force_to_one_side_is_refused(phonating: plica.Scene) -> None:
    simulation = build_simulation(phonating.replace({"symmetry": "half"}))
    force = np.zeros_like(np.asarray(simulation.displacement))
    force[5] = (1e-3, 0, 0)
    with pytest.raises(InvalidInput, match=r"the external force \(N\) at node 5"):
        simulation.set_external_force(force)


def test_a_cell_across_the_plane_is_refused(tmp_path: Path) -> None:
    box = plica.Block(corner=("-1 mm", 0.0, 0.0), size=("2 mm", "1 mm", "1 mm"))
    scene = plica.Scene(
        plica.MeshFile(file=tmp_path / "box.vtu"),
        {"body": plica.Tissue(E="20 kPa", nu=0.3)},
        time=plica.Stepping(step="0.1 ms", duration="1 ms"),
        symmetry="half",
    )
    with pytest.raises(SceneError, match="lies on both sides of the plane x = 0"):
        build_simulation(scene, build_mesh(box))


@pytest.mark.parametrize("symmetry", PLANES)
@pytest.mark.parametrize("kind", ["block", "blocks"])
def test_boxes_are_refused_as_they_never_are_mirror_images(kind: str, symmetry: str) -> None:
    """Two boxes that are each other's image in x = 0, and one about it, in whatever divisions."""
    left, right = (
        {"corner": [x, -1.0, 0.0], "size": [2.0, 2.0, 2.0], "divisions": [2] * 3} for x in (-3.0, 1.0)
    )
    one = {"corner": [-2.0, -1.0, 0.0], "size": [4.0, 2.0, 2.0], "divisions": [4, 2, 2]}
    mesh = {"block": one} if kind == "block" else {"blocks": {"left": left, "right": right}}
    tissue = {name: plica.Tissue(E="20 kPa", nu=0.3) for name in mesh.get("blocks", {"body": one})}
    time = plica.Stepping(step="0.1 ms", duration="1 ms")
    message = rf'symmetry = "{symmetry}"; must be left out with mesh\.block or mesh\.blocks: .* All boxes'
    with pytest.raises(SceneError, match=message):
        plica.Scene(mesh, tissue, time=time, symmetry=symmetry)
    built = build_mesh(plica.Scene(mesh, tissue, time=time).mesh)
    corners = np.asarray(built.points)[np.asarray(built.cells)]
    own, images = (
        {frozenset(map(tuple, cell.round(9) + 0.0)) for cell in corners * side} for side in (1, (-1, 1, 1))
    )
    assert {corner for cell in own for corner in cell} == {corner for cell in images for corner in cell}
    assert own != images


def test_what_has_no_symmetric_part_is_refused_by_name(phonating: plica.Scene) -> None:
    with pytest.raises(SceneError, match=r"contact\.nitsche: must be another method with symmetry"):
        phonating.replace({"symmetry": "half", "contact": {"nitsche": {}}})
