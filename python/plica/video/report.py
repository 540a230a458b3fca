"""The report of an analysis: one HTML page that fetches nothing."""

from __future__ import annotations

import base64
import io
import json
import os
import shlex
from dataclasses import fields
from importlib.resources import files
from pathlib import Path
from typing import Any

import h5py
import jinja2
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from plica.report.drawing import Drawing, blue, draw, green, grey, label_ends, line, purple, red
from plica.report.wording import number
from plica.video.analysis import Analysis, Settings
from plica.video.drift import without_drift
from plica.video.recording import Recording, Region

__all__ = ["write_report"]

_MOST_FRAMES = 60  # in the page
_NAMES = {
    "fundamental_frequency": "Fundamental frequency",
    "open_quotient": "Open quotient",
    "amplitude_left": "Amplitude, left in the image",
    "amplitude_right": "Amplitude, right in the image",
    "amplitude_asymmetry": "Amplitude asymmetry",
    "phase_asymmetry": "Phase asymmetry",
    "glottal_area_max": "Largest glottal area",
    "glottal_area_mean": "Mean glottal area",
}


def write_report(found: Analysis, source: str | Path) -> Path:
    """Write report.html beside the results of the analysis of the recording `source`; returns its path."""
    path = found.directory / "report.html"
    template = files("plica.video").joinpath("report.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    shown = np.unique(np.linspace(0, found.time.size - 1, _MOST_FRAMES).round().astype(int))
    with h5py.File(found.file, "r") as file:
        pictures = [_picture(image) for image in _overlays(found, source, file, shown)]
        sections = _sections(found, file)
    stride = max(1, round(found.time.size / shown.size))
    from plica import __version__

    text = environment.from_string(template).render(
        title=Path(source).name,
        remark=_remark(found),
        quality=_quality(found),
        frames=pictures,
        frames_json=json.dumps(pictures),
        numbers=json.dumps([int(k) for k in shown]),
        stride=stride if stride > 1 else "",
        suffix={1: "", 2: "nd", 3: "rd"}.get(stride, "th") if stride > 1 else "",
        rows=_rows(found),
        sections=sections,
        command=_command(found, source),
        version=__version__,
    )
    draft = path.with_name(path.name + ".part")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)
    return path


def _remark(found: Analysis) -> str:
    settings, cycles = found.settings, found.cycles
    rate = f"{settings.fps:g} frames/s" if settings.fps else "frame rate unknown: times in frames"
    size = f"{settings.mm_per_px:g} mm/px" if settings.mm_per_px else "pixel size unknown: lengths in pixels"
    counted = f"{cycles.count} cycles" if cycles.count else f"no cycles: {cycles.note}"
    return f"{found.time.size} frames; {rate}; {size}; {counted}."


def _quality(found: Analysis) -> tuple[str, str]:
    doubtful = sum(bool(flag.replace("collision", "").strip(", ")) for flag in found.flags)
    share = doubtful / len(found.flags)
    light = "good" if share < 0.02 else "fair" if share < 0.15 else "bad"
    said = f"{doubtful} of {len(found.flags)} frames are in doubt (blur, saturation, drift or residual)."
    return light, said


def _rows(found: Analysis) -> list[dict[str, str]]:
    rows = []
    for name, label in _NAMES.items():
        measure = found.measures[name]
        scale, unit = _in_mm(measure.unit, found.settings.mm_per_px)
        text = "-" if measure.value is None else number(scale * measure.value)
        if measure.spread is not None:
            text += f" ± {number(scale * measure.spread)}"
        cycles = f"{measure.cycles} cycles" if measure.cycles else ""
        shown = {"1": "", "px^2": "px²", "mm^2": "mm²"}.get(unit, unit)
        rows.append(
            {
                "name": label,
                "value": text,
                "unit": shown,
                "note": "; ".join(filter(None, (cycles, measure.note))),
            }
        )
    return rows


