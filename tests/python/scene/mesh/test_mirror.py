"""One fold, or a quarter of a larynx, from a file and mirrored: the mesh of the whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

import plica
from conftest import TINY_LARYNX
from mesh_parts import mirrored_larynx, write_fold
from plica import _engine
from plica.uncertainty.uniform import refined

FIBRED = {"E": "3 kPa", "nu": 0.4, "E_fibre": "20 kPa", "nu_fibre": 0.4, "mu_fibre": "6 kPa"}
PLANE_ENDS = {"plane": {"point": [0, "6 mm", 0], "normal": [0, 1, 0]}}


def tiny_larynx(order: int = 1) -> plica.Larynx:
    return plica.Larynx(
        larynx="thesis_coarse", order=order, options=plica.LarynxOptions.model_validate(TINY_LARYNX)
    )


def rows(nodes: np.ndarray) -> set[tuple[int, ...]]:
    return {tuple(row) for row in np.sort(nodes, axis=1).tolist()}


@pytest.mark.parametrize(
    ("mirror", "signs"),
    [("fold", (1, 1)), ("fold", (-1, 1)), ("quarter", (1, 1)), ("quarter", (1, -1)), ("quarter", (-1, -1))],
)
@pytest.mark.parametrize(
    "larynx",
    [tiny_larynx(), tiny_larynx(2), plica.Larynx(larynx="coarse", order=2)],
    ids=("1", "2", "curved"),
)
def test_a_larynx_that_was_cut_is_the_larynx_again_to_the_bit(
    larynx: plica.Larynx, mirror: str, signs: tuple[int, int], tmp_path: Path
) -> None:
    made = plica.build_mesh(larynx)
    own = plica.build_mesh(mirrored_larynx(larynx, tmp_path / "part.vtu", mirror, signs))
    number = cKDTree(np.asarray(own.points)).query(np.asarray(made.points))[1]
    assert np.array_equal(np.sort(number), np.arange(len(own.points)))
    assert np.array_equal(np.asarray(own.points)[number], np.asarray(made.points))
    assert rows(number[made.cells]) == rows(np.asarray(own.cells))
    for name in ("airway", "airway_left", "airway_right"):
        assert rows(number[made.surfaces[name]]) == rows(np.asarray(own.surfaces[name]))
    assert set(number[made.node_sets["wall"]]) == set(own.node_sets["wall"])
    layers_of_sides = [
        np.bincount(3 * np.asarray(mesh.cell_layer) + np.asarray(mesh.cell_side)) for mesh in (made, own)
    ]
    assert np.array_equal(*layers_of_sides)
    for side, sign in ((1, -1), (2, 1)):
        cells = np.asarray(own.cells)[np.asarray(own.cell_side) == side, :4]
        assert (sign * np.asarray(own.points)[cells].mean(axis=1)[:, 0] > 0).all()


@pytest.mark.parametrize("order", [1, 2])
def test_a_mirrored_mesh_refines_to_its_own_mirror_image(order: int, tmp_path: Path) -> None:
    """The line about which a cell is divided into eight is that of its image."""
    mesh = refined(
        plica.build_mesh(mirrored_larynx(tiny_larynx(order), tmp_path / "part.vtu", "quarter", (-1, 1)))
    )
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    for mirror in (np.array([-1, 1, 1]), np.array([1, -1, 1])):
        distance, image = cKDTree(points).query(points * mirror)
        assert distance.max() < 1e-15  # m
        assert rows(image[cells]) == rows(cells)


def folds(fields: dict[str, Any], mirror: str = "fold", **changes: Any) -> plica.MeshFile:
    return plica.MeshFile(mirror=mirror, **fields | changes)


def shared_nodes(mesh: _engine.TetMesh) -> np.ndarray:
    """(k, 3) places, m, of the nodes that cells of both folds have."""
    side = np.asarray(mesh.cell_side)
    left, right = (np.asarray(mesh.cells)[side == k] for k in (1, 2))
    return np.asarray(mesh.points)[np.intersect1d(left, right)]


def test_folds_share_nodes_only_where_they_meet(tmp_path: Path) -> None:
    apart = plica.build_mesh(folds(write_fold(tmp_path / "apart.vtu")))
    assert len(shared_nodes(apart)) == 0
    meeting = write_fold(tmp_path / "v.vtu", gap=lambda y, z: 0.1 * (12 - y))
    found = shared_nodes(plica.build_mesh(folds(meeting)))
    assert np.allclose(found[:, :2], [0, 12e-3])  # the anterior commissure
    assert np.array_equal(np.sort(found[:, 2]), 1e-3 * np.arange(4, 9))


def test_sides_by_x_are_those_that_mirroring_makes(tmp_path: Path) -> None:
    fields = write_fold(tmp_path / "part.vtu")
    made, said = (plica.build_mesh(folds(fields | sides)) for sides in ({}, {"sides": "x"}))
    assert (np.unique(np.asarray(made.cell_side)) == [1, 2]).all()
    assert np.array_equal(made.cell_side, said.cell_side)
    assert np.array_equal(made.cells, said.cells)


def test_nodes_almost_in_a_plane_are_moved_into_it(tmp_path: Path) -> None:
    """A file of seven digits: the cut of a quarter is flat to a tenth of a micrometre."""
    exact = plica.build_mesh(folds(write_fold(tmp_path / "q.vtu", y=(0, 6)), "quarter", surfaces={}))
    rough = write_fold(tmp_path / "r.vtu", y=(3e-6, 6))
    made = plica.build_mesh(folds(rough, "quarter", surfaces={}))
    assert len(made.points) == len(exact.points)
    assert (np.asarray(made.points)[:, 1] == 0).sum() == (np.asarray(exact.points)[:, 1] == 0).sum() > 0


def scene_of(mesh: plica.MeshFile, **tissue: Any) -> plica.Scene:
    return plica.Scene(
        mesh,
        {"cover": plica.Tissue(**FIBRED | tissue), "body": plica.Tissue(E="10 kPa", nu=0.4)},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        supports=plica.Supports(fixed=["lateral"]),
    )


def quarter(tmp_path: Path) -> plica.MeshFile:
    fields = write_fold(tmp_path / "q.vtu", y=(0, 6), divisions=(2, 3, 4))
    return folds(fields, "quarter", surfaces={"airway": 11, "lateral": 12, "ends": PLANE_ENDS})


@pytest.mark.parametrize(
    ("tissue", "materials"),
    [
        ({"fibre": (0.4, 1, 0.2)}, 5),
        ({"fibre": (0.4, -1, 0)}, 5),
        ({"fibre": (0, 1, 0.2)}, 3),
        ({"fibre": (0, -3, 0)}, 2),
        ({}, 2),
        ({"fibre": (1, 2, 3), "left": {"fibre": (-1, 2, 3)}}, 5),
    ],
)
def test_fibres_are_mirrored_with_the_mesh(tissue: Any, materials: int, tmp_path: Path) -> None:
    """The stiffness of mirrored displacements is that of the displacements."""
    simulation = plica.build_simulation(scene := scene_of(quarter(tmp_path), **tissue))
    mesh = plica.build_mesh(scene.mesh)
    assert len(plica.runs.materials.materials_of(scene, mesh)[0]) == materials
    values, columns, starts = simulation.stiffness
    rows_ = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    u = np.random.default_rng(3).standard_normal(3 * len(mesh.points))
    force = np.bincount(rows_, values * u[columns], minlength=len(u)).reshape(-1, 3)
    points = np.asarray(mesh.points)
    for axis in range(2):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        image = cKDTree(points).query(points * mirror)[1]
        turned = (u.reshape(-1, 3) * mirror)[image].ravel()
        other = np.bincount(rows_, values * turned[columns], minlength=len(u)).reshape(-1, 3)
        assert np.abs(other - (force * mirror)[image]).max() < 1e-12 * np.abs(force).max()


def test_a_fibre_of_one_side_is_that_of_this_side(tmp_path: Path) -> None:
    scene = scene_of(quarter(tmp_path), fibre=(1, 2, 3), left={"fibre": (1, 2, 3)})
    materials, names, of_cell = plica.runs.materials.materials_of(scene, mesh := plica.build_mesh(scene.mesh))
    found = {name: tuple(m.elasticity.fibre) for m, name in zip(materials, names, strict=True) if "." in name}
    assert found["cover.left.front"] == found["cover.right.front"] == (1, 2, 3)
    assert found["cover.left.back"] == found["cover.right.back"] == (1, -2, 3)
    centre = np.asarray(mesh.points)[np.asarray(mesh.cells)].mean(axis=1)
    for name, (x, y) in {"left.front": (-1, 1), "right.back": (1, -1)}.items():
        own = centre[of_cell == names.index(f"cover.{name}")]
        assert (own[:, :2] * (x, y) > 0).all()
        assert len(own) > 0


def test_a_mirrored_mesh_says_how_many_nodes_its_folds_share(tmp_path: Path) -> None:
    from plica.scene.mesh.summary import mesh_summary

    assert "the folds share no node" in mesh_summary(plica.build_mesh(quarter(tmp_path)))
    joined = plica.build_mesh(mirrored_larynx(tiny_larynx(), tmp_path / "part.vtu", "fold"))
    assert f"the folds share {len(shared_nodes(joined))} nodes" in mesh_summary(joined)
