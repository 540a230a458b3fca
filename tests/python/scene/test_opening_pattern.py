"""The opening pattern, of parametric larynges and measured on meshes from files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica
from plica.measures.contour import medial_surface, rest_contour
from plica.runs.build import fixed_components
from plica.scene.initial import initial_fields
from plica.scene.opening import Glottis, opening_pattern

MM = 1e3  # the files' unit


def built(larynx: str, order: int = 1, **options: Any) -> tuple[plica.Larynx, Any]:
    part = plica.Larynx(larynx=larynx, order=order, options=plica.LarynxOptions(**options))
    return part, plica.build_mesh(part)


def file_of(
    mesh: Any, path: Path, place: Callable[[Any], Any] = lambda points: points, **fields: Any
) -> plica.MeshFile:
    """The mesh written in mm, with its layers, its airway and its wall, as a mesh of the user's own."""
    outer = np.asarray(plica._engine.boundary(mesh.cells)[0])
    wall = outer[np.isin(outer, mesh.node_sets["wall"]).all(axis=1)]
    airway = np.asarray(mesh.surfaces["airway"])
    kind, face = ("tetra", "triangle") if mesh.order == 1 else ("tetra10", "triangle6")
    made = meshio.Mesh(
        MM * place(np.asarray(mesh.points)),
        [(kind, np.asarray(mesh.cells)), (face, airway), (face, wall)],
        cell_data={
            "label": [1 + np.asarray(mesh.cell_layer), np.full(len(airway), 11), np.full(len(wall), 12)]
        },
    )
    made.write(path)
    return plica.MeshFile(
        file=path,
        unit="mm",
        order=mesh.order,
        layers={name: 1 + k for k, name in enumerate(mesh.layer_names)},
        sides="x",
        **{"surfaces": {"airway": 11, "wall": 12}} | fields,
    )


def opened(mesh: Any, **initial: Any) -> plica.Scene:
    return plica.Scene(
        mesh,
        "thesis_corrected",
        time=plica.Stepping(step="50 us", duration="1 ms"),
        initial=plica.Initial(**initial),
        supports=plica.Supports(fixed=("wall",)),
    )


def velocity(scene: plica.Scene) -> np.ndarray:
    mesh = plica.build_mesh(scene.mesh)
    found = initial_fields(scene, mesh, fixed_components(scene, mesh))[1]
    assert found is not None
    return found


@pytest.mark.parametrize("larynx", ["coarse", "thesis_coarse", "demo"])
@pytest.mark.parametrize("order", [1, 2])
def test_a_larynx_from_a_file_begins_as_the_preset_that_it_was(
    larynx: str, order: int, tmp_path: Path
) -> None:
    part, mesh = built(larynx, order)
    own = velocity(opened(file_of(mesh, tmp_path / "own.vtu"), opening_velocity="0.1 m/s"))
    preset = velocity(opened(part, opening_velocity="0.1 m/s"))
    assert np.abs(preset).max() == pytest.approx(0.1, rel=1e-9)
    # mm and back, and the pattern's square roots: some units in the last place, more where the wall is near
    np.testing.assert_allclose(own, preset, rtol=0, atol=1e-14)


@pytest.mark.parametrize("larynx", ["coarse", "thesis_coarse"])
def test_the_edge_of_the_pattern_is_the_superior_edge_of_the_medial_surface(larynx: str) -> None:
    part, mesh = built(larynx)
    height, smaller, larger = rest_contour(np.asarray(mesh.points), np.asarray(mesh.surfaces["airway"])).T
    edge = medial_surface(larger - smaller, height).stop - 1
    assert height[edge] == -4e-4  # S26
    at = np.array([[larger[edge], 0.0, height[edge]], [smaller[edge], 0.0, height[edge]]])
    for glottis in (Glottis.of_larynx(part), Glottis.of_mesh(mesh, "airway")):
        np.testing.assert_allclose(opening_pattern(at, glottis), [[1, 0, 0], [-1, 0, 0]], atol=1e-14)


@pytest.mark.parametrize(
    ("move", "turn"),
    [
        ((0.4e-3, 0.0, 0.0), (1, 1, 1)),
        ((0.0, -0.3, 0.2), (1, 1, 1)),
        ((0.0, 0.0, 0.0), (-1, -1, 1)),
    ],
)
def test_the_pattern_moves_and_turns_with_the_mesh(
    move: tuple[float, ...], turn: tuple[int, ...], tmp_path: Path
) -> None:
    part, mesh = built("coarse")
    placed = file_of(mesh, tmp_path / "own.vtu", lambda points: points * turn + move)
    here = velocity(opened(placed, opening_velocity=1.0))
    there = velocity(opened(part, opening_velocity=1.0))
    # 0.3 m has a round-off of 6e-17 m, 1e-12 of the narrow glottis
    np.testing.assert_allclose(here, there * turn, rtol=0, atol=1e-10)


