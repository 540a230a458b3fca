"""Glottal waveforms of a recording: area left and right, kymograms, phases, measures.

Left and right are those of the image.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles, find_cycles
from plica.measures.measure import Measure, per_cycle, whole
from plica.video.errors import VideoError
from plica.video.midline import Midline, pixels
from plica.video.recording import Grey

__all__ = ["GlottalArea", "areas", "check_places", "kymogram", "measures", "middle", "phases"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

open_share = 0.05
"""Of a cycle's largest area: above it the glottis counts as open."""
wide_share = 0.95
"""Of a cycle's largest area: above it the phase is "open", neither opening nor closing."""


@dataclass(frozen=True)
class GlottalArea:
    """Glottal area, left and right of the midline in the image.

    Attributes
    ----------
    left, right : (frames) px^2
        Not a number where it is not known.
    left_edge, right_edge : (frames) px
        Mean distance of the folds' edges from the midline, over the middle tenth of its length.
    """

    left: Floats
    right: Floats
    left_edge: Floats
    right_edge: Floats

    @property
    def total(self) -> Floats:
        """(frames) px^2."""
        return self.left + self.right

    def filled(self) -> GlottalArea:
        """With frames whose area is not known (not a number) between their neighbours."""
        known = np.isfinite(self.total)
        if known.all() or not known.any():
            return self
        frames = np.arange(known.size)
        return GlottalArea(*(np.interp(frames, frames[known], part[known]) for part in vars(self).values()))


def middle(place: Floats, midline: Midline) -> Mask:
    """(h, w) the middle tenth along the line, of places (h, w, 2) that :meth:`Midline.place` gives."""
    return np.asarray(np.abs(place[..., 0] / midline.length - 0.5) < 0.05)


def areas(glottis: Iterable[Mask], midline: Midline) -> GlottalArea:
    """Area and edges of each mask (h, w) left and right of the midline; a pixel on it counts for both."""
    rows: list[tuple[float, float, float, float]] = []
    right: Floats | None = None
    tenth: Mask | None = None
    band = 0.0  # px, extent of the band along the line, as its pixels have it
    for mask in glottis:
        if right is None or tenth is None:
            place = midline.place(pixels(mask.shape))
            right = np.clip(0.5 + place[..., 1], 0.0, 1.0)  # of a pixel's area
            tenth = middle(place, midline)
            band = float(tenth.sum()) * midline.along[1] / mask.shape[1]
        sides = [(1 - right)[mask], right[mask]]
        edges = [float(side[tenth[mask]].sum()) / band for side in sides]
        rows.append((float(sides[0].sum()), float(sides[1].sum()), edges[0], edges[1]))
    return GlottalArea(*(np.array(column) for column in zip(*rows, strict=True)))


def check_places(places: Sequence[float]) -> None:
    """VideoError unless there are some, along the midline, 0 at its upper end and 1 at its lower."""
    if not (places and all(0 <= place <= 1 for place in places)):
        said = ", ".join(f"{place:g}" for place in places)
        raise VideoError(
            f"Video: kymogram = {said}; must be places in [0, 1], from the midline's upper to its lower end."
        )


def kymogram(
    frames: Iterable[Grey], midline: Midline, places: Sequence[float] = (0.5,), half_width: float = 60
) -> Floats:
    """Grey along lines across the midline, frame by frame, interpolated linearly; 0 beyond the frame.

    Parameters
    ----------
    frames : (h, w) each
    midline : Midline
    places : sequence of float
        Of the lines, in [0, 1]: 0 at the midline's upper end and 1 at its lower.
    half_width : float
        px, on either side of the midline.

    Returns
    -------
    (places, frames, 2 half_width + 1), from the image's left to its right.

    Raises
    ------
    VideoError
        For a place beyond the midline's ends.
    """
    from scipy import ndimage

    check_places(places)

    offsets = np.arange(-int(half_width), int(half_width) + 1.0)
    along = midline.length * np.asarray(places, dtype=float)
    lines = midline.points(np.stack(np.meshgrid(along, offsets, indexing="ij"), axis=-1))
    at = [lines[..., 1], lines[..., 0]]
    rows = [ndimage.map_coordinates(frame, at, order=1, mode="constant", cval=0.0) for frame in frames]
    return np.stack(rows, axis=1).astype(float)


