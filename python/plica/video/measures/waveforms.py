"""Glottal waveforms of a recording: phases of the cycle, measures.

Left and right are those of the image.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.glottal import (
    amplitude_growth,
    area_measures,
    cycle_quotients,
    frequency_measures,
    over_cycles,
    quotient_measures,
)
from plica.measures.measure import Measure, Measures, absent, cycle_frequency, per_cycle, whole
from plica.measures.perturbation import (
    noise_measures,
    perturbation_measures,
    sampled_harmonics_to_noise,
)
from plica.measures.pulses import autocorrelation_peak
from plica.measures.recorded import recorded_cycles
from plica.measures.recorded_quotients import count_measures, gap_measures, recorded_quotient_measures
from plica.measures.scale import Scale
from plica.measures.sides import amplitudes, asymmetry, side_measures
from plica.measures.thresholds import closed_share
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures.error_model import AreaErrors, Estimate, draws
from plica.video.measures.intervals import with_errors
from plica.video.measures.lateral_light import by_light, cautioned, is_lateral, is_shaded, is_wide
from plica.video.measures.slit_measures import differs, noted, open_besides
from plica.video.measures.steady_voice import steady_voice

__all__ = ["area_cycles", "counted", "edge_error", "measures", "phases", "scale_of", "wide_share"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_PRECISE = 0.05  # of an amplitude: a larger share of it is said

_APART = 0.05  # relative difference of two folds' frequencies
_PERIODIC = 0.5  # autocorrelation from which a fold has a frequency

_ENOUGH = 12  # cycles whose errors are drawn

edge_error = 0.5
"""px, within which a fold's edge is placed: masks are of whole pixels; a fold of less amplitude is still."""

many_lost = 0.02  # of the frames: more whose area is not known are said

wide_share = 0.95
"""Of a cycle's largest area: above it the phase is "open", neither opening nor closing."""


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
            if value <= closed_share * inside[peak]:
                labels[part.start + k] = "closed"
            elif value >= wide_share * inside[peak]:
                labels[part.start + k] = "open"
            else:
                labels[part.start + k] = "closing" if peak < k <= trough else "opening"
    return labels


def scale_of(fps: float | None, mm_per_px: float | None) -> tuple[float, float, Scale]:
    """What a pixel and a frame are, and in which units: m and s where that is known, else px and frames."""
    size = 1e-3 * mm_per_px if mm_per_px else 1.0
    scale = Scale("m" if mm_per_px else "px", "s" if fps else "frames")
    return size, 1.0 / (fps or 1.0), scale


def _placed(found: list[Measure], size: float) -> list[Measure]:
    """With a caution where the folds move little for edges that are placed to half a pixel."""
    moved = [item.value for item in found if item.quantity.side in ("left", "right")]
    known = [value / size for value in moved if value is not None]
    if len(known) == 2 and min(known) < edge_error:
        return _beside_still(found, known)
    if len(known) < 2 or min(known) >= edge_error / _PRECISE:
        return found
    said = f"edges are placed to {edge_error:g} px, and the lesser amplitude is {min(known):.2g} px"
    return [item if item.quantity.angle else replace(item, cautions=(*item.cautions, said)) for item in found]


def _lagging(item: Measure) -> Measure:
    """A phase with a note which fold comes later, where its interval says so."""
    ends = item.interval
    if not item.quantity.angle or ends is None or ends[0] <= 0 <= ends[1]:
        return item
    return replace(
        item, note="; ".join(filter(None, (f"the {'right' if ends[0] > 0 else 'left'} fold lags", item.note)))
    )