@pytest.mark.parametrize("glottal_angle", [-15, 15])
def test_a_convergent_or_divergent_glottis_opens_at_its_superior_edge(
    glottal_angle: float, tmp_path: Path
) -> None:
    half = 1.0 + np.tan(np.radians(glottal_angle)) * np.array([0.0, 2.7])
    sections = [
        ("-20 mm", "6 mm"),
        ("-3.1 mm", f"{half[0]} mm"),
        ("-0.4 mm", f"{half[1]} mm"),
        ("8 mm", "7 mm"),
    ]
    part, mesh = built(
        "thesis_coarse", sections=sections, levels=(8, 3, 8), layers_from_section=0, layers_to_section=3
    )
    pattern = opening_pattern(np.asarray(mesh.points), Glottis.of_larynx(part))
    assert np.asarray(mesh.points)[np.abs(pattern[:, 0]).argmax(), 2] == pytest.approx(-0.4e-3)
    own = velocity(opened(file_of(mesh, tmp_path / "own.vtu"), opening_velocity=1.0))
    np.testing.assert_allclose(own, velocity(opened(part, opening_velocity=1.0)), rtol=0, atol=1e-12)


def test_the_pattern_ends_where_the_contour_ends() -> None:
    tube = np.array([[-1e-2, 1e-3], [1e-2, 1e-3]])  # nowhere wider: the superior edge is its upper end
    glottis = Glottis(0.0, 0.0, tube, 7e-3, (8e-3, 8e-3), 8e-3)
    points = np.array([[1e-3, 0.0, z] for z in (-1e-2, 0.0, 1e-2, 1.1e-2)])
    np.testing.assert_allclose(opening_pattern(points, glottis)[:, 0], [0, 0.5, 1, 0], atol=1e-15)


def refused(scene: plica.Scene) -> str:
    with pytest.raises(plica.SceneError) as caught:
        plica.build_simulation(scene)
    return str(caught.value)


def test_a_mesh_without_a_glottis_is_refused(tmp_path: Path) -> None:
    mesh, path = built("coarse")[1], tmp_path / "own.vtu"
    unnamed = file_of(mesh, path, surfaces={"lumen": 11, "wall": 12})
    message = refused(opened(unnamed, opening_displacement="0.1 mm"))
    assert "initial.opening_displacement needs the glottis" in message
    assert 'a surface "airway"' in message
    facing = {"facing": {"along": [-1, 0, 0], "within": "80 deg"}, "side": "right"}
    hemilarynx = file_of(mesh, path, surfaces={"airway": facing, "wall": 12})
    message = refused(opened(hemilarynx, opening_velocity=1.0))
    assert "the left fold is missing; must have both folds, which face each other along x" in message
    turned = file_of(mesh, tmp_path / "turned.vtu", lambda points: points[:, [2, 0, 1]])  # x is upward
    assert "Are x lateral" in refused(opened(turned, opening_velocity=1.0))


def test_a_mesh_whose_folds_are_edges_has_no_medial_surface(tmp_path: Path) -> None:
    sections = [("-10 mm", "6 mm"), ("0 mm", "0.3 mm"), ("10 mm", "6 mm")]
    mesh = built(
        "thesis_coarse", sections=sections, levels=(8, 8), layers_from_section=0, layers_to_section=2
    )[1]
    message = refused(opened(file_of(mesh, tmp_path / "own.vtu"), opening_velocity=1.0))
    assert "initial.opening_velocity needs a medial surface" in message
    assert "25 degrees of vertical" in message


def test_folds_that_touch_have_no_pattern(tmp_path: Path) -> None:
    size = ("5 mm", "10 mm", "3 mm")
    both = plica.Blocks(
        blocks={
            "left": plica.Block(size=size, corner=("-5 mm", 0, 0)),
            "right": plica.Block(size=size),
        }
    )
    mesh = plica.build_mesh(both)
    faces = np.concatenate([mesh.surfaces["left.x_max"], mesh.surfaces["right.x_min"]])
    made = meshio.Mesh(
        np.asarray(mesh.points),
        [("tetra", np.asarray(mesh.cells)), ("triangle", faces)],
        cell_data={"label": [np.full(len(mesh.cells), 1), np.full(len(faces), 2)]},
    )
    made.write(tmp_path / "own.vtu")
    file = plica.MeshFile(file=tmp_path / "own.vtu", layers={"body": 1}, surfaces={"airway": 2})
    scene = plica.Scene(
        file,
        {"body": plica.Tissue(E="10 kPa", nu=0.3)},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        initial=plica.Initial(opening_velocity=1.0),
    )
    message = refused(scene)
    assert "needs an open glottis" in message
    assert "0 m apart at z = 0 m" in message


def test_each_fold_moves_as_far_as_its_own_wall() -> None:
    a, wall = 0.5e-3, (4e-3, 9e-3)
    contour = np.array([[-2e-3, 4 * a], [-1e-3, a], [0.0, a], [1e-3, 4 * a]])
    glottis = Glottis(1e-3, 2e-3, contour, 8e-3, wall, 8e-3)
    for sign, far in ((-1, wall[0]), (1, wall[1])):
        out = np.array([a, 0.25 * a + 0.75 * far, far])
        x = np.column_stack((glottis.x + sign * out, np.full(3, glottis.y), np.zeros(3)))
        assert opening_pattern(x, glottis)[:, 0] == pytest.approx([sign, 0.25 * sign, 0.0])
