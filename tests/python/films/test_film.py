"""Pictures of folds whose motion is given, against what is known of them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import ndimage

import plica
from filmed_folds import PIXEL, FilmedFolds, folds, moved, shifted, voiced
from plica.films.motion import Motion
from plica.films.raster import rasterise
from plica.films.sight import Hull
from plica.films.surface import skin

EVEN = {"ambient": 1.0, "highlights": 0.0, "vignetting": 0.0}  # brightness goes with the material
QUIET = {"photon_noise": 0.0, "read_noise": 0.0}


def test_a_shift_by_whole_pixels_moves_the_picture_by_them() -> None:
    clip = plica.film(moved(shifted(3 * PIXEL, -2 * PIXEL), [0, 1e-3]), vignetting=0.0, **QUIET)
    first, second = clip.clean(0), clip.clean(1)
    flow, visible = clip.flow(0)
    assert np.ptp(first[visible]) > 100
    np.testing.assert_allclose(flow[visible], np.broadcast_to([3.0, 2.0], flow[visible].shape), atol=1e-4)
    inner = ndimage.binary_erosion(visible, iterations=5)  # the lens mixes in what stands still
    y, x = np.nonzero(inner)
    assert len(y) > 30_000
    # float32 round-off of the shift moves a sample by 1e-6 px
    np.testing.assert_allclose(second[y + 2, x + 3], first[y, x], atol=1e-3)


def test_a_shift_by_a_part_of_a_pixel_is_the_flow() -> None:
    clip = plica.film(moved(shifted(0.37 * PIXEL, 0.81 * PIXEL), [0, 1e-3]))
    flow, visible = clip.flow(0)
    assert np.isfinite(flow[visible]).all()
    assert np.abs(flow[visible] - [0.37, -0.81]).max() < 1e-4


def test_the_surface_of_the_airflow_is_seen_whatever_its_name() -> None:
    mesh = folds()
    surfaces = {f"inner {name}": faces for name, faces in mesh.surfaces.items()}
    named = SimpleNamespace(points=mesh.points, cells=mesh.cells, surfaces=surfaces)
    still = moved(shifted(), [0, 1e-3])
    run = SimpleNamespace(mesh=named, fields=still.fields, airway="inner airway")
    expected, found = plica.film(still).clean(0), plica.film(run).clean(0)
    assert not np.array_equal(plica.film(FilmedFolds(named, still.fields)).clean(0), expected)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("frame", [3, 15])
def test_the_true_flow_warps_a_frame_to_the_next(frame: int) -> None:
    times = np.arange(17) * 0.25e-3
    clip = plica.film(moved(voiced(), times), **EVEN, **QUIET)
    first, second = clip.clean(frame), clip.clean(frame + 1)
    flow, visible = clip.flow(frame)
    u, v = np.nan_to_num(np.moveaxis(flow, -1, 0))
    y, x = np.mgrid[: first.shape[0], : first.shape[1]].astype(float)
    warped = ndimage.map_coordinates(second, [y + v, x + u], order=3, mode="nearest")
    inner = ndimage.binary_erosion(visible, iterations=3)  # three standard deviations of lens and pixel
    moving = inner & (np.hypot(u, v) > 0.5)
    assert moving.sum() > 3000
    still = (second - first)[moving].std()
    # Four samples a pixel alias a little of the grain; a camera's noise is ten times that.
    assert (warped - first)[moving].std() < 0.25
    assert still > 20 * (warped - first)[moving].std()


def _shutter(rest: np.ndarray, t: float) -> np.ndarray:
    """The upper edges, wide apart at first, come to hang over the lower ones within a millisecond."""
    x, y, z = rest.T
    share = np.clip(1 - (y / 7e-3) ** 2, 0, 1) * np.clip((z + 2.5e-3) / 2e-3, 0, 1) * (z < 0.5e-3)
    found = np.zeros_like(rest)
    found[:, 0] = np.sign(x) * share * 0.5e-3 * (1 - 1.4e3 * t) * (np.abs(x) < 4e-3)
    return found


def test_what_is_seen_again_is_what_no_triangle_hides() -> None:
    """Against every triangle tried for single points of tissue, one by one."""
    clip = plica.film(moved(_shutter, [0, 1e-3]), plica.Camera(mm_per_px=0.08, width=160, height=200))
    flow, visible = clip.flow(0)
    tissue = np.isfinite(flow[..., 0])
    triangles, corners, raster = clip._sight.surface.triangles, clip._view(1).corners, clip._view(0).raster
    place, again = raster.of(corners, triangles), visible.ravel()[raster.pixels]
    assert not (visible & ~tissue).any()
    assert (~again).sum() > 500
    random = np.random.default_rng(0)
    chosen = [random.choice(np.flatnonzero(part), 150, False) for part in (again, ~again)]
    p = corners[triangles]
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area[area == 0] = np.nan
    for i in np.concatenate(chosen):
        x, y, z = place[i]
        r = ((x - p[:, 0, 0]) * b[:, 1] - (y - p[:, 0, 1]) * b[:, 0]) / area
        s = ((y - p[:, 0, 1]) * a[:, 0] - (x - p[:, 0, 0]) * a[:, 1]) / area
        over = (r >= 0) & (s >= 0) & (r + s <= 1) & (area < 0)
        hidden = (over & (p[:, 0, 2] + r * a[:, 2] + s * b[:, 2] > z + 1e-3 * clip.camera.pixel)).any()
        assert again[i] == (area[raster.shown[i]] < 0 and not hidden)


def test_tissue_that_turns_its_back_is_not_seen_again() -> None:
    mesh = plica.build_mesh(plica.Block(size=(0.01, 0.01, 0.001), divisions=(2, 2, 1)))
    rest = np.asarray(mesh.points)
    over = rest * [-1, 1, -1] + [0.01, 0, 0.001]  # half a turn about its length
    run = FilmedFolds(mesh, {"time": np.array([0, 1e-3]), "displacement": np.array([0 * rest, over - rest])})
    clip = plica.film(run, plica.Camera(centre=(0.005, 0.005, 0.0)))
    flow, visible = clip.flow(0)
    assert np.isfinite(flow).any()
    assert not visible.any()


def _outline(mesh: plica.Larynx, height: float) -> np.ndarray:
    """Corners of the six-node faces' sides at a height, 33 a side, sorted by angle."""
    points = np.asarray(mesh.points)
    faces = np.asarray(mesh.surfaces["airway"])
    found = []
    for k in range(3):
        a, b, m = points[faces[:, k]], points[faces[:, (k + 1) % 3]], points[faces[:, 3 + k]]
        level = np.all(np.abs(np.stack([a, b, m])[..., 2] - height) < 1e-9, axis=0)
        for s in np.linspace(0, 1, 33):
            found.append(
                (1 - s) * (1 - 2 * s) * a[level] + s * (2 * s - 1) * b[level] + 4 * s * (1 - s) * m[level]
            )
    x, y = np.concatenate(found)[:, :2].T
    order = np.argsort(np.arctan2(y / 7e-3, x / 0.25e-3))
    return np.column_stack([x, y])[order]


