"""Rank regression against exact coefficients; scenes of rankings and stretch against closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import plica
from benchmarks.validation import m5, rankings, stretch
from benchmarks.validation.rank_regression import ranking
from benchmarks.validation.thresholds import threshold


def factorial(levels: int) -> np.ndarray:
    """All pairs of levels: two parameters that are independent to the last digit."""
    first, second = np.meshgrid(np.arange(levels), np.arange(levels), indexing="ij")
    return np.stack((first.ravel(), second.ravel()), axis=1).astype(float)


def test_ranks_of_a_sum_of_independent_parameters_have_its_coefficients() -> None:
    x = factorial(6)
    found = ranking(x, np.exp(6 * x[:, 0] - x[:, 1]))  # its logarithm ranks like six to one
    assert found.coefficients == pytest.approx(np.array([6, -1]) / np.sqrt(37), abs=1e-12)
    assert found.explained == pytest.approx(1)
    assert found.first.tolist() == [1, 0]
    assert found.count == 36


def test_what_a_measure_does_not_follow_has_an_interval_about_nothing() -> None:
    x = np.random.default_rng(2).random((80, 3))
    found = ranking(x, x[:, 2] ** 3 + 0.3 * np.random.default_rng(3).random(80))
    assert found.low[2] > 0.8
    for k in (0, 1):
        assert found.low[k] < 0 < found.high[k]
    wider = ranking(x[:20], x[:20, 2] + np.random.default_rng(3).random(20))
    assert wider.high[2] - wider.low[2] > 2 * (found.high[2] - found.low[2])


def test_cases_without_a_value_are_left_out_and_too_few_are_refused() -> None:
    x = factorial(4)
    y = x[:, 0].copy()
    y[3:5] = np.nan
    assert ranking(x, y).count == 14
    with pytest.raises(ValueError, match="4 cases for 2 parameters"):
        ranking(x[:4], y[6:10])


def test_the_centre_of_the_ranges_is_the_preset() -> None:
    scene, preset = rankings.scene_of(rankings.centre()), plica.Scene.of_voice("female")
    for layer, tissue in preset.tissue.items():
        for name in ("E", "nu", "E_fibre", "nu_fibre", "mu_fibre", "viscosity"):
            assert getattr(scene.tissue[layer], name) == pytest.approx(getattr(tissue, name), rel=1e-12)
    assert scene.mesh.folds == preset.mesh.folds
    for name, (low, high) in rankings.RANGES.items():
        assert low < rankings.centre()[name] < high


def compressibility(tissue: plica.Tissue) -> float:
    """E over the bulk modulus, by the compliance of the three normal directions, the fibre's the second."""
    across = [1 / tissue.E, -tissue.nu_fibre / tissue.E_fibre, -tissue.nu / tissue.E]
    along = [-tissue.nu_fibre / tissue.E_fibre, 1 / tissue.E_fibre, -tissue.nu_fibre / tissue.E_fibre]
    compliance = np.array([across, along, across[::-1]])
    assert np.linalg.eigvalsh(compliance).min() > 0
    return tissue.E * float(compliance.sum())


@pytest.mark.parametrize("along", [0.6, 2.0])
@pytest.mark.parametrize("across", [0.7, 2.0])
def test_stiffer_tissue_is_as_compressible_as_the_preset(across: float, along: float) -> None:
    place = rankings.centre() | {"E across": across, "E along": along}
    preset = plica.Scene.of_voice("female").tissue
    for layer, tissue in rankings.scene_of(place).tissue.items():
        factors = [getattr(tissue, name) / getattr(preset[layer], name) for name in ("E", "E_fibre")]
        assert factors == pytest.approx([across, along])
        assert compressibility(tissue) == pytest.approx(compressibility(preset[layer]))


def test_voices_are_spread_evenly_over_each_range() -> None:
    places = rankings.places(16, seed=1)
    for name, (low, high) in rankings.RANGES.items():
        strata = [int(16 * (place[name] - low) / (high - low)) for place in places]
        assert sorted(strata) == list(range(16))


def test_the_string_law_has_its_published_frequencies() -> None:
    for voice, published in (("male", (61, 89, 131, 193, 287)), ("female", (115, 153, 205, 277, 376))):
        found = [stretch.string_law(voice, elongation) for elongation in stretch.ELONGATIONS]
        assert found == pytest.approx(published, abs=0.6)


@pytest.mark.slow
def test_a_replica_is_stretched_evenly_and_a_threshold_is_a_crossing_of_onset(tmp_path: Path) -> None:
    posture = {"elongation": 0.2, "contraction": 0.5}
    scene = stretch.postured(stretch.replica(tmp_path, 7e3, 7e3), posture)
    y = np.asarray(plica.scene_mesh(scene).points)[:, 1]
    assert np.ptp(y) == pytest.approx(1.2e-3 * m5.LENGTH)
    found = threshold(scene, zeta=0.06, reach=400.0)
    full = plica.onset(scene, stop=400.0, modes=40, zeta=0.06)
    begins = [one for one in full.crossings if one.grows_above]  # the first is of a window of 10 Pa
    nearest = min(begins, key=lambda one: abs(one.pressure - found.pressure))
    assert found.pressure == pytest.approx(nearest.pressure, rel=3e-3)
    assert found.frequency == pytest.approx(nearest.frequency, rel=1e-3)
