"""Glottal waveforms of a recording: masks of all frames, area left and right, kymograms, measures.

Left and right are those of the image, looking along the midline from its anterior to its posterior end with
that end below; which of them is the patient's left is set by whoever knows, never guessed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.phonation.cycles import Cycles, find_cycles
from plica.phonation.measure import Measure, absent, per_cycle, whole
from plica.video.errors import VideoError
from plica.video.recording import Frames, Grey, spread
from plica.video.segmentation import Prior, around, blurred, region_below, segment

__all__ = ["GlottalArea", "Midline", "areas", "find_midline", "kymogram", "masks", "measures", "phases"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

open_share = 0.05
"""Of a cycle's largest area: above it the glottis counts as open."""
wide_share = 0.95
"""Of a cycle's largest area: above it the phase is "open", neither opening nor closing."""


@dataclass(frozen=True)
class Midline:
    """The glottal midline, px: from the anterior to the posterior end."""

    anterior: tuple[float, float]
    posterior: tuple[float, float]

    @property
    def length(self) -> float:
        """px."""
        return float(np.hypot(*np.subtract(self.posterior, self.anterior)))

    def along(self, shape: tuple[int, int]) -> Floats:
        """(h, w) how far a pixel lies along the line, 0 at its anterior and 1 at its posterior end."""
        y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
        dx, dy = np.subtract(self.posterior, self.anterior)
        return np.asarray(((x - self.anterior[0]) * dx + (y - self.anterior[1]) * dy) / self.length**2)

    def right_of(self, shape: tuple[int, int]) -> Mask:
        """(h, w) whether a pixel lies right of the line for who looks from its anterior to its posterior end
        with that end below: the image's right, for a midline that points down."""
        y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
        (ax, ay), (px, py) = self.anterior, self.posterior
        return np.asarray((px - ax) * (y - ay) - (py - ay) * (x - ax) < 0)


@dataclass(frozen=True)
class GlottalArea:
    """Glottal area, left and right of the midline in the image.

    Attributes
    ----------
    left, right : (frames) px^2
    left_edge, right_edge : (frames) px
        Mean distance of the folds' edges from the midline, over the middle tenth of its length.
    """

    left: Floats
    right: Floats
    left_edge: Floats
    right_edge: Floats

    @property
    def total(self) -> Floats:
        return self.left + self.right