@pytest.mark.parametrize("mm_per_px", [0.06, 0.1])
def test_the_glottis_at_rest_has_the_area_of_its_outline(mm_per_px: float) -> None:
    mesh = folds()
    x, y = _outline(mesh, -3.1e-3).T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    perimeter = np.hypot(np.diff(x), np.diff(y)).sum()
    assert area == pytest.approx(np.pi * 7e-3 * 0.25e-3, rel=0.02)
    camera = plica.Camera(mm_per_px=mm_per_px)
    clip = plica.film(moved(shifted(), [0, 1e-3]), camera)
    # A pixel may go either way along the outline: half a pixel of it at worst.
    assert abs(clip.area(0) - area) < 0.5 * perimeter * camera.pixel
    # Averaged over places of the pixels there is no error but the facets'.
    many = [
        plica.film(
            moved(shifted(), [0, 1e-3]),
            plica.Camera(mm_per_px=mm_per_px, width=32, height=256, centre=(s * camera.pixel, 0.0, 0.0)),
        ).area(0)
        for s in np.linspace(-0.5, 0.5, 8, endpoint=False)
    ]
    assert np.mean(many) == pytest.approx(area, rel=0.02)


def test_a_tilted_camera_foreshortens_by_the_cosine() -> None:
    tilt, lean = np.radians(20), np.radians(-15)
    along = plica.film(moved(shifted(y=4 * PIXEL), [0, 1e-3]), plica.Camera(tilt=20)).flow(0)
    np.testing.assert_allclose(
        along[0][along[1]].mean(axis=0, dtype=float), [0, -4 * np.cos(tilt)], atol=1e-4
    )
    across = plica.film(moved(shifted(x=4 * PIXEL), [0, 1e-3]), plica.Camera(lean=-15)).flow(0)
    np.testing.assert_allclose(
        across[0][across[1]].mean(axis=0, dtype=float), [4 * np.cos(lean), 0], atol=1e-4
    )
    # What rises goes away from where the camera stands: it stands towards +y, up in the picture.
    rising = plica.film(moved(shifted(z=4 * PIXEL), [0, 1e-3]), plica.Camera(tilt=20)).flow(0)
    np.testing.assert_allclose(
        rising[0][rising[1]].mean(axis=0, dtype=float), [0, 4 * np.sin(tilt)], atol=1e-4
    )


