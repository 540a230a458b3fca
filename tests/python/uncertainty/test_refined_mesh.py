"""Other meshes of the same body, and fields taken from one to another."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import plica
from conftest import THESIS_TISSUE
from plica import _engine
from plica.scene.mesh.changed import changed_mesh
from plica.scene.symmetry import mirrored_mean
from plica.tetrahedron import EDGES, shape_functions
from plica.uncertainty.meshes import coarser, finer, given
from plica.uncertainty.transfer import transferred
from plica.uncertainty.uniform import refined


def block(divisions: tuple[int, int, int], order: int = 1) -> Any:
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(3.0, 2.0, 1.0), divisions=divisions)
    return _engine.to_quadratic(mesh) if order == 2 else mesh


def volumes(mesh: Any) -> np.ndarray:
    x = np.asarray(mesh.points)[np.asarray(mesh.cells)[:, :4]]
    return np.linalg.det(x[:, 1:] - x[:, :1]) / 6


def face_area(mesh: Any, name: str) -> float:
    x = np.asarray(mesh.points)[np.asarray(_engine.flat_triangles(mesh.surfaces[name]))]
    return float(0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum())


@pytest.mark.parametrize("order", [1, 2])
def test_uniform_refinement_keeps_shape_labels_and_names(order: int) -> None:
    mesh = block((2, 2, 1), order)
    fine = refined(mesh)
    assert fine.order == order
    assert len(fine.cells) == 8 * len(mesh.cells)
    assert volumes(fine) == pytest.approx(np.repeat(volumes(mesh), 8) / 8)
    assert list(fine.layer_names) == list(mesh.layer_names)
    for name in mesh.surfaces:
        assert len(fine.surfaces[name]) == 4 * len(mesh.surfaces[name])
        assert face_area(fine, name) == pytest.approx(face_area(mesh, name))
    x = np.asarray(fine.points)
    assert set(fine.node_sets["x_min"]) == set(np.flatnonzero(x[:, 0] == 0))


def bent() -> Any:
    """Quadratic cells with curved sides."""
    flat = block((3, 2, 1), 2)
    x = np.array(flat.points)
    x[:, 2] += 0.1 * np.sin(x[:, 0]) * (1 + x[:, 1])
    return changed_mesh(flat, points=x)


def test_the_nodes_4_to_9_are_the_middles_of_the_edges() -> None:
    mesh = block((2, 1, 1), 2)
    nodes = np.asarray(mesh.points)[np.asarray(mesh.cells)]
    middles = np.stack([0.5 * (nodes[:, a] + nodes[:, b]) for a, b in EDGES], axis=1)
    assert nodes[:, 4:] == pytest.approx(middles, abs=1e-15)


def test_curved_sides_stay_where_they_are() -> None:
    mesh = bent()
    fine = refined(mesh)
    child = np.asarray(fine.points)[np.asarray(fine.cells)[:8]]  # of the parent's first cell
    parent = np.asarray(mesh.points)[np.asarray(mesh.cells)[0]]
    place = np.array([[0.55, 0.15, 0.2, 0.1]])  # in the child at the parent's first corner
    inside = 2 * place - [1, 0, 0, 0]
    assert shape_functions(inside) @ child[0] == pytest.approx(shape_functions(place) @ parent, abs=1e-14)


def test_cells_too_curved_for_eight_good_ones_are_refused() -> None:
    mesh = _engine.larynx_mesh(order=2, **_engine.larynx_preset("coarse"))
    with pytest.raises(plica.InvalidInput, match="It is inverted"):
        refined(mesh)


@pytest.mark.parametrize("order", [1, 2])
def test_a_field_that_elements_hold_exactly_is_taken_over_exactly(order: int) -> None:
    mesh, points = block((3, 2, 2), order), np.random.default_rng(1).uniform(0, 1, (40, 3)) * (3, 2, 1)

    def field(x: np.ndarray) -> np.ndarray:
        return x @ [[1, 2, 3], [0, 1, 0], [2, 0, 1.0]] + (x[:, :1] ** 2 if order == 2 else 0.0)

    (found,) = transferred(mesh, [field(np.asarray(mesh.points))], points)
    assert found == pytest.approx(field(points), abs=1e-12)


def larynx(**options: Any) -> plica.Scene:
    return plica.Scene(
        plica.Larynx(**options), THESIS_TISSUE, time=plica.Stepping(step="50 us", duration="1 ms")
    )


def test_a_larynx_is_refined_in_all_its_sizes_by_one_factor() -> None:
    scene = larynx(larynx="demo", order=2)
    fine, coarse = finer(scene), coarser(scene)
    assert fine is not None
    assert coarse is not None
    assert (fine.factor, coarse.factor) == (pytest.approx(1.4), pytest.approx(0.8))
    fields = fine.scene.resolved()["mesh"]["options"]
    assert fields["around"] == 28
    assert fields["size"] == pytest.approx(0.4e-3 / 1.4)
    assert fields["growth"] == pytest.approx(0.46 / 1.4)
    assert fine.scene.mesh.order == 2


def test_a_larynx_in_levels_is_doubled_and_where_it_cannot_be_halved_that_is_known() -> None:
    scene = larynx(larynx="thesis_coarse")
    fine = finer(scene)
    assert fine is not None
    assert fine.factor == 2
    assert len(fine.build().cells) == 8 * len(plica.build_mesh(scene.mesh).cells)
    assert coarser(scene) is None


def test_blocks_of_even_divisions_go_up_by_half_and_down_to_half(bar: plica.Scene) -> None:
    odd = finer(bar)  # 4 x 1 x 1
    assert odd is not None
    assert odd.factor == 2
    assert coarser(bar) is None
    even = bar.replace({"mesh.divisions": (4, 2, 2)})
    fine, coarse = finer(even), coarser(even)
    assert fine is not None
    assert coarse is not None
    assert tuple(fine.scene.mesh.divisions) == (6, 3, 3)
    assert tuple(coarse.scene.mesh.divisions) == (2, 1, 1)


def test_another_mesh_of_ones_own_must_be_another_and_all_else_the_same(bar: plica.Scene) -> None:
    fine = given(bar, bar.replace({"mesh.divisions": (8, 2, 2), "time.step": "50 us"}))
    assert fine.factor == pytest.approx(2)
    assert fine.scene.time == bar.time
    with pytest.raises(plica.InvalidInput, match="tissue differs from that of the run; must be the same"):
        given(bar, bar.replace({"mesh.divisions": (8, 2, 2), "tissue.body.nu": 0.2}))
    with pytest.raises(
        plica.InvalidInput, match=r"its edges are 1 times as long .* by a factor of 1\.1 or more"
    ):
        given(bar, bar)


def test_a_field_with_symmetry_has_it_on_another_mesh_too() -> None:
    """To the last bit of what an engine asks for, wherever the field was read."""
    coarse, fine = (
        plica.build_mesh(
            plica.Larynx(larynx="thesis_coarse", order=2, options=plica.LarynxOptions(**options))
        )
        for options in ({"around": 8}, {"around": 12})
    )
    x, points = np.asarray(coarse.points), np.asarray(fine.points)
    field = np.stack([np.sin(200 * x[:, 0]), np.cos(300 * x[:, 2]) * x[:, 1], np.cos(100 * x[:, 1])], axis=1)
    (found,) = transferred(coarse, [field], points)
    mean = mirrored_mean(found, points, 2)
    for axis, sign in enumerate(([-1, 1, 1], [1, -1, 1])):
        image = np.array([np.argmin(((points - p * sign) ** 2).sum(axis=1)) for p in points])
        np.testing.assert_allclose(mean[image] * sign, mean, atol=1e-15 * np.abs(mean).max())
        assert np.abs(mean[points[:, axis] == 0, axis]).max() == 0
    assert np.abs(mean - found).max() < 0.2 * np.abs(found).max()
