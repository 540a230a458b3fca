"""What EM makes of tissue: a free evolution G, as the thesis proposes, and a structured one, by its noise.

The twin is a chain of eight masses held at one end, in three layers of springs with stiffnesses k1, k2, k3,
driven by a known force of 150 Hz and by random ones of a share of it on every mass; HHT-alpha steps of 50 us,
the velocities of the three last masses seen with noise of 0.1 mm/s.

1. EM with all of G (its state scaled) and Gamma_w, from 30 % off and from the truth; theta is then read from
   G by least squares, its columns weighted by how much the input moves each state.
2. EM with G(theta) from 30 % off. The rate is that of its slowest direction at the maximum, the largest
   eigenvalue of 1 - (complete information)^-1 (information of y) (Dempster, Laird and Rubin 1977); by it, the
   iterations to come from 30 % to within 0.1 standard deviation.
3. That maximum itself, by a search over theta, with standard deviations from the curvature there.

Errors are of k1, k2, k3 in per cent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from benchmarks.harness.study import record, script_parser
from plica.identify import LinearGaussian, em, hht_evolution, kalman_filter, log_likelihood, structured_em
from plica.identify.state_space.moments import expected_moments
from plica.identify.state_space.structured_em import expected_objective

Array = NDArray[np.float64]
MASSES, STEP, SEEN = 8, 5e-5, 3
LAYERS = np.array([0, 0, 0, 1, 1, 1, 2, 2])  # of each spring
TRUTH = np.log([2e4, 1e4, 4e3])  # N/m
MASS = 1e-4  # kg
DRIVE = 0.1  # N
START = TRUTH + np.log([1.3, 0.7, 1.3])
SCALE = np.repeat([2.0**-17, 2.0**-7, 2.0**6], MASSES)  # m, m/s, m/s^2
NOISE_ROWS = np.arange(2 * MASSES, 3 * MASSES)


def stiffness(theta: Array) -> Array:
    K = np.zeros((MASSES, MASSES))
    for spring, layer in enumerate(LAYERS):
        k = np.exp(theta[layer])
        K[spring, spring] += k
        if spring > 0:
            K[spring - 1, spring - 1] += k
            K[spring - 1, spring] -= k
            K[spring, spring - 1] -= k
    return K


def model_of(theta: Array, share: float, frames: int) -> tuple[LinearGaussian, Array]:
    """The model in a scaled state and its input; random forces are `share` of the known one."""
    evolution = hht_evolution(MASS * np.eye(MASSES), 2e-5 * stiffness(TRUTH), stiffness(theta), STEP)
    n = 3 * MASSES
    H = np.zeros((SEEN, n))
    H[np.arange(SEEN), np.arange(2 * MASSES - SEEN, 2 * MASSES)] = 1.0
    drive = DRIVE * np.sin(2 * np.pi * 150 * STEP * np.arange(frames + 1))
    model = LinearGaussian(
        G=evolution.G,
        H=H,
        process_noise=evolution.force_noise(np.eye(MASSES), (share * DRIVE) ** 2 * np.eye(MASSES)),
        Gamma_v=np.full(SEEN, 1e-4**2),
        m0=np.zeros(n),
        P0=np.diag((0.1 * SCALE) ** 2),
    )
    return model.scaled(SCALE), evolution.input(np.outer(drive, np.linspace(0.5, 1, MASSES))) / SCALE


def draw(share: float, frames: int, seed: int) -> Array:
    model, f = model_of(TRUTH, share, frames)
    rng = np.random.default_rng(seed)
    noise = model.process_noise
    L = noise.patterns * np.sqrt(np.diag(noise.covariance))
    z, y = 0.1 * rng.standard_normal(model.states), np.empty((frames, SEEN))
    for k in range(frames):
        z = model.G @ z + f[k] + L @ rng.standard_normal(MASSES)
        y[k] = model.H @ z + np.sqrt(model.Gamma_v) * rng.standard_normal(SEEN)
    return y


def read_theta(G: Array, spread: Array, share: float) -> Array:
    """theta whose evolution is nearest to G."""
    found = least_squares(lambda theta: ((G - model_of(theta, share, 1)[0].G) * spread).ravel(), TRUTH)
    return found.x


def per_cent(theta: Array) -> str:
    return " / ".join(f"{100 * np.expm1(value):+.1f}" for value in theta - TRUTH)


def curvature(value: Callable[[Array], float], at: Array) -> Array:
    """Second derivatives of a function of theta, by central differences."""
    h, unit = 1e-3, np.eye(3)
    corners = [(s, t) for s in (1, -1) for t in (1, -1)]
    entries = [
        sum(s * t * value(at + h * (s * a + t * b)) for s, t in corners) / (4 * h**2)
        for a in unit
        for b in unit
    ]
    return np.reshape(entries, (3, 3))


def maximum(y: Array, share: float) -> tuple[Array, Array, float]:
    """The maximum of the likelihood, its standard deviations, and the rate of EM there."""
    frames = len(y)

    def minus_log_likelihood(theta: Array) -> float:
        model, f = model_of(theta, share, frames)
        return -log_likelihood(model, y, f)

    options = {"xatol": 1e-5, "fatol": 1e-6}
    best = minimize(minus_log_likelihood, TRUTH, method="Nelder-Mead", options=options).x
    seen = curvature(minus_log_likelihood, best)
    model, f = model_of(best, share, frames)
    moments = expected_moments(model, kalman_filter(model, y, f))
    complete = curvature(
        lambda theta: expected_objective(*model_of(theta, share, frames), moments, NOISE_ROWS), best
    )
    rate = 1.0 - float(np.linalg.eigvals(np.linalg.solve(complete, seen)).real.min())
    return best, np.sqrt(np.diag(np.linalg.inv(seen))), rate


def free(share: float, frames: int, iterations: int, start: Array) -> list[str]:
    y = draw(share, frames, 1)
    model, f = model_of(start, share, frames)
    full = replace(model, process_noise=model.Gamma_w + 1e-8 * np.eye(model.states))
    result = em(full, y, f, estimate=("G", "Gamma_w"), iterations=iterations, tolerance=0.0)
    moved = simulated_spread(model, f)
    theta = read_theta(result.model.G, moved, share)
    rise = result.log_likelihoods
    true_model, true_input = model_of(TRUTH, share, frames)
    at_truth = log_likelihood(true_model, y, true_input)
    begun = "the truth" if start is TRUTH else per_cent(start)
    return [f"{100 * share:g} %", begun, per_cent(theta), f"{rise[-1] - at_truth:.0f}"]


def simulated_spread(model: LinearGaussian, f: Array) -> Array:
    """How far each state moves under the known force, root mean square."""
    z, total = model.m0, np.zeros(model.states)
    for row in f:
        z = model.G @ z + row
        total += z**2
    return np.sqrt(total / len(f))


def structured(share: float, frames: int, iterations: int) -> list[str]:
    """Where EM with G(theta) stands after some iterations, and how many it needs."""
    y = draw(share, frames, 1)
    best, sd, rate = maximum(y, share)
    result = structured_em(
        lambda theta: model_of(theta, share, frames),
        START,
        y,
        noise_rows=NOISE_ROWS,
        iterations=iterations,
        tolerance=0.0,
    )
    left = float(np.max(np.abs(result.theta - best) / sd))
    needed = np.log(0.1 / np.max(np.abs(START - best) / sd)) / np.log(rate)
    return [
        f"{100 * share:g} %",
        per_cent(best),
        " / ".join(f"{100 * value:.2g}" for value in sd),
        f"{per_cent(result.theta)}, {left:.0f} sd off",
        f"1 - {1 - rate:.0e}",
        f"{max(needed, 1):.0e}",
    ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--shares", type=float, nargs="+", default=[0.003, 0.03, 0.3])
    given = parser.parse_args()
    note = f"Errors in %; {given.frames} frames, {given.iterations} iterations."
    starts = ((share, start) for share in given.shares for start in (START, TRUTH))
    rows = (free(share, given.frames, given.iterations, start) for share, start in starts)
    record("em-free", ["random force", "start", "read from G", "log p above that of the truth"], rows, note)
    columns = ["random force", "maximum of the likelihood", "sd", "EM stands at", "rate"]
    rows = (structured(share, given.frames, given.iterations) for share in given.shares)
    record("em-structured", [*columns, "iterations to 0.1 sd"], rows, note)


if __name__ == "__main__":
    main()
