"""Where the tissue of each fold ends, along the midline and over time.

A slit has its edges where its outline has them, each fold its own. While the folds touch, both edges are the
line of contact, which need not be the midline and need not rest: a fold that comes late is met beyond it.
Contact begins where the edges' last ways lead them together, at

    x = x_left + v_left tau,    tau = (x_right - x_left) / (v_left - v_right),

and ends where their first ways came from. The slower edge may have stopped between two frames, as it does
where the other one lies against it: of its way from its slit to x it goes the share that its speed is of the
other's. Between, contact moves as the edges come and go: a cubic in time, with a velocity at either end that
is the lesser of the edges' own where both go the same way, and none where they go against each other or one
of them stands still, which stops the other. Or it rests where it mostly is, as far as the slits that are seen
last and first have that place. Neither is seen: it is taken halfway between both, and may be off by as much,
by as far as it would go with the mean of their velocities, as two bodies alike do, or by what the midline is
nearer, where folds stop that meet on it
(docs/recordings_motion.md, "Left and right").

A strand of mucus hides the edges below it. In a wide slit it is known by parting the mask, in a narrow one it
is not; so what a strand crosses in many frames in which the slit is wide there has, in all frames, the edges
of the lines beside the strand, on a parabola in between: a strand that slants crosses many lines where the
slit is wide, in which the folds are curved.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plica.video.glottis.blurred_slit import slit_width
from plica.video.glottis.midline import Covered, Midline, Slits

__all__ = ["FoldEdges", "SlitsOverTime", "fold_edges"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_OPEN = 0.5  # px: a narrower slit is none
_ALONG = 2.0  # px, standard deviation of the blur along the midline of what is told of contact
_SLOW = 0.1  # px a frame: folds that near each other by less do not say where they meet
_STILL = 0.2  # of the other's speed: an edge that is slower stands still
_STOPS = 0.7  # px from the midline, within which folds may stop on it
_LATEST = 1.5  # frames from the last slit that is seen to contact, at most
_BEYOND = 0.3  # of the swing: contact does not leave its ends by more
_HIDDEN = 0.1  # of a slit's width, from which a strand crosses its line
_OFTEN = 0.2  # of the frames in which the slit is wide: then it does in all
_LEAST_BESIDE = 4  # lines on either side of those it crosses, at least
_CROSSED = 25  # lines: a strand that crosses more lies along the glottis, and its ends say nothing of them


@dataclass(frozen=True)
class FoldEdges:
    """The edges on lines across the midline, a pixel apart.

    Attributes
    ----------
    along : (lines) px
        From the midline's upper end.
    left, right : (frames, lines) px
        How far each fold's edge lies from the midline on its own side, negative beyond it.
    open : (frames, lines) bool
        Where there is a slit; elsewhere the folds touch.
    contact : (frames, lines) px
        To the right, how far the line of contact may be off; 0 in slits.
    """

    along: Floats
    left: Floats
    right: Floats
    open: Mask
    contact: Floats


class SlitsOverTime:
    """Collects slits frame by frame; for `blur` see :func:`fold_edges`."""

    def __init__(self, midline: Midline, blur: float = 0.0) -> None:
        self._midline, self._blur = midline, blur
        self._slits: Slits | None = None
        self._found: list[tuple[Floats, Floats, Floats]] = []

    def add(self, glottis: Covered) -> None:
        """Those of the next frame."""
        self._slits = self._slits or Slits(self._midline, glottis.shape)
        self._found.append(self._slits.of(glottis))

    def areas(self) -> tuple[Floats, Floats]:
        """(frames) px^2 of all slits, left and right of the midline, with what strands hide of them."""
        width, centre = self._uncovered()
        right = np.clip(width / 2 + centre, 0.0, width)
        return (width - right).sum(axis=1), right.sum(axis=1)

    def edges(self) -> FoldEdges:
        """Of all frames that were added."""
        if self._slits is None:
            none = np.zeros((0, 0))
            return FoldEdges(np.zeros(0), none, none, none > 0, none)
        width, centre = self._uncovered()
        along = self._slits.along
        kept = (along >= 0) & (along <= self._midline.length)
        return _edges(along[kept], width[:, kept], centre[:, kept], self._blur)

    def _uncovered(self) -> tuple[Floats, Floats]:
        """(frames, lines) px: widths, and centres right of the midline, below strands as beside them."""
        width, centre, over = np.moveaxis(np.array(self._found), 1, 0)
        crossed = _crossed(width, over)
        free = np.ones(width.shape[1], dtype=bool)
        for begin, end in crossed:
            free[begin:end] = False
        for begin, end in crossed:
            lines = slice(begin, end)
            width[:, lines], centre[:, lines] = _between_sides(width, centre, begin, end, free)
        return width, centre


def fold_edges(glottis: Iterable[Covered], midline: Midline, blur: float = 0.0) -> FoldEdges:
    """Of the masks, or coverages, (h, w) of all frames.

    Parameters
    ----------
    glottis, midline
    blur : float
        px, standard deviation, of their edges: which slits it made narrower is known for where they close.
    """
    slits = SlitsOverTime(midline, blur)
    for mask in glottis:
        slits.add(mask)
    return slits.edges()


def _crossed(width: Floats, over: Floats) -> list[tuple[int, int]]:
    """Lines, from and up to, that a strand crosses: in many frames in which the slit is wide there; with the
    line beside them either way, which its blurred border brightens. There are slits beside these."""
    largest = width.max(axis=0)
    wide = (width >= 0.5 * largest) & (width >= _OPEN)
    crossed = ((over > _HIDDEN) & wide).sum(axis=0) > _OFTEN * wide.sum(axis=0)
    crossed &= largest >= 0.5 * largest.max()  # at pointed ends masks are in parts without a strand
    ends = np.flatnonzero(np.diff(np.concatenate([[False], crossed, [False]]).astype(int))).reshape(-1, 2)
    wider = [(begin - 1, end + 1) for begin, end in ends.tolist() if end - begin <= _CROSSED]
    return [
        (begin, end)
        for begin, end in wider
        if begin > 0 and end < largest.size and min(largest[begin - 1], largest[end]) >= _OPEN
    ]


def _between_sides(width: Floats, centre: Floats, begin: int, end: int, free: Mask) -> tuple[Floats, Floats]:
    """(frames, end - begin) px: widths and centres on these lines, from those on either side which are free.

    Parabolas through half as many lines on each side in frames in which all of these are open; in the others
    straight from the line above to the one below, and the centre that of the one which is open.
    """
    above, below, count = begin - 1, end, max(_LEAST_BESIDE, (end - begin) // 2)
    share = ((np.arange(begin, end) - above) / (below - above))[None]
    parts = (1 - share) * (width[:, above, None] > 0), share * (width[:, below, None] > 0)
    known = np.maximum(parts[0] + parts[1], 1e-9)
    between = (
        (1 - share) * width[:, above, None] + share * width[:, below, None],
        (parts[0] * centre[:, above, None] + parts[1] * centre[:, below, None]) / known,
    )
    beside = np.r_[max(begin - count, 0) : begin, end : min(end + count, width.shape[1])]
    beside = beside[free[beside]]
    between_them = beside.size >= _LEAST_BESIDE and bool((beside < begin).any() and (beside >= end).any())
    whole = (width[:, beside] >= _OPEN).all(axis=1) & between_them
    middle, half = (above + below) / 2, (below - above) / 2
    powers = [np.vander((lines - middle) / half, 3) for lines in (np.arange(begin, end), beside)]
    along = powers[0] @ np.linalg.pinv(powers[1])  # (end - begin, beside)
    for found, seen in zip(between, (width, centre), strict=True):
        found[whole] = seen[np.ix_(whole, beside)] @ along.T
    return np.maximum(between[0], 0.0), between[1]


def _edges(along: Floats, width: Floats, centre: Floats, blur: float) -> FoldEdges:
    opened = width >= _OPEN
    width = np.where(opened, width, 0.0)
    moving, resting, carried = _contact(np.where(opened, slit_width(width, blur), 0.0), centre, opened)
    middle = np.where(opened, centre, (moving + resting) / 2)
    doubts = np.stack([(moving - resting) / 2, carried - middle, np.clip(-middle, -_STOPS, _STOPS)])
    most = np.take_along_axis(doubts, np.abs(doubts).argmax(axis=0)[None], axis=0)[0]
    doubt = np.where(opened, 0.0, most)
    return FoldEdges(along, width / 2 - middle, width / 2 + middle, opened, doubt)


def _contact(width: Floats, centre: Floats, opened: Mask) -> tuple[Floats, Floats, Floats]:
    """(frames, lines) px right of the midline, of closed lines: where contact is if it moves as the
    edges' ways lead it, if it rests, and if both carry it on. The midline where a line never opens."""
    width, centre = _blurred(width, opened), _blurred(centre, opened)
    edges = centre - width / 2, centre + width / 2
    swing = _swing(edges[0], opened) + _swing(edges[1], opened)
    moving, resting, carried = np.zeros((3, *opened.shape))
    for line in range(opened.shape[1]):
        closures = list(_closures(edges[0][:, line].tolist(), edges[1][:, line].tolist(), opened[:, line]))
        for part, begin, end in closures:
            moving[part, line] = _between(part, begin, end, float(swing[line]))
            carried[part, line] = _between(part, begin.carried_on, end.carried_on, float(swing[line]))
        if closures:
            rest = float(np.median(moving[~opened[:, line], line]))
            for part, begin, end in closures:
                resting[part, line] = _between(part, begin.at_rest(rest), end.at_rest(rest), 0.0)
    return moving, resting, carried


