"""A run without contact, filmed and identified by the command: the truth is in the intervals."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from flow_files import FPS, PAIRS, SETTINGS, SIZE, block_scene, flow_file
from plica.commands.main import main
from plica.identify import Identification, MarginalLikelihood, MotionModel, Settings, identify, load
from plica.identify.estimator import thickness
from plica.identify.estimator.iterates import Iterates
from plica.identify.model.coarser import coarser_scene, remainder
from plica.identify.model.step_error import angular_frequency, period_error, stiffness_error
from plica.identify.observation.paths import correlation_length, follow_points
from plica.identify.observation.placement import place
from plica.identify.observation.sources import open_motion
from plica.identify.report.page import rows
from plica.measures.measured import Measured
from stored_files import add_noise

TRUTH = {"E": 5e3, "viscosity": 0.3}
GUESS = {"E": 7e3, "viscosity": 0.2}
CAMERA = plica.Camera(mm_per_px=0.08, width=64, height=96, centre=(2e-3, 3e-3, 3e-3))
CHOSEN: dict[str, Any] = {
    "surface": "x_max",
    "seen": "z_max",
    "from_rest": True,
    "heights": (0.0, SIZE[2]),
    "spacing": 10.0,
    "closed_below": 0.0,  # the film of a block has no glottis, but slits beside it
}


def _scene(tissue: dict[str, float], step: float, **parts: Any) -> plica.Scene:
    made = plica.Scene(
        plica.Block(size=SIZE, divisions=(3, 4, 3), order=2),
        {"body": plica.Tissue(nu=0.4, **tissue)},
        time=plica.Stepping(step=step, duration=12e-3),
        supports=plica.Supports(fixed=("z_min", "y_min", "y_max")),
        **parts,
    )
    assert made.contact is None
    return made


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The truth of a film: the run has half the step and a pressure that is even over the face."""
    where = tmp_path_factory.mktemp("filmed")
    loads = [
        plica.Load(surface="x_max", traction=(150, 0, 0), frequency=180, phase=-np.pi / 2),
        plica.Load(surface="x_max", traction=(100, 0, 0), frequency=410, phase=-np.pi / 2),
    ]
    scene = _scene(TRUTH, 62.5e-6, loads=loads, output=plica.Output(every=250e-6))
    run = plica.run(scene, where / "run", progress=False)
    plica.write_film(plica.film(run, CAMERA), where / "clip.npy")
    rng = np.random.default_rng(7)
    add_noise(where / "clip.truth.h5", 0.03, rng)  # a camera's flow is never without error
    return where / "clip.truth.h5"


@pytest.fixture(scope="module")
def commanded(filmed: Path) -> Path:
    """The directory of ``plica identify``."""
    where = filmed.parent
    _scene(GUESS, 125e-6).save(where / "scene.toml")
    (where / "set.toml").write_text(
        '[identify]\nsurface = "x_max"\nseen = "z_max"\nheights = [0.0, "3 mm"]\nspacing = 10\n'
        "closed_below = 0\n"
    )
    arguments = [str(filmed), "--scene", str(where / "scene.toml"), "-o", str(where / "out")]
    assert main(["identify", *arguments, "--settings", str(where / "set.toml"), "--from-rest"]) == 0
    return where / "out"


@pytest.mark.slow
def test_the_truth_is_in_the_intervals(commanded: Path) -> None:
    found = load(commanded).posterior
    interval = dict(zip(found.names, found.interval(), strict=True))
    assert set(interval) == {"body.E", "viscosity"}
    for name, true in (("body.E", TRUTH["E"]), ("viscosity", TRUTH["viscosity"])):
        low, high = interval[name]
        assert low < true < high
    assert found.mesh_shift is not None
    assert found.sd[found.names.index("body.E")] < 0.5 * 0.7  # much is learned, the shift included


@pytest.mark.slow
def test_parameters_have_the_shape_of_measures(commanded: Path) -> None:
    found = load(commanded)
    assert set(found.measures) == set(found.posterior.names)
    parameter: Measured = found.measures["body.E"]
    low, high = found.posterior.interval()[found.posterior.names.index("body.E")]
    assert parameter.interval == (low, high)
    assert parameter.uncertainty == pytest.approx(0.5 * (high - low))
    assert low < parameter.value < high
    assert (parameter.unit, parameter.spread) == ("Pa", None)
    assert "posterior" in parameter.uncertainty_source
    assert set(parameter.cautions) <= set(found.warnings)
    assert not any('"viscosity"' in text and '"body.E"' not in text for text in parameter.cautions)
    with pytest.raises(plica.InvalidInput, match=r"body\.E"):
        found.measures["body.F"]


