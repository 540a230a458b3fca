"""What a vocal tract adds to the harmonics of a sound, and what is left of them without it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import plica
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.harmonics import harmonic_levels, level_difference
from plica.measures.measure import Measure
from plica.measures.run.sound import radiation_measures
from plica.measures.run.tract import tract_measures
from plica.runs.tubes import known_tract, tract_formants, tract_response
from repository import ROOT
from voices import lf_pulse

STEP = 20e-6
_SCENE = "[airflow]\nair_density = 1.14\n"


def vowel(name: str, **options: object) -> TractResponse:
    return tract_response(plica.Tract(vowel={"name": name}, **options), plica.Airflow())


def at_the_lips(tract: TractResponse, flow: np.ndarray) -> np.ndarray:
    """The flow at the lips by the exact motion of E x' = A x + e_0 U, U linear in each step."""
    size = tract.storage.size
    whole = np.zeros((size + 2, size + 2))
    whole[:size, :size] = tract.rates / tract.storage[:, None]
    whole[0, size] = 1 / tract.storage[0]
    whole[size, size + 1] = 1 / STEP
    moved = expm(STEP * whole)[:size]
    state, found = np.zeros(size), np.zeros(flow.size)
    for k in range(1, flow.size):
        state = moved @ np.concatenate((state, [flow[k - 1], flow[k] - flow[k - 1]]))
        found[k] = tract.outflow @ state
    return found


def measured(
    tract: TractResponse, frequency: float, seconds: float = 0.4
) -> tuple[dict[str, Measure], dict[str, float]]:
    """Measures of pulses through the tract, and the differences of their slope's harmonics."""
    _, pulse, _ = lf_pulse(1 / frequency, 1e-7, 3e-4)
    time = STEP * np.arange(1, round(seconds / STEP) + 1)
    flow = np.interp(time % (1 / frequency), 1e-7 * np.arange(pulse.size), pulse)
    cycles = Cycles(0.3 + np.arange(int((seconds - 0.32) * frequency)) / frequency)
    waves = {"flow": flow, "lip_flow": at_the_lips(tract, flow)}
    sound = {item.name: item for item in radiation_measures(time, waves, _SCENE, cycles, 800.0)}
    levels = harmonic_levels(time, flow, cycles)
    known = {
        f"sound_h{one}_h{other}_corrected": float(level_difference(levels, one, other).mean())
        + 20 * np.log10(one / other)
        for one, other in ((1, 2), (2, 4))
    }
    return {item.name: item for item in (*sound.values(), *tract_measures(tract, sound, cycles))}, known


@pytest.mark.parametrize("name", ["schwa", "a", "i", "u"])
@pytest.mark.parametrize("frequency", [117.3, 258.0])
def test_without_the_tract_harmonics_are_those_of_what_enters_it(name: str, frequency: float) -> None:
    """Also of /i/ at 258 Hz, whose first harmonic is 23 Hz below its first formant."""
    found, known = measured(vowel(name), frequency)
    for corrected, value in known.items():
        raw = found[corrected.removesuffix("_corrected")]
        assert raw.value is not None
        assert abs(raw.value - value) > 0.3
        assert found[corrected].value == pytest.approx(value, abs=0.02)
        assert found[corrected].cycles == raw.cycles > 0


def test_formants_are_those_of_the_model() -> None:
    tract = vowel("a")
    found = {item.name: item.value for item in tract_measures(tract, *_none())}
    for k, formant in enumerate(tract.formants()[:4], 1):
        assert found[f"formant_{k}"] == formant.frequency
        assert found[f"formant_{k}_bandwidth"] == formant.bandwidth


def test_a_short_tract_has_few_formants() -> None:
    tube = plica.Tract(uniform={"length": 0.05, "area": 3e-4}, wall="rigid")
    tract = tract_response(tube, plica.Airflow())
    count = len(tract.formants())
    assert count in (1, 2)
    found = {item.name: item for item in tract_measures(tract, *_none())}
    assert count < 4
    assert found["formant_4"].value is None
    assert found["formant_4"].note == f"the tract has {count} resonances up to 5000 Hz"


def test_a_tract_of_too_many_elements_says_so_instead_of_formants() -> None:
    """Whose resonances would take minutes, and tens of metres hours."""
    air = plica.Airflow()
    tract = plica.Tract(uniform={"length": 2.1, "area": 3e-4})
    with pytest.raises(plica.InvalidInput, match=r"tract: has 525 elements.* must have at most 500"):
        tract_formants(tract, air)
    assert tract_formants(plica.Tract(uniform={"length": 0.5, "area": 3e-4}), air)
    scene = plica.Scene.load(ROOT / "examples" / "vowel.toml").replace({"tract": tract})
    why = known_tract(scene)
    assert isinstance(why, str)
    found = {item.name: item for item in tract_measures(why, *_none())}
    assert found["formant_1"].value is None
    assert found["sound_h1_h2_corrected"].note == why


def test_cycles_that_differ_beside_a_formant_are_doubted() -> None:
    tract = vowel("i")
    raw = {name: Measure(name, 5.0, 0.1, 20) for name in ("sound_h1_h2", "sound_h2_h4")}
    for frequency, scatter, doubted in ((258.0, 0.02, True), (258.0, 0.001, False), (120.0, 0.02, False)):
        periods = (1 + scatter * np.array([-1, 1] * 10)) / frequency
        cycles = Cycles(np.concatenate(([0.0], np.cumsum(periods))))
        found = {item.name: item for item in tract_measures(tract, raw, cycles)}["sound_h1_h2_corrected"]
        assert (
            any("harmonic 1 is at 258 Hz, beside a formant of 28" in one for one in found.cautions) == doubted
        )


def _none() -> tuple[dict[str, Measure], Cycles]:
    sound = {name: Measure(name, None, note="silent") for name in ("sound_h1_h2", "sound_h2_h4")}
    return sound, Cycles(np.empty(0), "none", "none")


def test_a_sound_that_is_not_there_is_not_corrected() -> None:
    found = {item.name: item for item in tract_measures(vowel("u"), *_none())}
    assert found["sound_h1_h2_corrected"].value is None
    assert found["sound_h1_h2_corrected"].note == "silent"
