"""Flags of the frames of an analysis."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.video.motion.drift import Drift

__all__ = ["flags", "in_doubt", "lit"]

Floats = npt.NDArray[np.float64]

_SHUT = 0.02  # of the largest area
_BLURRED = 0.5  # of the median sharpness
_SATURATED = 0.05  # share of the folds
_MOVED = 1.0  # px from the frame before
_LEFT = 3.0  # times the median residual
_LIT = 0.03  # share by which the light changes to the next frame


def flags(
    total: Floats,
    drift: Drift,
    sharpness: Floats,
    saturated: Floats,
    border: npt.NDArray[np.bool_],
    residual: Floats | None = None,
    brightness: Floats | None = None,
) -> list[str]:
    """Of each frame, by commas: "collision", "border", "blur", "saturation", "drift", "lost"; with the
    residual of each pair of frames also "residual" and "blind", with the change of its brightness "light"."""
    moved = np.linalg.norm(np.diff(drift.motion[:, :2], axis=0, prepend=0.0), axis=1)
    falls = np.diff(total, prepend=total[0]) < 0
    wrong = {
        "collision": (total <= _SHUT * np.nanmax(total)) & falls,
        "border": border,
        "blur": sharpness < _BLURRED * np.median(sharpness),
        "saturation": saturated > _SATURATED,
        "drift": moved > _MOVED,
        "lost": drift.lost,
    }
    if residual is not None:
        known = residual[np.isfinite(residual)]
        limit = _LEFT * float(np.median(known)) if known.size else np.inf
        wrong["residual"] = np.append(residual > limit, False)
        wrong["blind"] = np.append(np.isnan(residual), False)
    if brightness is not None:
        wrong["light"] = np.append(np.abs(np.nan_to_num(brightness)) > _LIT, False)
    return [", ".join(name for name, where in wrong.items() if where[frame]) for frame in range(total.size)]


def in_doubt(flag: str) -> bool:
    """Whether a frame's flags speak against it: folds that collide do not, nor does light that changes, which
    the flow takes out (`lit` tells it)."""
    return any(reason not in ("collision", "light") for reason in flag.split(", ") if reason)


def lit(flag: str) -> bool:
    """Whether the light changes much from a frame to the next."""
    return "light" in flag.split(", ")