def test_what_lies_around_the_airway_stands_still_and_is_no_tissue() -> None:
    clip = plica.film(
        moved(voiced(), [0, 1e-3]), plica.Camera(mm_per_px=0.08, tilt=15, lean=10), blur=0.0, **QUIET
    )
    flow, _ = clip.flow(0)
    seen = np.isfinite(flow[..., 0]) | clip.glottis(0)
    # The airway's upper end is a circle of 7 mm, 20 mm high: an ellipse in the picture.
    angle = np.linspace(0, 2 * np.pi, 721)
    rim = 7e-3 * np.column_stack([np.cos(angle), np.sin(angle), np.full(721, 20 / 7)])
    circle = Hull(clip.camera.project(rim)[:, :2]).pixels(clip.camera.shape)
    assert 0 < (seen != circle).sum() < 0.01 * circle.sum()  # twelve parabolas are not quite a circle
    apart = ~ndimage.binary_dilation(circle, iterations=2)
    assert apart.sum() > 10_000
    np.testing.assert_array_equal(clip.clean(0)[apart], clip.clean(1)[apart])
    assert clip.clean(0)[apart].std() > 10


def test_the_projection_is_that_of_rotation_matrices() -> None:
    from scipy.spatial.transform import Rotation

    camera = plica.Camera(mm_per_px=0.05, centre=("1 mm", -2e-3, 0.0), tilt=12, lean=-7, roll=33)
    turn = Rotation.from_euler("xyz", [12, 7, 33], degrees=True)  # fixed axes; lean turns towards +x
    points = np.random.default_rng(3).normal(0, 5e-3, (20, 3))
    right, up, towards = turn.apply(points - [1e-3, -2e-3, 0.0]).T
    expected = np.column_stack([127.5 + right / 0.05e-3, 127.5 - up / 0.05e-3, towards])
    np.testing.assert_allclose(camera.project(points), expected, rtol=1e-12, atol=1e-12)


def test_a_camera_rolled_by_a_right_angle_turns_the_picture() -> None:
    run = moved(voiced(), [0.5e-3, 1e-3])
    options = plica.Film(light=(0, 0, 1), samples=1, **QUIET)
    upright = plica.film(run, plica.Camera(), options).clean(0)
    turned = plica.film(run, plica.Camera(roll=90), options).clean(0)
    assert np.ptp(upright) > 100
    differ = np.abs(turned - np.rot90(upright)) > 1.0  # rot90 turns anticlockwise as seen
    assert differ.mean() < 1e-3


