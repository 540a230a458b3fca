"""Filter, smoother and EM step beside statsmodels, pykalman and dynamax: time, memory, difference of results.

A random stable model of n states (spectral radius 0.98) with 0.4 n rows of independent noise, N frames; with
--gaps some, one frame in ten and one entry in twenty are missing (then without dynamax, which takes no gaps).
All sides have the same model, in double precision and with as many threads as asked for (dynamax takes what
XLA takes), and take turns within a round; a ratio is the median of the ratios within the rounds. A first call
of each stands apart, since dynamax compiles in it. "never settling" is plica without its switch to a steady
gain; statsmodels has its own and keeps its default. An EM step is a filter, a smoother with lag-one
covariances, and the sums of the M step. Memory is how far the peak of a process of its own rises above what
model and library take. Log-likelihoods are relative differences to plica's without the switch.

Peers that Python does not find are left out: pip install statsmodels pykalman dynamax.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

TASKS = ("likelihood", "filter", "smoother", "EM step")
SIDES = ("plica", "plica, never settling", "statsmodels", "pykalman", "dynamax")
Call = Callable[[], float | None]  # gives the log-likelihood where it has one


def problem(n: int, frames: int, gaps: str) -> tuple[Any, Any]:
    import numpy as np

    from plica.identify import LinearGaussian

    rng = np.random.default_rng(n)
    rows = max(2, 2 * n // 5)
    G = rng.standard_normal((n, n))
    G *= 0.98 / np.abs(np.linalg.eigvals(G)).max()
    w = rng.standard_normal((n, n)) / np.sqrt(n)
    model = LinearGaussian(
        G=G,
        H=rng.standard_normal((rows, n)) / np.sqrt(n),
        process_noise=w @ w.T,
        Gamma_v=rng.uniform(0.5, 2.0, rows),
        m0=np.zeros(n),
        P0=np.eye(n),
    )
    y = rng.standard_normal((frames, rows)) * 2.0
    if gaps == "some":
        y[rng.random(y.shape) < 0.05] = np.nan
        y[rng.random(frames) < 0.1] = np.nan
    return model, y


def plica_calls(model: Any, y: Any, **options: float) -> dict[str, Call]:
    from plica.identify import kalman_filter, log_likelihood, smooth
    from plica.identify.moments import expected_moments

    def smoother() -> float:
        filtered = kalman_filter(model, y, **options)
        smooth(model, filtered)
        return filtered.log_likelihood

    def em_step() -> float:
        filtered = kalman_filter(model, y, **options)
        expected_moments(model, filtered)
        return filtered.log_likelihood

    return {
        "likelihood": lambda: log_likelihood(model, y, **options),
        "filter": lambda: kalman_filter(model, y, **options).log_likelihood,
        "smoother": smoother,
        "EM step": em_step,
    }


def first_frame(model: Any) -> tuple[Any, Any]:
    """Mean and covariance of the state at the first frame, where the peers begin."""
    return model.G @ model.m0, model.G @ model.P0 @ model.G.T + model.Gamma_w


def statsmodels_calls(model: Any, y: Any) -> dict[str, Call]:
    import numpy as np
    from statsmodels.tsa.statespace import kalman_smoother as ks

    peer = ks.KalmanSmoother(k_endog=model.rows, k_states=model.states)
    peer.bind(np.asfortranarray(y.T))
    peer["design"], peer["transition"], peer["selection"] = model.H, model.G, np.eye(model.states)
    peer["state_cov"], peer["obs_cov"] = model.Gamma_w, np.diag(model.Gamma_v)
    peer.initialize_known(*first_frame(model))
    moments = ks.SMOOTHER_STATE | ks.SMOOTHER_STATE_COV
    return {
        "likelihood": lambda: float(peer.loglike()),
        "filter": lambda: float(peer.filter().llf),
        "smoother": lambda: float(peer.smooth(smoother_output=moments | ks.SMOOTHER_STATE_AUTOCOV).llf),
        "EM step": lambda: float(peer.smooth(smoother_output=moments | ks.SMOOTHER_STATE_AUTOCOV).llf),
    }


def pykalman_calls(model: Any, y: Any) -> dict[str, Call]:
    import numpy as np
    from pykalman import KalmanFilter

    mean, covariance = first_frame(model)
    arguments = {
        "transition_matrices": model.G,
        "observation_matrices": model.H,
        "transition_covariance": model.Gamma_w,
        "observation_covariance": np.diag(model.Gamma_v),
        "initial_state_mean": mean,
        "initial_state_covariance": covariance,
    }
    masked = np.ma.masked_invalid(y)
    peer = KalmanFilter(**arguments)

    def em_step() -> None:
        estimated = ["transition_covariance", "observation_covariance"]
        KalmanFilter(**arguments, em_vars=estimated).em(masked, n_iter=1)

    def none(call: Callable[[Any], Any]) -> Call:
        return lambda: call(masked) and None

    return {
        "likelihood": lambda: float(peer.loglikelihood(masked)),
        "filter": none(peer.filter),
        "smoother": none(peer.smooth),
        "EM step": em_step,
    }


def dynamax_calls(model: Any, y: Any) -> dict[str, Call]:
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp
    import numpy as np
    from dynamax.linear_gaussian_ssm import LinearGaussianSSM, lgssm_filter, lgssm_smoother

    mean, covariance = first_frame(model)
    peer = LinearGaussianSSM(model.states, model.rows, has_dynamics_bias=False, has_emissions_bias=False)
    params, _ = peer.initialize(
        initial_mean=jnp.asarray(mean),
        initial_covariance=jnp.asarray(covariance),
        dynamics_weights=jnp.asarray(model.G),
        dynamics_covariance=jnp.asarray(model.Gamma_w),
        emission_weights=jnp.asarray(model.H),
        emission_covariance=jnp.asarray(np.diag(model.Gamma_v)),
    )
    data = jnp.asarray(y)
    likelihood = jax.jit(lambda p, e: lgssm_filter(p, e).marginal_loglik)
    filtering, smoothing, expecting = (jax.jit(f) for f in (lgssm_filter, lgssm_smoother, peer.e_step))

    def waited(result: Any) -> float:
        jax.block_until_ready(result)
        return float(result.marginal_loglik)

    return {
        "likelihood": lambda: float(likelihood(params, data)),
        "filter": lambda: waited(filtering(params, data)),
        "smoother": lambda: waited(smoothing(params, data)),
        "EM step": lambda: float(jax.block_until_ready(expecting(params, data))[1]),
    }


MAKERS: dict[str, Callable[[Any, Any], dict[str, Call]]] = {
    "plica": plica_calls,
    "plica, never settling": lambda model, y: plica_calls(model, y, steady_tolerance=0.0),
    "statsmodels": statsmodels_calls,
    "pykalman": pykalman_calls,
    "dynamax": dynamax_calls,
}


def present(gaps: str, wanted: list[str]) -> list[str]:
    found = [
        side
        for side in SIDES
        if side.split(",")[0] in wanted and importlib.util.find_spec(side.split(",")[0])
    ]
    return [side for side in found if not (gaps == "some" and side == "dynamax")]


def peak_bytes() -> float:
    """Of this process since the kernel's mark was last reset."""
    status = Path("/proc/self/status").read_text()
    return 1024.0 * float(re.findall(r"VmHWM:\s+(\d+)", status)[0])


