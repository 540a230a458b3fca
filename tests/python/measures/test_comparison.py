"""Differences between two records: their intervals against Welch's, exact changes, how often they hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from plica.measures.comparison import changes
from plica.measures.cycles import Cycles
from plica.measures.glottal import area_measures, frequency_measures, quotient_measures
from plica.measures.interval import Replicates, difference_interval, of_mean
from plica.measures.measure import Measure, Measures, average_angle, per_cycle, per_cycle_angle, whole
from plica.measures.measured import Measured
from plica.measures.perturbation import perturbation_measures
from plica.measures.recorded import recorded_cycles
from plica.measures.scale import Scale
from plica.measures.thresholds import mark_shares
from plica.measures.uncertainty import Bound
from plica.report.comparison import change_row
from voices import scattered


def test_a_side_that_does_not_scatter_leaves_the_interval_of_the_other() -> None:
    drawn = of_mean(np.random.default_rng(1).standard_normal(40))
    low, high = difference_interval(Replicates(np.full(2000, 3.0), 40), drawn)
    assert (low + 3, high + 3) == pytest.approx(drawn.interval, abs=0.03)  # percentiles of 2000 draws
    still = Replicates(np.full(2000, 2.0), 5)
    assert difference_interval(still, still) == (0, 0)


def test_the_uncertainty_of_a_recorded_measure_is_half_of_its_interval() -> None:
    drawn = of_mean(np.random.default_rng(1).standard_normal(40))
    recorded: Measured = Measure("peak_flow", 0.0, 1.0, 40, replicates=drawn)
    low, high = drawn.interval
    assert recorded.uncertainty == pytest.approx(0.5 * (high - low))
    assert "95 % interval" in recorded.uncertainty_source
    simulated: Measured = Measure("peak_flow", 0.0, 1.0, 40)
    assert (simulated.uncertainty, simulated.uncertainty_source) == (None, "")


@pytest.mark.parametrize("sizes", [(8, 8), (12, 40), (60, 60)])
def test_the_interval_of_normal_values_is_that_of_welch(sizes: tuple[int, int]) -> None:
    random = np.random.default_rng(sum(sizes))
    lengths, middles = [], []
    for _ in range(60):
        one, other = random.standard_normal(sizes[0]), 2 * random.standard_normal(sizes[1])
        low, high = difference_interval(of_mean(one), of_mean(other))
        exact = stats.ttest_ind(other, one, equal_var=False).confidence_interval(0.95)
        lengths.append((high - low) / (exact.high - exact.low))
        middles.append((low + high - exact.low - exact.high) / (exact.high - exact.low))
    # Blocks of four know the scatter of 60 values less well: a wider quantile and fewer of them.
    assert np.mean(lengths) == pytest.approx(1, abs=0.06)
    assert np.abs(middles).mean() < 0.15


def test_the_same_record_twice_differs_by_nought_within_the_interval() -> None:
    values = 5 + np.random.default_rng(0).standard_normal(20)
    item = per_cycle("period", Cycles(np.arange(21.0), recorded=True), values)
    (change,) = changes(Measures([item]), Measures([item]))
    assert change.difference == 0
    assert change.interval[0] < 0 < change.interval[1]
    assert not change.beyond_scatter


@pytest.mark.parametrize(
    ("difference", "expected"),
    [
        (0.0, ()),
        (0.019, ("between single cycles", "numerical uncertainty")),
        (0.021, ("numerical uncertainty",)),  # the larger spread is 0.02
        (-0.0699, ("numerical uncertainty",)),  # 0.03 + 0.04
        (-0.0701, ()),
    ],
)
def test_a_difference_of_runs_says_what_else_may_explain_it(
    difference: float, expected: tuple[str, ...]
) -> None:
    one = Measure("open_quotient", 0.5, 0.01, 9, bound=Bound(0.03, "plica uncertainty"))
    other = Measure("open_quotient", 0.5 + difference, 0.02, 9, bound=Bound(0.04, "plica uncertainty"))
    (change,) = changes(Measures([one]), Measures([other]))
    assert len(change.cautions) == len(expected)
    for text, part in zip(change.cautions, expected, strict=True):
        assert part in text
    (unknown,) = changes(Measures([replace(one, bound=None)]), Measures([other]))
    assert any("numerical" in text for text in unknown.cautions) == (0 < abs(difference) < 0.04)


def test_a_difference_with_an_interval_has_no_other_judge() -> None:
    cycles = Cycles(np.arange(21.0), recorded=True)
    one, other = (
        Measures([per_cycle("period", cycles, 5 + np.random.default_rng(k).standard_normal(20))])
        for k in (0, 1)
    )
    (change,) = changes(one, other)
    assert change.interval is not None
    assert not any("the difference is" in text for text in change.cautions)


def test_a_phase_turns_the_short_way() -> None:
    random, cycles = np.random.default_rng(2), Cycles(np.arange(31.0), recorded=True)
    one, other = (
        Measures([per_cycle_angle("left_right_phase", cycles, middle + 0.05 * random.standard_normal(30))])
        for middle in (3.1, -3.1)
    )
    (change,) = changes(one, other)
    assert change.difference == pytest.approx(2 * np.pi - 6.2, abs=0.03)
    assert change.interval[0] < 2 * np.pi - 6.2 < change.interval[1]
    assert change.beyond_scatter


def test_what_cannot_be_compared_has_its_reason_and_no_difference() -> None:
    px, si = Scale("px"), Scale()
    one = Measures([whole("glottal_length", 80.0), average_angle("left_right_phase", np.zeros(3))], px)
    other = Measures([whole("glottal_length", 4e-3), whole("steps", 3.0)], si)
    (change,) = changes(one, other)  # what only one has is not there
    assert (change.difference, change.interval) == (None, None)
    assert change.withheld == "in px before and in m after"
    none = Measures([Measure("glottal_length", None, note="no midline")], px)
    (change,) = changes(Measures([whole("glottal_length", 80.0)], px), none)
    assert change.withheld == "no value after: no midline"
    (change,) = changes(none, none)
    assert change.withheld == "no value before and after: no midline"
    (change,) = changes(one, one, {"glottal_length": "of two places"})[:1]
    assert (change.difference, change.withheld) == (None, "of two places")


def test_cautions_name_the_side_that_they_are_of() -> None:
    one = whole("glottal_length", 1.0, cautions=["blurred", "cut"])
    other = whole("glottal_length", 2.0, cautions=["cut", "dark"])
    (change,) = changes(Measures([one]), Measures([other]))
    assert change.cautions == ("both: cut", "before: blurred", "after: dark")
    assert change.interval is None  # of a whole record
    assert change.as_json()["difference"] == 1


FRAMES = 30  # a cycle
SCATTER = 0.01  # of a pulse's share of the period


def measured(seed: int, period: float, height: float, jitter: float, width: float) -> Measures:
    """Of 40 cycles whose pulses sin^1.5 take `width` of the period."""
    random = np.random.default_rng(seed)
    periods, heights = scattered(40, jitter, 0.02, seed)
    edges = np.concatenate([[0], np.cumsum(periods * period / 5e-3)])
    time = period / FRAMES * (np.arange(int(edges[-1] / period * FRAMES)) + random.uniform(0.1, 0.9))
    cycle = np.searchsorted(edges, time, side="right") - 1
    widths = width + SCATTER * random.standard_normal(40)
    share = (time - edges[cycle]) / np.diff(edges)[cycle] / widths[cycle]
    pulse = np.where(share < 1, np.sin(np.pi * np.minimum(share, 1)) ** 1.5, 0)
    area = height * heights[cycle] * pulse
    cycles = recorded_cycles(time, area)
    return Measures(
        [
            *frequency_measures(time, area, cycles),
            *quotient_measures(time, area, cycles),
            *area_measures(time, area, cycles),
            *perturbation_measures(time, area, cycles),
        ]
    )


def exact(period: float, height: float, jitter: float, width: float) -> dict[str, float]:
    """In closed form. A mark is c of a period after its cycle's beginning, so that two neighbouring periods
    from mark to mark differ by (1 - c) T_1 - (1 - 2 c) T_2 - c T_3 and by the scatter of c."""
    place = float(np.mean(np.arcsin(np.array(mark_shares) ** (2 / 3)))) / np.pi
    c = width * place
    variance = jitter**2 * ((1 - c) ** 2 + (1 - 2 * c) ** 2 + c**2) + 6 * (SCATTER * place) ** 2
    return {
        "fundamental_frequency": 1 / period,
        "period": period,
        "open_quotient": width * (1 - 2 / np.pi * np.arcsin(0.05 ** (2 / 3))),
        "glottal_area_max": height,
        "jitter": float(np.sqrt(2 / np.pi * variance)),
    }


VOICE = {"period": 5e-3, "height": 10.0, "jitter": 0.01, "width": 0.6}


@pytest.mark.slow
@pytest.mark.parametrize("change", [{}, {"period": 4.5e-3, "height": 8.0, "jitter": 0.03, "width": 0.5}])
def test_intervals_of_differences_hold_the_true_change_as_often_as_they_say(change: dict) -> None:
    draws, held = 44, dict.fromkeys(exact(**VOICE), 0)
    true = {name: value - exact(**VOICE)[name] for name, value in exact(**VOICE | change).items()}
    for seed in range(draws):
        for one in changes(measured(2 * seed, **VOICE), measured(2 * seed + 1, **VOICE | change)):
            if one.name in held:
                held[one.name] += one.interval[0] <= true[one.name] <= one.interval[1]
    shares = np.array(list(held.values())) / draws
    # 44 at 95 %: a standard deviation of 3.3 %; hundreds of draws are in docs/verification.md.
    assert 0.88 <= shares.mean() <= 0.99
    assert (shares >= 0.86).all(), held


def test_differences_have_the_digits_of_their_values_however_small_they_are() -> None:
    def shown(name: str, before: float, after: float) -> str:
        (change,) = changes(Measures([whole(name, before)]), Measures([whole(name, after)]))
        return change_row(change, []).difference

    assert shown("energy_balance_error", 8.7e-10, 8.72e-10) == "+2.0 × 10⁻¹²"
    assert shown("energy_balance_error", 8.72e-10, 8.7e-10) == "−2.0 × 10⁻¹²"
    assert shown("energy_balance_error", 8.7e-14, 9.7e-14) == "+1.00 × 10⁻¹⁴"
    assert shown("energy_balance_error", 8.7e-10, 8.7e-10 * (1 + 1e-9)) == "0"
    assert shown("peak_flow", 400e-6, 401.5e-6) == "+1.5 ml/s"
    assert shown("mean_iterations", 3.25, 3.125) == "−0.125"
