"""What is measured of the tissue's fundamental: strain, and the speed of the mucosal wave."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from plica.measures.interval import of_mean
from plica.measures.measure import Measure, absent, whole
from plica.measures.thresholds import wave_percentile
from plica.video.glottis.midline import Midline, pixels
from plica.video.measures.wave_cautions import cautioned
from plica.video.motion.mucosal_wave import Fundamental, reach, wave_numbers

__all__ = ["wave_measures"]

_FEWEST = 3  # bands
_LEAST = 0.15  # px; what flow finds of less motion is noise as much as motion
_SHORT = 20.0  # px; of a shorter wave flow may find half of the amplitude (benchmarks/video/waves.py)
_SLOW = (-0.002, 0.011)  # rad per px, by which smooth flow lets the phase fall too slowly (the same)
_SEED = 20213


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
    most = float(np.percentile(strain, wave_percentile)) if strain.size else float("nan")
    said = "" if strain.size else "no tissue of the folds is seen in every frame"
    measured = [
        whole("strain_amplitude_across", most, said),
        whole("strain_rate_amplitude_across", turn * rate * most, said),
    ]
    sides = {"left": 1 if mirrored else -1, "right": -1 if mirrored else 1}
    numbers = {name: wave_numbers(found.displacement, midline, side) for name, side in sides.items()}
    ways = {name: _amplitude(found, midline, folds, side) for name, side in sides.items()}
    measured += [
        _speed(f"mucosal_wave_speed_{name}", numbers[name], turn * rate * size, ways[name]) for name in sides
    ]
    return cautioned(measured, [_short(name, numbers[name], ways[name]) for name in sides])


def _amplitude(found: Fundamental, midline: Midline, folds: npt.NDArray[np.bool_], side: int) -> float:
    """px, of the motion across the midline that few pixels of a side exceed; 0 where none is seen."""
    own = folds & (side * midline.place(pixels(folds.shape))[..., 1] > 0)
    sizes = np.abs(found.displacement[own] @ midline.across)
    sizes = sizes[np.isfinite(sizes)]
    return float(np.percentile(sizes, wave_percentile)) if sizes.size else 0.0


def _short(name: str, numbers: npt.NDArray[np.float64], way: float) -> str:
    """That a side moves too little for flow, or its wave is too short; empty where neither is, or no wave."""
    if way < _LEAST:
        return (
            f"the motion across the midline on the {name} fold is {way:.2g} px; flow does not tell less than "
            f"{_LEAST:g} px from noise, and strain may be several times too small"
        )
    if numbers.size < _FEWEST or not numbers.mean() > 2 * np.pi / _SHORT:
        return ""
    return (
        f"the wave on the {name} fold is {2 * np.pi / numbers.mean():.2g} px long: of waves below "
        f"{_SHORT:g} px flow may find half of the amplitude or less, and strain is as much too small. "
        "Film with more pixels a millimetre"
    )


def _speed(name: str, numbers: npt.NDArray[np.float64], scale: float, way: float) -> Measure:
    """The speed `scale` / k, k the mean of the bands' wave numbers; none where the motion is too small.

    The bands share what smoothness makes of k, so that they do not scatter by it: it is drawn for the
    interval.
    """
    if way < _LEAST:
        return absent(
            name, f"the motion's amplitude across the midline is {way:.2g} px; the flow tells a wave from "
            f"{_LEAST:g} px on"
        )  # fmt: skip
    if numbers.size < _FEWEST:
        return absent(
            name, f"bands of the fold that show its motion over {reach:g} px or more: {numbers.size}; "
            f"{_FEWEST} are needed"
        )  # fmt: skip
    drawn = of_mean(numbers)
    if drawn is None or not drawn.interval[0] + _SLOW[0] > 0:
        return absent(
            name, "the phase does not clearly fall away from the midline: no outward wave is told from a "
            "motion that stands"
        )  # fmt: skip
    slow = np.random.default_rng(_SEED).uniform(*_SLOW, drawn.values.size)
    kept = drawn.mapped(lambda values: scale / np.maximum(values + slow, 1e-9))
    return Measure(name, float(scale / numbers.mean()), None, 0, replicates=kept)
