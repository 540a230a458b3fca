"""The fundamental of the tissue's motion, pixel by pixel: its strain, and the wave that runs outward.

With theta(t) the angle that the cycles' marks give (2 pi from mark to mark), the displacement at a pixel has
the part Re(D exp(i theta)); a flow is its difference between two frames, so that D and up to four more
harmonics are found from all flows by least squares: those below half of the frame rate, since the others look
in frames like lower ones and would take their part of D. What is said is of the picture: a 2-D projection of
the motion, at fixed pixels. Strain is the symmetric gradient of D in the axes of the midline (across, along,
shear), that of the plane fitted with a Gaussian of standard deviation `strain_gauge` / 2 about each pixel,
over tissue alone: exact for linear fields, and smaller than the truth where motion changes within the gauge.

A wave that runs outward from the edge at the speed c has the outward displacement exp(i (theta - k d)) at the
distance d, k = omega / c (medial-lateral phase velocity; Titze, Jiang, Hsiao, Ann. Otol. Rhinol. Laryngol.
102, 1993). k is the slope of the phase, by least squares weighted by the amplitude, in bands across the fold,
from a gauge beyond the edge on: nearer, the flow, which is smooth, has the phase of what moves farther out,
and the slope would be too small (of known waves by 4 to 14 %).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.thresholds import strain_gauge, wave_share
from plica.video.glottis.midline import Midline, pixels

__all__ = ["Fundamental", "fundamental", "reach", "wave_numbers", "why_unknown"]

Floats = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Mask = npt.NDArray[np.bool_]

_HARMONICS = 5  # at most
_PAIRS = 4  # of frames in the cycles, for each harmonic: two for each unknown
_BANDS = np.linspace(0.2, 0.8, 7)  # of the midline: one wave number between each two
_FAR = 0.35  # of the glottal length
_FEWEST = 6  # px over which a slope is taken
reach = strain_gauge + _FEWEST
"""px of the fold beside its edge that must move for a wave number."""


@dataclass(frozen=True)
class Fundamental:
    """Complex amplitudes at the cycles' frequency; not a number where tissue is not seen.

    Attributes
    ----------
    displacement : (h, w, 2) px
        To the image's right and down.
    strain : (h, w, 3)
        Across the midline, along it, and shear (half the change of a right angle).
    """

    displacement: Complex
    strain: Complex


def fundamental(
    flows: Iterable[npt.NDArray[np.floating]], cycles: Cycles, time: Floats, tissue: Mask, midline: Midline
) -> Fundamental | None:
    """Of the motion over all complete cycles; None where it is not known (:func:`why_unknown`).

    Parameters
    ----------
    flows : (h, w, 2) px each
        From each frame to the next; one that is not finite at tissue does not count.
    cycles : Cycles
    time : (frames)
        In the unit of the cycles, equidistant.
    tissue : (h, w) bool
        Pixels that show tissue in every frame.
    midline : Midline
    """
    harmonics = _harmonics(cycles, float(time[1] - time[0]))
    if harmonics < 1:
        return None
    turns = np.interp(time, cycles.starts, np.arange(cycles.count + 1.0), left=np.nan, right=np.nan)
    angle = 2 * np.pi * turns[:, None] * np.arange(1, harmonics + 1)
    basis = np.diff(np.concatenate([np.cos(angle), np.sin(angle)], axis=1), axis=0)
    right = np.zeros((basis.shape[1], *tissue.shape, 2))
    normal = np.zeros((basis.shape[1],) * 2)
    used = 0
    for row, flow in zip(basis, flows, strict=True):
        if np.isfinite(row).all() and np.isfinite(flow[tissue]).all():
            normal += np.outer(row, row)
            right += row[:, None, None, None] * flow
            used += 1
    if used < _PAIRS * harmonics:
        return None
    first = np.linalg.pinv(normal, hermitian=True)[[0, harmonics]]
    cosine, sine = np.tensordot(first, right, 1)
    found = np.where(tissue[..., None], cosine - 1j * sine, np.nan)
    return Fundamental(found, _strain(found, tissue, midline))


def why_unknown(cycles: Cycles) -> str:
    """The reason for which :func:`fundamental` finds none; the cycles in frames."""
    if not cycles.count or cycles.no_period:
        return cycles.no_period or cycles.note
    harmonics = _harmonics(cycles, 1.0)
    if harmonics < 1:
        return f"a cycle has only {np.median(cycles.periods):.3g} frames; it must have more than two"
    return f"fewer than {_PAIRS * harmonics} pairs of frames in the cycles show tissue"


def _harmonics(cycles: Cycles, step: float) -> int:
    """How many are told from frames `step` apart: those below half of the frame rate; 0 without cycles."""
    if not cycles.count:
        return 0
    period = float(np.median(cycles.periods)) / step
    return min(_HARMONICS, int(np.ceil(0.5 * period)) - 1)


def _strain(displacement: Complex, tissue: Mask, midline: Midline) -> Complex:
    """(h, w, 3) of (h, w, 2) px; not a number off tissue."""
    gradient = np.stack([_gradient(part, tissue) for part in np.moveaxis(displacement, -1, 0)], axis=-2)
    axes = np.stack([midline.across, midline.along])  # rows
    turned = np.einsum("ai,...ij,bj->...ab", axes, gradient, axes)
    shear = 0.5 * (turned[..., 0, 1] + turned[..., 1, 0])
    return np.stack([turned[..., 0, 0], turned[..., 1, 1], shear], axis=-1)


def _gradient(values: Complex, tissue: Mask) -> Complex:
    """(h, w, 2) d/dx, d/dy of the plane fitted about each pixel."""
    from scipy import ndimage

    reach = np.arange(-round(1.5 * strain_gauge), round(1.5 * strain_gauge) + 1.0)
    weight = np.exp(-0.5 * (reach / (0.5 * strain_gauge)) ** 2)

    def moment(part: Floats, x: int, y: int) -> Floats:
        over_x = ndimage.correlate1d(part, weight * reach**x, axis=1, mode="constant")
        return np.asarray(ndimage.correlate1d(over_x, weight * reach**y, axis=0, mode="constant"))

    there = tissue.astype(float)
    known = np.where(tissue, values, 0.0)
    powers = [(0, 0), (1, 0), (0, 1)]
    matrix = np.stack(
        [np.stack([moment(there, a + c, b + d) for c, d in powers], -1) for a, b in powers], axis=-2
    )
    sums = np.stack([moment(known.real, *p) + 1j * moment(known.imag, *p) for p in powers], axis=-1)
    found = np.full((*tissue.shape, 2), np.nan, dtype=complex)
    sound = tissue & (np.linalg.cond(matrix) < 1e6)  # no plane through a line of pixels
    found[sound] = np.linalg.solve(matrix[sound].astype(complex), sums[sound][..., None])[:, 1:, 0]
    return found


def wave_numbers(displacement: Complex, midline: Midline, side: int) -> Floats:
    """(bands) rad per px, by which the outward motion lags from px to px away from the midline.

    Only bands of the middle of the fold that show six pixels or more beyond the gauge; a standing motion has
    0.

    Parameters
    ----------
    displacement : (h, w, 2) px
        As of :class:`Fundamental`.
    side : int
        -1 left of the midline in the image, 1 right of it.
    """
    place = midline.place(pixels(displacement.shape[:2]))
    along, distance = place[..., 0] / midline.length, side * place[..., 1]
    outward = side * (displacement @ midline.across)
    found = []
    for low, high in pairwise(_BANDS.tolist()):
        inside = (along >= low) & (along < high) & (distance > 0) & (distance < _FAR * midline.length)
        inside &= np.isfinite(outward)
        bins = np.floor(distance[inside]).astype(int)
        count = np.bincount(bins)
        sums = np.bincount(bins, outward[inside].real) + 1j * np.bincount(bins, outward[inside].imag)
        there = np.flatnonzero(count)
        if there.size < _FEWEST:
            continue
        mean = sums[there] / count[there]
        size = np.abs(mean)
        strong = size >= wave_share * size.max()
        edge = int(np.argmax(strong))
        weaker = np.flatnonzero(~strong[edge:])
        part = slice(edge + round(strain_gauge), edge + int(weaker[0]) if weaker.size else None)
        if there[part].size >= _FEWEST:
            phase = np.unwrap(np.angle(mean[part]))
            found.append(-np.polyfit(there[part] + 0.5, phase, 1, w=size[part])[0])
    return np.array(found)
