"""What modeFold 1.3 (github.com/yossie333/modeFold_v1.3, MIT) has in its folder, and runs of its program.

The folder is read where it is; nothing of it is kept. Its mesh is one fold of silicone in mm: x from the wall
to the midplane, y along the fold, z up, prisms between twenty sections.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from benchmarks.validation.extrusion import extruded, extruded_edges
from benchmarks.validation.m5 import write_labelled

__all__ = ["Fold", "Voice", "read_fold", "read_frequencies", "read_parameters", "voice", "write_fold"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_SAME = 0.02  # mm: one node wanders by half of that from section to section


@dataclass(frozen=True)
class Fold:
    """The section (n, 2) mm, lateral and z, its triangles, levels y, and its nodes along the airway."""

    section: Floats
    triangles: Integers
    levels: Floats
    airway: Integers
    modes: Floats
    """(k, levels, n, 3) of any scale"""

    @property
    def volume(self) -> float:
        """mm^3"""
        corners = self.section[self.triangles]
        doubled = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
        return float(0.5 * doubled.sum() * np.ptp(self.levels))


def read_fold(folder: Path) -> Fold:
    """From ``input/no_mem_mode.vtu`` and ``input/surface.txt``."""
    mesh = meshio.read(folder / "input" / "no_mem_mode.vtu")
    levels, level = np.unique(np.round(mesh.points[:, 1], 4), return_inverse=True)
    first = np.flatnonzero(level == 0)
    section = mesh.points[first][:, [0, 2]]
    row = np.array([_nearest(section, point) for point in mesh.points[:, [0, 2]]])
    place = np.empty((len(levels), len(section)), dtype=np.int64)
    place[level, row] = np.arange(len(mesh.points))
    prisms = mesh.cells_dict["wedge"]
    lowest = level[prisms] == 0
    triangles = row[prisms[lowest.sum(axis=1) == 3][lowest[lowest.sum(axis=1) == 3]].reshape(-1, 3)]
    airway = np.loadtxt(folder / "input" / "surface.txt", skiprows=1)
    modes = np.array([values[place] for name, values in sorted(mesh.point_data.items()) if "mode" in name])
    return Fold(section, triangles, levels, np.array([_nearest(section, point) for point in airway]), modes)


def _nearest(section: Floats, point: Floats) -> int:
    away = np.linalg.norm(section - point, axis=1)
    nearest = int(away.argmin())
    if away[nearest] > _SAME:
        raise SystemExit(f"modeFold: no node of the first section lies at {point}, where another one does.")
    return nearest


def read_frequencies(folder: Path) -> Floats:
    """(20) Hz, COMSOL's, from ``input/no_mem_freq.txt``."""
    lines = (folder / "input" / "no_mem_freq.txt").read_text(encoding="utf-8", errors="replace").splitlines()
    return np.array([float(line.split()[0]) for line in lines if line and not line.startswith("%")])


def read_parameters(folder: Path) -> dict[str, list[str]]:
    """Of ``input/param.txt``: the words below each comment, by the comment's first words."""
    found: dict[str, list[str]] = {}
    comment = ""
    for line in (folder / "input" / "param.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            comment = line.strip("# ").split("(")[0].strip()
        elif line.strip():
            found.setdefault(comment, line.split())
    return found


def write_fold(fold: Fold, path: Path, gap: float, quarter: bool = False) -> Path:
    """The right fold of two that are a gap (mm) apart where they are nearest; the flat top is no airway. Or
    the front half of it, cut through the middle of its central layer, with every second section."""
    depth = fold.section[:, 0].max()
    section = np.stack((depth + gap / 2 - fold.section[:, 0], fold.section[:, 1]), axis=1)
    levels = fold.levels - fold.levels.mean()
    if quarter:
        levels = np.concatenate(([0.0], levels[levels > 0][1::2]))
    points, cells = extruded(section, fold.triangles, levels)
    n, count = len(section), len(levels)
    top = fold.section[:, 1].max()
    along = fold.airway[: 1 + int(np.argmax(fold.section[fold.airway, 1] > top - _SAME))]
    wall = np.flatnonzero(fold.section[:, 0] < _SAME)
    wall = wall[np.argsort(fold.section[wall, 1])]
    surfaces = {
        "airway": extruded_edges(np.stack((along[:-1], along[1:]), axis=1), n, count),
        "wall": extruded_edges(np.stack((wall[:-1], wall[1:]), axis=1), n, count),
        "front": np.concatenate((fold.triangles, fold.triangles + (count - 1) * n)[quarter:]),
    }
    write_labelled(path, points, cells, np.ones(len(cells), dtype=np.int64), surfaces)
    return path


@dataclass(frozen=True)
class Voice:
    """A run of modeFold's own program."""

    time: Floats
    """s"""
    area: Floats
    """mm^2, the least one"""
    flow: Floats
    """cm^3/s; of incompressible flow not in any unit that its program states"""
    seconds: float
    """Of the program."""


def voice(folder: Path, changes: dict[str, str], keep_frames: bool = False) -> Voice | None:
    """Run the program `modeFold` of the folder, built there, on its input with the value below some comments
    changed; None where it is not built. Frames for ParaView are left out unless wanted."""
    program = folder / "modeFold"
    if not program.is_file():
        return None
    with tempfile.TemporaryDirectory() as work:
        shutil.copytree(folder / "input", Path(work) / "input")
        (Path(work) / "result").mkdir()
        parameters = Path(work) / "input" / "param.txt"
        lines = parameters.read_text(encoding="utf-8").splitlines()
        steps = read_parameters(folder)["number of step"][0]
        if not keep_frames:
            changes = {"output interval steps": changes.get("number of step", steps)} | changes
        for k, line in enumerate(lines):
            for comment, value in changes.items():
                if line.startswith(f"# {comment}"):
                    lines[k + 1] = value
        parameters.write_text("\n".join(lines) + "\n", encoding="utf-8")
        begin = time.perf_counter()
        subprocess.run([program.resolve()], cwd=work, check=False, capture_output=True)
        seconds = time.perf_counter() - begin
        # with incompressible flow it writes this file whole, and ends at an array that it has not allocated
        table = np.loadtxt(Path(work) / "result" / "flowrate.txt")
    return Voice(table[:, 0], table[:, 1], 1e6 * table[:, 2], seconds)
