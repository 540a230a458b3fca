"""The figures of the tissue's fundamental: motion, phase and strain, and kymograms of the flow."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.measures.scale import shown_unit
from plica.measures.thresholds import strain_gauge
from plica.report.drawing import Drawing, draw
from plica.video.analysis import Analysis
from plica.video.glottis.midline import pixels
from plica.video.motion.mucosal_wave import Fundamental
from plica.video.report.pictures import about, kymograms

__all__ = ["folds_box", "over_tissue", "wave_drawings"]

_LARGEST = 99  # percentile that a scale of colours ends at
_AS_HIGH = 0.8  # of its figure: a map's scale is no higher than the map
_FAINT = 0.15  # of the largest motion: less has no phase that could be read
_BESIDE = 2.0  # of what the kymograms show: tissue moves beside the edges too


def folds_box(found: Analysis) -> tuple[slice, slice]:
    """Rows and columns that maps show: the folds, whose motion is small in the whole frame."""
    return about(found, 0.7, 0.25)


def over_tissue(found: Analysis) -> Any:
    """(h, w, 3) the frame of the least glottal area, on which maps are laid."""
    frame = int(np.nanargmin(found.area.total))
    return found.frames().pictures({frame})[frame]


def wave_drawings(found: Analysis) -> list[Drawing]:
    """Maps of the fundamental, where there is one, and the flow along the kymograms' lines."""
    if "waves/known" not in found:
        return []
    known = found.fundamental
    return [*([] if known is None else [_maps(found, known), _strains(found, known)]), _kymograms(found)]


def _map(axes: Axes, picture: Any, values: Any, colours: str, low: float, high: float) -> Any:
    axes.imshow(picture)
    shown = axes.imshow(np.ma.masked_invalid(values), cmap=colours, vmin=low, vmax=high, alpha=0.75)
    axes.set_axis_off()
    return shown


def _largest(values: Any) -> float:
    there = np.abs(values[np.isfinite(values)])
    return max(float(np.percentile(there, _LARGEST)), 1e-12) if there.size else 1.0


def _maps(found: Analysis, known: Fundamental) -> Drawing:
    factor, unit = shown_unit(found.scale.unit("m"))
    line, picture, box = found.midline, over_tissue(found), folds_box(found)
    outward = np.sign(line.place(pixels(picture.shape))[..., 1]) * (known.displacement @ line.across)
    size = factor * found.pixel * np.abs(outward)
    strong = size >= _FAINT * _largest(size)
    mean = np.angle(np.sum(outward[strong]))
    phase = np.where(strong, np.degrees(np.angle(outward * np.exp(-1j * mean))), np.nan)

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        shown = _map(left, picture[box], size[box], "viridis", 0, _largest(size))
        figure.colorbar(shown, ax=left, label=f"amplitude ({unit})", shrink=_AS_HIGH)
        shown = _map(right, picture[box], phase[box], "twilight", -180, 180)
        figure.colorbar(shown, ax=right, label="phase (deg)", shrink=_AS_HIGH)

    caption = (
        "Motion across the midline at the voice's frequency, laid over the frame of least area: amplitude; "
        "and phase of the motion away from the midline against its mean, where it is over "
        f"{100 * _FAINT:g} % of the largest. A wave that runs outward lags more the farther out; left and "
        "right apart are a phase between the folds."
    )
    return draw("waves", caption, "Amplitude and phase of the motion", (9, 4.4), paint)


def _strains(found: Analysis, known: Fundamental) -> Drawing:
    picture, box = over_tissue(found), folds_box(found)
    names = ("across the midline", "along it", "shear")
    rate = 2 * np.pi / float(np.median(found.cycles.periods))
    unit = found.scale.unit("1/s")

    def paint(figure: Figure) -> None:
        for k, (axes, name) in enumerate(zip(figure.subplots(1, 3), names, strict=True)):
            values = np.abs(known.strain[..., k])
            shown = _map(axes, picture[box], 100 * values[box], "inferno", 0, 100 * _largest(values))
            figure.colorbar(shown, ax=axes, label="strain (%)", shrink=_AS_HIGH)
            axes.set_title(f"{name}\n(rate: {rate / 100:.3g} {unit} a %)", fontsize=8)

    size = shown_unit(found.scale.unit("m"))
    width = f" ({size[0] * found.pixel * strain_gauge:.2g} {size[1]})" if found.settings.mm_per_px else ""
    caption = (
        "Strain amplitude at the voice's frequency: 2-D projection of the surface's motion as the camera "
        "sees it, symmetric gradient of the displacement in the axes of the midline, over a gauge of "
        f"{strain_gauge:g} px{width}; colours end at what 1 % of the pixels exceed. Strain rates are strains "
        "times the number above each map. A surface that tips towards the camera changes its length in the "
        "picture without strain."
    )
    return draw("strain", caption, "Strain and strain rate of the tissue's surface", (9, 3.6), paint)


def _kymograms(found: Analysis) -> Drawing:
    stored, grey = found["waves/kymogram"], found["sides/kymogram"]
    factor, unit = shown_unit(found.scale.unit("m"))
    size, largest = factor * found.pixel, _largest(stored)
    step = found.time[1] - found.time[0]
    scale, name = shown_unit(found.scale.unit("s"))
    half = 0.5 * size * stored.shape[2]
    extent = (0.0, scale * step * stored.shape[1], half, -half)
    shown_half = min(half, _BESIDE * size * kymograms(found)[0].half)

    def paint(figure: Figure) -> None:
        rows = figure.subplots(len(stored), 2, sharex=True, sharey=True, squeeze=False)
        for (left, right), motion, picture, place in zip(
            rows, stored, grey, found.settings.places, strict=True
        ):
            left.imshow(picture[:-1].T, cmap="gray", aspect="auto", extent=extent, vmin=0, vmax=255)
            shown = right.imshow(
                size * motion.T,
                cmap="RdBu_r",
                aspect="auto",
                extent=extent,
                vmin=-size * largest,
                vmax=size * largest,
            )
            left.set_ylabel(f"{place:g}\nacross ({unit})")
            left.set_ylim(shown_half, -shown_half)
            figure.colorbar(shown, ax=right, label=f"{unit} a frame")
        for axes in rows[-1]:
            axes.set_xlabel(f"time ({name})")

    caption = (
        "Kymograms of the picture (left) and of the flow (right) along the same lines: how far what is seen "
        "moves to the image's right (red) or left (blue), to the next frame; the image's left is up. Within "
        "the glottis there is no tissue, and the flow is what lies around it, filled in."
    )
    return draw(
        "flow_kymograms", caption, "Kymograms of picture and flow", (9, 0.6 + 1.7 * len(stored)), paint
    )
