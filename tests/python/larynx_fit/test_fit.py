"""A larynx fitted to a picture, against the larynx that the picture shows."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Any

import numpy as np
import pytest

import plica
from pictured_folds import MM_PER_PX, coverage, pictured
from plica import InvalidInput, larynx_fit
from plica.scene.mesh.summary import mesh_summary

CAMERAS = [
    {"roll": 7.0},
    {"half_width": 0.8e-3, "roll": -3.0},
    {"half_width": 0.25e-3},
    {"tilt": 5.0},
    {"tilt": 8.0, "lean": 3.0, "roll": 4.0},
    {"lean": 6.0},
]


@cache
def _fit(folds: Any, *, frame: bool = False, **changed: Any) -> larynx_fit.LarynxFit:
    settings = folds.section.settings
    given = {"mm_per_px": MM_PER_PX, "tilt": settings.tilt, "lean": settings.lean, "larynx": "demo"} | changed
    return larynx_fit.fit_larynx(folds.frame if frame else None, folds.mask, **given)


def _section(mask: Any, settings: larynx_fit.FitSettings) -> larynx_fit.CrossSection:
    return larynx_fit.fit_cross_section(larynx_fit.glottal_contour(None, mask), settings, mask.shape)


def _thin_end(section: larynx_fit.CrossSection) -> float:
    """Length at each end over which what a leaning camera sees is less than a pixel wide, px.

    Two ellipses apart by 2 d meet at y / r = sqrt(1 - (d / w)^2), where the width falls by
    2 w (y / r) / (d / w) over r.
    """
    off = 2e-3 * np.sin(np.radians(section.settings.lean)) / section.half_width
    along = np.sqrt(1 - off**2)
    return float(off * section.r_in / (2 * section.half_width * along))


@pytest.mark.parametrize("camera", CAMERAS, ids=str)
def test_the_larynx_of_a_mask_is_the_one_filmed(camera: dict[str, float]) -> None:
    folds = pictured(**camera)
    made, truth = _section(folds.mask, folds.section.settings), folds.section
    pixel = 1e-3 * MM_PER_PX
    # Each of some 400 points of a mask's outline is off by 0.3 px (rms), so a half-width, their mean, by less
    # than 0.1 px; the ends, which few points tell of, by half a pixel.
    assert abs(made.half_width - truth.half_width) < 0.1 * pixel
    ends = max(0.5, _thin_end(truth))
    assert abs(made.r_in - truth.r_in) < ends * pixel
    column, row = np.abs(made.place(np.zeros((1, 2))) - truth.place(np.zeros((1, 2))))[0]
    assert column < 0.2
    assert row < ends
    assert made.camera.roll == pytest.approx(truth.camera.roll, abs=0.1)


@pytest.mark.parametrize("camera", CAMERAS[:4], ids=str)
def test_the_larynx_of_a_frame_is_wider_by_a_third_of_a_pixel_at_most(camera: dict[str, float]) -> None:
    folds = pictured(**camera)
    made, truth = _fit(folds, frame=True), folds.section
    pixel = 1e-3 * MM_PER_PX
    # The rim of the opening faces the lamp less than the tissue around it, so that half the brightness lies
    # outside of it.
    assert -0.05 * pixel < made.section.half_width - truth.half_width < pixel / 3
    assert abs(made.section.r_in - truth.r_in) < 0.5 * pixel
    assert made.error.mean < 0.3
    assert made.error.percentile_95 < 0.6


def test_a_larynx_displaced_is_found_where_it_is() -> None:
    folds = pictured()
    first, second = (_section(np.asarray(folds.clip.glottis(k)), folds.section.settings) for k in (0, 1))
    apart = second.commissures[0] - first.commissures[0]
    np.testing.assert_allclose(apart, [1.5, 0.0], atol=0.3)
    assert second.half_width == pytest.approx(first.half_width, abs=0.1e-3 * MM_PER_PX)


@pytest.mark.parametrize("camera", [{}, {"tilt": 8.0, "lean": 3.0, "roll": 4.0}], ids=str)
def test_the_opening_is_what_all_sections_have_in_common(camera: dict[str, float]) -> None:
    section = pictured(**camera).section
    rays = larynx_fit.Rays.of(64)
    edge = section.outline(rays, section.reach(rays))
    centre = section.centre
    heights, minors = np.array(section.sections).T
    z = np.linspace(heights[0], heights[-1], 4001)
    minor = np.interp(z, heights, minors)

    def seen(pixels: Any) -> Any:
        """Whether the line of sight at each place (n, 2) px stays in the airway at every height."""
        full = np.linalg.inv(section.camera.projection[:, :3])
        base = section.inside(pixels)
        slope = full[:2, 2] / full[2, 2]  # m of x and y per m of height along the line of sight
        point = base[:, None] + slope * (z - heights[3])[:, None]
        return ((point[..., 0] / minor) ** 2 + (point[..., 1] / section.r_in) ** 2 <= 1).all(axis=1)

    assert seen(centre + 0.995 * (edge - centre)).all()
    assert not seen(centre + 1.005 * (edge - centre)).any()


def test_the_edge_of_the_mesh_encloses_the_area_that_the_film_sees() -> None:
    for camera in ({}, {"tilt": 8.0, "lean": 3.0, "roll": 4.0}):
        folds = pictured(**camera)
        section = folds.section
        mesh = plica.build_mesh(larynx_fit.larynx_of(section))
        z = section.settings.heights
        edge = larynx_fit.glottal_edge(larynx_fit.MeshSeen(mesh, section.camera, z[3], z[4]), section)
        x, y = edge.T
        area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) * (1e-3 * MM_PER_PX) ** 2
        assert area == pytest.approx(folds.clip.area(0), rel=0.01)  # the film counts pixels
        analytic = section.outline(rays := larynx_fit.Rays.of(720), section.reach(rays))
        # Quadratic sides of 20 lines around, as flat pieces a twelfth of them long at the most.
        assert np.abs(edge - analytic).max() < 0.15


def test_pixels_show_the_places_that_project_onto_them() -> None:
    made = _fit(pictured(roll=7.0))
    places = made.seen.places
    shown = np.isfinite(places[..., 0])
    assert not (shown & made.contour.mask)[1:-1].sum() > 0.05 * made.contour.mask.sum()
    row, column = np.nonzero(shown)
    back = made.camera.project(places[shown])[:, :2]
    np.testing.assert_allclose(back, np.stack([column, row], axis=1), atol=1e-6)


def test_superior_nodes_lie_where_their_pixels_say() -> None:
    made = _fit(pictured())
    seen = made.seen
    points = np.asarray(made.mesh.points)[seen.superior]
    assert len(points) > 100
    assert points[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    assert points[:, 2].max() == pytest.approx(2e-3, abs=1e-12)
    assert seen.visible.mean() > 0.9
    own = pictured().section
    truth = own.camera.project(np.asarray(plica.build_mesh(larynx_fit.larynx_of(own)).points, dtype=float))[
        :, :2
    ]
    apart = np.linalg.norm(seen.pixels[:, None] - truth, axis=2).min(axis=1)
    assert np.percentile(apart, 95) < 0.5
    inner = seen.visible & (np.abs(points[:, 1]) < 0.6 * own.r_in)
    places = seen.places[tuple(np.round(seen.pixels[inner]).astype(int).T[::-1])]
    near = np.abs(places - points[inner]) / (1e-3 * MM_PER_PX)
    shown = np.isfinite(near[:, 0])  # some at the edge have their pixel's centre in the glottis
    assert shown.sum() > 30
    assert near[shown, :2].max() < 0.501
    # The surface rises by 2 mm over 0.8 r_in - half_width = 4.6 mm at least: 0.43 of what it is off, 0.71 px.
    assert near[shown, 2].max() < 0.35


def test_a_hidden_end_is_added_to_the_visible_length() -> None:
    folds = pictured()
    section, l_occ = folds.section, 1.2e-3
    last = section.place(np.array([[0.0, l_occ - section.r_in]]))[0, 1]
    mask = folds.mask & (np.arange(256)[:, None] < last)
    made = larynx_fit.fit_larynx(None, mask, mm_per_px=MM_PER_PX, l_occ=l_occ).section
    assert made.r_in == pytest.approx(section.r_in, abs=0.5e-3 * MM_PER_PX)
    assert made.half_width == pytest.approx(section.half_width, abs=0.2e-3 * MM_PER_PX)
    assert made.commissures[1, 1] == pytest.approx(last, abs=1.0)
    assert made.commissures[2, 1] - made.commissures[1, 1] == pytest.approx(1.2 / MM_PER_PX)


def test_a_length_that_is_given_gives_the_pixels_size() -> None:
    folds = pictured()
    made = larynx_fit.fit_larynx(None, folds.mask, r_in=folds.section.r_in)
    assert made.camera.mm_per_px == pytest.approx(MM_PER_PX, rel=0.005)
    assert made.section.r_in == folds.section.r_in


def test_the_lower_end_may_be_the_anterior_one() -> None:
    made = _fit(pictured(), anterior="lower")
    assert abs(made.camera.roll) == pytest.approx(180, abs=0.1)
    assert made.section.commissures[0, 1] > made.section.commissures[1, 1]
    seen = made.camera.project(np.array([[1e-3, 0, 0], [0, 0, 0]]))
    assert seen[0, 0] < seen[1, 0]  # the right fold is on the left of the picture


def test_given_commissures_are_kept() -> None:
    folds = pictured(tilt=5.0, roll=7.0)
    ends = folds.section.commissures
    made = _fit(folds, commissures=(tuple(ends[0]), tuple(ends[1])))
    np.testing.assert_allclose(made.section.commissures[:2], ends[:2], atol=1e-9)
    assert made.camera.roll == pytest.approx(7.0, abs=1e-9)
    assert made.section.half_width == pytest.approx(folds.section.half_width, abs=0.1e-3 * MM_PER_PX)


def test_a_fold_that_stands_at_the_midline_is_refused() -> None:
    inside = coverage((200, 120), (60.0, 100.0), (30.0, 80.0)) > 0.5
    inside[:, :59] = False
    with pytest.raises(InvalidInput, match=r"contour error .* must be <= 8.00 px, .*asymmetry \+0.8"):
        larynx_fit.fit_larynx(None, inside, mm_per_px=0.05, commissures=((60, 20), (60, 180)))
    allowed = larynx_fit.fit_larynx(
        None, inside, mm_per_px=0.05, commissures=((60, 20), (60, 180)), largest_error=0.5
    )
    assert allowed.error.percentile_95 > 8.0
    columns = inside.sum(axis=0)
    left, right = columns[59] + 0.5 * columns[60], columns[61:].sum() + 0.5 * columns[60]
    assert allowed.asymmetry == pytest.approx((right - left) / (right + left), abs=0.005)


def test_a_glottis_that_is_no_ellipse_is_warned_of() -> None:
    """A triangle: the ellipse has its length, and is off its sides by more than half of the half-width."""
    row, column = np.mgrid[:240, :120]
    triangle = np.abs(column - 60) < 8 * (row - 40) / 160
    triangle[row > 200] = False
    made = larynx_fit.fit_larynx(None, triangle & (row > 44), mm_per_px=0.05)
    assert made.missed_width == pytest.approx(
        made.error.percentile_95 * 0.05e-3 / made.section.half_width, rel=1e-12
    )
    assert made.missed_width > 0.5
    assert "of the half-width: this glottis is not elliptic" in made.warnings[0]
    assert _fit(pictured()).warnings == []


def test_the_scene_text_is_the_larynx() -> None:
    made = _fit(pictured(), order=1)
    table = tomllib.loads(made.scene_text())
    again = plica.build_mesh(plica.Larynx(**table["mesh"]))
    np.testing.assert_array_equal(again.points, made.mesh.points)
    np.testing.assert_array_equal(again.cells, made.mesh.cells)


@pytest.mark.parametrize("order", [1, 2])
def test_quality_is_what_plica_mesh_prints(order: int) -> None:
    made = _fit(pictured(), order=order)
    text, quality = mesh_summary(made.mesh), made.quality
    assert f"least {quality.least_mean_ratio:.3f}" in text
    assert f"dihedral angles: {quality.least_dihedral:.1f}" in text
    assert f"{quality.tetrahedra} {'quadratic' if order == 2 else 'linear'} tetrahedra" in text
    assert order == 1 or f"det dx/dxi at least {quality.least_jacobian:.3f}" in text
    assert quality.least_dihedral > 1.0


def test_the_overlay_names_what_it_shows() -> None:
    drawing = larynx_fit.overlay(_fit(pictured(), frame=True))
    for name in ("contour", "glottal edge of the mesh", "superior surface", "A"):
        assert f">{name}<" in drawing.svg
    assert "Distance between contour and glottal edge of the mesh: mean" in drawing.caption


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"mm_per_px": None}, "must be exactly one of the two"),
        ({"r_in": "7 mm"}, "must be exactly one of the two"),
        ({"mm_per_px": 0.0}, "mm_per_px = 0.0 mm; must be a number"),
        ({"mm_per_px": -0.05}, "mm_per_px = -0.05 mm"),
        ({"mm_per_px": "0.05"}, "mm_per_px = '0.05' mm"),
        ({"wall": 0.0}, "wall = 0 m; must be > 0"),
        ({"l_occ": "-1 mm"}, "l_occ = -0.001 m; must be >= 0"),
        ({"l_occ": "1 kPa"}, "l_occ = '1 kPa'"),
        ({"l_occ": "20 mm"}, "the length of the visible glottis"),
        ({"mm_per_px": None, "r_in": "5 mm", "l_occ": "5 mm"}, "must be < r_in"),
        ({"z": (-12e-3, -7e-3, -4e-3, 0.0, 0.0, 12e-3)}, "z[4] = 0 m; must be > z[3]"),
        ({"z": (0.0, 1.0)}, "z has 2 heights; must have 6"),
        ({"layer_thickness": 0.0}, "layer_thickness = 0 m"),
        ({"tilt": 60.0}, "tilt = 60.0 degrees"),
        ({"anterior": "left"}, "anterior = 'left'"),
        ({"larynx": "thesis"}, "larynx = 'thesis'"),
        ({"largest_error": 0.0}, "largest_error = 0.0"),
        ({"commissures": ((1.0, 2.0),)}, "must be two points"),
        ({"commissures": ((120.0, 240.0), (120.0, 20.0))}, "must have A as the upper one"),
        ({"commissures": ((120.0, 20.0), (120.0, 300.0))}, "P0 = (120, 300) px; must lie in the picture"),
    ],
)
def test_settings_out_of_range_are_refused(changed: dict[str, Any], expected: str) -> None:
    with pytest.raises(InvalidInput) as error:
        _fit(pictured(), **changed)
    assert expected in str(error.value)
    assert str(error.value).startswith("Larynx fit: ")
