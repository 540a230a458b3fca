"""The engine's kernels of a film, each beside a second algorithm."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import ConvexHull

from plica import _engine
from plica.errors import InvalidInput


@pytest.mark.parametrize("degree", [1, 3])
def test_a_periodic_spline_is_that_of_scipy(degree: int) -> None:
    random = np.random.default_rng(1)
    tile, places = random.standard_normal((7, 7, 7)), random.uniform(-20, 20, (200, 3))
    places[:3] = [[0, 0, 0], [6.5, -0.5, 7], [-7, 14, 3]]
    expected = ndimage.map_coordinates(tile, places.T, order=degree, prefilter=False, mode="grid-wrap")
    found = _engine.periodic_spline(tile, places, degree)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)  # of values of order 1


def test_values_are_interpolated_by_their_weights() -> None:
    random = np.random.default_rng(2)
    weights, values = random.standard_normal((50, 6)), random.standard_normal((9, 3))
    rows = random.integers(0, 9, (50, 6))
    expected = np.einsum("pn,pnc->pc", weights, values[rows])
    np.testing.assert_allclose(_engine.interpolated(weights, rows, values), expected, atol=1e-13)


def test_normals_of_a_corner_are_summed_over_its_triangles() -> None:
    corners = np.random.default_rng(3).standard_normal((4, 3))
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    own = [np.cross(corners[b] - corners[a], corners[c] - corners[a]) for a, b, c in triangles]
    expected = [own[0] + own[1], own[0], own[0] + own[1], own[1]]
    np.testing.assert_allclose(_engine.corner_normals(corners, triangles), expected, atol=1e-14)


def test_a_hull_holds_what_its_triangulation_holds() -> None:
    from scipy.spatial import Delaunay

    random = np.random.default_rng(4)
    points, places = random.standard_normal((30, 2)), random.uniform(-3, 3, (500, 2))
    found = _engine.within_hull(ConvexHull(points).equations, places)
    assert found.any()
    np.testing.assert_array_equal(found, Delaunay(points).find_simplex(places) >= 0)


def test_heights_are_those_of_the_highest_triangle_that_faces_the_camera() -> None:
    corners = np.array([[1, 1, 2], [1, 9, 2], [9, 1, 2], [1, 1, 5], [1, 9, 5], [9, 1, 5]], dtype=float)
    up, down = [0, 1, 2], [3, 5, 4]  # rows count downwards
    places = np.array([[3.0, 3.0], [8.5, 8.5], [-1.0, 3.0]])
    low = _engine.heights_above(places, corners, np.array([up, down]), 10, 10)
    np.testing.assert_array_equal(low, [2, -np.inf, -np.inf])
    both = _engine.heights_above(places, corners, np.array([up, [3, 4, 5]]), 10, 10)
    np.testing.assert_allclose(both, [5, -np.inf, -np.inf])


def test_a_tile_that_is_no_cube_is_refused() -> None:
    with pytest.raises(InvalidInput, match="tile"):
        _engine.periodic_spline(np.zeros((4, 4, 3)), np.zeros((3, 3)), 3)
