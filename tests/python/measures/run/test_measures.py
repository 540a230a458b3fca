import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic_run import AnalyticRun, Phonation, free_vibration
from plica.measures.cycles import Cycles, find_cycles
from plica.measures.file import write_measures
from plica.measures.glottal import over_cycles
from plica.measures.pulses import autocorrelation_frequency, rising_crossings
from plica.measures.run.free import free_measures
from plica.measures.run.measure import measure, steady_cycles
from voices import folds_apart, voice

# A frequency that no multiple of the step fits, so that nothing is exact by luck.
base = Phonation(frequency=213.7)


def value(run: AnalyticRun, name: str) -> float:
    found = measure(run)[name]
    assert found.value is not None, found.note
    return found.value


def test_frequency_and_period_are_those_of_the_motion() -> None:
    found = measure(base.run())
    # Crossings are interpolated linearly: error h^2 / 8 of the curvature, 1e-5 of the period here.
    assert found["fundamental_frequency"].value == pytest.approx(213.7, rel=1e-5)
    assert found["period"].value == pytest.approx(1 / 213.7, rel=1e-5)
    assert found["fundamental_frequency"].spread == pytest.approx(0.0, abs=0.1)
    assert found["fundamental_frequency"].cycles == 12  # of 12.8 periods, less the ends
    # A parabola through three samples of a correlation whose kinks are within a step.
    assert found["fundamental_frequency_autocorrelation"].value == pytest.approx(213.7, rel=2e-3)


@pytest.mark.parametrize(("name", "share"), [("open_quotient", 0.05), ("open_quotient_1_percent", 0.01)])
def test_open_quotient_is_the_time_above_its_share_of_the_largest_area(name: str, share: float) -> None:
    for gap in (0.1e-3, 0.25e-3, 0.4e-3):
        level = share * (gap + 0.5e-3)
        exact = np.arccos((level - gap) / 0.5e-3) / np.pi
        run = dataclasses.replace(base, gap=gap, impulse=0.0).run()
        # The jump to zero is placed in the middle of its step: at most half a step (0.011) at either end,
        # and as a rule a fifth of that in the mean.
        assert value(run, name) == pytest.approx(exact, abs=0.004)


def test_without_closure_the_glottis_is_always_open() -> None:
    run = dataclasses.replace(base, gap=0.8e-3, impulse=0.0).run()
    assert value(run, "open_quotient") == pytest.approx(1.0, abs=1e-12)
    # Least and largest area are half a period apart; the least is placed to half a step.
    assert value(run, "speed_quotient") == pytest.approx(1.0, abs=0.03)


def test_a_stopped_flow_counts_as_closed() -> None:
    run = dataclasses.replace(base, gap=0.8e-3, impulse=0.0).run()
    phase = (213.7 * run.time) % 1.0
    stopped = {**run.waveforms, "flow_stopped": (np.abs(phase - 0.5) < 0.15).astype(int)}
    # 0.3 of the period, each end placed to half a step of 0.0107 periods.
    assert value(dataclasses.replace(run, waveforms=stopped), "open_quotient") == pytest.approx(
        0.7, abs=0.003
    )


def test_speed_quotient_of_a_skewed_pulse_is_the_ratio_of_its_flanks() -> None:
    run = base.run()
    phase = (213.7 * run.time) % 1.0
    # Up over 0.4, down over 0.2, closed over 0.4 of the period.
    area = 1e-5 * np.clip(np.minimum(phase / 0.4, (0.6 - phase) / 0.2), 0.0, None)
    waveforms = {**run.waveforms, "minimum_area": area, "flow_stopped": (area <= 0).astype(int)}
    run = dataclasses.replace(run, waveforms=waveforms)
    # Flanks to half a step: 0.005 of 0.4 and 0.2; above 5 % of the largest area they are 5 % shorter.
    assert value(run, "speed_quotient") == pytest.approx(2.0, rel=0.06)
    assert value(run, "closing_quotient") == pytest.approx(0.95 * 0.2, abs=0.006)


