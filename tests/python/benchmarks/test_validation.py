"""M5 folds and modeFold's against closed forms of their shapes; the smallest cases of the studies."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import plica
from benchmarks.validation import m5, modefold_files, one_layer, onsets, static_flow
from benchmarks.validation.extrusion import extruded, extruded_edges

EXIT = 0.987  # mm, of both variants


def segment(radius: float, turn: float) -> float:
    """Area between an arc and its chord."""
    return 0.5 * radius**2 * (turn - np.sin(turn))


def polygon(points: np.ndarray) -> float:
    x, z = points.T
    return 0.5 * abs(np.dot(x, np.roll(z, 1)) - np.dot(z, np.roll(x, 1)))


@pytest.mark.parametrize("shape", [m5.M5.cast(), m5.M5.static()], ids=["cast", "static"])
def test_an_m5_section_has_the_area_the_angle_and_the_extent_of_its_drawing(shape: m5.M5) -> None:
    corners = shape.corners()
    area = polygon(corners) + segment(shape.entrance_radius, shape.direction - np.radians(40))
    area += segment(EXIT, np.pi - shape.direction)
    fine = shape.outline(0.01)
    assert polygon(fine) == pytest.approx(area, rel=1e-5)
    first = fine[1] - fine[0]
    assert np.degrees(np.arctan2(first[1], first[0])) == pytest.approx(40)
    np.testing.assert_allclose(fine[[0, -1]], [[0, 0], [0, 10.5]], atol=1e-9)
    assert fine[:, 0].max() == pytest.approx(8.4, abs=1e-4)
    turns = np.diff(np.arctan2(*np.diff(fine, axis=0).T[::-1]))
    assert (turns > -1e-9).all()  # convex
    bends = np.abs(turns) > 1e-6
    assert np.abs(turns).max() < 0.02  # no corner: arcs and lines are tangents
    assert bends.sum() > 100


def test_the_cast_section_is_that_of_two_circles_that_touch() -> None:
    """Their centres are the difference of their radii apart; the entrance arc begins on the inferior face."""
    shape = m5.M5.cast()
    exit_centre = np.array([8.4 - EXIT, 10.5 - EXIT])
    start = shape.corners()[1]
    entrance_centre = start + 6.0 * np.array([-np.sin(np.radians(40)), np.cos(np.radians(40))])
    assert np.linalg.norm(exit_centre - entrance_centre) == pytest.approx(6.0 - EXIT, abs=1e-9)
    assert start[1] / start[0] == pytest.approx(np.tan(np.radians(40)))


@pytest.mark.parametrize("angle", [-40, -10, 10, 40])
def test_a_static_glottis_narrows_or_widens_by_its_angle(angle: float) -> None:
    shape = m5.M5.static(3.0, np.radians(angle))
    corners = shape.corners()
    along = corners[3] - corners[2]
    assert np.linalg.norm(along) == pytest.approx(3.0)
    assert 2 * np.degrees(np.arctan2(-along[0], along[1])) == pytest.approx(angle)
    assert shape.outline(0.005)[:, 0].max() == pytest.approx(8.4, abs=1e-4)


@pytest.mark.parametrize("cover", [None, 2.0])
def test_the_mesh_of_a_quarter_has_the_volume_and_the_surfaces_of_its_section(
    cover: float | None, tmp_path: Path
) -> None:
    quarter = m5.Quarter(m5.M5.cast(), gap=0.4, edge=1.0, along=3, cover=cover)
    path = m5.write_quarter(quarter, tmp_path / "quarter.msh")
    outline = quarter.shape.outline(1.0)
    soft = plica.Tissue(E="10 kPa", nu=0.4)
    scene = m5.scene(path, soft, None if cover is None else soft, order=1)
    mesh = plica.build_mesh(scene.mesh)
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    volumes = np.linalg.det(edges) / 6
    assert (volumes > 0).all()
    assert volumes.sum() == pytest.approx(1e-9 * 2 * 17 * polygon(outline))
    assert points[points[:, 0] > 0, 0].min() == pytest.approx(0.2e-3)
    lengths = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    level = outline[:-1, 1] > 10.5 - 1e-9  # the flat top is no airway
    faces = points[np.asarray(mesh.surfaces["airway"])]
    doubled = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    assert 0.5 * np.linalg.norm(doubled, axis=1).sum() == pytest.approx(1e-6 * 34 * lengths[~level].sum())
    if cover is not None:
        nodes, triangles, covered, _ = m5.section_mesh(quarter.shape, 1.0, cover)
        parts = np.array([polygon(nodes[three]) for three in triangles])
        exact = cover * lengths.sum()  # of a strip: less at the convex corner, where it is the tighter one
        assert parts.sum() == pytest.approx(polygon(outline))
        assert 0.75 * exact < parts[covered].sum() < exact


def test_prisms_are_cut_so_that_neighbours_agree() -> None:
    nodes, triangles, _, airway = m5.section_mesh(m5.M5.static(), 1.5)
    points, cells = extruded(nodes, triangles, np.array([0.0, 1.0, 3.0]))
    faces = np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    unique, count = np.unique(faces, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    outside = points[unique[count == 1]]
    doubled = np.cross(outside[:, 1] - outside[:, 0], outside[:, 2] - outside[:, 0])
    around = np.linalg.norm(np.diff(nodes[[*range(airway), 0]], axis=0), axis=1).sum()
    area = 2 * polygon(nodes[:airway]) + 3.0 * around
    assert 0.5 * np.linalg.norm(doubled, axis=1).sum() == pytest.approx(area)
    edge = extruded_edges(np.array([[1, 0]]), len(nodes), 3)
    assert len(edge) == 4
    assert {tuple(sorted(face)) for face in edge} <= {tuple(face) for face in unique[count == 1]}


def modefold_folder(folder: Path) -> Path:
    """A clone's files, of a section of three triangles, 4 mm wide and 6 mm high, in three layers."""
    section = np.array([[0.0, 0.0], [4.0, 3.0], [3.0, 6.0], [0.0, 6.0], [0.0, 3.0]])
    triangles = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4]])
    levels = np.array([0.0, 3.0, 6.0, 9.0])
    points = np.concatenate([np.insert(section, 1, y, axis=1) for y in levels])
    order = np.random.default_rng(2).permutation(len(points))
    place = np.empty_like(order)
    place[order] = np.arange(len(points))
    wedges = np.concatenate([np.hstack((triangles + 5 * k, triangles + 5 * k + 5)) for k in range(3)])
    (folder / "input").mkdir()
    shape = np.where(points[:, 1:2] % 9 > 0, points, 0.0)
    meshio.Mesh(points[order], [("wedge", place[wedges])], point_data={"mode01": shape[order]}).write(
        folder / "input" / "no_mem_mode.vtu", binary=False
    )
    (folder / "input" / "surface.txt").write_text("4\n0 0\n4 3\n3 6\n0 6\n", encoding="utf-8")
    (folder / "input" / "no_mem_freq.txt").write_text("% Hz\n54.5 1 0 Inf\n79 2 0 Inf\n", encoding="utf-8")
    text = "# mass of vocal fold (Kg)\n1.7e-4\n# vocal tract length (cm) and area\n17.5 2.8 10\n"
    (folder / "input" / "param.txt").write_text(text, encoding="utf-8")
    return folder