def _closures(
    left: list[float], right: list[float], opened: Mask
) -> Iterator[tuple[slice, _Meeting, _Meeting]]:
    """Frames in which a line of these edges is closed, and where the folds begin to touch and part."""
    seen = opened.tolist()
    turns = np.flatnonzero(np.diff(opened.astype(int)))  # the frame before each turn
    for before, last in pairwise([-1, *turns.tolist(), len(seen) - 1]):
        if seen[last]:
            continue
        begin = _Meeting.of(left, right, seen, before, -1) if before >= 0 else None
        end = _Meeting.of(left, right, seen, last + 1, 1) if last + 1 < len(seen) else None
        begin, end = begin or end, end or begin
        if begin is not None and end is not None:
            yield slice(before + 1, last + 1), begin, end


class _Meeting(NamedTuple):
    """Where the folds begin to touch, or part.

    Attributes
    ----------
    frame : float
    place : float
        px right of the midline.
    velocity, carried : float
        px a frame, of the line of contact: as the edges lead it, and their mean.
    slit : (float, float)
        px, the edges in the slit that is seen last, or first.
    """

    frame: float
    place: float
    velocity: float
    carried: float
    slit: tuple[float, float]

    def at_rest(self, place: float) -> _Meeting:
        """The same at rest, at this place or what of the slit is nearest to it."""
        return self._replace(place=min(max(place, self.slit[0]), self.slit[1]), velocity=0.0)

    @property
    def carried_on(self) -> _Meeting:
        """The same with the mean of the velocities."""
        return self._replace(velocity=self.carried)

    @classmethod
    def of(cls, left: list[float], right: list[float], seen: list[bool], frame: int, way: int) -> _Meeting:
        """Of edges whose slit in this frame is the last before contact (way -1) or the first after it (1)."""
        ends = left[frame], right[frame]
        speeds = [_speed(edge, seen, frame, way) for edge in (left, right)]  # towards contact
        closing = speeds[0] - speeds[1]
        if closing <= _SLOW:
            middle = (ends[0] + ends[1]) / 2
            return cls(frame - way / 2, middle, 0.0, 0.0, ends)
        later = min((ends[1] - ends[0]) / closing, _LATEST)
        led = min(max(ends[0] + later * speeds[0], ends[0]), ends[1])
        slower = int(abs(speeds[1]) < abs(speeds[0]))
        share = abs(speeds[slower] / speeds[1 - slower])
        place = ends[slower] + share * (led - ends[slower])
        velocity = 0.0 if speeds[0] * speeds[1] <= 0 else speeds[slower]
        carried = 0.0 if share < _STILL else (speeds[0] + speeds[1]) / 2
        return cls(frame - way * later, place, -way * velocity, -way * carried, ends)


