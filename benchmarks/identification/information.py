"""How well the block's tissue can be known at all.

    python -m benchmarks.identification.estimates information

The posterior sd on the mesh of the truth, from the Fisher information: no unbiased estimate is better
(Cramer, Rao). Of the benchmark's recording, and where one thing of it is better.
"""

from __future__ import annotations

import argparse

import numpy as np

from benchmarks.harness.study import record
from benchmarks.identification.block import (
    COARSE,
    FLOW_SD,
    GAIN_SD,
    PRESSURE_SD,
    PRIOR_SD,
    SEVEN,
    STEP,
    Bench,
    Study,
)
from plica.identify import MarginalLikelihood, Noise

NAMES = ("cover.E", *SEVEN)


def information(arguments: argparse.Namespace) -> None:
    """The sd of every number for each recording, in per cent."""
    frames, drive = arguments.frames, arguments.drive
    plain = Study(Bench(COARSE, STEP, frames), NAMES, drive)
    longer = Study(Bench(COARSE, STEP, 2 * frames), NAMES, drive)
    cases = (
        (f"{frames} frames, {FLOW_SD:g} px, {PRESSURE_SD:g} Pa unknown", plain, FLOW_SD, PRESSURE_SD),
        (f"{2 * frames} frames", longer, FLOW_SD, PRESSURE_SD),
        (f"{FLOW_SD / 2:g} px", plain, FLOW_SD / 2, PRESSURE_SD),
        (f"{FLOW_SD / 10:g} px", plain, FLOW_SD / 10, PRESSURE_SD),
        (f"{PRESSURE_SD / 10:g} Pa unknown", plain, FLOW_SD, PRESSURE_SD / 10),
        (f"{FLOW_SD / 10:g} px and {PRESSURE_SD / 10:g} Pa", plain, FLOW_SD / 10, PRESSURE_SD / 10),
    )
    rows = ([name, *_sd(study, flow, pressure)] for name, study, flow, pressure in cases)
    note = f"{plain.bench.unknowns:,} unknowns, {drive:g} Pa."
    record("identify-information", ["posterior sd %", "viscosity", *NAMES, "gain"], rows, note)


def _sd(study: Study, flow: float, pressure: float) -> list[str]:
    """(p) of log theta at the truth in per cent, these noises held."""
    likelihood = MarginalLikelihood(study.model, Noise(pressure, flow / FLOW_SD))
    at = likelihood.evaluate_known(study.truth, study.responses)
    precision = np.append(np.full(len(study.truth) - 1, PRIOR_SD), GAIN_SD) ** -2.0
    covariance = np.linalg.inv(at.information + np.diag(precision))
    return [f"{100 * sd:.1f}" for sd in np.sqrt(np.diag(covariance))]
