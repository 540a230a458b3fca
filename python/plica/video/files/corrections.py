"""What was corrected by hand on the page of ``plica masks --page``: the file that the page saves, read.

The file is JSON, with ``plica_corrections`` for its version. ``recording`` says of which recording it is, as
the page was written: name, frames, width, height, and the grey levels that are black and white, which hardly
two recordings share. ``view`` says how its frames were turned and cut. Then only what was corrected::

    masks      {"57": [6400, 12, 148, ...]}  by frame: how many pixels are not glottis, then how many are,
                                             and so on, row by row from the upper left corner
    midline    [x, y, x, y]                  px of the frames as they were shown
    region     [x, y, width, height]         px of the turned frames
    mm_per_px  0.05
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.errors import nearest, one_of
from plica.storage.files import require_file, storage_errors
from plica.video.errors import VideoError
from plica.video.files.recording import Recording

__all__ = ["VERSION", "VIEW", "Corrections", "described", "read_corrections", "runs_of"]

Mask = npt.NDArray[np.bool_]
Box = tuple[int, int, int, int]

VERSION = 1
VIEW = ("rotation", "first", "last", "region", "correct_drift")
"""Settings on which depends what a frame shows where."""
_RECORDING = ("name", "frames", "width", "height", "grey")
_CORRECTED = ("masks", "midline", "region", "mm_per_px")
_KNOWN = ("plica_corrections", "recording", "view", *_CORRECTED)
_AGAIN = "Save it again from the page that plica masks --page writes."
_LEAST = 16  # px, of a side of a region


@dataclass(frozen=True)
class Corrections:
    """What was corrected by hand, on the frames as they are to be used: in the corrected region, if it was.

    Attributes
    ----------
    name : str
        Of the file, for messages.
    recording : dict
        Name, frames, width and height (px) and grey levels of the recording as the page showed it.
    view : dict
        The settings of :data:`VIEW` with which it was shown.
    masks : dict of frame to (h, w) bool
    midline : (x, y, x, y) or None
        px
    region : (x, y, width, height) or None
        px of the turned frames.
    mm_per_px : float or None
    """

    name: str
    recording: Mapping[str, Any]
    view: Mapping[str, Any]
    masks: Mapping[int, Mask] = field(default_factory=dict)
    midline: tuple[float, float, float, float] | None = None
    region: Box | None = None
    mm_per_px: float | None = None

    @property
    def settings(self) -> dict[str, Any]:
        """Those that were corrected, by their names."""
        all_of_them = {name: getattr(self, name) for name in ("midline", "region", "mm_per_px")}
        return {name: value for name, value in all_of_them.items() if value is not None}

    def require(self, source: Path, recording: Recording) -> None:
        """VideoError where they are not of this recording, opened as it is to be used."""
        found, wanted = described(source, recording), dict(self.recording)
        if found["name"] != wanted["name"]:
            raise VideoError(
                f"Corrections: {self.name} is of the recording {wanted['name']}; must be of {found['name']}, "
                "the one given. Was the wrong file taken? If the recording was renamed, analyse it by its "
                "new name, and correct it on a new page (plica masks --page)."
            )
        if self.region is not None:
            wanted["width"], wanted["height"] = self.region[2:]
        for shown in (
            "{frames} frames",
            "frames of {width} x {height} px",
            "grey levels {grey[0]} to {grey[1]}",
        ):
            if shown.format(**found) != shown.format(**wanted):
                raise VideoError(
                    f"Corrections: {self.name} is of a {wanted['name']} with {shown.format(**wanted)}; must "
                    f"be of {source}, which has {shown.format(**found)}. Was the wrong file taken? If the "
                    "recording was changed, correct it on a new page (plica masks --page)."
                )


def described(source: Path, recording: Recording) -> dict[str, Any]:
    """What tells a recording from others, wherever it lies, as the file of corrections has it."""
    height, width = recording.shape
    return {
        "name": source.resolve().name,
        "frames": recording.count,
        "width": width,
        "height": height,
        "grey": [f"{level:g}" for level in recording.scale],
    }


def runs_of(mask: Mask) -> list[int]:
    """Row by row: how many pixels are not glottis, then how many are, and so on."""
    flat = np.concatenate([[False], mask.ravel()])
    changes = np.flatnonzero(flat[1:] != flat[:-1])
    return [int(run) for run in np.diff([0, *changes, mask.size])]


def read_corrections(path: str | Path) -> Corrections:
    """The file that the page of ``plica masks --page`` saved.

    Masks and midline are drawn on the frames that the page showed; where the region was corrected they are
    moved to it, and cut by it.

    Raises
    ------
    VideoError
        Where it is no such file, is damaged, or has what no page saves.
    StorageFailed
        Where the system refuses to read it.
    """
    path = Path(path)
    content = _loaded(path)
    name = path.name
    recording = _recording_of(name, content.get("recording"))
    view = _view_of(name, content.get("view"))
    shape = recording["height"], recording["width"]
    masks = _masks_of(name, content.get("masks", {}), recording["frames"], shape)
    midline = _midline_of(name, content.get("midline"), shape)
    region = _region_of(name, content.get("region"))
    scale = _scale_of(name, content.get("mm_per_px"))
    if not masks and midline is None and region is None and scale is None:
        raise VideoError(
            f"Corrections: {name} has no {', '.join(_CORRECTED[:-1])} or {_CORRECTED[-1]}; must have one of "
            "them. Correct something on the page, then save it."
        )
    if region is not None:
        before = view["region"] or (0, 0)
        right, down = region[0] - before[0], region[1] - before[1]
        size = region[3], region[2]
        masks = {frame: _cut(mask, right, down, size) for frame, mask in masks.items()}
        if midline is not None:
            x, y, other_x, other_y = midline
            moved = x - right, y - down, other_x - right, other_y - down
            midline = _within(moved, size, f"{name}: midline within the region {_listed(region)}")
    return Corrections(name, recording, view, masks, midline, region, scale)


def _loaded(path: Path) -> dict[str, Any]:
    """The object of the file, of this version, with known entries alone."""
    where = f"Corrections: {path}"
    if not path.exists():
        raise VideoError(f"{where} does not exist; must be the file that the page saved, where it saved it.")
    if path.is_dir():
        raise VideoError(f"{where} is a folder; must be a file. Masks in a folder are given with --masks.")
    require_file(path, where)
    with storage_errors(path, "read"):
        raw = path.read_bytes()
    if not raw.strip():
        raise VideoError(f"{where} is empty: {len(raw)} bytes; must be JSON. {_AGAIN}")
    try:
        content = json.loads(raw)
    except (ValueError, RecursionError) as error:
        raise VideoError(f"{where} is no JSON ({error}); must be as the page saved it. {_AGAIN}") from None
    if not isinstance(content, dict) or "plica_corrections" not in content:
        raise VideoError(f"{where} is JSON without plica_corrections; must be as the page saved it. {_AGAIN}")
    version = content["plica_corrections"]
    if version != VERSION or isinstance(version, bool):
        raise VideoError(
            f"{where}: plica_corrections = {_short(version)}; must be {VERSION}, which this plica reads. "
            "Write the page again with this one (plica masks --page)."
        )
    for name in content:
        if name not in _KNOWN:
            raise VideoError(f'{where} has "{name}"; must be {one_of(_KNOWN)}.{nearest(name, _KNOWN)}')
    return content


def _recording_of(file: str, recording: Any) -> dict[str, Any]:
    """Of which recording it is."""
    known = isinstance(recording, dict) and set(recording) == set(_RECORDING)
    if not (
        known
        and isinstance(recording["name"], str)
        and all(_is_whole(recording[size]) and recording[size] > 0 for size in ("frames", "width", "height"))
        and isinstance(recording["grey"], list)
        and len(recording["grey"]) == 2
    ):
        raise VideoError(
            f"Corrections: {file}: recording = {_short(recording)}; must have {', '.join(_RECORDING)}, "
            f"as the page saved them. {_AGAIN}"
        )
    return dict(recording)


def _view_of(file: str, view: Any) -> dict[str, Any]:
    """With which settings it was shown."""
    if not isinstance(view, dict) or set(view) != set(VIEW):
        raise VideoError(
            f"Corrections: {file}: view = {_short(view)}; must have {', '.join(VIEW)}, as the page saved "
            f"them. {_AGAIN}"
        )
    region = view["region"]
    return {**view, "region": None if region is None else _region_of(file, region, "view: region")}


def _masks_of(file: str, masks: Any, frames: int, shape: tuple[int, int]) -> dict[int, Mask]:
    """Of the frames that were corrected."""
    if not isinstance(masks, dict):
        raise VideoError(
            f"Corrections: {file}: masks = {_short(masks)}; must be masks by their frames. {_AGAIN}"
        )
    found: dict[int, Mask] = {}
    for number, runs in masks.items():
        if not (number.isascii() and number.isdigit() and len(number) < 10) or int(number) >= frames:
            raise VideoError(
                f"Corrections: {file}: mask of frame {number[:20]}; must be one in [0, {frames}), those "
                f"of the recording. {_AGAIN}"
            )
        if int(number) in found:
            raise VideoError(
                f"Corrections: {file}: frame {int(number)} has two masks; must have one. {_AGAIN}"
            )
        if not isinstance(runs, list) or not all(_is_whole(run) and run >= 0 for run in runs):
            raise VideoError(
                f"Corrections: {file}: mask of frame {number} = {_short(runs)}; must be numbers of pixels, "
                f"whole and 0 or more. {_AGAIN}"
            )
        if sum(runs) != shape[0] * shape[1]:
            raise VideoError(
                f"Corrections: {file}: mask of frame {number} has {sum(runs)} pixels; must have "
                f"{shape[0] * shape[1]}, of a frame of {shape[1]} x {shape[0]} px. {_AGAIN}"
            )
        values = np.arange(len(runs)) % 2 == 1
        found[int(number)] = np.repeat(values, runs).reshape(shape)
    return found


def _midline_of(file: str, midline: Any, shape: tuple[int, int]) -> tuple[float, float, float, float] | None:
    if midline is None:
        return None
    if not isinstance(midline, list) or len(midline) != 4 or not all(map(_is_number, midline)):
        raise VideoError(
            f"Corrections: {file}: midline = {_short(midline)}; must be four numbers, x and y of both ends "
            f"in px. {_AGAIN}"
        )
    x, y, other_x, other_y = map(float, midline)
    return _within((x, y, other_x, other_y), shape, f"{file}: midline")


def _within(
    midline: tuple[float, float, float, float], shape: tuple[int, int], what: str
) -> tuple[float, float, float, float]:
    """The same; VideoError where an end lies outside a frame of this height and width."""
    height, width = shape
    if not all(0 <= x <= width - 1 for x in midline[::2]) or not all(
        0 <= y <= height - 1 for y in midline[1::2]
    ):
        raise VideoError(
            f"Corrections: {what} = {_listed(midline)} px; must have its ends within the frame, x in "
            f"[0, {width - 1}] and y in [0, {height - 1}]. Move its ends on the page."
        )
    return midline


def _region_of(file: str, region: Any, what: str = "region") -> Box | None:
    """Whether it lies within the frames is known to the recording."""
    if region is None:
        return None
    if not isinstance(region, list) or len(region) != 4 or not all(map(_is_whole, region)):
        raise VideoError(
            f"Corrections: {file}: {what} = {_short(region)}; must be four whole numbers: x, y, width and "
            f"height in px. {_AGAIN}"
        )
    x, y, width, height = region
    if min(x, y) < 0 or min(width, height) < _LEAST:
        raise VideoError(
            f"Corrections: {file}: {what} = {_listed(region)} px; must begin at 0 or more and be at least "
            f"{_LEAST} x {_LEAST} px. Draw it again on the page."
        )
    return x, y, width, height


def _scale_of(file: str, scale: Any) -> float | None:
    if scale is None:
        return None
    if not _is_number(scale) or not scale > 0:
        raise VideoError(
            f"Corrections: {file}: mm_per_px = {_short(scale)} mm; must be a number > 0. Click the two "
            "points on the page again and type their distance in mm."
        )
    return float(scale)


def _cut(mask: Mask, right: int, down: int, size: tuple[int, int]) -> Mask:
    """The part of a mask in a region that begins so far right of it and below it; beyond it is no glottis."""
    height, width = size
    cut = np.zeros(size, dtype=bool)
    top, left = max(down, 0), max(right, 0)
    part = mask[top : max(down + height, top), left : max(right + width, left)]
    cut[top - down : top - down + part.shape[0], left - right : left - right + part.shape[1]] = part
    return cut


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _listed(values: Any) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _short(value: Any) -> str:
    """As much of a wrong value as a line holds."""
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."
