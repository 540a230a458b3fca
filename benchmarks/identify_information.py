"""How well the block's tissue can be known at all: `python benchmarks/identify.py information`.

The posterior sd on the mesh of the truth, from the Fisher information: no unbiased estimate is better
(Cramer, Rao). Of the benchmark's recording, and where one thing of it is better.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from identify_block import (
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


def information(arguments: argparse.Namespace) -> dict[str, Any]:
    """Print the sd of every number for each recording."""
    frames, drive = arguments.frames, arguments.drive
    plain = Study(Bench(COARSE, STEP, frames), NAMES, drive)
    longer = Study(Bench(COARSE, STEP, 2 * frames), NAMES, drive)
    cases = (
        ("as it is", plain, FLOW_SD, PRESSURE_SD),
        (f"{2 * frames} frames", longer, FLOW_SD, PRESSURE_SD),
        ("flow's error / 2", plain, FLOW_SD / 2, PRESSURE_SD),
        ("flow's error / 10", plain, FLOW_SD / 10, PRESSURE_SD),
        ("unknown pressures / 10", plain, FLOW_SD, PRESSURE_SD / 10),
        ("both / 10", plain, FLOW_SD / 10, PRESSURE_SD / 10),
    )
    print(f"posterior sd %, {plain.bench.unknowns} unknowns, {frames} frames, {drive:g} Pa")
    print(f"{'':24}" + "".join(f"{name[-14:]:>15}" for name in ("viscosity", *NAMES, "gain")))
    out = {}
    for name, study, flow, pressure in cases:
        out[name] = _sd(study, flow, pressure)
        print(f"{name:24}" + "".join(f"{100 * sd:15.1f}" for sd in out[name]), flush=True)
    return out


def _sd(study: Study, flow: float, pressure: float) -> list[float]:
    """(p) of log theta at the truth, these noises held."""
    likelihood = MarginalLikelihood(study.model, Noise(pressure, flow / FLOW_SD))
    at = likelihood.evaluate_known(study.truth, study.responses)
    precision = np.append(np.full(len(study.truth) - 1, PRIOR_SD), GAIN_SD) ** -2.0
    return np.sqrt(np.diag(np.linalg.inv(at.information + np.diag(precision)))).tolist()
