"""What a posterior says in words: its table, and what a reader must know before believing it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from plica.identify.posterior import Posterior

__all__ = ["GAUSSIAN_FALL", "LEARNED", "started", "table", "warnings", "weakest", "widened"]

Array = NDArray[np.float64]
LEARNED = 0.7
"""A posterior sd above this share of the prior's is the prior's own."""
GAUSSIAN_FALL = 1.92
"""Of a Gaussian's log density, from the middle to an end of the 95 % interval."""
FED_BACK = (
    "The pressures are taken for a voice's own: the motion makes them, and they repeat themselves with it. "
    "The estimate takes unknown pressures for independent of the motion and from frame to frame, so that "
    "stiffness and viscosity may come out far off, though the model follows the motion and the residuals "
    "pass: sd and intervals are refused. Where something else moves the folds, say so: voiced = false in the "
    "settings."
)
_PRIOR = "What stands in the table is the prior."


def table(posterior: Posterior) -> str:
    """One line a parameter: median, sd, 95 % interval, prior."""
    lines = [f"{'':24}{'median':>10} {'':4}{'sd':>8}  {'95 % interval':>23}  {'prior 95 %':>23}"]
    if not posterior.carried:
        lines.insert(0, "The model does not follow the motion: no number below is carried by the data.")
    elif posterior.fed_back:
        lines.insert(0, "The motion makes its own pressures: sd and intervals are refused.")
    elif posterior.inflation is not None and posterior.answered:
        lines.insert(0, "Residual test failed: sd and intervals are widened as the residuals ask for.")
    low_high = posterior.interval()
    spread = 1.959964 * posterior.prior_sd
    priors = posterior.values(np.column_stack([posterior.prior_mean - spread, posterior.prior_mean + spread]))
    for j, name in enumerate(posterior.names):
        prior = priors[j]
        relative = posterior.logarithmic is None or posterior.logarithmic[j]
        sd = f"{100 * posterior.sd[j]:.1f} %" if relative else f"{posterior.sd[j]:.2g}"
        sd = "refused" if posterior.refused[j] else sd
        interval = f"{low_high[j, 0]:10.4g} - {low_high[j, 1]:10.4g}" if posterior.answered else "refused"
        lines.append(
            f"{name:24}{posterior.median[j]:10.4g} {posterior.units[j]:4}{sd:>8}  {interval:>23}  "
            f"{prior[0]:10.4g} - {prior[1]:10.4g}"
        )
    return "\n".join(lines)


def widened(posterior: Posterior) -> str:
    """How much wider the intervals are than the information says, in words."""
    if posterior.inflation is None or posterior.inflation.max() < 1.05:
        return "no wider than the information says, as the residuals' own correlations ask for no more"
    least, most = f"{posterior.inflation.min():.2g}", f"{posterior.inflation.max():.2g}"
    factor = most if least == most else f"{least} to {most}"
    asked = "as the residuals' own correlations ask for"
    return f"wider than the information says, by a factor of {factor}, {asked}"


def started(posterior: Posterior) -> str:
    """From how many starts, and where they ended, in words."""
    others = posterior.starts - posterior.ended_here
    where = f", {others} at less probable tissues or nowhere" if others else ""
    return f"started {posterior.starts} times, {posterior.ended_here} ended here{where}"


def residual_warnings(posterior: Posterior) -> list[str]:
    """What the failed residual test does to the intervals."""
    if posterior.residuals.passed:
        return []
    if posterior.inflation is None:
        return [
            "The residual test failed: sd and intervals of independent errors are refused, as these are not. "
            f"The flow's error is correlated, the model does not hold, or {_false_maximum(posterior)}."
        ]
    if posterior.carried and not posterior.gaussian:
        return [
            "The residual test failed, and the density is not Gaussian: sd and intervals cannot be widened "
            "to what the residuals ask for, and are refused. The model does not hold: other forces, another "
            "geometry or other supports move this tissue."
        ]
    if posterior.fed_back:
        return []
    told = [
        f"The residual test failed: the intervals are {widened(posterior)}. What the model misses at all "
        "points and times alike is not in them."
    ]
    alone = posterior.sd / posterior.inflation < LEARNED * posterior.prior_sd
    lost = [
        n
        for n, was, sd in zip(
            posterior.names, alone, posterior.sd > LEARNED * posterior.prior_sd, strict=True
        )
        if was and sd
    ]
    if lost:
        told.append(f"With that nothing is known any more of {', '.join(lost)}.")
    return told


def _false_maximum(posterior: Posterior) -> str:
    said = "this is a false maximum of the density"
    if posterior.starts == 1:
        return f"{said}, which another start may leave"
    return f"{said} ({started(posterior)})"


def warnings(posterior: Posterior) -> list[str]:
    """What a reader must know before believing the table."""
    told = (
        [FED_BACK] * posterior.fed_back
        + list(posterior.notes)
        + posterior.noise.sentences()
        + residual_warnings(posterior)
    )
    told += posterior.residuals.sentences() + _shape_words(posterior)
    shares = posterior.sd / posterior.prior_sd
    alone = np.sqrt(np.diag(posterior.statistical_covariance)) / posterior.prior_sd
    for j, name in enumerate(posterior.names):
        if posterior.belied[j] and posterior.shift_in_sd is not None:
            told.append(
                f'"{name}" moves by {posterior.shift_in_sd[j]:+.1f} of its sd when the mesh is refined: the '
                "sd of one mesh is not honest. The interval includes the shift."
            )
        if alone[j] <= LEARNED < shares[j]:
            told.append(
                f'"{name}" is hardly known after this recording: on one mesh the data tell it, but with '
                f"the shift between meshes its sd is {100 * shares[j]:.0f} % of the prior's. Take finer "
                "meshes."
            )
        elif shares[j] > LEARNED:
            told.append(
                f'"{name}" is hardly learned from this recording: its sd is {100 * shares[j]:.0f} % of '
                f"the prior's. {'Believe the prior.' if shares[j] > 1 else _PRIOR}"
            )
    if posterior.information_eigenvalues[0] < 1:
        told.append(
            f"This recording cannot tell where it lies between its prior bounds: {weakest(posterior)}."
        )
    if posterior.mesh_shift is None:
        told.append("Only one mesh was tried: how far the estimate moves on a finer one is not known.")
    return told


def _shape_words(posterior: Posterior) -> list[str]:
    """Where the density is no Gaussian's."""
    if posterior.gaussian or posterior.falls is None:
        return []
    low, high = (f"{fall:.2g}" if np.isfinite(fall) else "infinity" for fall in posterior.falls)
    along = _words(posterior, posterior.least_known / posterior.prior_sd)
    return [
        f"The density is not Gaussian along {along}: at the ends of the 95 % interval its logarithm falls by "
        f"{low} and {high}, and should fall by {GAUSSIAN_FALL}. Less means that the interval is too narrow "
        "there, more that it is too wide. Sample it (docs/identification_theory.md), or narrow the prior."
    ]


def weakest(posterior: Posterior) -> str:
    """The combination of parameters of which the recording tells least."""
    return _words(posterior, posterior.weakest_direction / posterior.prior_sd)


def _words(posterior: Posterior, direction: Array) -> str:
    """A combination of parameters, by those that have a part in it."""
    strong = np.flatnonzero(np.abs(direction) > 0.3 * np.abs(direction).max())
    if len(strong) == 1:
        return f'"{posterior.names[strong[0]]}"'
    return " with ".join(f'"{posterior.names[j]}" {"up" if direction[j] > 0 else "down"}' for j in strong)
