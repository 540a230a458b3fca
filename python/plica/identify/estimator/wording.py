"""Text output of a posterior: its table and warnings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica.identify.estimator.posterior import GAUSSIAN_FALL, Posterior

__all__ = ["CLOSE_TO_PRIOR", "posterior_table", "posterior_warnings", "started", "weakest", "widened"]

Array = NDArray[np.float64]
CLOSE_TO_PRIOR = 0.7
"""A posterior with an sd above this share of the prior's is close to the prior."""
FED_BACK = (
    "The pressures are assumed to be those of phonation: the motion generates them, and they repeat with it. "
    "The estimate treats unknown pressures as independent of the motion and between frames, so stiffness and "
    "viscosity may be far off even if the model follows the motion and the residuals pass: sd and intervals "
    "are refused. If something else drives the folds, set voiced = false in the settings."
)
_PRIOR = "The values in the table are those of the prior."


def posterior_table(posterior: Posterior) -> str:
    """One line per parameter: median, sd, 95 % interval, prior. A `refused` sd is not printed, nor an
    interval that is not `answered`."""
    lines = [f"{'':24}{'median':>10} {'':4}{'sd':>8}  {'95 % interval':>23}  {'prior 95 %':>23}"]
    if not posterior.carried:
        lines.insert(0, "The model does not follow the motion: the data support no number below.")
    elif posterior.fed_back:
        lines.insert(0, "The motion generates its own pressures: sd and intervals are refused.")
    elif posterior.inflation is not None and posterior.answered:
        lines.insert(0, f"Residual test failed: sd and intervals are {widened(posterior)}.")
    low_high = posterior.interval()
    priors = posterior.prior_interval()
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
    """How much wider the intervals are than by the information, as text."""
    if posterior.inflation is None or posterior.inflation.max() < 1.05:
        return "not widened, as the correlations of the residuals do not require it"
    least, most = f"{posterior.inflation.min():.2g}", f"{posterior.inflation.max():.2g}"
    factor = most if least == most else f"{least} to {most}"
    return f"widened by a factor of {factor}, as the correlations of the residuals require"


def started(posterior: Posterior) -> str:
    """The number of starts, and where they ended, as text."""
    others = posterior.starts - posterior.ended_here
    where = f", {others} at less probable maxima or without convergence" if others else ""
    return f"started {posterior.starts} times, {posterior.ended_here} ended here{where}"


def residual_warnings(posterior: Posterior) -> list[str]:
    """The consequences of a failed residual test for the intervals."""
    if posterior.residuals.passed:
        return []
    if posterior.inflation is None:
        return [
            "The residual test failed: sd and intervals assume independent errors and are refused. "
            f"The flow's error is correlated, the model does not hold, or {_false_maximum(posterior)}."
        ]
    if posterior.carried and not posterior.gaussian:
        return [
            "The residual test failed, and the density is not Gaussian: sd and intervals cannot be widened "
            "as the residuals require, and are refused. The model does not hold: forces, geometry or "
            "supports of this tissue differ from it."
        ]
    if posterior.fed_back:
        return []
    warnings = [
        f"The residual test failed: the intervals are {widened(posterior)}. A model error common to all "
        "points and times is not in them."
    ]
    alone = posterior.sd / posterior.inflation < CLOSE_TO_PRIOR * posterior.prior_sd
    lost = [
        f'"{n}"'
        for n, was, sd in zip(
            posterior.names, alone, posterior.sd > CLOSE_TO_PRIOR * posterior.prior_sd, strict=True
        )
        if was and sd
    ]
    if lost:
        warnings.append(f"With that, the data no longer determine {', '.join(lost)}.")
    return warnings


def _false_maximum(posterior: Posterior) -> str:
    text = "this is a false maximum of the density"
    if posterior.starts == 1:
        return f"{text}, which another start may avoid"
    return f"{text} ({started(posterior)})"


def posterior_warnings(posterior: Posterior) -> list[str]:
    """What to know before trusting the table."""
    found = (
        [FED_BACK] * posterior.fed_back
        + list(posterior.notes)
        + posterior.noise.sentences()
        + residual_warnings(posterior)
    )
    found += posterior.residuals.sentences() + _not_gaussian(posterior)
    shares = posterior.sd / posterior.prior_sd
    alone = np.sqrt(np.diag(posterior.statistical_covariance)) / posterior.prior_sd
    for j, name in enumerate(posterior.names):
        if posterior.belied[j] and posterior.shift_in_sd is not None:
            found.append(
                f'"{name}" moves by {posterior.shift_in_sd[j]:+.1f} of its sd when the mesh is refined: the '
                "sd on one mesh is not valid. The interval includes the shift."
            )
        if alone[j] <= CLOSE_TO_PRIOR < shares[j]:
            found.append(
                f'"{name}" is hardly known after this recording: on one mesh the data determine it, but with '
                f"the shift between meshes its sd is {100 * shares[j]:.0f} % of the prior's. Use finer "
                "meshes."
            )
        elif shares[j] > CLOSE_TO_PRIOR:
            found.append(
                f'"{name}" is hardly informed by this recording: its sd is {100 * shares[j]:.0f} % of the '
                f"prior's. {'Use the prior.' if shares[j] > 1 else _PRIOR}"
            )
    if posterior.information_eigenvalues[0] < 1:
        found.append(f"The prior is more informative than this recording on {weakest(posterior)}.")
    if posterior.mesh_shift is None:
        found.append("Only one mesh was used: the shift of the estimate on a finer one is not known.")
    return found


def _not_gaussian(posterior: Posterior) -> list[str]:
    """A warning if the density is not Gaussian."""
    if posterior.gaussian or posterior.falls is None:
        return []
    low, high = (f"{fall:.2g}" if np.isfinite(fall) else "infinity" for fall in posterior.falls)
    along = _combination(posterior, posterior.least_known / posterior.prior_sd)
    return [
        f"The density is not Gaussian along {along}: at the ends of the 95 % interval its logarithm falls by "
        f"{low} and {high} instead of {GAUSSIAN_FALL}. With a smaller fall the interval is too narrow there, "
        "with a larger one too wide. Sample it (docs/identification_theory.md), or narrow the prior."
    ]


def weakest(posterior: Posterior) -> str:
    """The combination of parameters on which the recording is least informative."""
    return _combination(posterior, posterior.weakest_direction / posterior.prior_sd)


def _combination(posterior: Posterior, direction: Array) -> str:
    """A combination of parameters as text, by its largest contributions."""
    strong = np.flatnonzero(np.abs(direction) > 0.3 * np.abs(direction).max())
    if len(strong) == 1:
        return f'"{posterior.names[strong[0]]}"'
    return " with ".join(f'"{posterior.names[j]}" {"up" if direction[j] > 0 else "down"}' for j in strong)