def test_an_exposure_blurs_and_conserves_the_mean_grey() -> None:
    run = moved(shifted(x=6 * PIXEL), np.arange(9) * 1e-3)
    chosen = {"start": "3 ms", "end": "5 ms", "samples": 24, "blur": 0.0, **EVEN, **QUIET}
    camera = plica.Camera(width=96, height=112, centre=("3.2 mm", 0.0, 0.0))  # 18 px of it were passed
    sharp = plica.film(run, camera, **chosen).clean(0)
    blurred = plica.film(run, camera, exposure="1 ms", **chosen).clean(0)
    inner = np.s_[30:80, 28:68]
    assert blurred[inner].std() < 0.85 * sharp[inner].std()
    # 6 px of path: the mean over the tissue seen, weighted by where the path has been
    path = ndimage.uniform_filter1d(sharp, 6, axis=1, origin=0)
    path = 0.5 * (path + ndimage.uniform_filter1d(sharp, 6, axis=1, origin=-1))
    assert np.abs(path - blurred)[inner].std() < 0.1 * (sharp - blurred)[inner].std()
    assert blurred.mean() == pytest.approx(sharp.mean(), rel=2e-3)


def test_noise_has_the_asked_spread() -> None:
    run = moved(shifted(), [0, 1e-3])
    options = {"highlights": 0.0, "samples": 1}
    read = plica.film(run, photon_noise=0.0, read_noise=3.0, **options)
    left = (read.frame(0) - read.clean(0))[read.clean(0) > 15]
    assert left.std() == pytest.approx(np.sqrt(9 + 1 / 12), rel=0.015)  # and of rounding; 55,000 pixels
    assert abs(left.mean()) < 0.05
    photon = plica.film(run, photon_noise=5.0, read_noise=0.0, **options)
    clean = photon.clean(0)
    left = photon.frame(0) - clean
    for low, high in ((30, 60), (90, 110), (140, 170)):
        chosen = (clean > low) & (clean < high)
        expected = np.sqrt(25 * clean[chosen].mean() / 255 + 1 / 12)
        assert left[chosen].std() == pytest.approx(expected, rel=0.04)
    assert (photon.frame(0) != photon.frame(1)).mean() > 0.5
    again = plica.film(run, photon_noise=5.0, read_noise=0.0, **options)
    np.testing.assert_array_equal(photon.frame(1), again.frame(1))


def test_the_texture_has_its_band_and_spread() -> None:
    mesh = plica.build_mesh(plica.Block(size=(0.01, 0.01, 0.001), divisions=(1, 1, 1)))
    grain = 0.4e-3
    clip = plica.film(
        moved(shifted(), [0, 1e-3], mesh),
        plica.Camera(mm_per_px=0.03, centre=(0.005, 0.005, 0.0)),
        plica.Film(grain=grain, blur=0, samples=1, glottis=0, **EVEN, **QUIET),
    )
    picture = clip.clean(0)
    assert picture.std() == pytest.approx(25, rel=0.3)  # one cut through the cube
    power = np.abs(np.fft.rfft2((picture - picture.mean()) * np.outer(np.hanning(256), np.hanning(256)))) ** 2
    k = np.hypot(np.fft.fftfreq(256, 0.03e-3)[:, None], np.fft.rfftfreq(256, 0.03e-3))
    assert power[k > 1.2 / grain].sum() < 1e-3 * power.sum()
    assert power[k > 0.4 / grain].sum() > 1e-2 * power.sum()


