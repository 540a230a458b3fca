"""The page: one file with the surface in all phases, waveforms, and the libraries that draw them."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.films.surface import skin
from plica.measures.mesh_data import flat_faces, toward_right
from plica.measures.run.cautions import cautions
from plica.measures.run.folds import glottal_canal, rest_width
from plica.measures.run.run_data import RunData
from plica.report.page import render
from plica.storage.files import refuse_overwriting, storage_errors, write_text
from plica.viewer.fields import displacements, quantities
from plica.viewer.packing import packed, packed_levels, packed_motion
from plica.viewer.phases import Phases, least_phases, phases_of
from plica.viewer.waves import waves

__all__ = ["largest_page", "most_phases", "write_view"]

most_phases = 60
largest_page = 4_000_000  # bytes
_RIGHT = 2  # of the sides of cells


def write_view(run: RunData, path: str | Path, *, phases: int | None = None, overwrite: bool = False) -> Path:
    """Write a page on which the larynx of a run can be turned, cut and played (docs/view.md).

    Parameters
    ----------
    run : Run or RunPart
        With fields (``output.every``). Of a run its last steady period with two or more of them is shown, of
        a part (`Run.between`) all of it, as of a run without such a period.
    path : str or Path
        Ends in .html; the file appears complete or not at all.
    phases : int, optional
        At most so many stored fields are shown, evenly chosen; default: 60, or as many as keep the page at
        4 MB.
    overwrite : bool
        Replace an existing file.

    Returns
    -------
    Path
        The page, which needs no other file and no network.

    Raises
    ------
    InvalidInput
        Without fields or with too few; for another file name extension, and if the file exists and
        `overwrite` is False.
    StorageFailed
        If the page cannot be written.
    """
    path = Path(path)
    _require_page(path, overwrite)
    if phases is not None and (phases < least_phases or phases % 1):
        raise InvalidInput(f"View: phases = {phases}; must be a whole number >= {least_phases}.")
    shown, said = phases_of(run), [str(one) for one in cautions(run.whole)]
    most = most_phases if phases is None else phases
    text = _page(run, shown.thinned(most), said)
    while phases is None and len(text.encode()) > largest_page and most > least_phases:
        most = max(min(most, len(shown.frames)) * 3 // 4, least_phases)
        text = _page(run, shown.thinned(most), said)
    with storage_errors(path):
        return write_text(text, path)


def _require_page(path: Path, overwrite: bool) -> None:
    if path.suffix.lower() not in (".html", ".htm"):
        raise InvalidInput(f"View: {path}; must end in .html.")
    if path.is_dir() or not path.absolute().parent.is_dir():
        problem = f"{path} is a directory" if path.is_dir() else f"{path.parent} is not a directory"
        raise InvalidInput(f"View: {problem}; must be a file in an existing directory.")
    refuse_overwriting([path], overwrite)


def _page(run: RunData, phases: Phases, said: list[str]) -> str:
    name = Path(getattr(run.whole, "directory", "run")).resolve().name
    own = files("plica.viewer")

    def bare(file: str) -> Markup:
        return Markup(own.joinpath(file).read_text(encoding="utf-8"))

    return render(
        "viewer/page.html.j2",
        title=name,
        running=name,
        remark=_remark(run, phases),
        banner=_banner(run.whole),
        cautions=said,
        data=_data(run, phases),
        style=bare("vendor/uPlot.min.css"),
        licences=bare("vendor/licences.txt"),
        vendor=bare("vendor/vendor.min.js"),
        script=bare("view.js"),
    )


def _remark(run: RunData, phases: Phases) -> str:
    """Which fields are shown."""
    count = len(phases.frames)
    of = f" of {phases.stored}" if phases.stored > count else ""
    first, last = (f"{1e3 * float(t):.5g}" for t in (phases.time[0], phases.time[-1]))
    if phases.cycle is None:
        return f"{count}{of} stored fields, from {first} to {last} ms."
    begin, end = (f"{1e3 * t:.5g}" for t in phases.cycle)
    return f"A steady period, from {begin} to {end} ms, in {count}{of} stored fields."


def _banner(run: RunData) -> str:
    """A note if the run is not finished, else empty."""
    done, asked = int(np.size(run.time)), run.steps_asked
    if run.failure:
        return f"This run failed after {done} of {asked} steps. {run.failure}"
    return f"This run is not complete: it has {done} of {asked} steps." if done < asked else ""


def _data(run: RunData, phases: Phases) -> dict[str, Any]:
    """All that the page's script reads."""
    mesh = run.mesh
    points = np.asarray(mesh.points, dtype=float)
    faces = skin(points, np.asarray(mesh.cells))
    sides = toward_right(points, np.asarray(mesh.cells), np.asarray(getattr(mesh, "cell_side", ())))
    on_right = _on_right(faces, run) if sides else np.zeros(len(faces), dtype=bool)
    faces = np.concatenate((faces[~on_right], faces[on_right]))
    nodes, local = np.unique(faces, return_inverse=True)
    triangles = flat_faces(local.reshape(faces.shape))
    motion, level = packed_motion(1e3 * displacements(run, phases.frames)[:, nodes])
    coloured = []
    for quantity in quantities(run, phases.frames, nodes.tolist()):
        levels, largest = packed_levels(quantity.values)
        described = {"name": quantity.name, "unit": quantity.unit, "meaning": quantity.meaning}
        coloured.append(described | {"levels": levels, "largest": largest})
    return {
        "time": [round(1e3 * float(t), 6) for t in phases.time],
        "cycle": None if phases.cycle is None else [1e3 * t for t in phases.cycle],
        "nodes": int(nodes.size),
        "points": packed((1e3 * points[nodes]).astype(np.float32)),
        "triangles": packed(triangles.astype(np.uint32)),
        "left": int((~on_right).sum()) * triangles.shape[1],
        "motion": motion,
        "level": level,
        "quantities": coloured,
        "colours": _colours(),
        "sides": sides,
        "canal": _canal(run),
        "waves": waves(run, phases),
    }


def _on_right(faces: NDArray[np.int64], run: RunData) -> NDArray[np.bool_]:
    """Which faces (f, 3 or 6) are of the right fold: all their corners are in its cells."""
    cells, side = np.asarray(run.mesh.cells), np.asarray(getattr(run.mesh, "cell_side", ()))
    right = np.zeros(len(run.mesh.points), dtype=bool)
    right[cells[side == _RIGHT, :4]] = True
    return np.asarray(right[faces[:, :3]].all(axis=1))


def _colours() -> list[int]:
    """Red, green, blue (sRGB, 0 to 255) of each level, one after the other: magma from its light end, where
    shading shows the shape, without its darkest sixth, where it would not."""
    table: NDArray[np.uint8] = mpl.colormaps["magma_r"](np.linspace(0, 5 / 6, 256), bytes=True)
    return [int(value) for value in table[:, :3].ravel()]


def _canal(run: RunData) -> list[float] | None:
    """Lowest and highest z (mm) of the glottal canal at rest; None without airflow."""
    height = np.asarray(run.section_height, dtype=float)
    if not height.size:
        return None
    canal = glottal_canal(rest_width(run))
    return [1e3 * float(height[canal.start]), 1e3 * float(height[canal.stop - 1])]
