"""Natural frequencies of the parametric larynx, outer wall held, by mesh.

    python -m benchmarks.tissue.larynx_modes

Presets by purpose, one in levels, and a mesh of small edges that grow slowly, with more lines ("between").
The tissue is that of examples/normal_phonation.toml. A mode is symmetric where the folds move as mirror
images; the eigenproblem is reduced to these, one fold with u_x = 0 where both meet. Errors are of the lowest
three, against REFERENCE.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import eigsh
from scipy.spatial import cKDTree

import plica
from benchmarks.harness.study import record, script_parser
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.summary import dihedral_angles, quality

SCENE = Path(__file__).parents[2] / "examples" / "normal_phonation.toml"
REFERENCE = np.array([185.5, 240.4, 258.9])
"""Hz, of a mesh of about 100,000 unknowns; by second order the limit is 0.2 to 0.4 % lower."""
PRESETS = ("coarse", "demo", "fine", "finest", "thesis_demo")
BETWEEN = {"size": 0.25e-3, "growth": 0.25, "around": 40}
COLUMNS = (
    *("mesh", "size (mm), growth, lines", "unknowns", "f1, f2, f3 (Hz)", "error (%)"),
    *("mean ratio: least, median", "dihedral angles"),
)


def symmetric_modes(
    larynx: plica.Larynx, count: int = 3, surface_mass: Literal["kept", "redistributed"] = "kept"
) -> tuple[int, NDArray[np.float64]]:
    """Free unknowns of the whole larynx, and its lowest symmetric frequencies in Hz; surface_mass: where that
    of the contact surfaces is."""
    scene = plica.Scene.load(SCENE)
    contact = plica.Contact(multipliers=plica.Multipliers(), surface_mass=surface_mass)
    bare = plica.Scene(larynx, scene.tissue, supports=scene.supports, time=scene.time, contact=contact)
    mesh = build_mesh(bare.mesh, bare.source)
    simulation = build_simulation(bare, mesh)
    x = np.asarray(mesh.points)
    fixed = np.zeros(x.shape, bool)
    fixed[mesh.node_sets["wall"]] = True
    mirror = cKDTree(x).query(x * [-1, 1, 1])[1]
    rows, columns, values = [], [], []
    width = 0
    for axis, sign in enumerate((-1, 1, 1)):
        middle = mirror == np.arange(len(x))
        own = np.flatnonzero((x[:, 0] >= 0) & ~fixed[:, axis] & ~(middle & (axis == 0)))
        numbers = np.arange(width, width + len(own))
        weight = np.where(middle[own], 0.5, 1.0)
        rows += [3 * own + axis, 3 * mirror[own] + axis]
        columns += [numbers, numbers]
        values += [weight, sign * weight]
        width += len(own)
    spread = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(x.size, width)
    ).tocsr()
    K, M = (
        (spread.T @ csr_array(m, shape=(x.size, x.size)) @ spread).tocsc()
        for m in (simulation.stiffness, simulation.mass)
    )
    found = np.sort(eigsh(K, count, M, sigma=0.0, return_eigenvectors=False))
    return int((~fixed).sum()), np.sqrt(found) / (2 * np.pi)


def row(name: str, larynx: plica.Larynx) -> list[str]:
    mesh = build_mesh(larynx)
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    ratio, angles = quality(points, cells), dihedral_angles(points, cells)
    unknowns, modes = symmetric_modes(larynx)
    errors = ", ".join(f"{100 * error:.1f}" for error in modes / REFERENCE - 1)
    made = larynx.all_options()
    lines = f"{1e3 * made['size']:g}, {made['growth']:g}, {made['around']}" if "size" in made else "in levels"
    return [
        name,
        lines,
        f"{unknowns:,}",
        ", ".join(f"{f:.2f}" for f in modes),
        errors,
        f"{ratio.min():.3f}, {np.median(ratio):.2f}",
        f"{angles.min():.1f}° to {angles.max():.0f}°",
    ]


def rows() -> Iterator[list[str]]:
    """A row for each mesh."""
    for name in PRESETS:
        yield row(f"`{name}`", plica.Larynx(larynx=name, order=2))
    yield row("between", plica.Larynx(larynx="demo", order=2, options=BETWEEN))


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    record("larynx_modes", COLUMNS, rows())