def test_flow_and_area_are_bernoullis_at_the_widest_instant() -> None:
    run = base.run()
    area = np.pi * 7e-3 * 0.75e-3
    # The sample nearest to the maximum is at most half a step away: 1 - cos(pi f h) = 6e-4 of the amplitude.
    assert value(run, "glottal_area_max") == pytest.approx(area, rel=5e-4)
    assert value(run, "peak_flow") == pytest.approx(np.sqrt(2 * 800 / 1.23) * area, rel=5e-4)
    assert value(run, "minimum_flow") == 0.0
    assert value(run, "subglottal_pressure") == pytest.approx(800.0)
    # Mean of max(g + a cos, 0): (g theta + a sin theta) / pi with theta = arccos(-g / a). Trapezoid-like sum.
    theta = np.arccos(-0.5)
    mean = np.pi * 7e-3 * (0.25e-3 * theta + 0.5e-3 * np.sin(theta)) / np.pi
    assert value(run, "glottal_area_mean") == pytest.approx(mean, rel=5e-3)


open_run = dataclasses.replace(
    base,
    gap=0.6e-3,
    amplitude_left=0.2e-3,
    amplitude_right=0.1e-3,
    right_phase=0.4,
    vertical_lag=0.7,
    impulse=0.0,
)


def test_amplitudes_phase_and_vertical_lag_are_those_of_the_motion() -> None:
    run = open_run.run()
    # The extremes are sampled: 1 - cos(pi f h) = 6e-4.
    assert value(run, "amplitude_left") == pytest.approx(0.2e-3, rel=1e-3)
    assert value(run, "amplitude_right") == pytest.approx(0.1e-3, rel=1e-3)
    assert value(run, "amplitude_ratio") == pytest.approx(0.5, rel=2e-3)
    assert value(run, "amplitude_asymmetry") == pytest.approx(-1 / 3, rel=2e-3)
    # A cycle's ends are interpolated to 1e-3 of a step; interpolating in between changes no phase.
    assert value(run, "left_right_phase") == pytest.approx(-0.4, abs=1e-3)  # the right is ahead
    assert value(run, "vertical_phase_difference") == pytest.approx(0.7, abs=1e-3)


def test_what_a_symmetry_imposes_is_not_measured() -> None:
    run = open_run.run()
    mirrored = measure(dataclasses.replace(run, scene_text=f'symmetry = "half"\n{run.scene_text}'))
    for name in ("amplitude_ratio", "amplitude_asymmetry", "left_right_phase"):
        assert mirrored[name].value is None
        assert "symmetry" in mirrored[name].note
    assert mirrored["amplitude_left"].value == value(run, "amplitude_left")


def test_the_phase_is_positive_where_the_right_fold_lags() -> None:
    run = dataclasses.replace(open_run, right_phase=-0.4).run()
    assert value(run, "left_right_phase") == pytest.approx(0.4, abs=1e-3)


def test_a_lag_of_the_upper_edge_converges_while_opening_and_the_reverse_diverges() -> None:
    symmetric = dataclasses.replace(open_run, amplitude_right=0.2e-3, right_phase=0.0)
    # Near the turning points of the area the edges swap: 0.05 of either phase.
    assert value(symmetric.run(), "converging_while_opening") > 0.9
    assert value(symmetric.run(), "diverging_while_closing") > 0.9
    reverse = dataclasses.replace(symmetric, vertical_lag=-0.7).run()
    assert value(reverse, "converging_while_opening") < 0.1
    assert value(reverse, "diverging_while_closing") < 0.1