@pytest.mark.slow
def test_what_is_stored_is_read_back(commanded: Path) -> None:
    found = load(commanded)
    picture, posterior = found.picture, found.posterior
    assert isinstance(found, Identification)
    assert picture.observed.shape == picture.predicted.shape == picture.whitened.shape
    assert picture.explained > 0.9
    assert picture.lead == 0
    assert found.iterations[-1, 1] < 0.05
    with (commanded / "posterior.csv").open() as file:
        rows = {row["parameter"]: row for row in csv.DictReader(file)}
    for j, name in enumerate(posterior.names):
        assert float(rows[name]["median"]) == posterior.median[j]
        assert float(rows[name]["low_95"]) == posterior.interval()[j, 0]
        assert rows[name]["unit"] == posterior.units[j]
    with h5py.File(commanded / "posterior.h5") as file:
        assert file["recording/place"].attrs["units"] == b"m"
        assert np.allclose(file["posterior/derived/interval"], posterior.interval())
        assert [text.decode() for text in file["posterior/derived/warnings"]] == found.warnings
    # the places of the points are on the upper face, where the camera sees them
    assert np.allclose(picture.place[:, 2], SIZE[2])
    assert np.allclose(CAMERA.project(picture.place)[:, :2], picture.start, atol=1e-6)


@pytest.mark.slow
def test_the_report_has_warnings_first_and_all_pictures(commanded: Path) -> None:
    text = (commanded / "report.html").read_text(encoding="utf-8")
    for warning in load(commanded).warnings:
        assert text.index(warning.split('"')[-1][:40]) < text.index("<h2>Tissue</h2>")
    titles = re.findall(r"<h3>(.*?)</h3>", text)
    assert titles == [
        "Prior against posterior",
        "Correlation",
        "Identifiability",
        "Predicted against observed motion",
        "Unknown pressures",
        "Whitened residuals",
    ]
    assert "Residual test" in text
    assert not re.search(r'(src|href)="http', text)


@pytest.mark.slow
def test_what_was_stopped_continues_to_the_same_end(
    filmed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, settings = _scene(GUESS, 250e-6), Settings(**CHOSEN | {"coarser": "none"})
    whole = identify(filmed, scene, tmp_path / "whole", settings, progress=False)
    add = Iterates.add

    def stopped(self: Iterates, mesh: str, at: Any) -> None:
        add(self, mesh, at)
        if at.number == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Iterates, "add", stopped)
        with pytest.raises(KeyboardInterrupt):
            identify(filmed, scene, tmp_path / "parts", settings, progress=False)
    parts = identify(filmed, scene, tmp_path / "parts", settings, resume=True, progress=False)
    assert np.abs((parts.posterior.mean - whole.posterior.mean) / whole.posterior.sd).max() < 0.05
    assert np.array_equal(parts.iterations[:4], whole.iterations[:4])


@pytest.mark.slow
def test_what_the_recording_cannot_tell_is_called_so(filmed: Path, tmp_path: Path) -> None:
    """Three frames of it say next to nothing of the viscosity."""
    settings = Settings(**CHOSEN | {"coarser": "none", "last": 3})
    found = identify(filmed, _scene(GUESS, 250e-6), tmp_path / "out", settings, progress=False)
    assert any('"viscosity" is hardly informed' in warning for warning in found.warnings)
    assert "hardly informed by the data: close to the prior" in (tmp_path / "out" / "report.html").read_text()
    assert any("Only one mesh was used" in warning for warning in found.warnings)


@pytest.mark.slow
def test_numbers_of_a_motion_that_is_not_followed_are_not_carried_by_the_data(commanded: Path) -> None:
    found = load(commanded)
    assert found.picture.carried
    assert not any("not supported" in row.verdict for row in rows(found))
    lost = replace(found, picture=replace(found.picture, predicted=0.2 * found.picture.observed))
    assert lost.picture.explained == pytest.approx(1 - 0.8**2)
    assert not lost.picture.carried
    assert all("not supported by the data" in row.verdict for row in rows(lost))


