"""Where lines of sight meet curved faces, and that film and identification see the same points there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import plica
from filmed_folds import FilmedFolds
from plica import _engine
from plica.camera.visible_faces import lattice, meet, shapes
from plica.identify import Observation, SurfacePoints
from plica.scene.mesh.changed import changed_mesh

CAMERA = plica.Camera(
    mm_per_px=0.05, width=96, height=136, centre=(2e-3, 3e-3, 3e-3), tilt=8.0, lean=-5.0, roll=10.0
)
Floats = NDArray[np.float64]


def curved_block() -> _engine.TetMesh:
    """Quadratic; its nodes moved so that sides bulge by up to a tenth of their length."""
    block = _engine.to_quadratic(_engine.block_mesh(size=(4e-3, 6e-3, 3e-3), divisions=(2, 3, 1)))
    x = np.array(block.points)
    x[:, 2] += 0.15e-3 * np.sin(1300 * x[:, 0] + 900 * x[:, 1])
    x[:, 0] += 0.10e-3 * np.sin(1500 * x[:, 1])
    return changed_mesh(block, points=x)


def test_a_point_moves_as_the_film_s_true_flow_says() -> None:
    """To what the flow is stored with, in single precision."""
    mesh = curved_block()
    x = np.asarray(mesh.points)
    u = 0.2e-3 * np.stack([np.sin(700 * x[:, 1]), np.cos(900 * x[:, 0]), np.sin(800 * x[:, 0])], axis=1)
    run = FilmedFolds(mesh, {"time": np.array([0, 1e-3]), "displacement": np.array([0 * u, u])})
    flow, _ = plica.film(run, CAMERA).flow(0)
    column, row = np.meshgrid(np.arange(24, 70, 3), np.arange(20, 116, 3))
    pixels = np.column_stack([column.ravel(), row.ravel()])
    points, there = SurfacePoints.met(mesh, "z_max", CAMERA, pixels)
    assert there.sum() > 400
    unknowns, rows = Observation(points, CAMERA, np.ones((2, there.sum(), 2))).displacements()
    moved = (rows @ u.ravel()[unknowns]).reshape(-1, 2)
    filmed = flow[pixels[there, 1], pixels[there, 0]]
    assert np.hypot(*filmed.T).max() > 4
    assert np.abs(moved - filmed).max() < 1e-6
    corners = replace_by_planes(mesh, pixels[there])  # what the faces' flat corners would say
    rows = Observation(corners, CAMERA, np.ones((2, there.sum(), 2))).displacements()[1]
    assert np.abs((rows @ u.ravel()[unknowns]).reshape(-1, 2) - filmed).max() > 1e-2


def replace_by_planes(mesh: _engine.TetMesh, pixels: NDArray[np.int64]) -> SurfacePoints:
    """Points where the planes through the faces' corners are met, with quadratic weights."""
    faces = np.asarray(mesh.surfaces["z_max"])
    found = meet(CAMERA.project(np.asarray(mesh.points)), faces[:, :3], pixels.astype(float))
    assert (found.face >= 0).all()
    return SurfacePoints(faces[found.face].astype(np.int32), shapes(6, found.place))


def test_points_on_curved_faces_are_seen_at_their_pixels() -> None:
    mesh = curved_block()
    random = np.random.default_rng(1)
    pixels = random.uniform([24, 22], [70, 114], (200, 2))
    points, there = SurfacePoints.met(mesh, "z_max", CAMERA, pixels)
    assert there.all()
    place = np.einsum("rk,rkc->rc", points.weights, np.asarray(mesh.points)[points.nodes])
    assert np.abs(CAMERA.project(place)[:, :2] - pixels).max() < 1e-8


def test_a_folded_face_is_met_where_it_looks_at_the_camera() -> None:
    """Its row is 50 - 80 s (1 - s): folded at s = 1/2, beyond which its back is nearer and not seen."""
    r, s = lattice(2).T  # row by row: corners and middles
    nodes = np.column_stack([100 * r + 10, 50 - 80 * s * (1 - s), 1e-3 * s])
    face = np.array([[0, 2, 5, 1, 4, 3]])  # 1, 2, 3, then 12, 23, 31
    column, row = (a.ravel() for a in np.meshgrid(np.linspace(15.0, 95.0, 9), np.linspace(26.5, 49.5, 12)))
    found = meet(nodes, face, np.column_stack([column, row]))
    along = 0.5 - 0.5 * np.sqrt(np.maximum(1 - 4 * (50 - row) / 80, 0))
    there = (row > 30) & ((column - 10) / 100 + along <= 1)
    assert 0 < there.sum() < len(there)
    assert (found.face >= 0).tolist() == there.tolist()
    assert found.place[there, 0] == pytest.approx((column[there] - 10) / 100, abs=1e-9)
    assert found.place[there, 1] == pytest.approx(along[there], abs=1e-9)


def test_of_faces_one_behind_the_other_the_nearest_is_met() -> None:
    r, s = lattice(2).T
    nodes = np.column_stack([100 * r, 100 - 100 * s - 10 * r * s, 1e-3 * r])
    above = np.array([0, 0, 1e-3])
    behind, before = nodes - above, nodes + above
    face = np.array([0, 2, 5, 1, 4, 3])
    everything = np.concatenate([behind, before, nodes])
    pixels = np.array([[20.0, 60.0], [50.0, 80.0]])
    assert meet(everything, np.array([face, face + 6, face + 12]), pixels).face.tolist() == [1, 1]


def test_what_no_line_of_sight_meets_is_reported() -> None:
    mesh = curved_block()
    pixels = np.array([[48.0, 68.0], [-40.0, 68.0], [np.nan, 3.0]])
    assert SurfacePoints.met(mesh, "z_max", CAMERA, pixels)[1].tolist() == [True, False, False]
    with pytest.raises(plica.InvalidInput, match=r"pixels\[1\] = \[-40, 68\] px; must show the surface"):
        SurfacePoints.seen(mesh, "z_max", CAMERA, pixels)
    below = replace(CAMERA, tilt=0.0, lean=0.0, roll=0.0)
    with pytest.raises(plica.InvalidInput, match='must show the surface "z_min"'):  # its back is turned
        SurfacePoints.seen(mesh, "z_min", below, pixels[:1])