def _in_mm(unit: str, mm_per_px: float | None) -> tuple[float, str]:
    """What to multiply a measure with, and its unit then."""
    if mm_per_px and unit in ("px", "px^2"):
        return (mm_per_px, "mm") if unit == "px" else (mm_per_px**2, "mm^2")
    return 1.0, unit


def _command(found: Analysis, source: str | Path) -> str:
    words = ["plica", "video", str(source), "-o", str(found.directory)]
    default = Settings()
    for entry in fields(Settings):
        value = getattr(found.settings, entry.name)
        if value == getattr(default, entry.name):
            continue
        if entry.name == "correct_drift":
            words.append("--no-drift")
            continue
        words += [f"--{entry.name.replace('_', '-')}"]
        words.append(",".join(f"{part:g}" for part in value) if isinstance(value, tuple) else str(value))
    return shlex.join(words)


def _overlays(
    found: Analysis, source: str | Path, file: h5py.File, shown: npt.NDArray[np.int_]
) -> list[npt.NDArray[np.uint8]]:
    from scipy import ndimage

    settings = found.settings
    recording = Recording.open(
        source,
        rotation=settings.rotation,
        region=None if settings.region is None else Region(*settings.region),
        dataset=settings.dataset,
    )
    (ax, ay), (px, py) = found.midline.anterior, found.midline.posterior
    along = np.linspace(0, 1, int(2 * found.midline.length) + 2)
    rows = np.clip(np.round(ay + along * (py - ay)), 0, recording.shape[0] - 1).astype(int)
    columns = np.clip(np.round(ax + along * (px - ax)), 0, recording.shape[1] - 1).astype(int)
    images = []
    wanted = set(shown.tolist())
    for index, frame in enumerate(without_drift(recording.frames(), file["frames/drift"][:])):
        if index not in wanted:
            continue
        coloured = np.stack([np.clip(frame, 0, 255).astype(np.uint8)] * 3, axis=-1)
        mask = file["glottis/mask"][index]
        coloured[rows, columns] = (90, 160, 230)
        coloured[mask & ~ndimage.binary_erosion(mask)] = (255, 140, 40)
        images.append(coloured)
    return images


def _picture(image: npt.NDArray[np.uint8]) -> str:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="JPEG", quality=80)
    return "data:image/jpeg;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def _sections(found: Analysis, file: h5py.File) -> list[tuple[str, list[Drawing]]]:
    return [
        ("Waveforms", [_area(found), _kymogram(found, file)]),
        ("Motion of the tissue", [_modes(file), _coefficients(found, file)]),
        ("Trust", [_trust(found, file), _map(file)]),
    ]


def _unit_of_time(found: Analysis) -> tuple[npt.NDArray[np.float64], str]:
    return (1e3 * found.time, "time (ms)") if found.settings.fps else (found.time, "frame")


def _area(found: Analysis) -> Drawing:
    time, name = _unit_of_time(found)
    scale = found.settings.mm_per_px**2 if found.settings.mm_per_px else 1.0

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for values, colour in ((found.area.total, grey), (found.area.left, blue), (found.area.right, red)):
            line(axes, time, scale * values, color=colour)
        for k in np.flatnonzero([phase == "closed" for phase in found.phase]):
            axes.axvspan(
                time[k] - 0.5 * (time[1] - time[0]),
                time[k] + 0.5 * (time[1] - time[0]),
                color=grey,
                alpha=0.12,
                lw=0,
            )
        axes.set_xlabel(name)
        axes.set_ylabel("glottal area (mm²)" if found.settings.mm_per_px else "glottal area (px²)")
        axes.margins(x=0)
        label_ends(axes, [("total", grey), ("left in the image", blue), ("right in the image", red)])

    caption = (
        "Glottal area, left and right of the midline. Shaded: closed, below 5 % of the cycle's largest area."
    )
    return draw("area", caption, caption, (9, 3), paint)