def test_each_collision_has_its_impulse_duration_and_forces() -> None:
    found = measure(base.run())
    assert found["contact_impulse"].cycles == found["fundamental_frequency"].cycles
    # A half-sine over 16 steps summed: 1 - pi^2 / (12 * 16^2) = 0.997; samples below 1 % are left out.
    assert found["contact_impulse"].value == pytest.approx(2e-6, rel=6e-3)
    # A whole number of steps: one step of sixteen.
    assert found["contact_duration"].value == pytest.approx(0.8e-3, abs=50e-6)
    peak = np.pi / 2 * 2e-6 / 0.8e-3
    for side in ("left", "right"):
        # The nearest sample to the top of the half-sine: 1 - cos(pi / 32) = 5e-3.
        assert found[f"contact_force_{side}_peak"].value == pytest.approx(peak, rel=5e-3)
        assert found[f"contact_force_{side}_mean"].value == pytest.approx(2e-6 / 0.8e-3, rel=0.07)
    assert found["contact_force_balance"].value == 0.0
    assert found["collisions"].value == 13


def test_a_violent_start_does_not_hide_the_collisions_that_follow() -> None:
    run = base.run()
    found = measure(run)
    for side, newton in (("first", -10.0), ("second", 10.0)):
        run.waveforms[f"contact_force_{side}"][3] = [newton, 0.0, 0.0]
    violent = measure(run)
    for name in ("contact_impulse", "contact_duration"):
        assert violent[name].value == pytest.approx(found[name].value, rel=1e-12)


def test_a_chattering_contact_is_one_collision() -> None:
    run = base.run()
    force = run.waveforms["contact_force_first"].copy()
    force[::3] = 0.0  # lost at every third step; the period has 94 steps
    found = measure(dataclasses.replace(run, waveforms={**run.waveforms, "contact_force_first": force}))
    assert found["collisions"].value == 13
    assert found["contact_impulse"].value == pytest.approx(2e-6 * 2 / 3, rel=0.05)


def test_an_unbalanced_force_is_reported() -> None:
    run = base.run()
    force = 0.9 * run.waveforms["contact_force_second"]
    run = dataclasses.replace(run, waveforms={**run.waveforms, "contact_force_second": force})
    assert value(run, "contact_force_balance") == pytest.approx(0.1, rel=1e-12)


def test_contact_pressure_is_averaged_over_its_stated_time() -> None:
    run = base.run()
    pressure = np.zeros(run.time.size)
    pressure[40::94] = 1000.0  # single steps of 50 us: a fourth of it in 0.2 ms
    run = dataclasses.replace(run, waveforms={**run.waveforms, "largest_contact_pressure": pressure})
    assert value(run, "peak_contact_pressure_step") == pytest.approx(1000.0)
    assert value(run, "peak_contact_pressure") == pytest.approx(250.0)
    assert "0.2 ms" in measure(run)["peak_contact_pressure"].note


def test_contact_length_is_a_fraction_of_the_fold_length() -> None:
    assert value(base.run(), "contact_length_fraction") == pytest.approx(0.4, rel=1e-12)
    assert value(base.run(), "contact_length_max") == pytest.approx(0.4 * 14e-3, rel=1e-12)


def test_the_energy_balance_error_is_relative_to_the_largest_energy() -> None:
    found = measure(base.run())
    run = base.run()
    assert found["energy_balance_error"].value == pytest.approx(
        np.abs(run.waveforms["energy_balance_error"]).max() / 1e-6
    )
    assert found["coupling_frozen_fraction"].value == pytest.approx(0.1)
    assert found["mean_iterations"].value == 9.0


def test_a_transient_is_left_out() -> None:
    found = measure(dataclasses.replace(base, rise_time=0.012).run())
    frequency = found["fundamental_frequency"]
    assert 3 <= frequency.cycles < 11
    # What is left of the transient shifts the closed phase, not the crossings by more than this.
    assert frequency.value == pytest.approx(213.7, rel=2e-3)


def test_a_growing_oscillation_is_called_not_settled() -> None:
    time = 50e-6 * np.arange(3000)
    cycles = find_cycles(time, np.exp(time / 0.02) * np.sin(2 * np.pi * 200 * time))
    assert cycles.count == 3
    assert "not settled" in cycles.note


