"""The line in which the folds meet: its ends, its bow, the sides of the frame that it divides, mirror images.

Folds need not meet on the straight line between their ends: a fold that is paralysed beside it is met where
it lies, folds may be bowed, a swelling fills the middle. So the line has a bow, how far it lies to the right
of the straight one at each place (:func:`closing_in`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.glottis.regions import bounds

__all__ = ["Midline", "closing_in", "find_midline"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Covered = Mask | Floats  # (h, w) a mask, or how much of each pixel is glottis

_STEEPEST = 45.0  # degrees from the vertical, beyond which left and right are not those of the image
# Standard deviations of a slit's centre: of edges rounded to pixels, px; as shares of its width, how far one
# fold is ahead of the other all along a frame, and how that differs from slit to slit. Chosen on recordings
# whose line is known (docs/verification/video.md).
_ROUNDED, _AHEAD, _UNLIKE = 0.3, 0.05, 0.1
_BOWED = 2.0  # px: folds that meet within it of a straight line meet on the straight line
_STRETCH = 4.0  # px, the same where it is asked whether there is one
_SEEN, _NARROW = 1.5, 0.05  # px, of slits that blur hardly makes narrower; the weight of others
_SHARED = 0.3  # of a width, what else its centre has
_SMOOTH = 1.5  # px, standard deviation of the blur of the bow along the line
_FEWEST = 4  # slits on a place, of as many frames, that tell where it closes
_ACROSS, _ALONG = 11, 5  # px: strands across the glottis, and along it, are narrower
_WIDE, _HALF = (
    4,
    0.5,
)  # px, and share of the extent of the lesser part beside it, over which a strand parts it
_KNOTS, _END = 65, 3  # of a bow that is found; those that tell where it ends


@dataclass(frozen=True)
class Midline:
    """The glottal midline, px: from its upper to its lower end in the image.

    Left and right of it are those of the image. Which end is the anterior one, and which side the patient's
    left, is for whoever knows to say.

    Attributes
    ----------
    upper, lower : (float, float) px
    bow : (k) px
        How far it lies right of the straight line between its ends, at places evenly spaced from the upper to
        the lower, linear between them; empty: it is straight.

    Raises
    ------
    VideoError
        Where the ends are one, or the line runs more than 45 degrees from the vertical.
    """

    upper: tuple[float, float]
    lower: tuple[float, float]
    bow: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not np.isfinite([self.upper, self.lower]).all() or self.length == 0:
            raise VideoError(f"Midline: ends = {self.upper}, {self.lower} px; must be two points.")
        along = self.along
        lean = float(np.degrees(np.arctan2(along[0], along[1])))  # anticlockwise as seen
        if abs(lean) > _STEEPEST:
            raise VideoError(
                f"Midline: it runs {abs(lean):.0f} degrees from the vertical; must be within {_STEEPEST:g}, "
                "with its upper end first, so that left and right are those of the image. Turn the frames "
                f"by {-lean:.0f} degrees more (--rotation); where what was found is no glottis, draw a mask "
                "(plica masks)."
            )

    @classmethod
    def between(cls, ends: Sequence[float], bow: Sequence[float] = ()) -> Midline:
        """The line with these ends, x, y, x, y in px, whichever is the upper one, and this bow."""
        x, y, other_x, other_y = map(float, ends)
        upper, lower = sorted(((x, y), (other_x, other_y)), key=lambda end: end[1])
        return cls(upper, lower, tuple(map(float, bow)))

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Midline:
        """The line of these :attr:`numbers`."""
        ends, bow = numbers[:4], numbers[4:]
        return cls.between(ends, bow if np.any(bow) else ())

    @property
    def as_set(self) -> Midline:
        """The line with ends that somebody set, of this one in which the folds meet beside it
        (:func:`closing_in`): through its ends, and between them bowed as the folds meet."""
        if not self.bow:
            return self
        bow = np.array(self.bow)
        first, last = (float(np.median(part)) for part in (bow[:_END], bow[-_END:]))
        rest = bow - np.linspace(first, last, bow.size)
        return replace(self, bow=tuple(rest.tolist()) if np.abs(rest).max() > _BOWED else ())

    @property
    def numbers(self) -> Floats:
        """(69) px: its ends, and its bow at 65 places, as a file has it."""
        return np.append(self.ends, self.bow_at(np.linspace(0.0, self.length, _KNOTS)))

    @property
    def ends(self) -> Floats:
        """(4) px: x, y of the upper end, x, y of the lower."""
        return np.array([*self.upper, *self.lower])

    @property
    def length(self) -> float:
        """px."""
        return float(np.hypot(*np.subtract(self.lower, self.upper)))

    @property
    def along(self) -> Floats:
        """(2) unit vector from the upper to the lower end."""
        return np.asarray(np.subtract(self.lower, self.upper) / self.length)

    @property
    def across(self) -> Floats:
        """(2) unit vector to the image's right."""
        return np.array([self.along[1], -self.along[0]])

    def place(self, points: Floats) -> Floats:
        """(..., 2) of points (..., 2), px: how far along the line from its upper end, and right of it."""
        place = np.asarray((points - np.array(self.upper)) @ np.stack([self.along, self.across], axis=1))
        if self.bow:
            place[..., 1] -= self.bow_at(place[..., 0])
        return place

    def bow_at(self, along: Floats) -> Floats:
        """(...) px, right of the straight line, at places (...) so many px from the upper end."""
        if not self.bow:
            return np.zeros_like(along)
        return np.interp(along, np.linspace(0.0, self.length, len(self.bow)), self.bow)

    def points(self, place: Floats) -> Floats:
        """(..., 2) px: the points that lie there; the inverse of :meth:`place`."""
        if self.bow:
            along, off = np.moveaxis(np.asarray(place, dtype=float), -1, 0)
            place = np.stack([along, off + self.bow_at(along)], axis=-1)
        return np.asarray(np.array(self.upper) + place @ np.stack([self.along, self.across]))

    def near(self, shape: tuple[int, int]) -> Mask:
        """(h, w) within half of its length: where the folds are."""
        along, across = np.moveaxis(self.place(pixels(shape)), -1, 0)
        beyond = np.maximum(np.maximum(-along, along - self.length), 0.0)
        return np.asarray(np.hypot(across, beyond) < 0.5 * self.length)

    def reach(self, tissue: Mask) -> float:
        """px on either side that take in the glottis at its widest, which is never `tissue` (h, w), and half
        as much again."""
        across = self.place(pixels(tissue.shape))[..., 1]
        return 1.5 * float(np.abs(across[~tissue]).max(initial=0.0))