@pytest.mark.slow
def test_a_layer_of_the_same_tissue_may_be_as_thick_as_it_likes(
    filmed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The upper third of the block, called a layer: to move its side moves no number by half an sd. With that
    bound set aside, the sentence is there."""

    def upper_third(mesh: Any, surface: str) -> dict[str, Any]:
        assert surface == "z_max"
        return {"upper": np.flatnonzero(np.abs(np.asarray(mesh.points)[:, 2] - 2 * SIZE[2] / 3) < 1e-9)}

    monkeypatch.setattr(thickness, "layers_below", upper_third)
    settings, scene = Settings(**CHOSEN | {"coarser": "none"}), _scene(GUESS, 250e-6)
    found = identify(filmed, scene, tmp_path / "out", settings, progress=False)
    assert found.posterior.answered
    assert not any("thicker" in warning for warning in found.warnings)
    monkeypatch.setattr(thickness, "REPORTED_SHIFT", 0.0)
    warnings = identify(filmed, scene, tmp_path / "told", settings, progress=False).warnings
    assert any('The thickness of the layer "upper"' in w and '"body.E" would' in w for w in warnings)


# ---- Parts -------------------------------------------------------------------------------------


def test_points_go_with_the_flow_and_are_lost_where_it_is_unknown(tmp_path: Path) -> None:
    height, width = 20, 30
    flow = np.zeros((6, height, width, 2), dtype=np.float32)
    flow[..., 0] = 0.5 + 0.1 * np.arange(width)  # dx/dt grows with x
    flow[4, :, :, :] = np.nan
    visible = np.ones(flow.shape[:3], dtype=bool)
    visible[1, :, :10] = False
    motion = open_motion(flow_file(tmp_path / "flow.h5", flow=flow, visible=visible))
    paths, seen, missed = follow_points(motion, range(6), np.array([[2.25, 3.0], [12.0, 3.0]]))
    x = [2.25]
    for _ in range(4):
        x.append(x[-1] + 0.5 + 0.1 * x[-1])
    assert np.allclose(paths[:5, 0, 0], x, rtol=1e-6)
    assert np.isnan(paths[5:]).all()
    assert np.isnan(seen[1, 0]).all()
    assert np.isfinite(seen[1, 1]).all()
    assert np.isnan(missed).all()


def test_the_length_over_which_an_error_is_correlated_is_found() -> None:
    """Noise averaged over n pixels is correlated by 1 - lag / n."""
    rng = np.random.default_rng(0)
    white = rng.normal(size=(6, 300, 300))
    smooth = np.array([_averaged(field, 10) for field in white])
    assert correlation_length(white) == 1
    assert correlation_length(smooth) in (8, 9)  # the first below 0.2
    smooth[:, 100:150] = np.nan
    assert correlation_length(smooth) in (8, 9)
    assert correlation_length([np.full((20, 20), np.nan)]) is None


def _averaged(field: Any, n: int) -> Any:
    total = np.cumsum(np.cumsum(np.pad(field, ((1, 0), (1, 0))), axis=0), axis=1)
    return total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n]


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (5.0, -3.0, 40.0), (0.0, 0.0, 180.0)])
def test_a_place_is_where_the_projection_shows_it(tmp_path: Path, angles: tuple[float, float, float]) -> None:
    tilt, lean, roll = angles
    camera = plica.Camera(
        mm_per_px=0.1, width=40, height=48, centre=(1e-3, 2e-3, 3e-3), tilt=tilt, lean=lean, roll=roll
    )
    scene = block_scene()
    mesh = plica.build_mesh(scene.mesh)
    motion = open_motion(flow_file(tmp_path / "flow.h5", projection=camera.projection))
    found = place(motion, Settings(), scene, mesh, "z_max")
    x = np.random.default_rng(1).normal(size=(5, 3))
    shown = camera.project(x)
    assert np.allclose(found.camera.project(x)[:, :2], shown[:, :2], rtol=0, atol=1e-9)
    without = open_motion(flow_file(tmp_path / "bare.h5", projection=None, mm_per_px=0.1))
    settings_given = Settings(centre=(1e-3, 2e-3, 3e-3), tilt=tilt, lean=lean, roll=roll)
    again = place(without, settings_given, scene, mesh, "z_max")
    assert np.allclose(again.camera.project(x)[:, :2], shown[:, :2], rtol=0, atol=1e-9)
    assert (found.tilt_sd, again.tilt_sd) == (0.0, 6.0)


def test_a_picture_is_laid_on_the_mesh_by_its_glottis(tmp_path: Path) -> None:
    """Its anterior end goes to +y, its middle to that of the mesh."""
    scene = block_scene()
    mesh = plica.build_mesh(scene.mesh)
    bare = open_motion(flow_file(tmp_path / "flow.h5", projection=None, mm_per_px=0.1))
    motion = replace(bare, glottis=((10.0, 40.0), (30.0, 20.0)))
    found = place(motion, Settings(), scene, mesh, "z_max")
    half = 0.5 * 1e-4 * np.linalg.norm(np.subtract(*motion.glottis))
    middle = np.array([SIZE[0] / 2, SIZE[1] / 2, SIZE[2]])
    ends = middle + half * np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])  # on the mesh
    assert np.allclose(found.camera.project(ends)[:, :2], motion.glottis, rtol=0, atol=1e-9)
    assert found.tilt_sd > 0


def test_closed_frames_are_those_with_next_to_no_glottis(tmp_path: Path) -> None:
    from plica.identify.observation.recording import observe

    area = np.array([0, 1, 9, 40, 100, 100, 40, 2, 1, 0, 50.0])
    scene = block_scene()
    motion = open_motion(flow_file(tmp_path / "flow.h5", glottal_area=area))
    settings = Settings(**SETTINGS | {"from_rest": False, "lead": 6e-3})
    found = observe(motion, settings, scene, plica.build_mesh(scene.mesh), "z_max")
    assert found.lead == round(6e-3 * FPS)
    closed = np.asarray(found.observation.closed)
    assert closed[found.lead :].tolist() == [True, True, False, False, False, False, True, True, True, True]
    assert not closed[: found.lead].any()
    assert np.isnan(found.observation.flow[: found.lead]).all()


def test_frames_that_are_closed_before_the_first_opening_are_distinguished_from_what_is_before_them(
    tmp_path: Path,
) -> None:
    """The frames of unknown pressures before the recording are open; all until the first opening is closed,
    and has forces of collision of its own."""
    from plica.identify.model.pressures import forcing_of
    from plica.identify.observation.recording import observe

    area = np.array([0, 0, 1, 0, 50, 100, 90, 80, 70, 60, 50.0])
    scene = block_scene()
    mesh = plica.build_mesh(scene.mesh)
    motion = open_motion(flow_file(tmp_path / "flow.h5", glottal_area=area))
    settings = Settings(**SETTINGS | {"from_rest": False})
    found = observe(motion, settings, scene, mesh, "z_max")
    closed = np.asarray(found.observation.closed)
    assert closed.tolist() == [False] * found.lead + [True] * 4 + [False] * 6
    forcing = forcing_of(settings, scene, mesh, found.observation, found.lead)
    inputs = MarginalLikelihood(MotionModel(scene, ["body.E"], found.observation, forcing, mesh=mesh)).inputs
    assert inputs.before.stop - inputs.before.start == 3 * found.lead
    assert inputs.classes[:2] == (3 * PAIRS, 3 * 4)


@pytest.mark.parametrize(
    ("heights", "lead", "frames"),
    [(None, 1e-3, 16), (2, 1e-3, 24), (5, 1e-3, 10), (None, 6e-3, 24), (48, 1e-4, 1)],
)
def test_pressures_before_a_recording_are_enough_to_make_its_state(
    heights: int | None, lead: float, frames: int, tmp_path: Path
) -> None:
    """48 of them, or as many frames as the settings say if that is more."""
    from plica.identify.observation.recording import observe

    scene = block_scene()
    motion = open_motion(flow_file(tmp_path / "flow.h5"))
    given: dict[str, Any] = {"from_rest": False, "lead": lead}
    if heights is not None:
        given["heights"] = tuple(np.linspace(0, SIZE[2], heights))
    found = observe(motion, Settings(**SETTINGS | given), scene, plica.build_mesh(scene.mesh), "z_max")
    assert found.lead == frames
    assert np.isnan(found.observation.flow[:frames]).all()
    assert not np.isnan(found.observation.flow[frames]).any()


def test_a_coarser_scene_differs_in_its_mesh_alone() -> None:
    scene = block_scene().replace({"mesh.divisions": (4, 5, 2)})
    coarser, why = coarser_scene(Settings(), scene)
    assert coarser is not None
    assert coarser.mesh.divisions == (2, 2, 1)  # type: ignore[union-attr]
    assert coarser.replace({"mesh.divisions": (4, 5, 2)}) == scene
    assert why == ""
    assert coarser_scene(Settings(coarser="none"), scene) == (None, "")
    larynx = plica.Scene(plica.Larynx(larynx="coarse", order=2), "thesis_corrected", time=scene.time)
    none, why = coarser_scene(Settings(), larynx)
    assert none is None
    assert 'no larynx coarser than "coarse"' in why
    demo, _ = coarser_scene(Settings(), larynx.replace({"mesh.larynx": "demo"}))
    assert demo == larynx


@pytest.mark.slow
def test_a_step_that_is_long_for_the_motion_is_reported(filmed: Path, tmp_path: Path) -> None:
    """Halving the step shows three quarters of an error that falls with its square; to a factor of two."""
    settings = Settings(**CHOSEN | {"coarser": "none"})
    found = {
        step: identify(filmed, _scene(GUESS, step), tmp_path / f"{step}", settings, progress=False)
        for step in (125e-6, 250e-6)
    }
    stiffness = [p.posterior.median[p.posterior.names.index("body.E")] for p in found.values()]
    assert [any("time step" in w for w in p.warnings) for p in found.values()] == [False, True]
    picture = found[250e-6].picture
    predicted = stiffness_error(picture.predicted, picture.frame_rate, 250e-6, -0.3)
    assert 0.5 * 0.75 * predicted < stiffness[1] / stiffness[0] - 1 < 2 * 0.75 * predicted


def test_the_error_of_a_period_is_that_of_the_time_scheme() -> None:
    assert period_error(1e-2, 0.0) == pytest.approx(1e-4 / 12, rel=1e-3)
    # steps of an oscillator by the scheme itself, phases read from its motion
    alpha, angle, steps = -0.3, 0.3, 400
    gamma, beta = 0.5 - alpha, (1 - alpha) ** 2 / 4
    u, v, a = 1.0, 0.0, -(angle**2)
    motion = [u]
    for _ in range(steps):
        guess = u + v + (0.5 - beta) * a
        after = -(angle**2) * ((1 + alpha) * guess - alpha * u) / (1 + (1 + alpha) * beta * angle**2)
        u, v, a = guess + beta * after, v + (1 - gamma) * a + gamma * after, after
        motion.append(u)
    signs = np.flatnonzero(np.diff(np.signbit(motion)))
    crossings = signs + [motion[k] / (motion[k] - motion[k + 1]) for k in signs]
    period = 2 * (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    assert period / (2 * np.pi / angle) - 1 == pytest.approx(period_error(angle, alpha), rel=0.01)


def test_the_frequency_of_a_sine_is_found() -> None:
    t = np.arange(80) / 4000
    motion = np.sin(2 * np.pi * 200 * t)[:, None, None] * np.ones((3, 2))
    motion[7:9] = np.nan
    assert angular_frequency(motion, 4000.0) == pytest.approx(2 * np.pi * 200, rel=0.02)


def test_what_is_left_of_a_shift_falls_with_the_square() -> None:
    """Errors c h^2 and c (r h)^2: their difference is c h^2 (r^2 - 1)."""
    assert remainder(1.25) == pytest.approx(1 / (1.25**2 - 1))
    assert remainder(2.0) == 1.0


def test_the_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["identify", "--help"])
    message = capsys.readouterr().out
    for part in ("examples:", "[identify]", "--resume", "hardly informed", "Delete its contact"):
        assert part in message
    table = re.search(r"\n  \[identify\]\n(.*?)\n\n", message, re.DOTALL)
    assert table is not None
    import tomllib

    chosen = Settings(**tomllib.loads("[identify]\n" + table[1])["identify"])
    assert chosen.parameters[1].median == 30e3
    assert chosen.heights == (-4.5e-3, -2e-3, -0.2e-3)