def test_the_skin_of_a_block_closes_and_looks_outward() -> None:
    for order, nodes in ((1, 3), (2, 6)):
        mesh = plica.build_mesh(plica.Block(size=(0.03, 0.02, 0.01), divisions=(3, 2, 2), order=order))
        points = np.asarray(mesh.points)
        faces = skin(points, np.asarray(mesh.cells))
        assert faces.shape[1] == nodes
        a, b, c = (points[faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a) / 2
        np.testing.assert_allclose(normal.sum(axis=0), 0, atol=1e-15)
        assert np.einsum("ij,ij->", normal, a) / 3 == pytest.approx(6e-6)
        if nodes == 6:
            np.testing.assert_allclose(points[faces[:, 3]], (a + b) / 2, atol=1e-15)
            np.testing.assert_allclose(points[faces[:, 5]], (a + c) / 2, atol=1e-15)


def test_the_raster_shows_the_nearest_triangle_and_leaves_no_gap() -> None:
    random = np.random.default_rng(5)
    corners = np.column_stack([random.uniform(-5, 45, (90, 2)), random.uniform(0, 1, 90)])
    triangles = np.arange(90).reshape(-1, 3)
    found = rasterise(corners, triangles, np.ones((40, 40), dtype=bool)).triangle
    expected = np.full((40, 40), -1)
    for y in range(40):
        for x in range(40):
            best = -np.inf
            for t, (a, b, c) in enumerate(corners[triangles]):
                matrix = np.array([b[:2] - a[:2], c[:2] - a[:2]]).T
                if np.linalg.det(matrix) >= 0:
                    continue
                r, s = np.linalg.solve(matrix, [x - a[0], y - a[1]])
                height = a[2] + r * (b[2] - a[2]) + s * (c[2] - a[2])
                if min(r, s, 1 - r - s) >= 0 and height > best:
                    best, expected[y, x] = height, t
    np.testing.assert_array_equal(found, expected)
    y, x = np.mgrid[:5, :5] * 9.0
    grid = np.column_stack([x.ravel(), y.ravel(), np.zeros(25)])
    cells = [(i, i + 5, i + 1) for i in range(19) if i % 5 < 4] + [
        (i + 1, i + 5, i + 6) for i in range(19) if i % 5 < 4
    ]
    assert (rasterise(grid, np.array(cells), np.ones((37, 37), dtype=bool)).triangle >= 0).all()


def test_the_hull_holds_the_pixels_of_a_disc() -> None:
    angle = np.linspace(0, 2 * np.pi, 720)
    hull = Hull(np.column_stack([30 + 20 * np.cos(angle), 25 + 20 * np.sin(angle)]))
    found = hull.pixels((50, 64))
    y, x = np.mgrid[:50, :64]
    radius = np.hypot(x - 30, y - 25)
    assert found[radius < 19.99].all()
    assert not found[radius > 20.01].any()
    np.testing.assert_array_equal(hull.holds(np.column_stack([x.ravel(), y.ravel()])), found.ravel())


def test_motion_between_stored_fields_is_a_cubic_s() -> None:
    times = np.arange(9) * 1e-3
    cubic = lambda rest, t: np.full_like(rest, 1.0) * (1 + 2e2 * t - 3e4 * t**2 + 4e6 * t**3)  # noqa: E731
    motion = Motion(moved(cubic, times), np.arange(4))
    for t in (0.3e-3, 4.4e-3, 7.9e-3):
        expected = 1 + 2e2 * t - 3e4 * t**2 + 4e6 * t**3
        np.testing.assert_allclose(motion.at(t), expected, rtol=1e-12)


@pytest.mark.parametrize("kind", ["smooth", "kinked"])
@pytest.mark.parametrize("each", [8, 12, 24])
def test_the_error_between_stored_fields_is_reported_to_a_factor(kind: str, each: int) -> None:
    def swing(t: float | np.ndarray) -> np.ndarray:
        return 1e-3 * np.maximum(-2.0 if kind == "smooth" else -0.3, np.sin(2 * np.pi * 200 * t))

    times = np.arange(6 * each + 1) / (200 * each)
    motion = Motion(moved(lambda rest, t: np.full_like(rest, swing(t)), times), np.arange(4))
    between = np.linspace(times[4], times[-5], 801)
    missed = np.array([motion.at(t)[0, 0] for t in between]) - swing(between)
    true = np.sqrt(3 * np.mean(missed**2))
    assert 1e-8 < 0.5 * true < motion.error_between() < 3 * true
