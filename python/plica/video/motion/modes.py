"""Modes of a flow sequence: principal components, without forming their covariance.

With the N flows as rows of V (N x n), centred, V = U G W^T: the modes are the columns of W, the coefficients
U G, the variances G^2 / (N - 1), and a mode's share its variance over the sum of all (Paper C, Eqs. 9-12,
with the mean subtracted). As N is far below n, the Gram matrix V V^T (N x N, float64) is accumulated over
blocks of rows of pixels, its eigenvectors are U, and the modes follow in a second pass. Memory: N^2 numbers
and a block.

Principal components are there of anything, of errors too. A mode of the motion is one of either half of the
frames: with P_B the projection on the first k + 2 modes of the second half, mode k of the first half has
|P_B w_k| near 1 where both move alike, and near 0 where it is chance (Gram matrices give it: w of one half
is V_A^T u / s). What travels takes two modes, in quadrature in space and in time: with the analytic signals z
of their coefficients, |sum z_k conj(z_k+1)| over their magnitudes is 1, though real coefficients are
uncorrelated. Their shares add up to that of the wave; neither has a meaning of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError
from plica.video.glottis.midline import Midline, pixels

__all__ = ["Modes", "modes"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_BLOCK = 64e6  # bytes
_SPARE = 2  # modes more of the other half, where two of about one size may be one behind the other


@dataclass(frozen=True)
class Modes:
    """Principal components of a flow sequence of N frames.

    Attributes
    ----------
    mean : (h, w, 2) px
        Mean flow; zero outside the mask.
    patterns : (k, h, w, 2)
        Modes, orthonormal over the mask's pixels and both directions, zero outside.
    coefficients : (N, k) px
        flow[i] = mean + sum over k of coefficients[i, k] patterns[k], but for the modes left out.
    share : (k)
        Of the variance of all modes.
    variance : float
        px^2, of all modes: sum over pixels of the variance over frames.
    mask : (h, w) bool
        Pixels that count.
    repeated : (k)
        0 to 1: how far each mode of the first half of the frames is one of the second; not a number where
        the halves have too few frames.
    travelling : (k)
        0 to 1: how far each mode and the next are one motion that travels; the last is not a number.
    """

    mean: Floats
    patterns: Floats
    coefficients: Floats
    share: Floats
    variance: float
    mask: Mask
    repeated: Floats
    travelling: Floats

    def symmetry(self, midline: Midline) -> Floats:
        """(k) -1 to 1: the modes' likeness to their mirror image in the midline.

        1: left and right move alike, towards and from the midline; -1: in opposite phase. Mirror images are
        interpolated linearly; pixels whose mirror image does not count do not count.
        """
        from scipy import ndimage

        place = midline.place(pixels(self.mask.shape))
        x, y = np.moveaxis(midline.points(place * [1, -1]), -1, 0)
        other = ndimage.map_coordinates(self.mask.astype(float), [y, x], order=1, mode="constant")
        both = self.mask & (other > 0.999)
        found = np.full(len(self.patterns), np.nan)
        for k, pattern in enumerate(self.patterns):
            image = np.stack(
                [ndimage.map_coordinates(part, [y, x], order=1) for part in np.moveaxis(pattern, -1, 0)], -1
            )
            image -= 2 * (image @ midline.across)[..., None] * midline.across
            a, b = pattern[both], image[both]
            size = np.sqrt(np.sum(a * a) * np.sum(b * b))
            if size > 0:
                found[k] = np.sum(a * b) / size
        return found


def modes(
    flows: Any,
    count: int = 6,
    mask: Mask | None = None,
    midline: Midline | None = None,
    seen: Mask | None = None,
) -> Modes:
    """Principal components of a sequence of flows.

    Parameters
    ----------
    flows : (N, h, w, 2) px
        An array, or an HDF5 dataset that is read in blocks of rows, twice.
    count : int
        Modes kept, fewer than N.
    mask : (h, w) bool, optional
        Pixels that count.
    midline : Midline, optional
        With it a mode's sign is that in which the folds part while its coefficient is positive; without, and
        where it neither parts nor closes them, its largest component is positive.
    seen : (N) bool, optional
        Flows that count; the coefficients of others are not a number.

    Raises
    ------
    VideoError
        For fewer than three flows, a mask without pixels, a flow that is not finite within it, or no motion.
    """
    height, width = int(flows.shape[1]), int(flows.shape[2])
    rows_used = np.arange(flows.shape[0]) if seen is None else np.flatnonzero(seen)
    frames = rows_used.size
    if frames < 3:
        raise VideoError(f"Modes: {frames} flows; must be three or more.")
    if not 1 <= count < frames:
        raise VideoError(f"Modes: count = {count}; must be in [1, {frames}), fewer than the flows.")
    used = np.ones((height, width), dtype=bool) if mask is None else np.asarray(mask, dtype=bool)
    if used.shape != (height, width) or not used.any():
        raise VideoError(
            f"Modes: the mask has {int(used.sum())} pixels; must have some, of {height} x {width}."
        )
    rows = max(1, int(_BLOCK / (16 * flows.shape[0] * width)))
    bands = [slice(top, min(top + rows, height)) for top in range(0, height, rows)]

    mean = np.zeros((height, width, 2))
    gram = np.zeros((frames, frames))
    for band in bands:
        data = _band(flows, band, used)[rows_used]
        mean[band][used[band]] = data.mean(axis=0).reshape(-1, 2)
        data -= data.mean(axis=0)
        gram += data @ data.T
    variances, vectors = np.linalg.eigh(gram)
    variances, vectors = np.maximum(variances[::-1], 0.0), vectors[:, ::-1]
    total = float(variances.sum())
    if not total > 0:
        raise VideoError("Modes: no flow differs from the mean; must be a recording of something that moves.")
    # Eigenvalues below the Gram matrix's round-off say nothing.
    found = min(count, int(np.sum(variances > 1e-12 * variances[0])))
    sizes = np.sqrt(variances[:found])
    patterns = np.zeros((found, height, width, 2))
    for band in bands:
        data = _band(flows, band, used)[rows_used]
        data -= data.mean(axis=0)
        part = (vectors[:, :found] / sizes).T @ data
        patterns[:, band][:, used[band]] = part.reshape(found, -1, 2)
    signs = _signs(patterns, midline)
    coefficients = np.full((flows.shape[0], found), np.nan)
    coefficients[rows_used] = vectors[:, :found] * sizes * signs
    return Modes(
        mean,
        patterns * signs[:, None, None, None],
        coefficients,
        variances[:found] / total,
        total / (frames - 1),
        used,
        _repeated(gram, found),
        _travelling(vectors[:, :found]),
    )


def _repeated(gram: Floats, count: int) -> Floats:
    """(count) |P_B w_k| of the module docstring, from the centred Gram matrix (N, N)."""
    half = len(gram) // 2
    found = np.full(count, np.nan)
    parts = slice(0, half), slice(half, len(gram))
    sizes, vectors = [], []
    for part in parts:
        own = _centred(_centred(gram[part, part]).T)
        values, own_vectors = np.linalg.eigh(own)
        sizes.append(np.sqrt(np.maximum(values[::-1], 0.0)))
        vectors.append(own_vectors[:, ::-1])
    between = _centred(_centred(gram[parts]).T).T
    most = min(half - 1, count)
    there = [int(np.sum(size > 1e-6 * size[0])) if size[0] > 0 else 0 for size in sizes]
    inner = vectors[0].T @ between @ vectors[1]
    for k in range(min(most, there[0])):
        other = min(k + _SPARE, there[1])
        part = inner[k, :other] / (sizes[0][k] * sizes[1][:other])
        found[k] = min(float(np.linalg.norm(part)), 1.0)
    return found


def _centred(matrix: Floats) -> Floats:
    """Less the mean of its rows."""
    return np.asarray(matrix - matrix.mean(axis=0))


def _travelling(coefficients: Floats) -> Floats:
    """(k) of each of the coefficients (N, k) and the next."""
    from scipy import signal

    analytic = signal.hilbert(coefficients, axis=0)
    found = np.full(coefficients.shape[1], np.nan)
    for k in range(found.size - 1):
        one, other = analytic[:, k], analytic[:, k + 1]
        sizes = float(np.linalg.norm(one) * np.linalg.norm(other))
        found[k] = abs(np.vdot(other, one)) / sizes if sizes > 0 else np.nan
    return found


def _band(flows: Any, band: slice, used: Mask) -> Floats:
    """(N, 2 x pixels of the mask in these rows)."""
    data = np.asarray(flows[:, band], dtype=np.float64)[:, used[band]]
    if not np.isfinite(data).all():
        frame = int(np.argwhere(~np.isfinite(data))[0, 0])
        raise VideoError(f"Modes: flow {frame} is not finite within the mask; must be.")
    return data.reshape(data.shape[0], -1)


def _signs(patterns: Floats, midline: Midline | None) -> Floats:
    flat = patterns.reshape(patterns.shape[0], -1)
    largest = np.take_along_axis(flat, np.abs(flat).argmax(axis=1)[:, None], axis=1)[:, 0]
    telling = largest
    if midline is not None:
        outward = np.sign(midline.place(pixels(patterns.shape[1:3]))[..., 1])
        parting = np.sum(patterns @ midline.across * outward, axis=(1, 2))
        says = np.abs(parting) > 1e-6 * np.abs(patterns).sum(axis=(1, 2, 3))
        telling = np.where(says, parting, largest)
    return np.where(telling < 0, -1.0, 1.0)