def _kymogram(found: Analysis, file: h5py.File) -> Drawing:
    picture = file["glottis/kymogram"][:].T
    time, name = _unit_of_time(found)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        half = picture.shape[0] / 2
        extent = (float(time[0]), float(time[-1]), half, -half)
        axes.imshow(picture, cmap="gray", aspect="auto", extent=extent, vmin=0, vmax=255)
        axes.set_xlabel(name)
        axes.set_ylabel("across the midline (px)")

    caption = "Kymogram: the line across the middle of the midline, frame by frame; the image's left is up."
    return draw("kymogram", caption, caption, (9, 2.6), paint)


def _modes(file: h5py.File) -> Drawing:
    from matplotlib.colors import hsv_to_rgb

    patterns, share = file["modes/patterns"][:3], file["modes/share"][:]
    symmetry = file["modes/symmetry"][:]

    def paint(figure: Figure) -> None:
        panels = np.atleast_1d(figure.subplots(1, len(patterns)))
        for k, (axes, pattern) in enumerate(zip(panels, patterns, strict=True)):
            size = np.hypot(pattern[..., 0], pattern[..., 1])
            angle = np.arctan2(pattern[..., 1], pattern[..., 0]) / (2 * np.pi) % 1.0
            strength = np.clip(size / max(float(np.percentile(size, 99.5)), 1e-12), 0, 1)
            axes.imshow(hsv_to_rgb(np.stack([angle, np.ones_like(angle), strength], axis=-1)))
            axes.set_title(f"mode {k + 1}: {100 * share[k]:.1f} %, symmetry {symmetry[k]:+.2f}")
            axes.set_axis_off()

    caption = (
        "Principal modes of the tissue's motion: colour is the direction (red: to the right, cyan: to the "
        "left), brightness "
        "the size; share of the variance; likeness to the mirror image, +1 symmetric, -1 in opposite phase."
    )
    return draw("modes", caption, caption, (9, 3.4), paint)


def _coefficients(found: Analysis, file: h5py.File) -> Drawing:
    values = file["modes/coefficients"][:]
    time, name = _unit_of_time(found)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        chosen = list(zip(range(min(3, values.shape[1])), (blue, red, green), strict=False))
        for k, colour in chosen:
            line(axes, time[: len(values)], values[:, k], color=colour)
        axes.set_xlabel(name)
        axes.set_ylabel("coefficient (px)")
        axes.margins(x=0)
        label_ends(axes, [(f"mode {k + 1}", colour) for k, colour in chosen])

    caption = "Coefficients of the modes over time; positive: the folds part."
    return draw("coefficients", caption, caption, (9, 2.4), paint)


def _trust(found: Analysis, file: h5py.File) -> Drawing:
    residual, mismatch = file["flow/residual"][:], file["trust/mismatch"][:]
    time, name = _unit_of_time(found)

    def paint(figure: Figure) -> None:
        upper, lower = figure.subplots(2, 1, sharex=True)
        line(upper, time[: residual.size], residual, color=purple)
        line(lower, time[: mismatch.size], mismatch, color=green)
        upper.set_ylabel("residual (grey)")
        lower.set_ylabel("mismatch (px)")
        lower.set_xlabel(name)
        upper.margins(x=0)

    caption = (
        "Residual: root mean square of what is left of the brightness difference after the motion. "
        "Mismatch: median distance "
        "from the start after going to the next frame and back."
    )
    return draw("trust", caption, caption, (9, 3), paint)


def _map(file: h5py.File) -> Drawing:
    values: Any = file["trust/per_pixel"][:]

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        shown = axes.imshow(
            values, cmap="viridis", vmin=0, vmax=max(float(np.nanpercentile(values, 98)), 1e-6)
        )
        figure.colorbar(shown, ax=axes, label="mismatch (px)")
        axes.set_axis_off()

    caption = "Median mismatch of each pixel: where it is large, the motion is not to be trusted."
    return draw("map", caption, caption, (5, 3.4), paint)