def test_growth_per_cycle_is_the_relative_change_of_the_amplitude() -> None:
    run = dataclasses.replace(base, impulse=0.0).run()
    area = 1e-5 + 4e-6 * np.exp(-run.time / 1.0) * np.cos(2 * np.pi * 213.7 * run.time)
    run = dataclasses.replace(run, waveforms={**run.waveforms, "minimum_area": area})
    # A line through an exponential of 5 % in all, and extremes that are sampled to 6e-4 of the amplitude.
    assert value(run, "amplitude_growth") == pytest.approx(-1 / 213.7, rel=0.05)
    assert value(base.run(), "amplitude_growth") == pytest.approx(0.0, abs=1e-4)


def test_alternating_amplitudes_are_called_subharmonic_and_all_are_used() -> None:
    time = 50e-6 * np.arange(4000)
    signal = (1.0 + 0.3 * np.cos(2 * np.pi * 100 * time)) * np.cos(2 * np.pi * 200 * time)
    cycles = find_cycles(time, signal)
    assert cycles.count == 38  # of 39 complete ones: whole pairs
    assert cycles.verdict == "subharmonic"
    assert cycles.pattern == 2
    assert "200 Hz" in cycles.note
    assert "100 Hz" in cycles.note


def test_noise_near_the_level_makes_no_extra_cycles() -> None:
    time = 50e-6 * np.arange(4000)
    noise = np.random.default_rng(1).normal(0.0, 0.02, time.size)
    cycles = find_cycles(time, np.sin(2 * np.pi * 200 * time) + noise)
    # A crossing moves by noise over slope, 0.02 / (2 pi 200) s = 16 us of 5 ms; the mean of many by less.
    assert 1 / cycles.periods.mean() == pytest.approx(200.0, rel=1e-3)
    assert cycles.count >= 35


def test_ripples_between_pulses_are_not_cycles() -> None:
    time = 50e-6 * np.arange(1, 4001)
    phase = (200.3 * time) % 1.0
    pulse = np.where(phase < 0.4, np.sin(np.pi * phase / 0.4), 0.0)
    ripple = np.where(phase > 0.5, 0.6 * np.abs(np.sin(2 * np.pi * (phase - 0.5) / 0.5)), 0.0)
    signal = pulse + ripple
    assert rising_crossings(time, signal).size > 100  # three a period with a narrow hysteresis
    cycles = find_cycles(time, signal)
    assert 1 / cycles.periods.mean() == pytest.approx(200.3, rel=1e-3)
    assert cycles.verdict == "steady"
    assert "rises 3 times a cycle" in cycles.note


def test_a_weak_ripple_is_called_weak() -> None:
    time = 50e-6 * np.arange(4000)
    assert "weak" in find_cycles(time, 1.0 + 0.02 * np.sin(2 * np.pi * 200 * time)).note
    assert find_cycles(time, 1.0 + 0.2 * np.sin(2 * np.pi * 200 * time)).note == ""


def test_short_pulses_are_found_although_their_mean_is_low() -> None:
    time = 50e-6 * np.arange(4000)
    phase = (200.3 * time) % 1.0
    cycles = find_cycles(time, np.where(phase < 0.1, np.sin(np.pi * phase / 0.1), 0.0))
    assert 1 / cycles.periods.mean() == pytest.approx(200.3, rel=1e-3)


def test_autocorrelation_finds_the_pitch_of_a_waveform_with_a_weak_fundamental() -> None:
    time = 50e-6 * np.arange(4000)
    signal = 0.3 * np.sin(2 * np.pi * 150 * time) + np.sin(2 * np.pi * 300 * time)
    assert autocorrelation_frequency(signal, 50e-6) == pytest.approx(150.0, rel=1e-3)


def test_autocorrelation_without_a_positive_peak_names_no_frequency() -> None:
    # Up once and back over the record: what overlaps is never alike.
    time = 50e-6 * np.arange(40)
    signal = np.where(time < 1e-3, time, 2e-3 - time) ** 2
    ripple = 1e-3 * signal.max() * np.cos(2 * np.pi * 2000 * time)
    assert np.isnan(autocorrelation_frequency(signal * (time < 1.2e-3) + ripple, 50e-6))


