"""The report of an analysis: one HTML page that fetches nothing."""

from __future__ import annotations

import base64
import io
import json
import shlex
from dataclasses import fields
from pathlib import Path

import numpy as np
import numpy.typing as npt

from plica._engine import build_info
from plica.report.page import render
from plica.report.wording import numbered, tables
from plica.storage.files import write_text
from plica.video.analysis import Analysis
from plica.video.light import light_of
from plica.video.report.figures import lead, sections
from plica.video.report.summary import summary
from plica.video.settings import Settings

__all__ = ["running", "write_report"]

_MOST_FRAMES = 60  # in the page
_SAME_RATE = 1e-3  # relative; files round it


def write_report(found: Analysis) -> Path:
    """Write report.html beside the results, of the flow where it was found; returns its path."""
    shown = np.unique(np.linspace(0, found.count - 1, _MOST_FRAMES).round().astype(int))
    pictures = [_picture(image) for image in _overlays(found, shown)]
    widest = int(np.argmax(np.nan_to_num(found.area.total[shown])))
    measured, notes = tables(found.measures), list[str]()
    marks = {row.name: numbered(row.cautions, notes) for _, rows in measured for row in rows}
    kept, left_out = summary(found, {row.name: row for _, rows in measured for row in rows})
    drawings = sections(found)
    text = render(
        "video/report/page.html.j2",
        title=found.label,
        running=running(found),
        remark=_remark(found),
        light=light_of(found),
        kept=kept,
        left_out=left_out,
        lead=lead(found),
        frames=pictures,
        first=widest,
        frames_json=json.dumps(pictures),
        labels=json.dumps([f"frame {k} {found.flags[k]}" for k in shown]),
        shown="Every frame" if shown.size == found.count else f"{shown.size} of {found.count} frames",
        tables=measured,
        marks=marks,
        notes=notes,
        sections=drawings,
        command=_command(found),
        version=build_info()["version"],
    )
    return write_text(text, found.directory / "report.html")


def running(found: Analysis) -> str:
    """What stands at the head of each printed page: label, and the day of recording where it is known."""
    return f"{found.label}, {found.recorded}" if found.recorded else found.label


def _remark(found: Analysis) -> str:
    settings, cycles, drawn = found.settings, found.cycles, found.drawn
    said = found.described
    by = f" (by the file's {said['recorded_by']})" if "recorded_by" in said else ""
    parts = [
        *([found.source.name] if "label" in said else []),
        *([f"recorded {said['recorded']}{by}"] if "recorded" in said else []),
        f"{found.count} frames",
        f"{settings.fps:g} frames/s" if settings.fps else "frame rate unknown: times in frames",
        f"{settings.mm_per_px:g} mm/px" if settings.mm_per_px else "pixel size unknown: lengths in pixels",
        f"{cycles.count} complete cycles found, {cycles.count - len(cycles.left_out)} used, {cycles.verdict}"
        if cycles.count
        else f"no cycles: {cycles.note}",
        *([cycles.note] if cycles.count and cycles.note else []),
    ]
    if settings.patient_left is None:
        parts.append("patient's left unknown: sides are those of the image")
    else:
        parts.append(f"sides are those of the image, whose {settings.patient_left} is the patient's left")
    parts += _of_camera(found)
    if settings.segmenter:
        parts.append(f"glottis found by the network {Path(settings.segmenter).name}")
    parts += found.signals.said
    if drawn:
        parts.append(f"masks drawn by hand: {len(drawn)}")
    return "; ".join(parts) + "."


def _of_camera(found: Analysis) -> list[str]:
    """What the file says of the camera."""
    camera, fps = found.camera, found.settings.fps
    if camera is None:
        return []
    said = [f"{camera.bits} bits"] if camera.bits else []
    if camera.fps and fps and abs(fps / camera.fps - 1) > _SAME_RATE:
        said.append(f"the camera's file states {camera.fps:g} frames/s, {fps:g} was given")
    return [*said, *camera.unused.values()]


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
    for index, coloured in steady.pictures(set(shown.tolist())).items():
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