def pixels(shape: tuple[int, ...]) -> Floats:
    """(h, w, 2) px, x and y of every pixel."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]].astype(float)
    return np.stack([x, y], axis=-1)


def find_midline(glottis: Iterable[Mask]) -> Midline:
    """The straight line in which the folds meet, or that they meet beside (:func:`closing_in`).

    Across the principal axis of all masks together, a slit of width w at the place s has its centre at
    o + k s + a w + e: off the line o + k s by the share a of its width, since one fold is farther from it
    than the other, and by an error e. The share is the frame's own, about alike in all of its slits; e is
    of what pixels round and of what differs from slit to slit. Least squares over all slits, with the a of
    each frame solved for too: so neither the fold that swings further draws the line to it, nor do slits of
    one pixel, which can only stand in one column or in the next, decide alone. Keeps a bit a pixel.

    Raises
    ------
    VideoError
        Where no mask has a glottis, or all together no direction, or one across the image.
    """
    kept: list[tuple[tuple[int, ...], npt.NDArray[np.uint8]]] = []
    moments = np.zeros(6)  # sums of 1, x, y, xx, xy, yy over all pixels
    for mask in glottis:
        y, x = np.nonzero(mask)
        if x.size:
            moments += [x.size, x.sum(), y.sum(), x @ x, x @ y, y @ y]
            kept.append((mask.shape, np.packbits(mask)))
    if not kept:
        raise VideoError("Midline: no frame has a glottis; must have one. Set the midline's two ends.")
    centre, along = _axis(moments)
    across = np.array([along[1], -along[0]])
    matrix, right, ends = np.zeros((2, 2)), np.zeros(2), np.array([np.inf, -np.inf])
    for shape, bits in kept:
        inside = np.unpackbits(bits, count=shape[0] * shape[1]).reshape(shape)
        points = np.argwhere(inside)[:, ::-1] - centre
        slits = _slits(points @ along, points @ across)
        matrix, right = matrix + (terms := _terms(*slits))[0], right + terms[1]
        ends = np.array([min(ends[0], slits[0].min()), max(ends[1], slits[0].max())])
    offset, slope = np.linalg.lstsq(matrix, right, rcond=None)[0]
    upper, lower = (centre + end * along + (offset + slope * end) * across for end in ends)
    return Midline((float(upper[0]), float(upper[1])), (float(lower[0]), float(lower[1])))


def closing_in(glottis: Iterable[Covered], line: Midline, *, keep_ends: bool = False) -> Midline:
    """The line in which the folds meet, with its bow, from the straight one.

    On each line across it, slits of all frames have centres m = c + a w, w being their width and a what one
    fold moves more than the other there: c is where they close, by least squares. A slit's weight falls with
    its width, whose share in the centre need not be one number. Where no place closes over two pixels beside
    the straight line it is kept: folds that swing out of phase seem to close by so much beside it.

    Parameters
    ----------
    glottis : (h, w), of each frame
        Masks, or how much of each pixel is glottis.
    line : Midline
        Straight.
    keep_ends : bool
        Whether its ends are those that somebody set, which the folds may meet beside; else they come to lie
        where the folds meet there.
    """
    sums: Floats | None = None  # of 1, w, w w, m, m w over the slits of each line, weighted; of the slits
    slits: Slits | None = None
    for mask in glottis:
        slits = slits or Slits(line, mask.shape)
        width, centre, _ = slits.of(mask)
        weight = np.where(width >= _SEEN, 1.0, np.where(width >= 0.5, _NARROW, 0.0))
        weight /= _ROUNDED**2 + (_SHARED * width) ** 2
        terms = np.stack(
            [weight, weight * width, weight * width**2, weight * centre, weight * centre * width]
        )
        terms = np.vstack([terms, weight > 0])
        sums = terms if sums is None else sums + terms
    if sums is None or slits is None:
        return line
    closes, sure = _closing(sums)
    there = (sums[5] >= _FEWEST) & (slits.along > -_SMOOTH) & (slits.along < line.length + _SMOOTH)
    if there.sum() < 2 * _FEWEST:
        return line
    from scipy import ndimage

    weight = np.where(there, sure, 0.0)
    smooth, smoother = (
        ndimage.gaussian_filter1d(weight * closes, width)
        / np.maximum(ndimage.gaussian_filter1d(weight, width), 1e-12)
        for width in (_SMOOTH, _STRETCH)
    )
    often = there & (sums[5] >= sums[5].max() / 2)
    if not often.any() or np.abs(smoother[often]).max() <= _BOWED:
        return line
    along, off = slits.along[there], smooth[there]
    if keep_ends:
        at = np.linspace(0.0, line.length, _KNOTS)
        return replace(line, bow=tuple(np.interp(at, along, off).tolist()))
    ends = along[0], along[-1]
    reached = [float(np.median(off[np.abs(along - end) < 2 * _SMOOTH])) for end in ends]
    upper, lower = line.points(np.stack([ends, reached], axis=1))
    bent = Midline((float(upper[0]), float(upper[1])), (float(lower[0]), float(lower[1])))
    place = bent.place(line.points(np.stack([along, off], axis=1)))
    at = np.linspace(0.0, bent.length, _KNOTS)
    return replace(bent, bow=tuple(np.interp(at, place[:, 0], place[:, 1]).tolist()))


def _closing(sums: Floats) -> tuple[Floats, Floats]:
    """(lines) px, where slits with these sums close, and what that weighs: a's standard deviation is 1/2."""
    one, w, ww, m, mw, _ = sums
    ww = ww + 4.0
    determinant = np.maximum(one * ww - w * w, 1e-12)
    return (ww * m - w * mw) / determinant, determinant / ww


