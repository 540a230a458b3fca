"""A figure or table of the thesis made anew: its data as a file, its picture, a sentence that compares."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from plica.report.drawing import ink, style

LARGEST = 60_000  # bytes of a picture


@dataclass
class Plate:
    """One figure or table."""

    name: str  # of its files, e.g. fig05
    title: str
    shows: str  # what the thesis's shows
    text: str  # agreement or difference
    header: Sequence[str]
    rows: Iterable[Sequence[object]]  # numbers are written with five digits
    size: tuple[float, float] = (0.0, 0.0)  # inches
    paint: Callable[[Figure], None] | None = None

    def write_data(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / f"{self.name}.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.header)
            writer.writerows([cell(value) for value in row] for row in self.rows)

    def write_picture(self, folder: Path) -> None:
        """A PNG of at most 128 colours; none where there is nothing to paint."""
        if self.paint is None:
            return
        colours = {key: "#24282f" if value == ink else value for key, value in style.items()}
        white = {"figure.facecolor": "white", "axes.facecolor": "white", "savefig.facecolor": "white"}
        buffer = io.BytesIO()
        with mpl.rc_context({**colours, **white, "font.size": 8.5, "lines.linewidth": 1.1}):
            figure = Figure(figsize=self.size, layout="constrained")
            self.paint(figure)
            figure.savefig(buffer, format="png", dpi=110)
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"thesis_{self.name}.png"
        Image.open(buffer).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)
        if path.stat().st_size > LARGEST:
            raise RuntimeError(f"{path}: {path.stat().st_size} bytes; must be <= {LARGEST}. Draw it smaller.")


def cell(value: object) -> object:
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value:.5g}"
    return value
