"""The picture of a larynx before it moves shows the sizes that it has."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import plica
from plica.report import glottis
from plica.report.glottis import draw_glottis, narrowest, plane_cut
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.changed import changed_mesh

FOLDS = plica.Folds(length="12 mm", gap="0.6 mm", cover="0.8 mm", edge_radius="0.6 mm")


def area(polygon: np.ndarray) -> float:
    x, z = polygon.T
    return 0.5 * abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1)))


def test_layers_of_the_middle_plane_fill_what_the_airway_leaves() -> None:
    mesh = build_mesh(plica.Larynx(larynx="coarse", folds=FOLDS))
    corners = np.asarray(mesh.points)[np.asarray(mesh.cells)[:, :4]]
    z, minor = np.array(FOLDS.shape()["sections"]).T
    tissue = 2 * np.trapezoid(FOLDS.shape()["radius"] - minor, z)
    assert sum(map(area, plane_cut(corners, 0.0))) == pytest.approx(tissue, rel=1e-9)
    cover = corners[np.asarray(mesh.cell_layer) == list(mesh.layer_names).index("cover")]
    edges = z[[FOLDS.shape()["layers_from_section"], FOLDS.shape()["layers_to_section"]]]
    assert sum(map(area, plane_cut(cover, 0.0))) == pytest.approx(2 * 0.8e-3 * np.ptp(edges), rel=1e-9)


def test_the_glottis_from_above_is_the_narrowest_ellipse() -> None:
    larynx = plica.Larynx(larynx="fine", folds=FOLDS)
    mesh = build_mesh(larynx)
    y, left, right = narrowest(np.asarray(mesh.points), np.asarray(mesh.surfaces["airway"]))
    np.testing.assert_allclose(left, -right, atol=1e-12)
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, larynx.all_options()["around"] // 2 + 1)
    chords = np.interp(y, 6e-3 * np.sin(angle), 0.3e-3 * np.cos(angle))
    np.testing.assert_allclose(right, chords, atol=1e-9)


@pytest.mark.parametrize(("suffix", "begins"), [(".svg", b"<?xml"), (".PNG", b"\x89PNG"), (".pdf", b"%PDF")])
def test_it_is_a_file_of_the_suffix(tmp_path: Path, suffix: str, begins: bytes) -> None:
    mesh = build_mesh(plica.Larynx(larynx="coarse", order=2))
    draw_glottis(mesh, tmp_path / f"glottis{suffix}")
    drawn = (tmp_path / f"glottis{suffix}").read_bytes()
    assert drawn.startswith(begins)
    if suffix == ".svg":
        draw_glottis(mesh, tmp_path / "again.svg")
        assert (tmp_path / "again.svg").read_bytes() == drawn
        assert all(name in drawn.decode() for name in ("cover", "ligament", "left", "front"))


def test_sides_are_those_of_the_mesh(tmp_path: Path) -> None:
    mesh = build_mesh(plica.Larynx(larynx="coarse", folds=FOLDS))
    turned = changed_mesh(mesh, cell_side=3 - np.asarray(mesh.cell_side))  # seen from below, or x to the left
    for one, across in ((mesh, r"left +x \(mm\) +right"), (turned, r"right +x \(mm\) +left")):
        draw_glottis(one, tmp_path / "glottis.svg")
        assert re.search(across, (tmp_path / "glottis.svg").read_text())


def test_the_tissue_from_above_is_as_wide_as_the_mesh() -> None:
    """Of a mesh that is neither round nor about x = 0, too."""
    larynx = build_mesh(plica.Larynx(larynx="coarse", folds=FOLDS))
    mesh = changed_mesh(larynx, points=np.asarray(larynx.points) * (1, 2, 1) + (5e-3, 0, 0))
    figure = Figure()
    axes = figure.subplots()
    glottis._paint_above(axes, mesh, 1e3 * np.asarray(mesh.points), np.asarray(mesh.surfaces["airway"]))
    low, high = axes.patches[0].get_extents().transformed(axes.transData.inverted()).get_points()
    seen = 1e3 * np.asarray(mesh.points)[:, :2]
    np.testing.assert_allclose([low, high], [seen.min(axis=0), seen.max(axis=0)], rtol=1e-6)


def test_what_has_no_glottis_and_other_files_are_refused(tmp_path: Path) -> None:
    larynx = build_mesh(plica.Larynx(larynx="coarse"))
    with pytest.raises(plica.InvalidInput, match=r"glottis\.gif: must be a picture, \.svg, \.png, \.pdf"):
        draw_glottis(larynx, tmp_path / "glottis.gif")
    block = build_mesh(plica.Block(size=(1e-3, 1e-3, 1e-3)))
    with pytest.raises(plica.InvalidInput, match='has no surface "airway"'):
        draw_glottis(block, tmp_path / "glottis.svg")
    assert not list(tmp_path.iterdir())