class Slits:
    """The slits of masks, or coverages, (h, w) on lines across a midline, a pixel apart.

    A pixel counts for the two lines it lies between, by how near it is to each. What lies over a slit, as a
    strand of mucus, is no tissue's edge: what parts the mask over its width by a few pixels is slit. Folds
    that touch in their middle part it where it is narrow.

    Attributes
    ----------
    along : (lines) px
        From the midline's upper end.
    """

    def __init__(self, midline: Midline, shape: tuple[int, ...]) -> None:
        along, self._off = np.moveaxis(midline.place(pixels(shape)), -1, 0)
        self._turn = float(midline.across[0])  # px across the line, of one along an image's row
        self._first = int(np.floor(along.min()))
        self._count = int(np.floor(along.max())) - self._first + 2
        self._number = np.floor(along).astype(int) - self._first
        self._share = along - np.floor(along)  # of the line below
        self.along = self._first + np.arange(self._count, dtype=float)

    def _sums(self, where: Mask, values: Floats) -> Floats:
        number, share = self._number[where], self._share[where]
        found = np.bincount(number, values * (1 - share), self._count)
        return np.asarray(found + np.bincount(number + 1, values * share, self._count))

    def of(self, glottis: Covered) -> tuple[Floats, Floats, Floats]:
        """(lines) each: widths, px; centres right of the midline, px; share of the width that something lies
        over; 0 where there is no slit."""
        covered = np.asarray(glottis, dtype=float)
        seen = covered >= 0.5
        inside = without_strands(seen)
        left, right = np.zeros_like(inside), np.zeros_like(inside)  # neighbours that are inside
        left[:, 1:], right[:, :-1] = inside[:, :-1], inside[:, 1:]
        begins, ends = (inside & ~left) | (~inside & right), (inside & ~right) | (~inside & left)
        share = np.where((begins | ends) & (seen | ~inside), covered, inside)
        there = share > 0
        # What is covered of a pixel at an end lies on the side of the slit.
        part = share[there]
        off = self._off[there] + self._turn * (begins[there].astype(float) - ends[there]) * (1 - part) / 2
        count = self._sums(there, part)
        some = np.maximum(count, 1e-9)
        over = self._sums(there, part * ~seen[there])
        return count, self._sums(there, part * off) / some, over / some


