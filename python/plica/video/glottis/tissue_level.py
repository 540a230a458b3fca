"""What each pixel of a recording is where it shows tissue: shadows and creases are told from the glottis.

One grey level for all pixels takes for glottis what is as dark as it in every frame: a shadow, the crease
of a ventricle. So a pixel's own tissue T is the brightest that it gets within two cycles before a frame and
the brightest within two cycles after it, whichever is less, and no more than the tissue's common grey B.
With D the glottis' dark, it shows glottis where it is darker than halfway from D to T. A pixel that is
bright at another time of the recording (folds that part for a breath) shows glottis too where it is as dark
as D.

A pixel that is never brighter than halfway from D to B is *always dark*: a gap that never closes and a shadow
look alike there. It counts as a gap where it is as dark as D at some time (within a fifth) and the folds move
beside it, in the mean over seven rows across the glottis' axis. Pixels move that vary by two fifths of B - D.
They do on both sides of a gap: one or more on either, and on neither less than a fifth of those on the other.
Or on one side, if the other fold is still: then those nearer to the gap are dark for longer, as the fold that
moves comes from afar, while beside a crease the fold that moves away from it leaves the farther ones dark for
longer; and the nearest three come to be dark in most cycles, unlike those that a shadow creeps over. A gap
and two pixels about it have the common level, since the lens blurs the edge where it turns. Of what else is
always dark, glottis can only be seen where the pixel's own tissue is a fifth of the way from D to B or
brighter.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.measures.pulses import autocorrelation_frequency
from plica.video.files.recording import Grey

__all__ = ["PixelLevels", "pixel_levels"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_APART = 0.2  # of the way from the glottis' dark to the tissue: own tissue that is not brighter tells nothing
_EDGE = 2  # px about a gap, over which the lens blurs its edge
_DEEP = 0.15  # of the same way: as dark as the glottis
_BLOCK = 8  # frames whose brightest values are kept together
_CYCLES = 2.0  # on either side of a frame
_ROWS = 7  # over which sides are compared
_BESIDE = 0.2  # of the moving pixels on the other side
_LONGER = 0.1  # of the time: by so much the nearer of them are dark for longer, beside a gap
_COMPARED = 2.0  # px that move, at least, so that nearer and farther ones can be compared
_NEAREST, _MOST = 3, 0.7  # px, and share of the cycles in which they come to be dark


@dataclass(frozen=True)
class PixelLevels:
    """Of every pixel within a box about the glottis.

    Attributes
    ----------
    box : (slice, slice)
        Rows and columns.
    brightest : (blocks, bh, bw)
        Grey, of each eight frames.
    window : int
        Blocks on either side: two cycles.
    always_dark : (h, w) bool
        Pixels that are darker than halfway to tissue in every frame.
    gap : (h, w) bool
        Those of them that count as glottis.
    common : (h, w) bool
        Where all pixels have one level: the gap and what is near it.
    """

    box: tuple[slice, slice]
    brightest: npt.NDArray[np.float32]
    window: int
    always_dark: Mask
    gap: Mask
    common: Mask

    def level(self, index: int, dark: float, tissue: float, share: float) -> Floats:
        """(h, w) grey below which pixels of this frame show glottis; minus infinity where they cannot."""
        block, last = index // _BLOCK, len(self.brightest) - 1
        # A cycle at least, also where the recording begins or ends.
        cycle = min(math.ceil(self.window / _CYCLES), last)
        before = self.brightest[max(block - self.window, 0) : max(block, cycle) + 1].max(axis=0)
        after = self.brightest[min(block, last - cycle) : block + self.window + 1].max(axis=0)
        own = np.minimum(np.minimum(before, after), tissue)
        least = dark + _DEEP * (tissue - dark)
        found = np.full(self.always_dark.shape, -np.inf)
        seen = own > dark + _APART * (tissue - dark)
        hidden = np.where(self.always_dark[self.box], -np.inf, least)
        found[self.box] = np.where(seen, np.maximum(dark + share * (own - dark), hidden), hidden)
        found[self.common] = dark + share * (tissue - dark)
        return found


def pixel_levels(
    frames: Iterable[Grey], near: Mask, dark: float, tissue: float, drawn: list[Mask] | None = None
) -> PixelLevels:
    """Learn them from all frames, which are read once.

    Parameters
    ----------
    frames : (h, w) each
        As they are segmented; those that show another thing left out by a mask of not-a-number values.
    near : (h, w) bool
        Where a glottis can be.
    dark, tissue : float
        Grey of the glottis and of tissue around it.
    drawn : list of (h, w) bool, optional
        Masks drawn by hand: of what is always dark the glottis is what all of them have, without asking.
    """
    rows, columns = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    box = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    within, half = near[box], 0.5 * (dark + tissue)
    blocks: list[npt.NDArray[np.float32]] = []
    darkest = np.full(within.shape, np.inf)
    area: list[int] = []
    (often, turns), seen, dark_before = np.zeros((2, *within.shape)), 0, np.ones(within.shape, dtype=bool)
    for index, frame in enumerate(frames):
        part = np.asarray(frame[box], dtype=np.float32)
        if index % _BLOCK == 0:
            blocks.append(np.full(within.shape, -np.inf, dtype=np.float32))
        np.fmax(blocks[-1], part, out=blocks[-1])
        np.fmin(darkest, part, out=darkest)
        dark_now = part < half
        if not np.isnan(part).all():
            seen += 1
            often += dark_now
            turns += dark_now & ~dark_before
            dark_before = dark_now
        area.append(int(np.sum(dark_now & within)))
    brightest = np.stack(blocks)
    frequency = autocorrelation_frequency(np.array(area, dtype=float), 1.0) if len(area) >= 8 else math.nan
    period = 1 / frequency if math.isfinite(frequency) else float(len(area))
    whole = brightest.max(axis=0)
    bright = whole > half
    always, gap = np.zeros(near.shape, dtype=bool), np.zeros(near.shape, dtype=bool)
    always[box] = within & ~bright
    if drawn:
        gap = always & np.all(drawn, axis=0)
    else:
        apart = _APART * (tissue - dark)
        moving = within & bright & (whole - darkest > 2 * apart)
        shares = often / max(seen, 1), turns * (period / max(seen, 1) if math.isfinite(frequency) else 0.0)
        gap[box] = _beside_folds(within & ~bright, moving, *shares) & (darkest < dark + apart)
    window = math.ceil(_CYCLES * period / _BLOCK)
    return PixelLevels(box, brightest, window, always, gap, _about(gap, _EDGE))


def _about(mask: Mask, width: int) -> Mask:
    from scipy import ndimage

    return np.asarray(ndimage.binary_dilation(mask, iterations=width)) if mask.any() else mask


def _beside_folds(still: Mask, moving: Mask, often: Floats, turns: Floats) -> Mask:
    """Those pixels of what is always dark beside which folds move as they do beside a gap.

    Parameters
    ----------
    still, moving : (h, w) bool
        What is always dark, and what varies by two fifths of the contrast.
    often : (h, w)
        Share of the time in which a pixel is dark.
    turns : (h, w)
        How many times a cycle it comes to be so; 0 without cycles.
    """
    y, x = np.nonzero(moving)
    if x.size < 3 or not still.any():
        return np.zeros(still.shape, dtype=bool)
    along = np.linalg.eigh(np.cov(np.stack([x, y])))[1][:, 1]
    if abs(along[1]) >= abs(along[0]):  # its rows across are the picture's rows
        return _beside_folds_in_rows(still, moving, often, turns)
    return _beside_folds_in_rows(still.T, moving.T, often.T, turns.T).T


def _beside_folds_in_rows(still: Mask, moving: Mask, often: Floats, turns: Floats) -> Mask:
    from scipy import ndimage

    places = np.arange(still.shape[1])
    beside, longer, cyclic = np.zeros((3, 2, *still.shape))  # left and right of each run of what is still
    for row in np.flatnonzero(still.any(axis=1)):
        runs, count = ndimage.label(still[row])
        for run in range(1, count + 1):
            columns = np.flatnonzero(runs == run)
            for side, away in enumerate((places[: columns[0]][::-1], places[columns[-1] + 1 :])):
                pixels = _leading(moving[row, away])
                if not pixels:
                    continue
                beside[side, row, columns] = pixels
                longer[side, row, columns] = _fall(often[row, away][:pixels])
                cyclic[side, row, columns] = turns[row, away][: min(pixels, _NEAREST)].mean()
    weight = np.maximum(_over_rows(still.astype(float)), 1e-9)
    count_of, longer, cyclic = (
        np.stack([_over_rows(side) / weight for side in part]) for part in (beside, longer, cyclic)
    )
    less, more = count_of.min(axis=0), count_of.max(axis=0)
    on_both = less >= np.maximum(1.0, _BESIDE * more)
    on_one = (count_of == more) & (count_of >= _COMPARED) & (longer > _LONGER) & (cyclic > _MOST)
    return np.asarray(still & (on_both | on_one.any(axis=0)))


def _over_rows(values: Floats) -> Floats:
    from scipy import ndimage

    return np.asarray(ndimage.uniform_filter1d(values, _ROWS, axis=0, mode="constant"))


def _fall(often: Floats) -> float:
    """By how much longer the nearer half of these pixels is dark."""
    half = often.size // 2
    return float(often[:half].mean() - often[-half:].mean()) if half else 0.0


def _leading(values: Mask) -> int:
    """How many are true before the first that is not."""
    return values.size if values.all() else int(np.argmin(values))
