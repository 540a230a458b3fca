"""Strain and waves of the tissue's motion, against planted fields and waves."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from plica.measures.cycles import Cycles
from plica.measures.measure import Measures
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import chain
from plica.video.analysis import Analysis, analyse, load
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.glottis.midline import Midline, pixels
from plica.video.measures.wave_measures import wave_measures
from plica.video.motion.mucosal_wave import fundamental, wave_numbers, why_unknown
from plica.video.settings import Settings
from stored_files import forget, rewrite

_SHAPE, _FRAMES, _PERIOD = (80, 96), 61, 14.3
_LINE = Midline((47.5, 8.0), (47.5, 72.0))
_TIME = np.arange(float(_FRAMES))
_CYCLES = Cycles(_PERIOD * np.arange(5.0), recorded=True)
_ALL = np.ones(_SHAPE, dtype=bool)


def _flows(phasor: np.ndarray, second: np.ndarray | float = 0.0) -> np.ndarray:
    """(frames - 1, h, w, 2) of a motion with these amplitudes at the fundamental and its double."""
    turn = 2j * np.pi * _TIME[:, None, None, None] / _PERIOD
    return np.diff((phasor * np.exp(turn) + second * np.exp(2 * turn)).real, axis=0)


def _linear(gradient: np.ndarray) -> np.ndarray:
    return (pixels(_SHAPE) - 40) @ gradient.T


def test_a_linear_field_has_its_strain_at_every_pixel_of_tissue_up_to_its_border() -> None:
    gradient = np.array([[0.02 + 0.01j, 0.004], [0.01j, -0.03]])
    tissue = np.hypot(*np.moveaxis(pixels(_SHAPE) - 40, -1, 0)) > 12  # a hole, as a glottis is one
    found = fundamental(_flows(_linear(gradient), 0.3), _CYCLES, _TIME, tissue, _LINE)
    assert np.isnan(found.strain[~tissue]).all()
    expected = [gradient[0, 0], gradient[1, 1], 0.5 * (gradient[0, 1] + gradient[1, 0])]
    np.testing.assert_allclose(found.strain[tissue], np.tile(expected, (tissue.sum(), 1)), atol=1e-10)
    np.testing.assert_allclose(found.displacement[tissue], _linear(gradient)[tissue], atol=1e-9)


def test_strain_is_in_the_axes_of_the_midline_and_a_turn_of_the_whole_is_none() -> None:
    turned = Midline((30.0, 8.0), (60.0, 72.0))
    across = np.outer(turned.across, turned.across) * 0.05
    spin = np.array([[0.0, 0.02], [-0.02, 0.0]])
    found = fundamental(_flows(_linear(across + spin) + 0j), _CYCLES, _TIME, _ALL, turned)
    np.testing.assert_allclose(found.strain[40, 40], [0.05, 0, 0], atol=1e-10)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("speed", [1.5, 4.0])  # px a frame
def test_a_wave_that_runs_outward_has_its_speed(side: int, speed: float) -> None:
    distance = np.abs(pixels(_SHAPE)[..., 0] - 47.5)
    sign = np.sign(pixels(_SHAPE)[..., 0] - 47.5)
    number = 2 * np.pi / _PERIOD / speed
    outward = 2 * np.exp(-distance / 20 - 1j * number * distance)
    phasor = np.stack([sign * outward, 0 * outward], axis=-1)
    noise = 0.05 * np.random.default_rng(1).standard_normal((_FRAMES - 1, *_SHAPE, 2))
    found = fundamental(_flows(phasor) + noise, _CYCLES, _TIME, distance > 6, _LINE)
    numbers = wave_numbers(found.displacement, _LINE, side)
    assert numbers.size == 6
    assert numbers.mean() == pytest.approx(number, rel=0.03)


def test_a_standing_motion_has_no_wave_number() -> None:
    distance = np.abs(pixels(_SHAPE)[..., 0] - 47.5)
    phasor = np.stack(
        [np.sign(pixels(_SHAPE)[..., 0] - 47.5) * np.exp(-distance / 20 + 0.7j), 0 * distance], -1
    )
    found = fundamental(_flows(phasor), _CYCLES, _TIME, distance > 6, _LINE)
    np.testing.assert_allclose(wave_numbers(found.displacement, _LINE, 1), 0, atol=1e-6)


def _measured(phasor: np.ndarray, *, mirrored: bool = False) -> Measures:
    distance = np.abs(pixels(_SHAPE)[..., 0] - 47.5)
    noise = 0.02 * np.random.default_rng(1).standard_normal((_FRAMES - 1, *_SHAPE, 2))
    found = fundamental(_flows(phasor) + noise, _CYCLES, _TIME, distance > 6, _LINE)
    return Measures(wave_measures(found, _LINE, _ALL, _PERIOD, 1e-4, 4000.0, mirrored=mirrored))


def test_the_speed_of_a_wave_is_in_metres_a_second_with_an_interval_that_holds_it() -> None:
    offset = pixels(_SHAPE)[..., 0] - 47.5
    distance, right = np.abs(offset), offset > 0
    speed = np.where(right, 2.0, 5.0)  # px a frame, of 0.1 mm and 0.25 ms: 0.8 and 2 m/s
    outward = 2 * np.exp(-distance / 20 - 2j * np.pi / _PERIOD / speed * distance)
    phasor = np.stack([np.sign(offset) * outward, 0 * outward], axis=-1)
    found = _measured(phasor)
    for side, true in (("right", 0.8), ("left", 2.0)):
        item = found[f"mucosal_wave_speed_{side}"]
        assert item.value == pytest.approx(true, rel=0.05)
        assert item.interval[0] < true < item.interval[1]
        assert item.unit == "m/s"
    changed = _measured(phasor, mirrored=True)
    assert changed["mucosal_wave_speed_left"].value == found["mucosal_wave_speed_right"].value


def test_where_no_wave_runs_there_is_no_speed_and_strain_is_that_of_the_field() -> None:
    found = _measured(_linear(np.array([[0.03, 0.0], [0.0, 0.0]])) + 0j)
    assert found["mucosal_wave_speed_left"].value is None
    assert (
        "14 px or more: 0; 3 are needed" in found["mucosal_wave_speed_left"].note
    )  # it moves too near to its far end
    assert found["mucosal_wave_speed_right"].value is None
    assert "no outward wave" in found["mucosal_wave_speed_right"].note
    assert found["strain_amplitude_across"].value == pytest.approx(0.03, rel=0.1)  # noise adds to it
    rate = found["strain_rate_amplitude_across"].value / found["strain_amplitude_across"].value
    assert rate == pytest.approx(2 * np.pi * 4000 / _PERIOD)


@pytest.mark.parametrize("period", [3.0, 4.0, 5.0, 6.0, 6 * (1 + 1e-6), 7.0, 7.5, 12.0])
def test_a_cycle_of_few_frames_has_its_amplitude(period: float) -> None:
    turn = 2 * np.pi * _TIME / period + 0.4
    flows = np.diff(2 * np.cos(turn))[:, None, None, None] * np.array([1.0, 0.5])
    cycles = Cycles(period * np.arange(_FRAMES // period))
    found = fundamental(np.broadcast_to(flows, (_FRAMES - 1, 6, 6, 2)), cycles, _TIME, _ALL[:6, :6], _LINE)
    expected = 2 * np.exp(0.4j) * np.array([1.0, 0.5])
    np.testing.assert_allclose(found.displacement, np.broadcast_to(expected, (6, 6, 2)), atol=1e-9)


def test_the_time_of_frames_may_be_in_seconds() -> None:
    flows, step = _flows(_linear(np.eye(2) + 0j)), 2.5e-4
    frames = fundamental(flows, _CYCLES, _TIME, _ALL, _LINE)
    seconds = fundamental(flows, Cycles(step * _CYCLES.starts), step * _TIME, _ALL, _LINE)
    np.testing.assert_allclose(seconds.displacement, frames.displacement, atol=1e-9)


def test_without_cycles_nothing_is_known_and_why_is_said() -> None:
    flows = _flows(_linear(np.eye(2) + 0j))
    none = Cycles(np.empty(0), "too short")
    assert fundamental(flows, none, _TIME, _ALL, _LINE) is None
    assert why_unknown(none) == "too short"


def test_cycles_of_two_frames_have_no_fundamental() -> None:
    flows, two = _flows(_linear(np.eye(2) + 0j)), Cycles(np.arange(0.0, 30.0, 2.0))
    assert fundamental(flows, two, _TIME, _ALL, _LINE) is None
    assert why_unknown(two) == "a cycle has only 2 frames; it must have more than two"


@pytest.mark.parametrize(("period", "fewest"), [(5.0, 8), (7.0, 12), (14.3, 20)])
def test_two_pairs_for_each_unknown_are_enough_and_one_less_is_not(period: float, fewest: int) -> None:
    turn = np.exp(2j * np.pi * _TIME / period).real
    flows = np.broadcast_to(np.diff(turn)[:, None, None, None], (_FRAMES - 1, 6, 6, 2)).copy()
    cycles = Cycles(period * np.arange(4.0))
    flows[fewest:] = np.nan
    found = fundamental(flows, cycles, _TIME, _ALL[:6, :6], _LINE)
    np.testing.assert_allclose(found.displacement, 1, atol=1e-6)
    flows[fewest - 1] = np.nan
    assert fundamental(flows, cycles, _TIME, _ALL[:6, :6], _LINE) is None
    assert why_unknown(cycles) == f"fewer than {fewest} pairs of frames in the cycles show tissue"


_WAVES = [
    "strain_amplitude_across",
    "strain_rate_amplitude_across",
    "mucosal_wave_speed_left",
    "mucosal_wave_speed_right",
]


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """Three cycles of 6.67 frames; the flow, which would take its time, is a field that is given."""
    glottis = SyntheticGlottis(
        Synthetic(height=96, width=80, frames=30, frequency=0.15, amplitude=(5, 5), opening=(2, 2))
    )
    where = tmp_path_factory.mktemp("short")
    np.save(where / "short.npy", glottis.stack())
    given = iter(range(29))

    def known(before: np.ndarray, after: np.ndarray, **_: object) -> SimpleNamespace:
        x = pixels(before.shape)[..., 0] - 39.5
        k = next(given)
        wave = 2 * np.sign(x) * np.exp(-np.abs(x) / 20 - 0.3j * np.abs(x))
        u = np.diff((wave * np.exp(2j * np.pi * 0.15 * np.array([k, k + 1])[:, None, None])).real, axis=0)[0]
        flow = np.stack([u, 0 * u], axis=-1)
        light = SimpleNamespace(change=0.0, gain=np.ones(2))
        return SimpleNamespace(flow=flow, round_trip=0.01 * flow, residual=0 * u + 1, light=light)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chain, "flow", known)
        return analyse(where / "short.npy", where / "a", _SETTINGS, progress=False)


_SETTINGS = Settings(fps=4000, correct_drift=False, modes=1)


@pytest.mark.usefixtures("few_draws")
def test_three_cycles_of_few_frames_are_analysed_to_the_end(short: Analysis) -> None:
    assert short.cycles.count == 3
    first, last = short.cycles_in_frames.starts[[0, -1]]
    assert np.floor(last) - np.ceil(first) == 19  # pairs of frames: fewer than five harmonics would need
    assert short.measures["strain_amplitude_across"].value > 0
    assert short.measures["mucosal_wave_speed_left"].value > 0


@pytest.mark.usefixtures("few_draws")
def test_what_speaks_against_the_area_speaks_against_strain_and_waves(short: Analysis) -> None:
    few = "a cycle has only 6.7 frames"
    assert any(text.startswith(few) for text in short.doubts)
    for mirrored in (False, True):
        for item in short.wave_measures(mirrored=mirrored):
            assert any(text.startswith(few) for text in item.cautions), item.name


@pytest.mark.usefixtures("few_draws")
def test_what_is_unusual_about_the_cycles_is_said_of_strain_and_waves(
    short: Analysis, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = np.isin(np.arange(30), [14, 15])
    parts = {name: np.where(lost, np.nan, part) for name, part in short.area.parts.items()}
    found = load(short.directory)
    monkeypatch.setitem(vars(found), "area", GlottalArea(**parts))
    assert "the area of 2 of" in found.cycles.note
    for name in _WAVES:
        assert found.cycles.note in found.measures[name].cautions


@pytest.mark.usefixtures("few_draws")
def test_an_analysis_whose_pairs_show_too_little_says_so_and_ends(short: Analysis, tmp_path: Path) -> None:
    copy = load(shutil.copytree(short.directory, tmp_path / "a"))
    residual = copy["flow/residual"]
    residual[11:] = np.nan
    rewrite(copy.directory / "flow.h5", "residual", residual)
    forget(copy.path, "waves")
    found = analyse(copy.source, copy.directory, _SETTINGS, progress=False)
    assert found.fundamental is None
    for name in _WAVES:
        item = found.measures[name]
        assert item.value is None
        assert item.note == "fewer than 12 pairs of frames in the cycles show tissue"