def phases(area: GlottalArea, cycles: Cycles, time: Floats) -> list[str]:
    """ "closed", "opening", "open" or "closing" for each frame; "" outside the cycles and where the area is
    not known.

    Closed and open are told by the largest area of the cycle; between them the area falls from its largest
    value to its least, and rises from there.
    """
    labels = [""] * time.size
    total = area.total
    for part in cycles.samples(time):
        inside = total[part]
        if not np.isfinite(inside).any():
            continue
        peak = int(np.nanargmax(inside))
        trough = inside.size - 1 - int(np.nanargmin(inside[peak:][::-1]))  # the last of the least
        for k, value in enumerate(inside):
            if not np.isfinite(value):
                continue
            if value <= open_share * inside[peak]:
                labels[part.start + k] = "closed"
            elif value >= wide_share * inside[peak]:
                labels[part.start + k] = "open"
            else:
                labels[part.start + k] = "closing" if peak < k <= trough else "opening"
    return labels


def measures(
    area: GlottalArea, fps: float | None = None, mm_per_px: float | None = None, length: float | None = None
) -> tuple[dict[str, Measure], Cycles]:
    """Frequency, open quotient, amplitudes and asymmetries, each with its spread over cycles.

    Times are in seconds with `fps`, else in frames: a frequency is then in cycles per frame, "1/frame".
    Lengths and areas are in mm and mm^2 with `mm_per_px`, else in px and px^2; with the glottal `length` (px)
    they are given over it and its square too. The amplitude of a side is half of its edge's way in a cycle;
    the amplitude asymmetry is that of the areas' ranges; the phase asymmetry, at the cycles' frequency, is
    positive where the right lags.
    """
    known, area = area.total, area.filled()
    frequency, px = "Hz" if fps else "1/frame", "mm" if mm_per_px else "px"
    time = np.arange(area.total.size) / (fps or 1.0)
    cycles = find_cycles(time, area.total, name="glottal area")
    opened, amplitude, phase = [], [], []
    swing: dict[str, list[float]] = {"amplitude_left": [], "amplitude_right": []}
    for (begin, end), part in zip(pairwise(cycles.starts), cycles.samples(time), strict=True):
        opened.append(_open_share(time, area.total, begin, end, float(area.total[part].max())))
        for name, edge in (("amplitude_left", area.left_edge), ("amplitude_right", area.right_edge)):
            swing[name].append(0.5 * float(np.ptp(edge[part])))
        left, right = (0.5 * float(np.ptp(side[part])) for side in (area.left, area.right))
        amplitude.append((right - left) / (right + left) if right + left else np.nan)
        angle = [_angle(time[part], side[part], begin, end - begin) for side in (area.left, area.right)]
        phase.append(angle[0] - angle[1])

    def cyclic(values: Any, unit: str, note: str = "") -> Measure:
        return per_cycle(cycles, np.asarray(values, dtype=float), unit, note)

    size = mm_per_px or 1.0
    found = {
        "glottal_area_max": whole(size**2 * float(np.nanmax(known)), f"{px}^2"),
        "glottal_area_mean": whole(size**2 * float(np.nanmean(known)), f"{px}^2"),
        "fundamental_frequency": cyclic(1 / cycles.periods, frequency, cycles.note),
        "open_quotient": cyclic(
            opened, "1", f"open: area above {100 * open_share:g} % of the cycle's maximum"
        ),
    }
    way = "half of the way of the edge in the middle of the midline"
    for name, values in swing.items():
        found[name] = cyclic(size * np.array(values), px, way)
    found["amplitude_asymmetry"] = cyclic(amplitude, "1", "(right - left) / (right + left)")
    phase_mean = float(np.angle(np.mean(np.exp(1j * np.array(phase))))) if phase else 0.0
    about = [(angle - phase_mean + np.pi) % (2 * np.pi) - np.pi + phase_mean for angle in phase]
    found["phase_asymmetry"] = cyclic(about, "rad", "positive where the right lags")
    if length:
        found["glottal_length"] = whole(size * length, px, "of the midline")
        found["glottal_area_max_relative"] = whole(
            float(np.nanmax(known)) / length**2, "1", "over the square of the glottal length"
        )
        for name, values in swing.items():
            found[f"{name}_relative"] = cyclic(np.array(values) / length, "1", "over the glottal length")
    return found, cycles


def _open_share(time: Floats, total: Floats, begin: float, end: float, largest: float) -> float:
    """Share of a cycle in which the area, linear between frames, is above its open level."""
    fine = np.linspace(begin, end, 1001)
    return float(np.mean(np.interp(fine, time, total) > open_share * largest))


def _angle(time: Floats, signal: Floats, begin: float, period: float) -> float:
    """Phase of the signal at the cycle's frequency, rad, by least squares with a constant."""
    argument = 2 * np.pi * (time - begin) / period
    basis = np.stack([np.ones_like(argument), np.cos(argument), np.sin(argument)], axis=1)
    _, cosine, sine = np.linalg.lstsq(basis, signal, rcond=None)[0]
    return float(np.arctan2(cosine, sine))