def without_strands(mask: Mask) -> Mask:
    """The mask (h, w) with what strands over it hide: they part it by a few pixels, over half its width or
    more where they lie across it, over half its length or more where they lie along it."""
    from scipy import ndimage

    box = bounds(mask, max(_ACROSS, _ALONG))
    part = mask[box]
    parts, count = ndimage.label(part, np.ones((3, 3)))
    if count < 2:
        return mask
    found = mask.copy()
    found[box] |= _bridges(part, parts, _ACROSS) | _bridges(part.T, parts.T, _ALONG).T
    return found


def _bridges(mask: Mask, parts: npt.NDArray[np.int32], most: int) -> Mask:
    """What parts the mask by up to so many pixels along the first axis, over half of the extent along the
    second of either part beside it."""
    from scipy import ndimage

    around = np.ones((3, 3))
    regions, count = ndimage.label(ndimage.binary_closing(mask, np.ones((most, 1))) & ~mask, around)
    found = np.zeros_like(mask)
    for number in range(1, count + 1):
        region = regions == number
        beside = np.setdiff1d(parts[ndimage.binary_dilation(region, around)], 0)
        if beside.size < 2:
            continue
        narrowest = min(int((parts == part).sum(axis=1).max()) for part in beside)
        if region.any(axis=0).sum() >= max(_WIDE, _HALF * narrowest):
            found |= region
    return found


def _axis(moments: Floats) -> tuple[Floats, Floats]:
    """(2) centre and (2) principal axis, downwards, of pixels with these sums of 1, x, y, xx, xy, yy."""
    centre = moments[1:3] / moments[0]
    second = moments[[3, 4, 4, 5]].reshape(2, 2) / moments[0] - np.outer(centre, centre)
    spreads, axes = np.linalg.eigh(second)
    if not spreads[1] > 2.0 * spreads[0]:
        raise VideoError(
            f"Midline: the glottis is {np.sqrt(spreads[1] / max(spreads[0], 1e-12)):.2g} times as long as "
            "wide; must be clearly longer. Does it open? Set the midline's two ends, or draw a mask."
        )
    return centre, axes[:, 1] if axes[1, 1] >= 0 else -axes[:, 1]


def _slits(along: Floats, across: Floats) -> tuple[Floats, Floats, Floats]:
    """Place along the axis, centre across it and width of each slit of one mask, px."""
    first = along.min()
    rows = np.floor(along - first + 0.5).astype(int)
    count = np.bincount(rows)
    there = np.flatnonzero(count)
    total = np.bincount(rows, weights=across)
    return there + first, total[there] / count[there], count[there].astype(float)


def _terms(place: Floats, centre: Floats, width: Floats) -> tuple[Floats, Floats]:
    """A frame's part of the normal equations (2, 2), (2) for offset and slope, its own share a eliminated."""
    weight = 1 / (_ROUNDED**2 + (_UNLIKE * width) ** 2)
    lines = np.stack([np.ones_like(place), place])
    matrix, right = (lines * weight) @ lines.T, (lines * weight) @ centre
    coupled = (lines * weight) @ width
    own = weight @ width**2 + 1 / _AHEAD**2
    return matrix - np.outer(coupled, coupled) / own, right - coupled * (weight @ (width * centre)) / own
