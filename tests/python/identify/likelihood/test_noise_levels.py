"""The levels of the noises: where the joint Gaussian is most probable, and that to round-off."""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize

from plica.identify.likelihood.level_search import LevelDensity, minimum
from plica.identify.likelihood.noise_levels import Noise, profiled

Floats = NDArray[np.float64]
CLASSES = {"pressures": (9, 0, 0), "collisions": (9, 5, 0), "gains": (9, 0, 8), "all": (9, 5, 8)}
FIXED = 4.0


def recorded(classes: tuple[int, int, int], seed: int = 3) -> tuple[Floats, Floats]:
    """T (60, i) and e (60) of inputs of levels 3, 4 and 0.5, and noise of level 0.7."""
    rng = np.random.default_rng(seed)
    T = rng.normal(size=(60, sum(classes)))
    w = np.repeat([3.0, FIXED, 0.5], classes) * rng.normal(size=sum(classes))
    return T, T @ w + 0.7 * rng.normal(size=60)


def found(T: Floats, e: Floats, classes: tuple[int, int, int], fixed: float | None) -> Noise:
    return profiled(T.T @ T, T.T @ e, float(e @ e), len(e), classes, fixed)


def density(T: Floats, e: Floats, classes: tuple[int, int, int], levels: Floats, flow: float) -> float:
    """-2 log p of e, of the dense covariance."""
    C = (T * np.repeat(levels**2, classes)) @ T.T + flow**2 * np.eye(len(e))
    return float(np.linalg.slogdet(C)[1] + e @ np.linalg.solve(C, e))


@pytest.mark.parametrize("kind", CLASSES)
@pytest.mark.parametrize("fixed", [None, FIXED])
def test_the_levels_are_those_of_the_most_probable_gaussian(kind: str, fixed: float | None) -> None:
    """Beside a search without derivatives over the dense covariance, from the truth."""
    classes = CLASSES[kind]
    T, e = recorded(classes)
    noise = found(T, e, classes, fixed)
    free = [k for k in range(3) if classes[k] and not (k == 1 and fixed is not None)]

    def cost(logs: Floats) -> float:
        levels = np.array([0.0, fixed or 0.0, 0.0])
        levels[free] = np.exp(logs[:-1])
        return density(T, e, classes, levels, math.exp(logs[-1]))

    start = np.log([*np.array([3.0, FIXED, 0.5])[free], 0.7])
    options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000, "maxfev": 4000}
    end = optimize.minimize(cost, start, method="Nelder-Mead", options=options)
    levels = np.array([noise.pressure, noise.collision, noise.gain])
    here = density(T, e, classes, levels, noise.flow)
    assert here <= end.fun + 1e-9
    assert np.log([*levels[free], noise.flow]) == pytest.approx(end.x, abs=1e-5)
    if classes[1] and fixed is not None:
        assert noise.collision == fixed


@pytest.mark.parametrize("kind", CLASSES)
@pytest.mark.parametrize("fixed", [None, FIXED])
def test_levels_do_not_depend_on_the_order_of_sums(kind: str, fixed: float | None) -> None:
    """Another number of threads adds up T' T in another order: levels move as the sums do, by 1e-15 times the
    condition of the problem, and not by a tolerance."""
    classes = CLASSES[kind]
    T, e = recorded(classes)
    order = np.random.default_rng(4).permutation(len(e))
    one, other = (found(T[rows], e[rows], classes, fixed) for rows in (np.arange(len(e)), order))
    assert (T[order].T @ T[order] != T.T @ T).any()
    assert astuple(other)[:4] == pytest.approx(astuple(one)[:4], rel=1e-12)


@pytest.mark.parametrize("fixed", [False, True])
def test_derivatives_by_the_levels_are_central_differences(fixed: bool) -> None:
    classes = CLASSES["all"]
    T, e = recorded(classes)
    parts = [slice(0, 9), slice(9, 14), slice(14, 22)]
    free = [parts[0], parts[2]] if fixed else parts
    chosen: dict[str, Any] = {"fixed": parts[1], "fixed_sd": FIXED} if fixed else {}
    levels = LevelDensity(T.T @ T, T.T @ e, float(e @ e), len(e), free, **chosen)
    x, h = np.array([1.0, -0.5, 0.7, -0.3])[-len(free) - 1 :], 1e-5
    _, gradient, hessian = levels.at(x)
    for k, step in enumerate(h * np.eye(len(x))):
        (low, below, _), (high, above, _) = levels.at(x - step), levels.at(x + step)
        assert abs(gradient[k]) > 1e-2
        assert gradient[k] == pytest.approx((high - low) / (2 * h), rel=1e-6)
        assert hessian[k] == pytest.approx((above - below) / (2 * h), rel=1e-6, abs=1e-6)


def test_the_search_ends_where_the_slope_is_nothing_or_at_a_bound() -> None:
    classes = CLASSES["all"]
    T, e = recorded(classes)
    parts = [slice(0, 9), slice(9, 14), slice(14, 22)]
    levels = LevelDensity(T.T @ T, T.T @ e, float(e @ e), len(e), parts)
    bounds = [(-12.0, 12.0)] * 4
    ends = [minimum(levels, np.full(4, start), bounds)[0] for start in (-3.0, 0.0, 4.0)]
    for end in ends:
        assert np.abs(levels.at(end)[1]).max() < 1e-10
        assert end == pytest.approx(ends[0], abs=1e-11)
    bounds[0] = (ends[0][0] + 1.0, 12.0)
    bounded, _ = minimum(levels, np.full(4, 4.0), bounds)
    assert bounded[0] == bounds[0][0]
    slopes = levels.at(bounded)[1]
    assert slopes[0] > 0
    assert np.abs(slopes[1:]).max() < 1e-10
