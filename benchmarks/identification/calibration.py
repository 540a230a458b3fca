"""Simulation-based calibration of whole estimates.

    python -m benchmarks.identification.estimates calibration

In each draw a tissue is drawn from the prior, a recording of it is made, and the estimate iterates to its end
from the prior's median. If prior, likelihood and the Gaussian that stands for the posterior are right, the
place of the truth in its posterior, u = Phi((truth - mean) / sd), is uniform in [0, 1] for each number.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
from scipy import stats

import plica
from benchmarks.harness.study import record
from benchmarks.identification.block import (
    GAIN_SD,
    PRIOR_SD,
    SIZE,
    STEP,
    THICKNESS,
    Bench,
    Divisions,
    offsets,
    parameters,
    true_log,
)
from plica.identify import MarginalLikelihood, MotionModel, Posterior, estimate
from plica.identify.estimator.posterior import standard_deviations

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


NUMBERS = ("viscosity", *NAMES, "gain")


def calibration(arguments: argparse.Namespace) -> None:
    """Whole estimates of tissues drawn from the prior, on the mesh of the truth."""
    drawn = Drawn(arguments.frames, arguments.drive)
    found, failed = [], 0
    for draw in range(arguments.draws):
        truth, model = drawn.recording(arguments.seed + draw)
        began = time.process_time()
        try:
            posterior = estimate(MarginalLikelihood(model))
        except plica.SolveFailed as error:
            failed += 1
            print(f"draw {draw}: {error}", flush=True)
            continue
        found.append(Ended.of(posterior, truth, time.process_time() - began))
        print(f"draw {draw}: {found[-1]}", flush=True)
    kept = [one for one in found if not one.warned]
    far = [one for one in found if np.abs(one.score).max() > 4]
    columns = ["", *NUMBERS, "all"]
    note = (
        f"{arguments.draws} draws, {arguments.frames} frames, {arguments.drive:g} Pa; "
        f"{drawn.bench.unknowns:,} unknowns, prior sd {PRIOR_SD:g}."
    )
    record(
        "identify-calibration", columns, ranks(kept), f"The draws without a warning, {len(kept)} of {note}"
    )
    counts = {
        "draws": len(found) + failed,
        "not converged": failed,
        "95 % covers, of all": f"{_covers(found, standard_deviations()):.1f} %",
        "50 % covers, of all": f"{_covers(found, 0.67449):.1f} %",
        "warned of": len(found) - len(kept),
        "over 4 sd off": len(far),
        "of these not warned of": sum(not one.warned for one in far),
        "begun again": sum(one.starts > 1 for one in found),
        "of these ended elsewhere": sum(one.starts > one.ended_here for one in found),
        "iterations, median": f"{np.median([one.iterations for one in found]):.0f}",
        "s of a processor, median": f"{np.median([one.busy for one in found]):.1f}",
    }
    record("identify-calibration-draws", list(counts), [list(counts.values())], note)


@dataclass(frozen=True)
class Ended:
    """How an estimate ended."""

    score: np.ndarray
    """(p) errors in sd"""
    warned: bool
    """Of the residuals, or of the density's shape."""
    iterations: int
    starts: int
    ended_here: int
    busy: float
    """s of a processor"""

    @classmethod
    def of(cls, found: Posterior, truth: np.ndarray, busy: float) -> Ended:
        """A posterior beside the truth (p)."""
        warned = not found.residuals.passed or not found.gaussian
        score = (found.mean - truth) / np.sqrt(np.diag(found.covariance))
        return cls(score, warned, found.iterations, found.starts, found.ended_here, busy)

    def __str__(self) -> str:
        return (
            f"{self.iterations} iterations, {self.starts} starts, {self.ended_here} ended here, "
            f"{self.busy:.1f} s busy; errors in sd {np.round(self.score, 2)}{', warned' * self.warned}"
        )


def _covers(found: list[Ended], bound: float) -> float:
    """Per cent of the intervals of this half-width in sd that hold the truth."""
    return 100 * float(np.mean(np.abs([one.score for one in found]) <= bound))


def ranks(found: list[Ended]) -> list[list[str]]:
    """The truth's places in the posteriors, in tenths, and how uniform they are: the p-value of Kolmogorov
    and Smirnov's test, and the mean square of the scores. A column a number and one of all."""
    scores = np.array([one.score for one in found])
    columns = []
    for part in [*scores.T, scores.ravel()]:
        places = stats.norm.cdf(-part)
        tenths = np.histogram(places, bins=10, range=(0, 1))[0]
        columns.append(
            [
                " ".join(str(k) for k in tenths),
                f"{stats.kstest(places, 'uniform').pvalue:.2f}",
                f"{np.mean(part**2):.2f}",
                *[f"{100 * np.mean(np.abs(part) <= standard_deviations(p)):.1f} %" for p in (0.95, 0.5)],
            ]
        )
    names = ("u in tenths of [0, 1]", "p", "mean square of error over sd", "95 % covers", "50 % covers")
    return [[name, *row] for name, row in zip(names, zip(*columns, strict=True), strict=True)]