def test_a_fold_of_modefold_is_read_whatever_the_order_of_its_nodes(tmp_path: Path) -> None:
    folder = modefold_folder(tmp_path)
    fold = modefold_files.read_fold(folder)
    assert fold.volume == pytest.approx(9.0 * (6.0 + 6.0 + 4.5))
    np.testing.assert_allclose(fold.section[fold.airway], [[0, 0], [4, 3], [3, 6], [0, 6]])
    np.testing.assert_allclose(modefold_files.read_frequencies(folder), [54.5, 79])
    assert modefold_files.read_parameters(folder)["vocal tract length"] == ["17.5", "2.8", "10"]
    lateral = fold.modes[0][1:3, :, 0]
    np.testing.assert_allclose(lateral, np.broadcast_to(fold.section[:, 0], lateral.shape))
    path = modefold_files.write_fold(fold, tmp_path / "fold.msh", 0.2)
    scene = m5.scene(path, plica.Tissue(E="7 kPa", nu=0.4), mirror="fold", order=1)
    mesh = plica.build_mesh(scene.mesh)
    points = np.asarray(mesh.points)
    edges = points[np.asarray(mesh.cells)[:, 1:]] - points[np.asarray(mesh.cells)[:, :1]]
    assert np.abs(np.linalg.det(edges)).sum() / 6 == pytest.approx(2e-9 * fold.volume)
    assert points[points[:, 0] > 0, 0].min() == pytest.approx(0.1e-3)
    faces = points[np.asarray(mesh.surfaces["airway_right"])]
    doubled = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    assert 0.5 * np.linalg.norm(doubled, axis=1).sum() == pytest.approx(9e-6 * (5 + np.sqrt(10)))
    assert modefold_files.voice(folder, {}) is None


