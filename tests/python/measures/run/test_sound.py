"""Measures of what a run radiates, against flows in closed form."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from analytic_run import AnalyticRun, Phonation
from plica.measures.catalogue import CATALOGUE, names
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, Measures
from plica.measures.run.measure import measure
from plica.measures.run.sound import radiation_measures
from plica.sound.far_field import far_field
from plica.sound.voice import sound_level
from plica.video.files.signal_file import Signal
from plica.video.measures.signal_measures import signal_measures
from voices import lf_pulse

_RHO, _PRESSURE, _F = 1.14, 800.0, 187.3
_SCENE = f"[airflow]\nair_density = {_RHO}\nsubglottal_pressure = {_PRESSURE}\n"


def radiated(
    flow: np.ndarray, step: float, cycles: Cycles, supply: float | None = _PRESSURE, **waves: np.ndarray
) -> dict[str, Measure]:
    time = step * np.arange(1, flow.size + 1)
    found = radiation_measures(time, {"flow": flow, **waves}, _SCENE, cycles, supply)
    return {item.name: item for item in found}


def _names(signal: str) -> set[str]:
    return {name for name in names(signal=signal) if CATALOGUE[name].source != "video"}


def cycles_of(frequency: float, count: int, first: float = 0.02) -> Cycles:
    return Cycles(first + np.arange(count + 1) / frequency)


def sine(step: float, amplitude: float = 1e-4, mean: float = 2e-4, seconds: float = 0.12) -> np.ndarray:
    time = step * np.arange(1, round(seconds / step) + 1)
    return mean + amplitude * np.sin(2 * np.pi * _F * time)


@pytest.mark.parametrize("step", [5e-6, 50e-6, 80e-6])
def test_level_and_efficiency_of_a_sine_are_those_of_the_small_source(step: float) -> None:
    amplitude, mean = 1e-4, 2e-4
    found = radiated(sine(step, amplitude, mean), step, cycles_of(_F, 12))
    omega = 2 * np.pi * _F
    pressure = _RHO * omega * amplitude / (4 * np.pi * 0.3) / np.sqrt(2)
    level, share = found["sound_pressure_level"], found["glottal_efficiency"]
    assert level.value == pytest.approx(20 * np.log10(pressure / 20e-6), abs=0.01)
    assert level.cycles == 12
    assert level.spread == pytest.approx(0.0, abs=0.01)
    # rho omega^2 |U|^2 / (8 pi c): the power of a small source in free air.
    power = _RHO * omega**2 * amplitude**2 / (8 * np.pi * 350.0)
    assert share.value == pytest.approx(power / (_PRESSURE * mean), rel=2e-3)
    assert level.note == "of the glottal flow, as there is no tract"


def test_the_level_of_cycles_without_an_end_is_that_of_the_last_third() -> None:
    step = 50e-6
    none = Cycles(np.empty(0), "no oscillation", "none")
    item = radiated(sine(step), step, none)["sound_pressure_level"]
    wanted = sound_level(_RHO * 2 * np.pi * _F * 1e-4 / (4 * np.pi * 0.3) / np.sqrt(2))
    assert item.value == pytest.approx(wanted, abs=0.2)  # of seven periods and a half
    assert item.cautions == ("over the last third of the record; no oscillation",)
    still = radiated(np.full(2400, 1e-4), step, none)["sound_pressure_level"]
    assert still.value is None
    assert still.note == "silent; no oscillation"


def test_the_subglottal_pressure_of_the_run_goes_before_that_of_the_scene() -> None:
    step = 50e-6
    swinging = 1000.0 + 300.0 * np.cos(2 * np.pi * _F * step * np.arange(1, 2401))
    scene, run = (
        radiated(sine(step), step, cycles_of(_F, 12), **waves)["glottal_efficiency"]
        for waves in ({}, {"subglottal_pressure": swinging})
    )
    assert scene.value is not None
    assert run.value == pytest.approx(0.8 * scene.value, rel=1e-3)
    unknown = radiated(sine(step), step, cycles_of(_F, 12), None)["glottal_efficiency"]
    assert unknown.value is None
    assert "not known" in unknown.note


def test_the_flow_at_the_lips_makes_the_sound_and_the_glottal_flow_its_own_measures() -> None:
    step, cycles = 50e-6, cycles_of(_F, 12)
    time = step * np.arange(1, 2401)
    flow = sine(step) + 0.3e-4 * np.sin(4 * np.pi * _F * time)
    lips = sine(step) + 0.9e-4 * np.sin(4 * np.pi * _F * time)
    bare, tract = radiated(flow, step, cycles), radiated(flow, step, cycles, lip_flow=lips)
    assert bare["flow_h1_h2"].value == pytest.approx(20 * np.log10(1 / 0.3), abs=0.01)
    assert tract["flow_h1_h2"] == bare["flow_h1_h2"]
    assert bare["sound_h1_h2"].value == pytest.approx(20 * np.log10(1 / 0.6), abs=0.01)
    assert tract["sound_h1_h2"].value == pytest.approx(20 * np.log10(1 / 1.8), abs=0.01)
    assert tract["sound_h1_h2"].note == "of the flow at the lips"


def test_a_step_that_is_too_long_is_said_to_be() -> None:
    step = 120e-6
    found = radiated(sine(step), step, cycles_of(_F, 12))
    assert (
        "time.step = 120 us leaves the sound up to 3750 Hz alone" in found["sound_pressure_level"].cautions[0]
    )
    assert found["flow_h1_h2"].cautions == ()
    fine = radiated(sine(50e-6), 50e-6, cycles_of(_F, 12))
    assert fine["sound_pressure_level"].cautions == ()


def test_a_flow_that_contact_stops_at_once_is_doubted_and_one_that_runs_out_is_not() -> None:
    step, cycles = 50e-6, cycles_of(_F, 12)
    phase = (_F * step * np.arange(1, 2401)) % 1.0
    for least, doubted in ((0.0, False), (0.3, True)):
        flow = 3e-4 * np.where(phase < 0.6, least + np.sin(np.pi * np.clip(phase / 0.6, 0, 1)), 0.0)
        found = radiated(flow, step, cycles, flow_stopped=(phase >= 0.6).astype(int))
        texts = " ".join(found["sound_pressure_level"].cautions)
        assert ("contact stops the flow at once, by 2" in texts) == doubted
        assert bool(found["maximum_flow_declination_rate"].cautions) == doubted


@pytest.mark.parametrize(
    ("flow", "why"),
    [
        (np.full(12, 1e-4), "the run has 12 steps; must have 16 or more"),
        (np.where(np.arange(400) == 9, np.nan, 1e-4), "the flow is no finite number in 1 steps"),
    ],
)
def test_what_has_no_sound_says_why_at_every_measure(flow: np.ndarray, why: str) -> None:
    cycles = Cycles(np.empty(0), "too short", "none")
    found = radiated(flow, 50e-6, cycles)
    whole = radiated(sine(50e-6), 50e-6, cycles)
    assert found.keys() == whole.keys() == {*_names("flow"), *_names("sound")}
    for name, item in found.items():
        assert item.value is None
        assert why in item.note or (name in _names("flow") and item.note == "too short")


def test_a_constant_flow_and_an_onset_before_the_cycles_change_nothing() -> None:
    """A transient at the start, ten times as loud, and leakage through a glottis that stays open."""
    step, cycles = 50e-6, cycles_of(_F, 12, 0.04)
    time = step * np.arange(1, 2401)
    plain = sine(step) + 0.3e-4 * np.sin(4 * np.pi * _F * time)
    start = np.where(
        time < 0.02, 1e-3 * np.sin(2 * np.pi * 900 * time) * np.cos(np.pi * time / 0.04) ** 2, 0.0
    )
    for other in (plain + 5e-4, plain + start):
        one, two = radiated(plain, step, cycles), radiated(other, step, cycles)
        for name, item in one.items():
            if name in ("glottal_efficiency", "sound_harmonics_to_noise") or item.value is None:
                continue
            assert two[name].value == pytest.approx(item.value, rel=2e-3, abs=2e-3), name


def test_a_microphone_and_the_run_that_it_hears_have_the_same_measures() -> None:
    run = dataclasses.replace(Phonation(frequency=_F, impulse=0.0), steps=3000).run()
    simulated = measure(run)
    heard = far_field(run.time, run.waveforms, run.scene_text)
    signal = Signal(heard.pressure, heard.rate, heard.begin)
    recorded = {
        item.name: item
        for item in signal_measures(signal, None, run.waveforms["minimum_area"], run.cycles, 20000.0).measures
    }
    for name, tolerance in (
        ("sound_h1_h2", 0.05),
        ("sound_h2_h4", 0.1),
        ("sound_cepstral_peak_prominence", 2.0),  # of some cycles more
        ("sound_harmonics_to_noise", 2.0),
    ):
        assert recorded[name].value == pytest.approx(simulated[name].value, abs=tolerance), name
        assert recorded[name].unit == simulated[name].unit
    assert recorded["sound_jitter"].value == pytest.approx(0.0, abs=1e-3)
    assert recorded["sound_h1_h2"].interval is not None
    assert simulated["sound_h1_h2"].interval is None


def voice(*, periods: np.ndarray, heights: np.ndarray, step: float = 50e-6) -> AnalyticRun:
    """A run whose cycles have these periods (s) and heights: flow and area are alike."""
    edges = np.concatenate(([0.0], np.cumsum(periods)))
    base = Phonation(step=step, steps=int(edges[-1] / step), impulse=0.0).run()
    cycle = np.clip(np.searchsorted(edges, base.time, side="right") - 1, 0, periods.size - 1)
    phase = (base.time - edges[cycle]) / periods[cycle]
    pulse = heights[cycle] * np.where(phase < 0.7, np.sin(np.pi * np.clip(phase / 0.7, 0, 1)) ** 2, 0.0)
    waves = {**base.waveforms, "minimum_area": 1e-5 * pulse, "flow": 3e-4 * pulse}
    waves["flow_stopped"] = np.zeros(base.time.size, dtype=int)
    return dataclasses.replace(base, waveforms=waves)


def test_jitter_and_shimmer_of_a_run_are_those_of_its_cycles() -> None:
    random = np.random.default_rng(6)
    periods = (1 + 0.004 * random.standard_normal(60)) / 150.0
    heights = 1 + 0.02 * random.standard_normal(60)
    run = voice(periods=periods, heights=heights)
    found: Measures = measure(run)
    assert run.cycles.count >= 55
    # A mark is where sin^2 of the phase passes 0.2, 0.3 and 0.4, whatever the height of the pulse.
    share = float(np.mean(0.7 / np.pi * np.arcsin(np.sqrt([0.2, 0.3, 0.4]))))
    between = np.diff(np.concatenate(([0.0], np.cumsum(periods)[:-1])) + share * periods)
    between = between[-run.cycles.count :]
    jitter = np.abs(np.diff(between)).mean() / between.mean()
    assert found["sound_jitter"].value == pytest.approx(jitter, rel=0.03)
    # The sound is the slope of sin^2, proportional to A / T sin(2 x), from flank to flank.
    fine = np.linspace(run.cycles.starts[0], run.cycles.starts[-1], 400_001)[:-1]
    edges = np.concatenate(([0.0], np.cumsum(periods)))
    k = np.searchsorted(edges, fine, side="right") - 1
    turn = np.clip((fine - edges[k]) / periods[k] / 0.7, 0, 1)
    square = (heights[k] / periods[k] * np.sin(2 * np.pi * turn)) ** 2
    cycle = np.searchsorted(run.cycles.starts, fine, side="right") - 1
    loud = np.sqrt(np.bincount(cycle, square) / np.bincount(cycle))
    assert found["sound_shimmer"].value == pytest.approx(np.abs(np.diff(loud)).mean() / loud.mean(), rel=0.03)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_few_cycles_have_values_or_reasons(count: int) -> None:
    run = voice(periods=np.full(count, 1 / 150.0), heights=np.ones(count))
    for item in measure(run).values():
        assert item.value is not None or item.note, item.name
        assert item.value is None or np.isfinite(item.value), item.name


@pytest.mark.parametrize("step", [50e-6, 100e-6])
def test_sampled_corners_are_within_what_the_notes_say(step: float) -> None:
    """Equal pulses with a corner: all that tells their cycles apart is how they are sampled."""
    peaks = []
    for frequency in (97.7, 137.3, 220.7, 313.3):
        _, flow, _ = lf_pulse(1 / frequency, step, 3e-4)
        found = radiated(flow, step, cycles_of(frequency, 7, 3 / frequency + step))
        noise, shimmer = found["sound_harmonics_to_noise"], found["sound_shimmer"]
        assert 20.0 < (noise.value or 0.0) < 35.0
        assert "leaves 20 to 30 dB" in noise.note
        limit = float(re.findall(r"makes up to (\S+) %", shimmer.note)[0])
        assert 100 * (shimmer.value or 0.0) <= 1.05 * limit
        fine = radiated(lf_pulse(1 / frequency, 5e-6, 3e-4)[1], 5e-6, cycles_of(frequency, 7, 3 / frequency))
        assert (fine["sound_harmonics_to_noise"].value or 99.0) > 40.0
        assert "sampled" not in fine["sound_shimmer"].note
        two = [one["sound_cepstral_peak_prominence"].value or 0.0 for one in (found, fine)]
        peaks.append(two[1] - two[0])
    assert max(peaks) < (6.0 if step == 50e-6 else 10.0)


def test_the_slopes_of_the_flow_are_known_where_its_sound_is_not() -> None:
    step, cycles = 50e-6, cycles_of(_F, 12)
    flow = sine(step)
    heard = radiated(flow, step, cycles)
    lips = np.full(flow.size, np.nan)
    for waves in ({"lip_flow": lips}, {"lip_flow": np.zeros(flow.size)}):
        found = radiated(flow, step, cycles, **waves)
        assert found["sound_pressure_level"].value is None
        for name in ("maximum_flow_declination_rate", "normalised_amplitude_quotient", "flow_h1_h2"):
            assert found[name] == heard[name]
    assert heard["maximum_flow_declination_rate"].value == pytest.approx(2 * np.pi * _F * 1e-4, rel=1e-3)
    flow[7] = np.nan
    broken = radiated(flow, step, cycles)["maximum_flow_declination_rate"]
    assert broken.value is None
    assert broken.note == "the flow is no finite number in 1 steps"


def test_an_end_that_reflects_is_doubted() -> None:
    step, cycles = 50e-6, cycles_of(_F, 12)
    time = step * np.arange(1, 2401)
    waves = {"flow": sine(step), "lip_flow": sine(step)}
    scene = _SCENE + "[tract.end.reflecting]\nreflection = 0\n"
    for text, doubted in ((scene, True), (_SCENE + '[tract]\nend = "reflecting"\n', True), (_SCENE, False)):
        found = {item.name: item for item in radiation_measures(time, waves, text, cycles, _PRESSURE)}
        level = found["sound_pressure_level"]
        assert any("tract.end reflects" in caution for caution in level.cautions) == doubted
        assert ("as if it left into a room" in level.note) == doubted
