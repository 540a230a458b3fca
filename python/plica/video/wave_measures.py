"""What is measured of the tissue's fundamental: strain, and the speed of the mucosal wave."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.measures.interval import of_mean
from plica.measures.measure import Measure, absent, whole
from plica.video.midline import Midline
from plica.video.waves import Fundamental, wave_numbers

__all__ = ["wave_measures"]

_FEWEST = 3  # bands
_MOST = 95  # percentile


def wave_measures(
    found: Fundamental,
    midline: Midline,
    folds: npt.NDArray[np.bool_],
    period: float,
    size: float,
    rate: float,
    *,
    mirrored: bool = False,
) -> list[Measure]:
    """Strain amplitudes and the waves' speeds.

    Parameters
    ----------
    folds : (h, w) bool
    period : float
        Frames a cycle.
    size, rate : float
        What a pixel is, and frames in the unit of time.
    mirrored : bool
        Whether left is what is right in the image.
    """
    turn = 2 * np.pi / period  # rad a frame
    strain = np.abs(found.strain[..., 0][folds])
    strain = strain[np.isfinite(strain)]
    most = float(np.percentile(strain, _MOST)) if strain.size else float("nan")
    said = "" if strain.size else "no tissue of the folds is seen in every frame"
    measured = [
        whole("strain_amplitude_across", most, said),
        whole("strain_rate_amplitude_across", turn * rate * most, said),
    ]
    for name, side in (("left", 1 if mirrored else -1), ("right", -1 if mirrored else 1)):
        numbers = wave_numbers(found.displacement, midline, side)
        measured.append(_speed(f"mucosal_wave_speed_{name}", numbers, turn * rate * size))
    return measured


def _speed(name: str, numbers: npt.NDArray[np.float64], scale: float) -> Measure:
    """The speed `scale` / k, k the mean of the bands' wave numbers."""
    if numbers.size < _FEWEST:
        return absent(name, f"only {numbers.size} bands of the fold show its motion; {_FEWEST} are needed")
    drawn = of_mean(numbers)
    if drawn is None or not drawn.interval[0] > 0:
        return absent(
            name, "the phase does not clearly fall away from the midline: no outward wave is told from a "
            "motion that stands"
        )  # fmt: skip
    kept = drawn.mapped(lambda values: scale / np.maximum(values, 1e-9))
    return Measure(name, float(scale / numbers.mean()), None, 0, replicates=kept)