def _beside_still(found: list[Measure], amplitudes: list[float]) -> list[Measure]:
    """Without the phase of a fold that does not move, and without a ratio over its amplitude."""
    still = [f"{side} fold by {way:.2g} px" for side, way in zip(("left", "right"), amplitudes, strict=True)]
    least = " and the ".join(part for part, way in zip(still, amplitudes, strict=True) if way < edge_error)
    said = f"the {least} moves less than edges are placed to ({edge_error:g} px)"
    gone = {"left_right_phase"} | ({"amplitude_ratio"} if amplitudes[0] < edge_error else set())
    moves = {side for side, way in zip(("left", "right"), amplitudes, strict=True) if way >= edge_error}
    kept = [absent(item.name, f"undefined: {said}") if item.name in gone else item for item in found]
    way = max(amplitudes)
    placed = f"edges are placed to {edge_error:g} px, and the amplitude is {way:.2g} px"
    known = (placed,) if way < edge_error / _PRECISE else ()
    return [
        item
        if item.name in gone
        else replace(item, cautions=(*item.cautions, *(known if item.quantity.side in moves else (said,))))
        for item in kept
    ]


def measures(
    area: GlottalArea,
    fps: float | None = None,
    mm_per_px: float | None = None,
    length: float | None = None,
    sides: tuple[str, str] = ("left in the image", "right in the image"),
    *,
    doubts: Sequence[str] = (),
    band: tuple[Floats, Floats] | None = None,
    brightness: Floats | None = None,
    cycles: Cycles | None = None,
) -> tuple[Measures, Cycles]:
    """What the glottal area and the edges of the folds tell, each with its interval over cycles.

    Times are in seconds with `fps`, else in frames: a frequency is then in cycles per frame, "1/frame".
    Lengths and areas are in m and m^2 with `mm_per_px`, else in px and px^2; with the glottal `length` (px)
    they are given over it and its square too. `sides` says what is left and what is right; `doubts` what
    speaks against the whole area, which all that stands on it repeats; `band` (px^2, of each frame) between
    which outlines it lies, which is said, and is in the intervals, where there is shade. Slits that blur
    hides are counted where they are known (`area.lost`). `brightness` is that of the tissue on either side
    of the midline (:mod:`.lateral_light`). `cycles` are all complete ones, by the outline, unless given.
    """
    cycles = area_cycles(area, fps, mm_per_px) if cycles is None else cycles
    area = area.filled()
    size, step, scale = scale_of(fps, mm_per_px)
    time = step * np.arange(area.total.size)
    seen = _Seen(time, size, sides)
    clear = area.lost is not None and area.lost.by_blur_alone
    sharp = counted(area)

    def of_sides(counted: GlottalArea, outlined: GlottalArea) -> list[Measure]:
        with_slits, without = (seen.of_sides(part, length, cycles) for part in (counted, outlined))
        return noted(with_slits, without, scale)

    def of_area(total: Floats) -> list[Measure]:
        return [*seen.of_quotients(total, cycles), *seen.of_area(total, length, cycles)]

    of_folds, chosen, bare, shade = of_sides(sharp, area), sharp, area, None
    by_blur = area.lost.band if area.lost is not None and clear else None
    wide = band is not None and is_wide(area.total, band, by_blur)
    if sharp.inner is not None and area.inner is not None:
        inner = of_sides(sharp.inner, area.inner)
        while_open = seen.of_sides(sharp.inner.while_open(sharp), length, cycles)
        of_folds, darkest = by_light(of_folds, inner, while_open, wide=wide, brightness=brightness)
        shade = sharp.less(sharp.inner.while_open(sharp))
        if darkest:
            chosen, bare = sharp.inner, area.inner
    with_slits, without = (of_area(part.total) for part in (sharp, area))
    by_area = noted(with_slits, without, scale)
    most = None
    if area.lost is not None and (besides := open_besides(sharp.total, area.lost.most, cycles, time)):
        most = area.lost.most
        opened = of_area(sharp.total + most)
        by_area = [
            replace(item, cautions=(*item.cautions, besides)) if differs(item, other) else item
            for item, other in zip(by_area, opened, strict=True)
        ]
    outlines = None
    if band is not None and (wide or is_shaded(of_folds)):
        low, high = (np.where(np.isfinite(edge), edge, area.total) for edge in band)
        outlines, by_area = (
            (low, high),
            cautioned(by_area, _outlines_said(area, band, is_lateral(brightness))),
        )
    total = size**2 * area.total
    found = [
        *count_measures(cycles),
        *frequency_measures(time, total, cycles, scale),
        *_doubted(by_area, doubts),
        *perturbation_measures(time, total, cycles),
        *noise_measures(time, total, cycles),
        *of_folds,
    ]
    if length:
        found.append(whole("glottal_length", size * length))
    if cycles.count:
        errors = AreaErrors(
            added=None if area.lost is None else area.unblurred.total - area.total,
            counted=clear,
            of_sides=chosen.less(bare) if clear else None,
            most=most,
            band=outlines,
            shade=shade,
            darkest=chosen is sharp.inner,
            lateral=is_lateral(brightness),
        )
        found = seen.with_errors(
            found, Estimate(area.total, sharp.total, sharp.total, chosen, length), errors, cycles
        )
    return Measures(map(_lagging, found), scale), cycles


