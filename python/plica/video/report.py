"""The report of an analysis: one HTML page that fetches nothing."""

from __future__ import annotations

import base64
import io
import json
import shlex
from collections import Counter
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

import jinja2
import numpy as np
import numpy.typing as npt

from plica.report.wording import tables
from plica.storage.files import replaced
from plica.video.analysis import Analysis
from plica.video.figures import sections
from plica.video.quality import in_doubt, lit
from plica.video.settings import Settings

__all__ = ["write_report"]

_MOST_FRAMES = 60  # in the page
_FOLLOWS = 0.7  # correlation with the edges' way, below which the flow does not follow the folds


def write_report(found: Analysis) -> Path:
    """Write report.html beside the results, of the flow where it was found; returns its path."""
    path = found.directory / "report.html"
    template = files("plica.video").joinpath("report.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    shown = np.unique(np.linspace(0, found.count - 1, _MOST_FRAMES).round().astype(int))
    pictures = [_picture(image) for image in _overlays(found, shown)]
    from plica._engine import build_info

    text = environment.from_string(template).render(
        title=found.source.name,
        remark=_remark(found),
        quality=_quality(found),
        frames=pictures,
        frames_json=json.dumps(pictures),
        labels=json.dumps([f"frame {k} {found.flags[k]}" for k in shown]),
        shown="Every frame" if shown.size == found.count else f"{shown.size} of {found.count} frames",
        tables=tables(found.measures),
        sections=sections(found),
        command=_command(found),
        version=build_info()["version"],
    )

    def write(draft: Path) -> None:
        draft.write_text(text, encoding="utf-8")

    replaced(path, write)
    return path


def _remark(found: Analysis) -> str:
    settings, cycles, drawn = found.settings, found.cycles, found.drawn
    parts = [
        f"{found.count} frames",
        f"{settings.fps:g} frames/s" if settings.fps else "frame rate unknown: times in frames",
        f"{settings.mm_per_px:g} mm/px" if settings.mm_per_px else "pixel size unknown: lengths in pixels",
        f"{cycles.count} complete cycles found, {cycles.count - len(cycles.left_out)} used, {cycles.verdict}"
        if cycles.count
        else f"no cycles: {cycles.note}",
    ]
    if settings.patient_left is None:
        parts.append("patient's left unknown: sides are those of the image")
    if drawn:
        parts.append(f"masks drawn by hand: {len(drawn)}")
    return "; ".join(parts) + "."


def _quality(found: Analysis) -> tuple[str, str]:
    doubtful = [flag for flag in found.flags if in_doubt(flag)]
    share = len(doubtful) / found.count
    light = "good" if share < 0.02 else "fair" if share < 0.15 else "bad"
    reasons = Counter(reason for flag in doubtful for reason in flag.split(", ") if in_doubt(reason))
    why = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common())
    said = f"{len(doubtful)} of {found.count} frames are in doubt{': ' + why if why else ''}. "
    if found.doubts:
        light = "bad" if light == "bad" else "fair"
        said += " ".join(f"{text[0].upper()}{text[1:]}." for text in found.doubts) + " "
    if not found.complete:
        return light, said + "The motion of the tissue was not looked at (plica video does it)."
    changes = sum(map(lit, found.flags))
    if changes:
        light = "fair" if light == "good" else light
        most = 100 * float(np.nanmax(np.abs(found.brightness)))
        said += (
            f"The light changes by up to {most:.0f} % from frame to frame ({changes} times by over 3 %); the "
            "flow takes it out. "
        )
    edges = found.edges
    if not np.isfinite(edges.correlation):
        return light, said + "Too few ways of the folds' edges are seen to hold the flow against them."
    if edges.correlation < _FOLLOWS:
        light = "bad"
    return light, said + (
        f"Beside the edges of the folds the flow is {edges.slope:.2f} of the edges' own way (correlation "
        f"{edges.correlation:.2f}, {edges.count} ways)."
    )


def _command(found: Analysis) -> str:
    """What makes the analysis anew; the masks drawn by hand are a folder of the user's."""
    words = ["plica", "video" if found.complete else "glottis", str(found.source)]
    words += ["-o", str(found.directory.resolve())]
    default = Settings()
    for entry in fields(Settings):
        value = getattr(found.settings, entry.name)
        if value == getattr(default, entry.name):
            continue
        if entry.name == "correct_drift":
            words.append("--no-drift")
            continue
        text = ",".join(map(repr, value)) if isinstance(value, tuple) else str(value)
        words.append(f"--{entry.name.replace('_', '-')}={text}")
    return shlex.join(words) + (" --masks drawn" if found.drawn else "")


def _overlays(found: Analysis, shown: npt.NDArray[np.int_]) -> list[npt.NDArray[np.uint8]]:
    """Frames with the outline of the glottis and the midline."""
    from scipy import ndimage

    steady = found.frames()
    along = np.linspace(0, found.midline.length, int(2 * found.midline.length) + 2)
    line = np.round(found.midline.points(np.stack([along, 0 * along], axis=-1))).astype(int)
    rows, columns = np.clip(line[:, ::-1], 0, np.array(steady.shape) - 1).T
    images = []
    for index, frame in steady.some(set(shown.tolist())):
        coloured = np.stack([np.clip(frame, 0, 255).astype(np.uint8)] * 3, axis=-1)
        mask = found.mask(index)
        coloured[rows, columns] = (90, 160, 230)
        coloured[mask & ~ndimage.binary_erosion(mask)] = (255, 140, 40)
        images.append(coloured)
    return images


def _picture(image: npt.NDArray[np.uint8]) -> str:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="JPEG", quality=80)
    return "data:image/jpeg;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