def masks(recording: Frames) -> Iterator[Mask]:
    """The glottis of every frame, (h, w) bool each, in order; reads the frames three times.

    Where it can be is learnt from how much each pixel varies; some twenty frames and the darkest are
    segmented alone. They tell how dark the glottis is and how bright the tissue around it; the outline of
    every frame is halfway between the two, which is where a blurred step stands.

    Raises
    ------
    VideoError
        Where no frame has a glottis, or one no darker than the noise.
    """
    from scipy import ndimage

    darkness: list[float] = []

    def seen() -> Iterator[Grey]:
        for frame in recording.frames():
            darkness.append(float(np.percentile(frame, 5)))
            yield frame

    varies = spread(seen())
    prior = Prior(where=_smooth(varies))
    chosen = {*range(0, recording.count, max(1, recording.count // 20)), int(np.argmin(darkness))}
    found = [(frame, segment(frame, prior)) for k, frame in enumerate(recording.frames()) if k in chosen]
    largest = max(glottis.mask.sum() for _, glottis in found)
    if not largest:
        raise VideoError(
            f"Glottis: none of the {len(found)} frames looked at has a dark region within an edge; must be "
            "a recording in which the glottis opens. Cut the region around it (--region)."
        )
    reach = np.zeros(recording.shape, dtype=bool)
    dark, tissue, noise = [], [], []
    for raw, glottis in found:
        if glottis.mask.sum() < 0.3 * largest:
            continue
        frame = blurred(raw)
        noise.append(1.4826 * np.median(np.abs(raw - frame)))
        inside = ndimage.binary_erosion(glottis.mask)
        dark.append(np.median(frame[inside if inside.any() else glottis.mask]))
        tissue.append(np.median(frame[around(glottis.mask)]))
        reach |= glottis.mask
    contrast = float(np.median(tissue) - np.median(dark))
    if not contrast > 2 * np.median(noise):
        raise VideoError(
            f"Glottis: the darkest region is {contrast:.3g} grey levels darker than what is around it, "
            f"the noise {np.median(noise):.3g}; must be more than twice as much. Is this a recording of a "
            "larynx?"
        )
    level = float(np.median(dark)) + 0.5 * contrast
    # Beyond, what is dark is another thing: a shadow, the rim of the endoscope's view.
    near = ndimage.binary_dilation(reach, iterations=max(2, round(0.01 * max(recording.shape))))
    for frame in recording.frames():
        yield region_below(np.where(near, blurred(frame), np.inf), level, reach)


def _smooth(spread: Floats) -> Floats:
    from scipy import ndimage

    smooth = ndimage.gaussian_filter(spread, 0.02 * max(spread.shape))
    return np.asarray(smooth / max(float(smooth.max()), 1e-12))


def find_midline(glottis: Iterable[Mask]) -> Midline:
    """The line in which the folds meet, from its upper to its lower end in the image.

    Across the principal axis of all masks together, the centre of a slit is off the line by half its width at
    most: the line is fitted to the slits of every mask, weighted by the inverse square of their width, so
    that commissures and closing folds decide and not the larger swing of one fold.

    Raises
    ------
    VideoError
        Where no mask has a glottis, or all together no direction.
    """
    kept = [np.argwhere(mask)[:, ::-1].astype(float) for mask in glottis]
    points = np.concatenate([*kept, np.empty((0, 2))])
    if not points.size:
        raise VideoError("Midline: no frame has a glottis; must have one. Set the midline's two ends.")
    centre = points.mean(axis=0)
    spreads, axes = np.linalg.eigh(np.cov((points - centre).T))
    if not spreads[1] > 2.0 * spreads[0]:
        raise VideoError(
            f"Midline: the glottis is {np.sqrt(spreads[1] / max(spreads[0], 1e-12)):.2g} times as long as "
            "wide; must be clearly longer. Set the midline's two ends."
        )
    along = axes[:, 1] if axes[1, 1] >= 0 else -axes[:, 1]
    across = np.array([along[1], -along[0]])
    place, middle, width = [], [], []
    for mask in kept:
        if not mask.size:
            continue
        rows = np.round((mask - centre) @ along).astype(int)
        count = np.bincount(rows - rows.min())
        total = np.bincount(rows - rows.min(), weights=(mask - centre) @ across)
        there = count > 0
        place.append(np.flatnonzero(there) + rows.min())
        middle.append(total[there] / count[there])
        width.append(count[there])
    s, c, w = (np.concatenate(part).astype(float) for part in (place, middle, width))
    slope, offset = np.polyfit(s, c, 1, w=1 / w)
    ends = [centre + end * along + (offset + slope * end) * across for end in (s.min(), s.max())]
    return Midline(*((float(end[0]), float(end[1])) for end in ends))


def areas(glottis: Iterable[Mask], midline: Midline) -> GlottalArea:
    """Area and edges of each mask left and right of the midline."""
    rows: list[tuple[float, float, float, float]] = []
    side: Mask | None = None
    middle: Mask | None = None
    band = 0.0  # px, extent of the band along the line, as its pixels have it
    for mask in glottis:
        if side is None or middle is None:
            shape = (mask.shape[0], mask.shape[1])
            side = midline.right_of(shape)
            middle = np.abs(midline.along(shape) - 0.5) < 0.05
            down = abs(midline.posterior[1] - midline.anterior[1]) / midline.length
            band = float(middle.sum()) * down / shape[1]
        right, whole = mask & side, mask & middle
        rows.append(
            (
                float(mask.sum() - right.sum()),
                float(right.sum()),
                float((whole & ~side).sum()) / band,
                float((whole & side).sum()) / band,
            )
        )
    return GlottalArea(*(np.array(column) for column in zip(*rows, strict=True)))


def kymogram(recording: Frames, midline: Midline, place: float = 0.5, half_width: float = 60) -> Floats:
    """(frames, 2 half_width + 1) grey along the line across the midline at `place` (0 anterior, 1
    posterior)."""
    from scipy import ndimage

    if not 0 <= place <= 1:
        raise VideoError(
            f"Kymogram: place = {place:g}; must be in [0, 1], from the anterior to the posterior end."
        )
    start, end = np.array(midline.anterior), np.array(midline.posterior)
    along = (end - start) / midline.length
    across = np.array([along[1], -along[0]])  # to the image's right where the midline points down
    offsets = np.arange(-int(half_width), int(half_width) + 1)
    points = (start + place * (end - start))[:, None] + across[:, None] * offsets
    rows = [
        ndimage.map_coordinates(frame, [points[1], points[0]], order=1, mode="constant", cval=0.0)
        for frame in recording.frames()
    ]
    return np.asarray(rows, dtype=float)


def phases(area: GlottalArea, cycles: Cycles, time: Floats) -> list[str]:
    """ "closed", "opening", "open" or "closing" for each frame; "" outside the cycles."""
    labels = [""] * time.size
    for part in cycles.samples(time):
        inside = area.total[part]
        peak = int(inside.argmax())
        for k, value in enumerate(inside):
            if value <= open_share * inside[peak]:
                labels[part.start + k] = "closed"
            elif value >= wide_share * inside[peak]:
                labels[part.start + k] = "open"
            else:
                labels[part.start + k] = "opening" if k < peak else "closing"
    return labels


def measures(area: GlottalArea, fps: float | None = None) -> tuple[dict[str, Measure], Cycles]:
    """Frequency, open quotient, amplitudes and asymmetries, each with its spread over cycles.

    With `fps` times are in seconds, without in frames: a frequency is then in cycles per frame, unit
    "1/frame". The amplitude of a side is half of its edge's way in a cycle, its asymmetry that of the
    areas' ranges; the phase asymmetry, at
    the cycles' frequency, is positive where the right lags.
    """
    unit = "Hz" if fps else "1/frame"
    time = np.arange(area.total.size) / (fps or 1.0)
    cycles = find_cycles(time, area.total, name="glottal area")
    names = {
        "fundamental_frequency": unit,
        "open_quotient": "1",
        "amplitude_left": "px",
        "amplitude_right": "px",
        "amplitude_asymmetry": "1",
        "phase_asymmetry": "rad",
    }
    found: dict[str, Measure] = {
        "glottal_area_max": whole(float(area.total.max()), "px^2"),
        "glottal_area_mean": whole(float(area.total.mean()), "px^2"),
    }
    if not cycles.count:
        return found | {name: absent(of, cycles.note) for name, of in names.items()}, cycles
    parts = cycles.samples(time)
    opened, amplitude, phase = [], [], []
    swing: dict[str, list[float]] = {"amplitude_left": [], "amplitude_right": []}
    for (begin, end), part in zip(zip(cycles.starts, cycles.starts[1:], strict=False), parts, strict=True):
        opened.append(_open_share(time, area.total, begin, end, float(area.total[part].max())))
        for name, edge in (("amplitude_left", area.left_edge), ("amplitude_right", area.right_edge)):
            swing[name].append(0.5 * float(np.ptp(edge[part])))
        left, right = (0.5 * float(np.ptp(side[part])) for side in (area.left, area.right))
        amplitude.append((right - left) / (right + left) if right + left else np.nan)
        angle = [_angle(time[part], side[part], begin, end - begin) for side in (area.left, area.right)]
        phase.append((angle[0] - angle[1] + np.pi) % (2 * np.pi) - np.pi)
    found["fundamental_frequency"] = per_cycle(cycles, 1 / cycles.periods, unit, cycles.note)
    found["open_quotient"] = per_cycle(
        cycles, np.array(opened), "1", f"open: area above {100 * open_share:g} % of the cycle's maximum"
    )
    for name, values in swing.items():
        note = "half of the way of the edge in the middle of the midline"
        found[name] = per_cycle(cycles, np.array(values), "px", note)
    found["amplitude_asymmetry"] = per_cycle(
        cycles, np.array(amplitude), "1", "(right - left) / (right + left)"
    )
    found["phase_asymmetry"] = per_cycle(cycles, np.array(phase), "rad", "positive where the right lags")
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
