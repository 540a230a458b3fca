"""The page on which a recording's outlines, midline, region and scale are corrected: one HTML file.

What the page saves is read by :func:`plica.video.files.corrections.read_corrections`.
"""

from __future__ import annotations

import base64
import io
import shlex
from collections.abc import Collection
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.report.page import render
from plica.storage.files import write_text
from plica.video.analysis import Analysis
from plica.video.errors import VideoError
from plica.video.files.corrections import VERSION, VIEW, described, runs_of
from plica.video.settings import Settings

__all__ = ["write_corrections_page"]

_KEPT = (
    *("fps", "mm_per_px", "anterior", "patient_left", "label", "recorded", "kymogram", "midline", "modes"),
    *("audio", "egg", "sound_start", "sync"),
)
"""Settings that a directory keeps where they are not given again."""
_FLAGS = {"correct_drift": "--no-drift"}
_OPTIONS = {"first": "--from", "last": "--to"}


def write_corrections_page(found: Analysis, frames: Collection[int], path: Path) -> Path:
    """Write the page with these frames of an analysis, those that were drawn before, and that of the widest
    glottis; returns its path.

    Raises
    ------
    VideoError
        For a name that is not that of a page, which may be that of a recording, and where the recording is
        not there any more.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        raise VideoError(f"Masks: page = {path}; must end in .html.")
    chosen = {*frames, *found.drawn}
    if "sides" in found and np.isfinite(found.area.total).any():
        chosen.add(int(np.nanargmax(found.area.total)))
    text = render(
        "video/report/corrections_page.html.j2",
        title=f"Correct {found.label}",
        running=found.label,
        page=_content(found, sorted(chosen)),
    )
    return write_text(text, path)


def _content(found: Analysis, chosen: list[int]) -> dict[str, Any]:
    """All that the page is told."""
    steady, settings = found.frames(), found.settings
    recording = steady.recording
    black = np.zeros(steady.shape, dtype=bool)
    known = "glottis" in found
    pictures = steady.pictures(set(chosen))
    _, whole = next(replace(recording, region=None).pictures({0}))
    line, points = None, []
    if "sides" in found:
        line = _rounded(found.midline.ends)
        along = np.linspace(0, found.midline.length, 33)
        points = [_rounded(point) for point in found.midline.points(np.stack([along, 0 * along], axis=-1))]
    return {
        "version": VERSION,
        "recording": described(found.source, recording),
        "view": {name: getattr(settings, name) for name in VIEW},
        "frames": [
            {
                "number": frame,
                "picture": _png(pictures[frame]),
                "mask": runs_of(found.mask(frame) if known else black),
                "drawn": frame in found.drawn,
            }
            for frame in chosen
        ],
        "whole": {
            "picture": _png(np.clip(np.round(whole), 0, 255).astype(np.uint8)),
            "width": whole.shape[1],
            "height": whole.shape[0],
        },
        "midline": line,
        "bowed": points,
        "mm_per_px": settings.mm_per_px,
        "command": f"plica {'video' if found.complete else 'glottis'} {shlex.quote(str(found.source))}",
        "directory": str(found.directory.resolve()),
        "options": _options(settings),
    }


def _options(settings: Settings) -> list[dict[str, Any]]:
    """What the analysis was begun with, an option each, and whether its directory keeps it."""
    default, given = asdict(Settings()), asdict(settings)
    found = []
    for name in (entry.name for entry in fields(Settings)):
        value = given[name]
        if value == default[name]:
            continue
        option = _OPTIONS.get(name, f"--{name.replace('_', '-')}")
        text = ",".join(map(repr, value)) if isinstance(value, tuple) else str(value)
        word = _FLAGS.get(name) or shlex.quote(f"{option}={text}")
        found.append({"name": name, "word": word, "kept": name in _KEPT})
    return found


def _rounded(values: npt.NDArray[np.float64]) -> list[float]:
    return [round(float(value), 2) for value in values]


def _png(image: npt.NDArray[np.uint8]) -> str:
    """A picture (h, w, 3) as the address of its data; in grey where it has no colours."""
    from PIL import Image

    grey = bool((image == image[..., :1]).all())
    buffer = io.BytesIO()
    Image.fromarray(image[..., 0] if grey else image).save(buffer, format="PNG")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
