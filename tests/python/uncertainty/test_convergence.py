"""The rule from levels to an uncertainty, on sequences whose limit is known."""

from __future__ import annotations

import numpy as np
import pytest

from plica.uncertainty.convergence import Level, converge, observed_order

LIMIT = 3.0


def levels(order: float, sizes: tuple[float, ...], factor: float = 0.2) -> list[Level]:
    return [Level(size, LIMIT + factor * size**order) for size in sizes]


@pytest.mark.parametrize("order", [0.5, 1.0, 1.7, 2.0, 3.0])
@pytest.mark.parametrize("sizes", [(1.0, 0.5, 0.25), (1.0, 0.8, 0.3), (2.0, 1.0, 0.7)])
@pytest.mark.parametrize("run", [0, 1, 2])
def test_three_levels_of_a_power_law_hold_its_limit(order: float, sizes: tuple[float, ...], run: int) -> None:
    made = levels(order, sizes)
    found = converge(made[run], [one for one in made if one is not made[run]], 1.0, 2.0)
    error = abs(float(made[run].values[0]) - LIMIT)
    assert found.order == pytest.approx(order, abs=1e-6)
    assert error <= found.uncertainty < 40 * error
    assert found.verdict == ("expected order" if order == 2.0 else "other order")


def test_at_the_order_of_theory_the_limit_is_found() -> None:
    made = levels(2.0, (1.0, 0.5, 0.25))
    found = converge(made[0], made[1:], 1.0, 2.0)
    assert found.extrapolated == pytest.approx(LIMIT, abs=1e-9)
    assert found.uncertainty == pytest.approx(1.25 * 0.2)


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("run", [0, 1])
def test_two_levels_hold_the_limit_of_any_order_that_is_sure(order: float, run: int) -> None:
    made = levels(order, (1.0, 0.5))
    found = converge(made[run], [made[1 - run]], 1.0, 2.0)
    assert found.verdict == "one other level"
    assert abs(float(made[run].values[0]) - LIMIT) <= found.uncertainty


def test_two_levels_have_three_times_what_the_order_that_is_sure_leaves() -> None:
    coarse, finest = Level(1.0, 5.0), Level(0.5, 4.0)  # first order: as much again is left
    assert converge(coarse, [finest], 1.0, 2.0).uncertainty == pytest.approx(1 + 3 * 1)
    assert converge(finest, [coarse], 1.0, 2.0).uncertainty == pytest.approx(3 * 1)
    assert converge(coarse, [finest], 2.0, 2.0).uncertainty == pytest.approx(1 + 3 / 3)


def test_two_levels_that_scatter_are_apart_by_as_much_as_they_may_be() -> None:
    coarse, finest = Level(1.0, 5.0, 0.8), Level(0.5, 4.0, 0.9)
    most = np.hypot(1.0, np.hypot(0.8, 0.9))
    for run, other, bound in ((coarse, finest, 4 * most), (finest, coarse, 3 * most)):
        found = converge(run, [other], 1.0, 2.0)
        assert found.verdict == "within scatter"
        assert found.uncertainty == pytest.approx(bound)
    assert converge(coarse, [Level(0.5, 2.0, 0.9)], 1.0, 2.0).verdict == "one other level"


def test_a_lower_order_than_a_half_is_taken_for_a_half() -> None:
    made = levels(0.2, (1.0, 0.5, 0.25))
    found = converge(made[0], made[1:], 1.0, 2.0)
    assert found.order == pytest.approx(0.2, abs=1e-6)
    coarse, fine, finest = (float(one.values[0]) for one in made)
    assert found.uncertainty == pytest.approx(coarse - finest + 3 * (fine - finest) / (np.sqrt(2) - 1))


@pytest.mark.parametrize("values", [(1.0, 1.1, 1.0), (1.0, 1.1, 1.3), (1.0, 1.1, 1.2), (1.0, 2.0, 2.0)])
def test_differences_that_do_not_fall_are_called_no_convergence(values: tuple[float, ...]) -> None:
    made = [Level(size, value) for size, value in zip((1.0, 0.5, 0.25), values, strict=True)]
    found = converge(made[0], made[1:], 1.0, 2.0)
    assert found.verdict == "no convergence"
    assert found.extrapolated is None
    assert found.uncertainty == pytest.approx(3 * (max(values) - min(values)))


def test_errors_that_happen_to_be_alike_do_not_look_as_if_they_were_gone() -> None:
    # the run's error is -0.1 and that of the finest +0.1: both differ by little, from the coarsest by much
    made = [Level(2.0, LIMIT + 1.0), Level(1.0, LIMIT + 0.101), Level(0.7, LIMIT + 0.1)]
    found = converge(made[1], [made[0], made[2]], 2.0, 2.0)
    assert found.order is not None
    assert found.order > 5
    assert found.uncertainty >= 0.101


def test_a_difference_within_the_scatter_of_the_cycles_is_not_read_as_an_order() -> None:
    made = [
        Level(size, value, 0.05) for size, value in zip((1.0, 0.5, 0.25), (1.0, 1.04, 1.041), strict=True)
    ]
    found = converge(made[0], made[1:], 1.0, 2.0)
    assert found.verdict == "within scatter"
    assert found.order is None
    apart = np.hypot(0.041, np.hypot(0.05, 0.05))
    assert found.uncertainty == pytest.approx(1.25 * apart / (1 - 1 / 4))  # r = 4, p = 1


def test_levels_that_scatter_no_more_than_the_finest_two_are_apart_bound_what_is_left() -> None:
    made = [Level(size, value, 0.05) for size, value in zip((1.0, 0.5, 0.25), (2.0, 1.04, 1.03), strict=True)]
    found = converge(made[0], made[1:], 1.0, 2.0)
    assert found.verdict == "within scatter"
    noise = np.hypot(0.05, 0.05)
    left = np.hypot(0.01, noise) / 3
    assert found.uncertainty == pytest.approx(1.25 * (np.hypot(0.97, noise) + left))


def test_no_difference_at_all_is_unchanged_and_not_converged() -> None:
    found = converge(Level(1.0, 2.0), [Level(0.5, 2.0), Level(0.25, 2.0)], 1.0, 2.0)
    assert (found.verdict, found.uncertainty, found.order) == ("no difference", 0.0, None)


def test_no_difference_beside_scatter_leaves_the_scatter() -> None:
    made = [Level(size, 2.0, 0.1) for size in (1.0, 0.5, 0.25)]
    found = converge(made[0], made[1:], 1.0, 2.0)
    assert found.verdict == "within scatter"
    assert found.uncertainty == pytest.approx(1.25 * np.hypot(0.1, 0.1) / (1 - 1 / 4))


def test_a_waveform_is_as_far_from_its_limit_as_is_reported() -> None:
    time = np.linspace(0, 1, 50)
    made = [Level(size, np.sin(7 * time) + 0.1 * size**2 * np.cos(5 * time)) for size in (1.0, 0.5, 0.25)]
    found = converge(made[0], made[1:], 1.0, 2.0)
    error = float(np.linalg.norm(made[0].values - np.sin(7 * time)))
    assert found.order == pytest.approx(2.0, abs=1e-9)
    assert error <= found.uncertainty < 1.3 * error
    assert found.extrapolated is None


def test_observed_order_of_unequal_ratios() -> None:
    coarse, fine, finest = levels(1.3, (1.0, 0.71, 0.4))
    assert observed_order(coarse, fine, finest) == pytest.approx(1.3, abs=1e-9)