def _speed(edge: list[float], seen: list[bool], frame: int, way: int) -> float:
    """px a frame, at which an edge comes to a frame from the one a `way` from there; 0 if it is not seen
    there."""
    beside = frame + way
    return edge[frame] - edge[beside] if 0 <= beside < len(seen) and seen[beside] else 0.0


def _between(part: slice, begin: _Meeting, end: _Meeting, swing: float) -> Floats:
    """(k) px, of the line of contact in these frames."""
    at = np.arange(float(part.start), float(part.stop))
    if begin == end:
        return np.full(at.size, begin.place)
    long = max(end.frame - begin.frame, 1.0)
    s = np.minimum(np.maximum((at - begin.frame) / long, 0.0), 1.0)  # np.clip takes longer than all the rest
    smooth = begin.place + s * s * (3 - 2 * s) * (end.place - begin.place)
    cubic = smooth + long * s * (1 - s) * ((1 - s) * begin.velocity - s * end.velocity)
    low, high = sorted((begin.place, end.place))
    return np.asarray(np.minimum(np.maximum(cubic, low - _BEYOND * swing), high + _BEYOND * swing))


def _swing(edge: Floats, opened: Mask) -> Floats:
    """(lines) px, of an edge where there is a slit."""
    low, high = np.where(opened, edge, np.inf).min(axis=0), np.where(opened, edge, -np.inf).max(axis=0)
    return np.maximum(np.where(opened.any(axis=0), high - low, 0.0), 0.0)


def _blurred(values: Floats, opened: Mask) -> Floats:
    """Along the midline, of slits alone."""
    from scipy import ndimage

    weight = opened.astype(float)
    top, bottom = (ndimage.gaussian_filter1d(part, _ALONG, axis=1) for part in (weight * values, weight))
    return np.asarray(np.where(opened, top / np.maximum(bottom, 1e-9), 0.0))