def silent(run: AnalyticRun, area: float) -> AnalyticRun:
    constant = np.full(run.time.size, area)
    stopped = np.full(run.time.size, int(area == 0))
    flow = constant * np.sqrt(2 * 800 / 1.23)
    changed: dict[str, Any] = {"minimum_area": constant, "flow": flow, "flow_stopped": stopped}
    return dataclasses.replace(run, waveforms={**run.waveforms, **changed})


def test_a_silent_glottis_has_no_frequency_but_a_flow() -> None:
    found = measure(silent(dataclasses.replace(base, impulse=0.0).run(), 5e-6))
    for name in ("fundamental_frequency", "open_quotient", "amplitude_left", "left_right_phase"):
        assert found[name].value is None
        assert found[name].cycles == 0
        assert "no oscillation" in found[name].note
    assert found["mean_flow"].value == pytest.approx(5e-6 * np.sqrt(2 * 800 / 1.23))
    assert "last third" in found["mean_flow"].cautions[0]


def test_without_cycles_a_recording_is_measured_over_all_of_it_and_a_run_over_its_end() -> None:
    time, area = np.arange(30.0), np.r_[9.0, np.ones(29)]
    none = Cycles(np.empty(0), "too short")
    of_run, of_recording = (
        over_cycles("glottal_area_max", time, area, cycles, max)
        for cycles in (none, dataclasses.replace(none, recorded=True))
    )
    assert (of_run.value, of_recording.value) == (1.0, 9.0)
    assert of_run.cautions == ("over the last third of the record; too short",)
    assert of_recording.cautions == ("over the whole record; too short",)


def test_a_locked_closed_glottis_says_so() -> None:
    run = dataclasses.replace(base, impulse=0.0).run()
    area = np.where(run.time < 0.01, run.waveforms["minimum_area"], 0.0)
    found = measure(dataclasses.replace(run, waveforms={**run.waveforms, "minimum_area": area}))
    assert found["fundamental_frequency"].value is None
    assert "stays at zero" in found["fundamental_frequency"].note


def test_fewer_than_three_cycles_give_no_frequency_and_the_reason() -> None:
    found = measure(dataclasses.replace(base, steps=250).run())  # 2.7 periods
    assert found["fundamental_frequency"].value is None
    assert "too short" in found["fundamental_frequency"].note
    assert found["contact_impulse"].value is not None  # a collision needs no cycles


def test_an_interrupted_run_is_measured_as_far_as_it_came() -> None:
    run = base.run()
    waveforms = {name: values[:799] for name, values in run.waveforms.items()}
    found = measure(dataclasses.replace(run, time=run.time[:799], waveforms=waveforms))
    assert found["steps"].value == 799
    assert found["fundamental_frequency"].value == pytest.approx(213.7, rel=1e-5)
    assert found["mean_iterations"].value == 9.0


def test_a_residual_that_never_has_a_value_shortens_nothing() -> None:
    run = base.run()
    residual = np.full(run.time.size, np.nan)
    run = dataclasses.replace(run, waveforms={**run.waveforms, "coupling_residual": residual})
    assert value(run, "steps") == run.time.size


def test_a_run_without_a_step_has_no_measures_but_says_so() -> None:
    run = base.run()
    empty = {name: values[:0] for name, values in run.waveforms.items()}
    found = measure(dataclasses.replace(run, time=run.time[:0], waveforms=empty))
    assert list(found) == ["steps"]
    assert found["steps"].value == 0


def test_absent_parts_give_no_entries() -> None:
    without_contact = measure(dataclasses.replace(base, impulse=0.0).run())
    assert not [name for name in without_contact if "contact" in name or "collision" in name]
    assert "open_quotient" in without_contact
    free = measure(free_vibration())
    assert not [name for name in free if "flow" in name or "glottal" in name or "contact" in name]


def test_folds_that_never_touch_have_no_impulse() -> None:
    run = base.run()
    none = np.zeros((run.time.size, 3))
    run = dataclasses.replace(
        run, waveforms={**run.waveforms, "contact_force_first": none, "contact_force_second": none}
    )
    found = measure(run)
    assert found["contact_impulse"].value is None
    assert found["collisions"].value == 0
    assert found["contact_length_fraction"].value == 0.0


