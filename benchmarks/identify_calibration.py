"""Simulation-based calibration of whole estimates: `python benchmarks/identify.py calibration`.

In each draw a tissue is drawn from the prior, a recording of it is made, and the estimate iterates to its end
from the prior's median. If prior, likelihood and the Gaussian that stands for the posterior are right, the
place of the truth in its posterior, u = Phi((truth - mean) / sd), is uniform in [0, 1] for each number.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
from identify_block import (
    GAIN_SD,
    PRIOR_SD,
    SIZE,
    STEP,
    THICKNESS,
    Bench,
    Divisions,
    offsets,
    parameters,
    report,
    true_log,
)
from scipy import stats

import plica
from plica.identify import MarginalLikelihood, MotionModel, estimate

SMALL: Divisions = (2, 3, (1, 1, 1))


NAMES = ("cover.mu_fibre", "body.mu_fibre", "body.E_fibre")


class Drawn:
    """Recordings of tissues and gains that are drawn from the prior."""

    def __init__(self, frames: int, drive: float) -> None:
        self.bench = Bench(SMALL, STEP, frames, SIZE, THICKNESS)
        middle = parameters(NAMES, np.zeros(1 + len(NAMES)))
        self._model = self.bench.model(middle, np.ones((frames, len(self.bench.points.nodes), 2)), drive)

    def recording(self, seed: int) -> tuple[np.ndarray, MotionModel]:
        """log theta and the log of the gain, (p), and the model that sees them, its priors the block's."""
        rng = np.random.default_rng(seed)
        truth = true_log(NAMES) + offsets(NAMES, self.bench, rng)
        truth[-1] = rng.normal(0, GAIN_SD)
        responses = self._model.responses(truth[:-1], derivatives=False)
        flow = self.bench.recording(responses, rng, float(np.exp(truth[-1])))
        return truth, self._model.seeing(flow)


def calibration(arguments: argparse.Namespace) -> dict[str, Any]:
    """Whole estimates of tissues drawn from the prior, on the mesh of the truth."""
    titles = ("viscosity", *NAMES, "gain")
    drawn = Drawn(arguments.frames, arguments.drive)
    print(f"{drawn.bench.unknowns} unknowns, {arguments.frames} frames, prior sd {PRIOR_SD:g}", flush=True)
    errors, sds, told, failed, starts = [], [], [], [], []
    for draw in range(arguments.draws):
        truth, model = drawn.recording(arguments.seed + draw)
        began = time.process_time()
        try:
            found = estimate(MarginalLikelihood(model))
        except plica.SolveFailed as error:
            failed.append((draw, str(error)))
            print(f"draw {draw}: {error}", flush=True)
            continue
        told.append(not found.residuals.passed or not found.gaussian)
        errors.append(found.mean - truth)
        sds.append(np.sqrt(np.diag(found.covariance)))
        starts.append((found.starts, found.ended_here, time.process_time() - began))
        print(
            f"draw {draw}: {found.iterations} iterations, {found.starts} starts, {found.ended_here} ended "
            f"here, {starts[-1][2]:.1f} s busy; "
            f"errors in sd {np.round(errors[-1] / sds[-1], 2)}{', warned' * told[-1]}",
            flush=True,
        )
    out = report("whole estimates of tissues drawn from the prior", titles, np.array(errors), np.array(sds))
    scores, kept = np.array(errors) / np.array(sds), ~np.array(told)
    out["failed"], out["warned"] = failed, int(np.sum(told))
    out["ranks"], out["starts"] = ranks(titles, scores), starts
    again = [row for row in starts if row[0] > 1]
    print(
        f"begun again: {len(again)}, of which {sum(s > e for s, e, _ in again)} ended elsewhere than some "
        f"start; {sum(row[2] for row in again):.0f} of {sum(row[2] for row in starts):.0f} s busy"
    )
    far = np.abs(scores).max(axis=1) > 4
    print(
        f"{len(failed)} did not converge; {int(np.sum(told))} warned of residuals or shape; {int(far.sum())} "
        f"off by more than 4 sd, {int((far & kept).sum())} of these without a warning"
    )
    print("\nwithout those warned of:")
    out["ranks, not warned"] = ranks(titles, scores[kept])
    return out


def ranks(names: tuple[str, ...], scores: np.ndarray) -> dict[str, Any]:
    """Print the truth's places in the posteriors, (draws, p) errors in sd, in tenths, and how uniform they
    are: the p-value of Kolmogorov and Smirnov's test, and the mean square of the scores."""
    places = stats.norm.cdf(-scores)
    rows = {}
    for j, name in [*enumerate(names), (slice(None), "all")]:
        tenths = np.histogram(places[:, j], bins=10, range=(0, 1))[0]
        p_value = float(stats.kstest(places[:, j].ravel(), "uniform").pvalue)
        square = float(np.mean(scores[:, j] ** 2))
        inner = float(np.mean(np.abs(scores[:, j]) < 0.6745))
        shown = " ".join(f"{k:3d}" for k in tenths)
        print(
            f"{name:20} tenths {shown}; p {p_value:.2f}, mean square {square:.2f}, "
            f"50 % covers {100 * inner:.0f} %"
        )
        rows[name] = {"tenths": tenths.tolist(), "p": p_value, "mean_square": square, "covers_50": inner}
    return rows
