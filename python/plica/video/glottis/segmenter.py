"""The glottis in every frame of a recording, found, and corrected by hand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from plica.storage.files import replaced
from plica.video.errors import VideoError
from plica.video.files.image_file import read_image
from plica.video.files.recording import Frames, Grey, spread
from plica.video.glottis.brightness import around, blurred, region_below
from plica.video.glottis.candidates import Prior
from plica.video.glottis.coverage import coverage
from plica.video.glottis.frame_outline import Outline
from plica.video.glottis.frame_segmentation import segment
from plica.video.glottis.regions import grown
from plica.video.glottis.tissue_level import PixelLevels, pixel_levels

__all__ = ["Look", "learn", "masks", "read_masks", "write_masks"]

Mask = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]

_NOISE = 0.03  # of the contrast
_BAND = (0.15, 0.7)  # shares of the way from dark to tissue between whose outlines the true area lies
_INNER = 0.2  # the same, of the outline that shade hardly moves (docs/verification/video.md, "One lamp")
_DEEPEST = 75  # percentile of the depths of a mask: in a narrow slit the lens fills the rest with light
_TINY = 0.1  # of the largest mask: what is smaller may be no glottis
_LEAST = 6  # px; what is smaller is noise, and would draw the midline to it


@dataclass(frozen=True)
class Look:
    """How the glottis looks in a recording.

    Attributes
    ----------
    dark, tissue : float
        Grey of the glottis and of the tissue around it.
    reach : (h, w) bool
        Where it can be.
    blur : float
        px, by which frames are blurred against noise: none that is not needed, as it closes narrow slits.
    levels : PixelLevels or None
        What each pixel is where it shows tissue; None: not known, all have one level.
    """

    dark: float
    tissue: float
    reach: Mask
    blur: float
    levels: PixelLevels | None = None

    @cached_property
    def near(self) -> Mask:
        """(h, w) the reach and a little about it: beyond, what is dark is another thing, as a shadow or the
        rim of the endoscope's view."""
        return grown(self.reach, max(2, round(0.01 * max(self.reach.shape))))

    @cached_property
    def _limit(self) -> Mask:
        """(h, w) the last pixels of what is near, but for those at the frame's border, and all beyond."""
        return grown(~self.near, 1)

    def left_out(self, glottis: Mask) -> Mask:
        """(h, w) what is dark in every frame and was no glottis in any, though it touches one.

        Parameters
        ----------
        glottis : (h, w) bool
            What is glottis in some frame.
        """
        from scipy import ndimage

        if self.levels is None:
            return np.zeros_like(glottis)
        dark = self.levels.always_dark & ~glottis
        labels, _ = ndimage.label(dark, structure=np.ones((3, 3)))
        beside = np.unique(labels[grown(glottis, _LEAST // 2) & dark])
        return np.asarray(np.isin(labels, beside) & dark)

    def mask(self, frame: Grey, index: int | None = None, share: float = 0.5) -> Mask:
        """(h, w) where a blurred frame is darker than this share of the way from dark to tissue.

        A half is where a blurred step stands. The tissue is the pixel's own in the frame of this `index`;
        without one, the common one.
        """
        return region_below(self._below(blurred(frame, self.blur), index, share), 0.0, self.reach, _LEAST)

    def _below(self, smooth: npt.NDArray[np.floating], index: int | None, share: float) -> Floats:
        """(h, w) a blurred frame less the level that its pixels have; infinite where no glottis can be."""
        level: Floats | float = self.dark + share * (self.tissue - self.dark)
        if index is not None and self.levels is not None:
            level = self.levels.level(index, self.dark, self.tissue, share)
        return np.where(self.near, smooth - level, np.inf)

    def outline(self, frame: Grey, index: int) -> Outline:
        """The glottis of a frame; its band is that of the outlines at 0.15 and 0.7 of the way."""
        smooth = blurred(frame, self.blur)
        below = [self._below(smooth, index, share) for share in (0.5, _INNER, *_BAND)]
        mask, inner, narrow, wide = (region_below(one, 0.0, self.reach, _LEAST) for one in below)
        areas = float(narrow.sum()), float(mask.sum()), float(wide.sum())
        whole, dark = coverage(mask, below[0]), coverage(inner & mask, below[1])
        return Outline(mask, whole, np.minimum(dark, whole), min(areas), max(areas), self._confined(mask))

    def _confined(self, mask: Mask) -> float:
        """Share of a mask's outline on the limit of what is near, where none comes that was learnt from: the
        widest openings may not have been."""
        from scipy import ndimage

        outline = mask & ~ndimage.binary_erosion(mask, border_value=1)
        return float((outline & self._limit).sum() / max(outline.sum(), 1))


def learn(
    recording: Frames, drawn: Mapping[int, Mask] | None = None, lost: npt.NDArray[np.bool_] | None = None
) -> Look:
    """How the glottis looks, from masks drawn by hand; where none is drawn, from frames segmented alone.

    Where a glottis can be is then learnt from how much each pixel varies, and some twenty frames and the
    darkest are segmented. Reads the frames twice, or three times.

    Parameters
    ----------
    recording : Frames
    drawn : dict of frame to (h, w) bool, optional
        An empty mask says that the glottis is closed, and nothing of how it looks; but nothing that is dark
        in every frame is glottis then.
    lost : (frames) bool, optional
        Frames that show another thing.

    Raises
    ------
    VideoError
        Where no frame has a glottis, or one no darker than the noise; where drawn masks are brighter than
        what is around them, or leave nothing around them.
    """
    shown = {frame: mask for frame, mask in (drawn or {}).items() if mask.any()}
    if shown:
        found = [(frame, shown[k]) for k, frame in enumerate(recording.frames()) if k in shown]
    else:
        found = _segmented(recording)
    largest = max(mask.sum() for _, mask in found)
    clear = [(frame, mask) for frame, mask in found if mask.sum() >= 0.3 * largest]
    dark, tissue, noise = np.median([_levels(frame, mask) for frame, mask in clear], axis=0).tolist()
    contrast = tissue - dark
    if shown:
        _check_drawn(shown, contrast)
    if not contrast > 2 * noise:
        raise VideoError(
            f"Glottis: the darkest region is {contrast:.3g} grey levels darker than what is around it, "
            f"the noise {noise:.3g}; must be more than twice as much. Is this a recording of a larynx?"
        )
    reach = np.any([mask for _, mask in clear], axis=0)
    look = Look(dark, tissue, reach, _needed(noise / contrast))
    gone = np.zeros(recording.count, dtype=bool) if lost is None else lost
    seen = (
        np.full(frame.shape, np.nan) if gone[k] else blurred(frame, look.blur)
        for k, frame in enumerate(recording.frames())
    )
    levels = pixel_levels(seen, look.near, dark, tissue, list((drawn or {}).values()))
    return replace(look, levels=levels)


def _levels(raw: Grey, mask: Mask) -> tuple[float, float, float]:
    """Grey of the glottis, away from its edge, and of the tissue around it; the noise's standard deviation.

    Not a number for tissue that is not there.
    """
    from scipy import ndimage

    frame = blurred(raw)
    depth = ndimage.distance_transform_edt(mask)
    inside = depth >= max(1.0, float(np.percentile(depth[mask], _DEEPEST)))
    outside = around(mask)
    tissue = float(np.median(frame[outside])) if outside.any() else float("nan")
    return float(np.median(raw[inside])), tissue, 1.4826 * float(np.median(np.abs(raw - frame)))


def _check_drawn(shown: Mapping[int, Mask], contrast: float) -> None:
    """VideoError where drawn masks leave no tissue around them, or it is the darker."""
    named = ", ".join(map(str, sorted(shown)))
    if np.isnan(contrast):
        raise VideoError(
            f"Masks: those drawn (frames {named}); must leave tissue around the glottis: white where the "
            "glottis is, black elsewhere."
        )
    if not contrast > 0:
        raise VideoError(
            f"Masks: what is drawn (frames {named}) is {-contrast:.3g} grey levels brighter than what is "
            "around it; must be darker: white where the glottis is, black elsewhere."
        )


def _needed(noise: float) -> float:
    """The blur s (px, at most 1) by which white noise falls to 3 % of the contrast: 1 / (2 sqrt(pi) s) of it
    is left."""
    blur = min(noise / _NOISE / (2 * np.sqrt(np.pi)), 1.0)
    return blur if noise > _NOISE else 0.0


def masks(recording: Frames, drawn: Mapping[int, Mask] | None = None) -> Iterator[Mask]:
    """The glottis of every frame, (h, w) bool each, in order: as drawn, or as :func:`learn` says it looks.

    Raises VideoError as :func:`learn` does.
    """
    look = learn(recording, drawn)
    for index, frame in enumerate(recording.frames()):
        yield drawn[index] if drawn and index in drawn else look.mask(frame, index)


def _segmented(recording: Frames) -> list[tuple[Grey, Mask]]:
    """Frames and their masks, each found without the others."""
    from scipy import ndimage

    darkness: list[float] = []

    def seen() -> Iterator[Grey]:
        for frame in recording.frames():
            darkness.append(float(np.percentile(frame, 5)))
            yield frame

    varies = ndimage.gaussian_filter(spread(seen()), 0.02 * max(recording.shape))
    prior = Prior(where=varies / max(float(varies.max()), 1e-12))
    chosen = {*range(0, recording.count, max(1, recording.count // 20)), int(np.argmin(darkness))}
    frames = [frame for k, frame in enumerate(recording.frames()) if k in chosen]
    found = [(frame, segment(frame, prior).mask) for frame in frames]
    sizes = np.array([int(mask.sum()) for _, mask in found])
    tiny = (sizes > 0) & (sizes < _TINY * sizes.max(initial=0))
    if tiny.any():  # digits that are burnt in, not a glottis
        larger = replace(prior, least_area=_TINY * float(sizes.max()) / frames[0].size)
        for k in np.flatnonzero(tiny):
            found[k] = frames[k], segment(frames[k], larger).mask
    if not any(mask.any() for _, mask in found):
        raise VideoError(
            f"Glottis: none of the {len(found)} frames looked at has a dark region within an edge; must be "
            "a recording in which the glottis opens. Cut the region around it (--region), or draw the mask "
            "of one frame (--masks)."
        )
    return found


def write_masks(folder: Path, frames: Mapping[int, tuple[Grey, Mask]]) -> None:
    """``mask_N.png``, white where the glottis is, and ``frame_N.png`` to draw it on, N being the frame.

    Raises
    ------
    VideoError
        Where one is there already: someone may have drawn on it.
    """
    from PIL import Image

    folder.mkdir(parents=True, exist_ok=True)
    for index in frames:
        path = folder / f"mask_{index:05d}.png"
        if path.exists():
            raise VideoError(
                f"Masks: {path} is there; must not be, as someone may have drawn it. Choose another folder."
            )
    for index, (frame, mask) in frames.items():
        seen = np.clip(np.round(frame), 0, 255).astype(np.uint8)
        for name, picture in (("frame", seen), ("mask", 255 * mask.astype(np.uint8))):
            image = Image.fromarray(picture)
            replaced(folder / f"{name}_{index:05d}.png", partial(image.save, format="PNG"))


def read_masks(folder: Path, shape: tuple[int, int]) -> dict[int, Mask]:
    """Masks drawn by hand: every ``mask_N.png`` of a folder, where it is brighter than half of its brightest.

    Raises
    ------
    VideoError
        Where there is none, or one without a number or of another size.
    """
    if not folder.is_dir():
        raise VideoError(f"Masks: {folder} is no folder; must be one with mask_N.png in it.")
    drawn: dict[int, Mask] = {}
    for path in sorted(folder.glob("mask_*.png")):
        number = path.stem.removeprefix("mask_")
        if not number.isdecimal():
            raise VideoError(f"Masks: {path.name}; must be mask_N.png with N the number of a frame.")
        if int(number) in drawn:
            raise VideoError(f"Masks: {path.name} is a second mask of frame {int(number)}; must be one.")
        image = read_image(path)
        if image.shape != shape:
            raise VideoError(
                f"Masks: {path.name} is {image.shape[1]} x {image.shape[0]} px; must be {shape[1]} x "
                f"{shape[0]} px like the frames as used (turned and cut)."
            )
        drawn[int(number)] = image > 0.5 * image.max()
    if not drawn:
        raise VideoError(
            f"Masks: {folder} has no mask_N.png; must have some. plica masks writes some to draw on."
        )
    return drawn