def test_free_vibration_has_its_frequency_and_damping() -> None:
    found = measure(free_vibration(frequency=120.0, damping_ratio=0.02))
    # Interpolated crossings of a decaying cosine, whose mean is not quite zero.
    assert found["fundamental_frequency"].value == pytest.approx(120.0, rel=1e-4)
    assert found["damping_ratio"].value == pytest.approx(0.02, rel=1e-3)
    assert found["fundamental_frequency"].cycles > 10


def test_a_damping_ratio_of_one_mode_has_no_caution_and_that_of_a_beat_has() -> None:
    time = 1e-4 * np.arange(1, 3001)
    work = np.zeros(time.size)
    for ratio in (0.001, 0.01, 0.05, -0.005):
        probes = (np.exp(-ratio * 628 * time) * np.cos(628 * time))[:, None, None] * np.ones(3)
        found, _ = free_measures(time, {"probes": probes, "load_work": work})
        (one,) = (item for item in found if item.name == "damping_ratio")
        assert one.value == pytest.approx(ratio, rel=1e-2)
        assert one.cautions == ()
    beat = np.exp(-6 * time) * (np.cos(628 * time) + 0.8 * np.cos(690 * time))
    found, _ = free_measures(time, {"probes": beat[:, None, None] * np.ones(3), "load_work": work})
    (one,) = (item for item in found if item.name == "damping_ratio")
    assert one.value is not None
    assert one.value < 0  # of three cycles, though both modes decay
    assert one.cautions[0].startswith("from 3 of 2")


def test_the_file_holds_every_measure_in_si_with_unit_spread_and_cycles(tmp_path: Path) -> None:
    found = measure(base.run())
    path = write_measures(found, tmp_path / "measures.json")
    read = json.loads(path.read_text())
    assert read.keys() == found.keys()
    assert all({"value", "unit", "spread", "cycles"} <= entry.keys() for entry in read.values())
    assert read["fundamental_frequency"]["unit"] == "Hz"
    assert list(tmp_path.iterdir()) == [path]


def test_one_cycle_has_no_growth_but_all_other_measures() -> None:
    run = base.run()
    cycles = find_cycles(run.time, run.waveforms["minimum_area"])
    found = measure(run, Cycles(cycles.starts[:2], verdict=cycles.verdict))
    assert found["amplitude_growth"].value is None
    assert found["amplitude_growth"].note
    assert found["open_quotient"].cycles == found["fundamental_frequency"].cycles == 1


def test_contact_without_a_period_is_of_the_last_third_and_says_so() -> None:
    run = Phonation(steps=3000).run()
    time, strong = run.time, np.where(run.time < 0.05, 5.0, 1.0)  # the onset is five times as hard
    pulses = np.interp(time, *voice(*folds_apart(), samples=100))
    waveforms = {**run.waveforms, "minimum_area": 1e-6 * pulses}
    for name in ("contact_force_first", "contact_force_second"):
        waveforms[name] = run.waveforms[name] * strong[:, None]
    for name in ("largest_contact_pressure", "contact_length", "contact_area"):
        waveforms[name] = run.waveforms[name] * strong
    ambiguous = dataclasses.replace(run, waveforms=waveforms)
    assert steady_cycles(ambiguous).verdict == "ambiguous"
    found, plain = measure(ambiguous), measure(run)
    for name in ("collisions", "contact_impulse", "contact_duration", "contact_force_left_mean"):
        assert found[name].value is None
        assert "pulses are no periods" in found[name].note
    for name in (
        "peak_contact_pressure",
        "contact_length_max",
        "contact_area_max",
        "contact_length_fraction",
    ):
        assert found[name].value == pytest.approx(plain[name].value, rel=1e-6), name
        (said,) = (
            text for text in found[name].cautions if "the last third of the run, 100 to 150 ms" in text
        )
        assert "pulses are no periods" in said