def test_a_wide_rigid_glottis_lets_through_what_a_jet_without_friction_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(static_flow, "EDGE", 1.0)
    glottis = static_flow.rigid(3.2)
    assert glottis.areas.min() == pytest.approx(3.2e-3 * 12e-3)
    pressure = 15 * static_flow.WATER
    pressures, flow = glottis.at(pressure)
    jet = 1.2 * glottis.areas.min() * np.sqrt(2 * pressure / static_flow.AIR)
    assert flow == pytest.approx(jet, rel=0.01)
    assert flow < jet
    # Bernoulli's suction in the straight part, where the air is 1.2 times as fast as the jet
    assert pressures.min() == pytest.approx((1 - 1.44) * pressure, rel=0.02)
    assert static_flow.entrance_coefficient(3.2, 15) == pytest.approx(1, abs=0.01)
    assert static_flow.exit_coefficient(3.2, 15) == pytest.approx(1 - 1 / 1.44, abs=0.01)
    assert static_flow.van_den_berg(3.2, 15) == pytest.approx(jet / 1.2 / np.sqrt(0.875), rel=0.01)


def test_draws_are_within_what_is_said_of_the_silicone() -> None:
    cases = one_layer.draws("cast", 0.5, 12, seed=1)
    assert cases == one_layer.draws("cast", 0.5, 12, seed=1)
    assert {case.separation for case in cases} == {1.05, 1.2, 1.3}
    assert {case.zeta for case in cases} == {0.03, 0.06}
    strata = np.floor([12 * (case.E / 13.7e3 - 0.8) / 0.4 for case in cases]).astype(int)
    assert sorted(strata) == list(range(12))
    assert min(case.gap for case in cases) > 0.05
    assert max(case.gap for case in cases) < 1


def test_what_is_found_is_summed_up_with_what_is_not() -> None:
    found = [
        onsets.Found(1e3, 120.0, 3e3),
        onsets.Found(2e3, 100.0, 3e3),
        onsets.Found(None, None, 900.0, "end"),
    ]
    assert onsets.summed(found) == [3, "2 of 3", "1.50 (1.00 to 2.00)", "110 (100 to 120)", 1]
    assert [one.text for one in found] == ["1.00 kPa, 120 Hz", "2.00 kPa, 100 Hz", "none to 0.9 kPa (end)"]
    assert onsets.Found(30.0, 90.0, 3e3, at_most=True).text == "at most 0.03 kPa, 90 Hz"


@pytest.mark.slow
def test_a_tube_below_lets_one_layer_folds_phonate_which_do_not_without() -> None:
    coarse = onsets.Case(edge=2.0, along=2, sections=30, modes=10, reach=2000.0)
    without, with_tube = (
        onsets.find(onsets.Case(**{**coarse.__dict__, "trachea": length})) for length in (0.0, 0.5)
    )
    assert without.pressure is None
    assert with_tube.pressure is not None
    assert with_tube.frequency is not None
    assert with_tube.frequency < 350 / (4 * 0.5)