def memory(side: str, task: str, given: argparse.Namespace, n: int) -> float:
    """Growth of the peak (bytes) of a process that does one task."""
    arguments = [__file__, "--child", side, task, "--sizes", str(n), "--frames", str(given.frames)]
    arguments += ["--threads", str(given.threads), "--gaps", given.gaps]
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True)
    return float(done.stdout.split()[-1])


def child(side: str, task: str, n: int, frames: int, gaps: str) -> None:
    call = MAKERS[side](*problem(n, frames, gaps))[task]
    Path("/proc/self/clear_refs").write_text("5")
    before = peak_bytes()
    call()
    print(peak_bytes() - before)


def measure(n: int, given: argparse.Namespace) -> None:
    model, y = problem(n, given.frames, given.gaps)
    sides = {side: MAKERS[side](model, y) for side in present(given.gaps, ["plica", *given.peers])}
    expected = sides["plica, never settling"]["likelihood"]()
    assert expected is not None
    for task in TASKS:
        first: dict[str, float] = {}
        found: dict[str, float | None] = {}
        times: dict[str, list[float]] = {side: [] for side in sides}
        for turn in range(given.rounds + 1):
            for side, calls in sides.items():
                start = time.perf_counter()
                found[side] = calls[task]()
                taken = time.perf_counter() - start
                if turn == 0:
                    first[side] = taken
                else:
                    times[side].append(taken)
        for side in sides:
            ratio = statistics.median(a / b for a, b in zip(times[side], times["plica"], strict=True))
            value = found[side]
            cells = [
                str(n),
                task,
                side,
                f"{first[side]:.3f}",
                f"{statistics.median(times[side]):.4f}",
                f"{ratio:.2f}",
                f"{memory(side, task, given, n) / 1e6:.0f}" if given.memory == "yes" else "",
                "" if value is None else f"{abs(value / expected - 1):.0e}",
            ]
            print("| " + " | ".join(cells) + " |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[20, 100, 300, 600])
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--gaps", choices=("none", "some"), default="none")
    parser.add_argument("--memory", choices=("yes", "no"), default="yes")
    parser.add_argument("--peers", nargs="*", default=["statsmodels", "pykalman", "dynamax"])
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    os.environ["OPENBLAS_NUM_THREADS"] = str(given.threads)  # read when NumPy loads it
    import plica

    plica.set_threads(given.threads)
    if given.child:
        child(*given.child, given.sizes[0], given.frames, given.gaps)
        return
    print("| n | task | side | first (s) | time (s) | to plica | memory (MB) | log-likelihood |")
    print("|" + " --- |" * 8)
    for n in given.sizes:
        measure(n, given)


if __name__ == "__main__":
    main()
