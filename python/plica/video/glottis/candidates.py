"""Dark parts of a frame that an edge surrounds: what may be the glottis, or one of its openings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.video.glottis.brightness import blurred, edge_strength
from plica.video.glottis.regions import grown

__all__ = ["Candidate", "Prior", "View", "candidates"]

Floats = npt.NDArray[np.floating]
Mask = npt.NDArray[np.bool_]

_LADDER = 48  # thresholds


@dataclass(frozen=True)
class Prior:
    """What is known before the frame is looked at.

    Attributes
    ----------
    where : (h, w) or None
        Weight of each pixel, >= 0, largest 1: how much it varies over the recording, say. None: towards the
        centre of the frame.
    least_area, largest_area : float
        Of a glottis, as a share of the frame.
    """

    where: Floats | None = None
    least_area: float = 2e-4
    largest_area: float = 0.2


class View:
    """A frame's brightness over that of its surroundings, its edges, and its parts below a threshold."""

    def __init__(self, relative: Floats) -> None:
        self.relative, self.smooth = relative, blurred(relative)
        self.strength = edge_strength(relative)

    def parts(self, threshold: float) -> tuple[npt.NDArray[np.int32], int]:
        """(h, w) each part's number, 0 outside; and how many there are."""
        from scipy import ndimage

        labels, count = ndimage.label(self.smooth < threshold)
        return labels, int(count)


@dataclass(frozen=True)
class Candidate:
    """A part below a threshold.

    Attributes
    ----------
    score : float
        Mean edge strength along its outline times the mean of the prior's weight.
    threshold : float
        Relative brightness.
    label : int
        Its number among the parts of that threshold.
    labels : (h, w)
        The numbers of these.
    view : View
    """

    score: float
    threshold: float
    label: int
    labels: npt.NDArray[np.int32]
    view: View

    def mask(self) -> Mask:
        """(h, w)."""
        return np.asarray(self.labels == self.label)


def candidates(view: View, prior: Prior, least_score: float) -> Iterator[Candidate]:
    """The parts below every threshold whose score is above the least one."""
    shape = view.relative.shape
    where = _central(shape) if prior.where is None else np.asarray(prior.where, dtype=float)
    size = where.size
    for threshold in np.linspace(0.1, 0.9, _LADDER):
        labels, count = view.parts(threshold)
        if not count:
            continue
        sizes = np.bincount(labels.ravel(), minlength=count + 1)
        fits = (sizes >= prior.least_area * size) & (sizes <= prior.largest_area * size)
        for rim in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
            fits[rim] = False
        fits[0] = False
        if not fits.any():
            continue
        part = fits[labels]
        outline = part & grown(~part, 1)
        on_edge = np.bincount(labels[outline], minlength=count + 1)
        edges = np.bincount(labels[outline], weights=view.strength[outline], minlength=count + 1)
        weights = np.bincount(labels[part], weights=where[part], minlength=count + 1)
        score = edges / np.maximum(on_edge, 1) * weights / np.maximum(sizes, 1)
        for label in np.flatnonzero(fits & (score > least_score)):
            yield Candidate(float(score[label]), float(threshold), int(label), labels, view)


def _central(shape: tuple[int, ...]) -> Floats:
    """A weight that falls from 1 at the centre to a half at the middle of the sides."""
    y, x = np.ogrid[-1 : 1 : shape[0] * 1j, -1 : 1 : shape[1] * 1j]
    return np.asarray(1 / (1 + x**2 + y**2))
