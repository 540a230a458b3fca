"""Surfaces of a mesh file chosen by plane, box, direction and side; initial values of a layer or a fold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica
from plica.runs.build import fixed_components
from plica.scene.initial import initial_fields

_SIZE = np.array([4.0, 3.0, 2.0])  # mm


@pytest.fixture
def box(tmp_path: Path) -> Path:
    """A block of 4 x 3 x 2 mm about x = 0, two cells an edge of 2, 1 and 1 mm, without labelled triangles."""
    made = plica.build_mesh(plica.Block(size=tuple(_SIZE), divisions=(4, 3, 2)))
    points = np.asarray(made.points) - [2.0, 0.0, 0.0]
    path = tmp_path / "box.vtu"
    meshio.Mesh(
        points, [("tetra", np.asarray(made.cells))], cell_data={"label": [np.ones(len(made.cells), int)]}
    ).write(path)
    return path


def _surface(file: Path, wanted: Any, **fields: Any) -> tuple[np.ndarray, np.ndarray]:
    """Centres (f, 3) mm and areas (f) mm^2 of the faces selected."""
    scene = plica.MeshFile(file=file, unit="1 mm", layers={"body": 1}, surfaces={"chosen": wanted}, **fields)
    mesh = plica.build_mesh(scene)
    nodes = 1e3 * np.asarray(mesh.points)[np.asarray(mesh.surfaces["chosen"])[:, :3]]
    normals = np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0])
    return nodes.mean(axis=1), 0.5 * np.linalg.norm(normals, axis=1)


@pytest.mark.parametrize(
    ("wanted", "area", "holds"),
    [
        ({"plane": {"point": [0, 0, "2 mm"], "normal": [0, 0, -3]}}, 12.0, lambda c: c[:, 2] == 2),
        ({"facing": {"along": [0, 0, 1]}}, 12.0, lambda c: c[:, 2] == 2),
        (
            {"facing": {"along": [1, 1, 0], "within": "46 deg"}},
            6.0 + 8.0,
            lambda c: (c[:, 0] == 2) | (c[:, 1] == 3),
        ),
        ({"facing": {"along": [1, 1, 0]}}, 6.0 + 8.0, lambda c: (c[:, 0] == 2) | (c[:, 1] == 3)),
        ({"box": {"x": ["-2 mm", "0 mm"]}}, 2 * 6 + 2 * 4 + 6, lambda c: c[:, 0] <= 0),
        ({"side": "right"}, 2 * 6 + 2 * 4 + 6, lambda c: c[:, 0] >= 0),
        ({"box": {"z": ["2 mm", "2 mm"]}, "side": "left"}, 6.0, lambda c: (c[:, 0] < 0) & (c[:, 2] == 2)),
    ],
)
def test_faces_are_chosen_by_what_they_have_in_common(
    box: Path, wanted: Any, area: float, holds: Any
) -> None:
    centres, areas = _surface(box, wanted, sides="x")
    assert areas.sum() == pytest.approx(area, rel=1e-9)
    assert holds(np.round(centres, 9)).all()


def test_a_selection_has_the_mid_side_nodes_of_a_quadratic_mesh(box: Path) -> None:
    file = plica.MeshFile(
        file=box, unit="1 mm", layers={"body": 1}, order=2, surfaces={"top": {"facing": {"along": [0, 0, 1]}}}
    )
    mesh = plica.build_mesh(file)
    assert mesh.surfaces["top"].shape[1] == 6
    assert np.array_equal(mesh.node_sets["top"], np.flatnonzero(np.asarray(mesh.points)[:, 2] == 2e-3))


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({}, "must have one of plane, box, facing, side"),
        ({"box": {}}, "must have one of x, y, z"),
        ({"box": {"x": [1, 0]}}, "must have the smallest first"),
        ({"facing": {"along": [0, 0, 0]}}, "must not be zero"),
        ({"facing": {"along": [0, 0, 1], "within": "30 mm"}}, '"mm" has another dimension'),
        ({"normal": [0, 0, 1]}, "normal"),
        (
            {"plane": {"point": [0, 0, "2 m"], "normal": [0, 0, 1]}},
            "selects none of the 104 faces of the boundary",
        ),
        ({"side": "left"}, "needs mesh.sides"),
    ],
)
def test_a_selection_that_selects_nothing_is_refused(box: Path, wanted: Any, message: str) -> None:
    with pytest.raises(plica.SceneError, match="chosen") as caught:
        _surface(box, wanted)
    assert message in str(caught.value)


def _velocity(mesh: Any, **velocity: Any) -> np.ndarray:
    soft = plica.Tissue(E="10 kPa", nu=0.3)
    layers = ("body", "ligament", "cover") if isinstance(mesh, plica.Larynx) else ("body",)
    scene = plica.Scene(
        mesh,
        dict.fromkeys(layers, soft),
        time=plica.Stepping(step="50 us", duration="1 ms"),
        initial=plica.Initial(velocity=velocity),
        supports=plica.Supports(fixed=()),
    )
    return np.asarray(plica.build_simulation(scene).velocity).reshape(-1, 3)


def test_each_fold_may_have_a_velocity_of_its_own() -> None:
    larynx = plica.Larynx(larynx="thesis_coarse")
    mesh = plica.build_mesh(larynx)
    found = _velocity(larynx, left=(1, 0, 0), right=("-2 m/s", 0, 0))
    left, right = (np.unique(np.asarray(mesh.cells)[np.asarray(mesh.cell_side) == k]) for k in (1, 2))
    both = np.intersect1d(left, right)
    assert (found[np.setdiff1d(left, both)] == [1, 0, 0]).all()
    assert (found[np.setdiff1d(right, both)] == [-2, 0, 0]).all()
    assert (found[both] == 0).all()


def test_a_layer_may_have_a_velocity_of_its_own() -> None:
    larynx = plica.Larynx(larynx="thesis_coarse")
    mesh = plica.build_mesh(larynx)
    found = _velocity(larynx, cover=(0, 0, 3))
    cover = np.unique(np.asarray(mesh.cells)[np.asarray(mesh.cell_layer) == mesh.layer_names.index("cover")])
    moving = np.flatnonzero(found.any(axis=1))
    assert np.array_equal(moving, cover)


def test_equal_scenes_begin_equally_whatever_the_order_of_their_regions() -> None:
    given = {"left": (1.0, 0, 0), "right": (-1.0, 0, 0), "body": (0, 1.0, 0), "cover": (0, 0, 1.0)}
    found = []
    for names in (given, reversed(given)):
        scene = plica.Scene(
            plica.Larynx(larynx="thesis_coarse"),
            "thesis_corrected",
            time=plica.Stepping(step="50 us", duration="1 ms"),
            initial=plica.Initial(velocity={name: given[name] for name in names}),
            supports=plica.Supports(fixed=("ends",)),
        )
        mesh = plica.build_mesh(scene.mesh)
        velocity = initial_fields(scene, mesh, fixed_components(scene, mesh))[1]
        assert velocity is not None
        found.append((scene, velocity))
    assert found[0][0] == found[1][0]
    np.testing.assert_array_equal(found[0][1], found[1][1])
    cover = np.unique(np.asarray(mesh.cells)[np.asarray(mesh.cell_layer) == mesh.layer_names.index("cover")])
    free = ~fixed_components(scene, mesh)[cover].any(axis=1)
    assert (found[0][1][cover[free]] == given["cover"]).all()


def test_a_region_that_the_mesh_does_not_have_is_refused() -> None:
    with pytest.raises(plica.SceneError, match=r'not a layer or fold of the mesh; .* Did you mean "left"'):
        _velocity(plica.Larynx(larynx="thesis_coarse"), lefft=(1, 0, 0))
    with pytest.raises(plica.SceneError, match="must be one of body"):
        _velocity(plica.Block(size=(1, 1, 1)), left=(1, 0, 0))


def test_a_mesh_file_of_one_label_is_one_layer(box: Path) -> None:
    mesh = plica.build_mesh(plica.MeshFile(file=box))
    assert mesh.layer_names == ["body"]
    assert not np.any(mesh.cell_layer)


def test_a_mesh_file_of_several_labels_is_not_taken_for_one_layer(box: Path) -> None:
    made = meshio.read(box)
    made.cell_data["label"][0][:3] = 7
    made.write(box)
    with pytest.raises(plica.SceneError, match=r"mesh.layers is missing; must name .* labels \[1, 7\]"):
        plica.build_mesh(plica.MeshFile(file=box))


@pytest.mark.parametrize(
    "fields",
    [
        {"layers": {"body": 5}},
        {"surfaces": {"top": {"box": {"x": ["8 m", "9 m"]}}}},
        {"surfaces": {"airway": 3}, "sides": "x"},
    ],
)
def test_a_broken_mesh_is_reported_before_labels_that_it_lacks(box: Path, fields: dict[str, Any]) -> None:
    with pytest.raises(plica.SceneError, match=r"mesh\.(layers|surfaces)\."):
        plica.build_mesh(plica.MeshFile(file=box, **fields))
    made = meshio.read(box)
    made.points[7, 2] = np.nan
    made.write(box)
    with pytest.raises(plica.SceneError, match=r"node 7 is at .*; its coordinates must be finite"):
        plica.build_mesh(plica.MeshFile(file=box, **fields))


def test_labels_may_be_whole_real_numbers(box: Path) -> None:
    made = meshio.read(box)
    labels = np.asarray(made.cell_data["label"][0]).astype(float)
    labels[:3] = 2.0
    for name in ("label", "material"):
        made.cell_data = {name: [labels]}
        made.write(box)
        file = plica.MeshFile(file=box, labels=name, layers={"body": 1, "cover": 2})
        assert np.asarray(plica.build_mesh(file).cell_layer).sum() == 3
    labels[0] = 1.5
    made.write(box)
    with pytest.raises(plica.SceneError, match=r'mesh\.labels = "material"; must be'):
        plica.build_mesh(file)


def test_a_unit_alone_is_one_of_it(box: Path) -> None:
    one, alone = (plica.MeshFile(file=box, unit=unit, layers={"body": 1}) for unit in ("1 mm", "mm"))
    assert one.unit == alone.unit == 1e-3
    with pytest.raises(plica.InvalidInput, match='"furlongs per day" has another dimension'):
        plica.MeshFile(file=box, unit="furlongs per day", layers={"body": 1})