def counted(area: GlottalArea) -> GlottalArea:
    """With the slits that blur hides, where what darkens the midline is slits and no shade."""
    return area.unblurred if area.lost is not None and area.lost.by_blur_alone else area


def area_cycles(area: GlottalArea, fps: float | None = None, mm_per_px: float | None = None) -> Cycles:
    """All complete cycles of a glottal area but those of onset and offset (:mod:`.steady_voice`), by its
    outline: in s, or in frames without `fps`."""
    known = np.isfinite(area.total)
    area = area.filled()
    size, step, scale = scale_of(fps, mm_per_px)
    time = step * np.arange(area.total.size)
    total = size**2 * area.total
    cycles = recorded_cycles(time, total, name="glottal area", scale=scale)
    cycles = steady_voice(cycles, time, total, scale)
    apart = _folds_apart(area, cycles, scale, step)
    verdict = "diplophonic" if apart else cycles.verdict
    left_out = _with_lost(known, time, cycles)
    lost = "" if left_out else _lost(known, time, cycles)
    said = filter(None, (cycles.note, apart, lost))
    return replace(cycles, verdict=verdict, note="; ".join(said), left_out=left_out)


@dataclass(frozen=True)
class _Seen:
    """How a recording is measured: instants of its frames, what a pixel is, which side is which."""

    time: npt.NDArray[np.floating]
    size: float
    sides: tuple[str, str]

    def of_quotients(self, total: Floats, cycles: Cycles) -> list[Measure]:
        """What instants of the area (px^2) tell."""
        area = self.size**2 * total
        of_cycles = cycle_quotients(self.time, area, cycles)
        return [
            *quotient_measures(self.time, area, cycles, of_cycles),
            *recorded_quotient_measures(self.time, area, cycles, of_cycles),
        ]

    def of_area(self, total: Floats, length: float | None, cycles: Cycles) -> list[Measure]:
        """What the size of the area (px^2) tells."""
        time, area = self.time, self.size**2 * total
        found = [
            *area_measures(time, area, cycles),
            *gap_measures(time, area, cycles, self.size * length if length else None),
        ]
        if length:
            over = total / length**2
            found.append(over_cycles("glottal_area_max_relative", time, over, cycles, np.max))
        return found

    def of_sides(self, area: GlottalArea, length: float | None, cycles: Cycles) -> list[Measure]:
        """What is measured of either fold, and between them."""
        return _of_sides(area, self.time, cycles, self.size, length, self.sides)

    def values(self, estimate: Estimate, cycles: Cycles) -> dict[str, float | None]:
        """All that has an interval, by name."""
        outline = self.size**2 * estimate.outline
        found = [
            cycle_frequency(cycles),
            per_cycle("period", cycles, cycles.periods),
            amplitude_growth(self.time, outline, cycles),
            *self.of_quotients(estimate.timed, cycles),
            *self.of_area(estimate.total, estimate.length, cycles),
            *perturbation_measures(self.time, outline, cycles),
            *noise_measures(self.time, outline, cycles),
            *self.of_sides(estimate.sides, estimate.length, cycles),
        ]
        return {item.name: item.value for item in found}

    def with_errors(
        self, found: list[Measure], estimate: Estimate, errors: AreaErrors, cycles: Cycles
    ) -> list[Measure]:
        """The measures with intervals that have the errors of the estimate too."""
        some = _middle_cycles(replace(cycles, recorded=False), _ENOUGH)
        drawn = [
            (self.values(*true), self.values(*noisy), crest)
            for true, noisy, crest in draws(estimate, errors, some, self.time)
        ]
        step = float(self.time[1] - self.time[0])
        sampled = sampled_harmonics_to_noise(self.time[some.extent(self.time)], some.frequency, step)
        return with_errors(found, drawn, self.values(estimate, some), some.count / cycles.count, sampled)


