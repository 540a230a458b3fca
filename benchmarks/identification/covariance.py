"""The covariance kernels of identification beside BLAS: time, rate, share of the peak, difference.

For each size the kernels and NumPy's and SciPy's BLAS (OpenBLAS in their wheels) take turns within a round,
all with as many threads as asked for. The peak is the rate of one dgemm of the same size into memory that is
there, in the same round; a share is the median over the rounds of a kernel's rate over that peak. Rates count
the operations that symmetry leaves: 3 n^3 for G P G', n^2 r for P - W'W, n^3 / 3 for a factor, n^2 m for a
triangular solve. "copy" is reading and writing one matrix, the floor of whatever touches it. Differences are
relative to the largest entry.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from collections.abc import Callable
from typing import Any


def kernels(n: int) -> dict[str, tuple[float, Callable[[], Any], Callable[[], Any]]]:
    """Name to operations, ours and the peer's; both return the result."""
    import numpy as np
    from scipy.linalg import blas

    from plica import _engine

    rng = np.random.default_rng(n)
    G, W = rng.standard_normal((n, n)), rng.standard_normal((n // 2, n))
    P = G @ G.T + n * np.eye(n)
    noise = np.eye(n)
    R = _engine.cholesky(P)
    f = np.asfortranarray

    def in_place(kernel: Callable[[Any], Any], start: Any) -> Callable[[], Any]:
        def call() -> Any:
            target = start.copy()
            kernel(target)
            return target

        return call

    fG, fP, fW, fR, out = f(G), f(P), f(W), f(R), f(np.empty((n, n)))
    gemm, syrk, trsm = blas.dgemm, blas.dsyrk, blas.dtrsm
    return {
        "A B": (2 * n**3, lambda: _engine.product(G, P), lambda: G @ P),
        "Q + G P G'": (3 * n**3, lambda: _engine.congruence(G, P, noise), lambda: noise + (G @ P) @ G.T),
        "A B symmetric": (
            n**3,
            lambda: _engine.symmetric_product(G, G.T),
            lambda: symmetric(syrk(1.0, fG)),
        ),
        "P - W'W": (
            n**2 * (n // 2),
            in_place(lambda p: _engine.gram_update(p, W, -1.0), P),
            lambda: symmetric(syrk(-1.0, fW, 1.0, fP, trans=1)),
        ),
        "Cholesky": (n**3 / 3, lambda: _engine.cholesky(P), lambda: np.linalg.cholesky(P).T),
        "R'^-1 X": (
            n**3,
            in_place(lambda x: _engine.solve_lower(R, x), G),
            lambda: trsm(1.0, fR, fG, trans_a=1),
        ),
        "R^-1 X": (
            n**3,
            in_place(lambda x: _engine.solve_upper(R, x), G),
            lambda: trsm(1.0, fR, fG),
        ),
        "peak": (2 * n**3, *[lambda: gemm(1.0, fG, fP, 0.0, out, overwrite_c=1)] * 2),
        "copy": (0.0, P.copy, P.copy),
    }


def symmetric(upper: Any) -> Any:
    """BLAS leaves one triangle; a covariance has two."""
    import numpy as np

    return np.triu(upper) + np.triu(upper, 1).T


def timed(call: Callable[[], Any], repeats: int) -> float:
    start = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - start) / repeats


def measure(n: int, rounds: int) -> list[list[str]]:
    import numpy as np

    cases = kernels(n)
    repeats = max(1, int(4e7 / n**3))
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in cases}
    for _ in range(rounds):
        for name, (_, ours, peer) in cases.items():
            times[name].append((timed(ours, repeats), timed(peer, repeats)))
    rows = []
    for name, (operations, ours, peer) in cases.items():
        own, other = (statistics.median(pair[side] for pair in times[name]) for side in (0, 1))
        cells = [name, str(n), f"{1e3 * own:.3f}", f"{1e3 * other:.3f}"]
        if name not in ("peak", "copy"):
            share = statistics.median(
                (operations / mine) / (2 * n**3 / best)
                for (mine, _), (best, _) in zip(times[name], times["peak"], strict=True)
            )
            expected = np.asarray(peer())
            difference = np.abs(np.asarray(ours()) - expected).max() / np.abs(expected).max()
            ratio = statistics.median(b / a for a, b in times[name])
            cells += [f"{ratio:.2f}", f"{operations / own / 1e9:.1f}"]
            cells += [f"{100 * share:.0f} %", f"{difference:.0e}"]
        else:
            cells += ["", f"{operations / own / 1e9:.1f}" if operations else "", "", ""]
        rows.append(cells)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[20, 60, 100, 300, 600, 1200])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=15)
    given = parser.parse_args()
    os.environ["OPENBLAS_NUM_THREADS"] = str(given.threads)  # read when NumPy loads it
    import plica

    plica.set_threads(given.threads)
    from benchmarks.harness.table import show

    columns = (
        "kernel",
        "n",
        "ours (ms)",
        "BLAS (ms)",
        "BLAS / ours",
        "ours (GF/s)",
        "of the peak",
        "difference",
    )
    show(columns, (row for n in given.sizes for row in measure(n, given.rounds)))


if __name__ == "__main__":
    main()