def _middle_cycles(cycles: Cycles, most: int) -> Cycles:
    """So many in the middle, none of them left out unless it was."""
    first = max((cycles.count - most) // 2, 0)
    left_out = tuple(k - first for k in cycles.left_out if 0 <= k - first < most)
    if len(left_out) >= min(most, cycles.count):  # none would be left
        return cycles
    return replace(cycles, starts=cycles.starts[first : first + most + 1], left_out=left_out)


def _doubted(found: list[Measure], doubts: Sequence[str]) -> list[Measure]:
    return [
        item if item.value is None else replace(item, cautions=(*item.cautions, *doubts)) for item in found
    ]


def _of_sides(
    area: GlottalArea,
    time: npt.NDArray[Any],
    cycles: Cycles,
    size: float,
    length: float | None,
    sides: tuple[str, str],
) -> list[Measure]:
    """What is measured of either fold, and between them."""
    between = f"the left fold being the one {sides[0]}"
    edges = size * area.left_edge, size * area.right_edge
    found = [
        *_placed(side_measures(time, *edges, cycles, sides, between), size),
        _area_asymmetry(time, area, cycles, between),
    ]
    if length:
        found += [
            per_cycle(name, cycles, amplitudes(time, edge, cycles) / (size * length), said)
            for name, edge, said in zip(
                ("amplitude_left_relative", "amplitude_right_relative"), edges, sides, strict=True
            )
        ]
    return found


def _outlines_said(area: GlottalArea, band: tuple[Floats, Floats], lateral: bool) -> str:
    """By how much it is open where the outline is, and that shade makes it so under a lamp to one side."""
    low, high = (float(np.nanmean(edge)) / float(area.total.mean()) for edge in band)
    shade = ". Shade beside the folds makes it too large" if lateral else ""
    return (
        f"the outline is not sharp: in the mean the area lies between {low:.2f} and {high:.2f} of what is "
        f"measured, which the intervals have{shade}"
    )


def _folds_apart(area: GlottalArea, cycles: Cycles, scale: Scale, step: float) -> str:
    """That the areas beside the midline have different frequencies, neither a multiple of the other."""
    if not cycles.count:
        return ""
    left, of_left = autocorrelation_peak(area.left, step)
    right, of_right = autocorrelation_peak(area.right, step)
    if not (of_left > _PERIODIC and of_right > _PERIODIC):
        return ""
    times = max(left, right) / min(left, right)
    if abs(times / round(times) - 1) <= _APART:
        return ""
    unit = scale.unit("Hz")
    return (
        f"diplophonic: the area left of the midline repeats itself at {left:.4g} {unit}, "
        f"right of it at {right:.4g}"
    )


def _with_lost(known: Mask, time: npt.NDArray[Any], cycles: Cycles) -> tuple[int, ...]:
    """Cycles some of whose frames are not known; none of them where three, or half, would not be left."""
    lost = tuple(k for k, part in enumerate(cycles.samples(time)) if not known[part].all())
    return lost if cycles.count - len(lost) >= max(3, 0.5 * cycles.count) else ()


def _lost(known: Mask, time: npt.NDArray[Any], cycles: Cycles) -> str:
    """That the area of many frames is not known, of the cycles or, without any, of the record."""
    used = known[cycles.extent(time)] if cycles.count else known
    lost = int(np.sum(~used))
    if lost <= many_lost * used.size:
        return ""
    return f"the area of {lost} of {used.size} frames is not known and taken to lie between their neighbours'"


def _area_asymmetry(time: npt.NDArray[Any], area: GlottalArea, cycles: Cycles, note: str) -> Measure:
    values = asymmetry(amplitudes(time, area.left, cycles), amplitudes(time, area.right, cycles))
    return per_cycle("area_asymmetry", cycles, values, note)
