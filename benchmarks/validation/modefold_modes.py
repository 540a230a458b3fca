"""The modes of modeFold's silicone fold, by COMSOL and by Plica.

    python -m benchmarks.validation.modefold_modes --modefold DIR     3 minutes

DIR is a clone of github.com/yossie333/modeFold_v1.3; nothing of it is kept, and without it nothing is done.
Modes are paired by their shapes (MAC: 1 where they are the same), not by their order. Fitted: E / density on
modes 1 to 6, for each Poisson's ratio. Judged: modes 7 to 20, and all shapes. Assumed: isotropic, one layer,
held at the wall and both ends. Record: `modefold_modes`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation import m5
from benchmarks.validation.modefold_files import (
    Fold,
    read_fold,
    read_frequencies,
    read_parameters,
    write_fold,
)

FITTED = 6
RATIOS = (0.3, 0.45, 0.49)
COMPUTED = 26  # modes among which partners are sought
GAP = 0.1  # mm; modes do not depend on it
Floats = NDArray[np.float64]


def density(folder: Path) -> float:
    """kg/m^3: the mass of param.txt over the mesh's volume."""
    mass = float(read_parameters(folder)["mass of vocal fold"][0])
    return mass / (1e-9 * read_fold(folder).volume)


def fitted(found: Floats, published: Floats) -> float:
    """The factor of all frequencies by which the first ones agree in the mean of their logarithms."""
    return float(np.exp(np.log(published[:FITTED] / found[:FITTED]).mean()))


def rms(errors: Floats) -> float:
    return float(np.sqrt((errors**2).mean()))


def likeness(fold: Fold, mesh_points: Floats, shapes: Floats) -> Floats:
    """(modes of the file, k) MAC of its shapes and of shapes (k, n, 3) at nodes (n, 3) m of the scene."""
    from scipy.spatial import cKDTree

    lateral = fold.section[:, 0].max() + GAP / 2 - fold.section[:, 0]
    along = fold.levels[:, None] - fold.levels.mean()
    places = np.stack(np.broadcast_arrays(lateral, along, fold.section[:, 1]), axis=-1)
    right = np.flatnonzero(mesh_points[:, 0] > 0)
    away, rows = cKDTree(mesh_points[right]).query(1e-3 * places.reshape(-1, 3))
    assert away.max() < 1e-7
    ours = (shapes[:, right[rows]] * (-1, 1, 1)).reshape(len(shapes), -1)
    theirs = fold.modes.reshape(len(fold.modes), -1)
    ours /= np.linalg.norm(ours, axis=1, keepdims=True)
    theirs = theirs / np.linalg.norm(theirs, axis=1, keepdims=True)
    return np.asarray((theirs @ ours.T) ** 2)


def rows(folder: Path) -> Iterator[list[object]]:
    fold, published = read_fold(folder), read_frequencies(folder)
    found = [_paired(folder, fold, published, nu) for nu in RATIOS]
    yield ["E / density (m^2/s^2)", "-", *(f"{one.stiffness:.2f}" for one in found)]
    for k, hertz in enumerate(published):
        cells = [f"{one.hertz[k]:.1f} ({one.errors[k]:+.1f} %; {one.likeness[k]:.2f})" for one in found]
        yield [f"mode {k + 1} (Hz), {'fitted' if k < FITTED else 'judged'}", f"{hertz:.1f}", *cells]
    for said, part in (("fitted", slice(0, FITTED)), ("judged", slice(FITTED, None))):
        yield [f"rms error of those {said} (%)", "-", *(f"{rms(one.errors[part]):.1f}" for one in found)]
        lowest = (f"{np.median(one.likeness[part]):.2f}, {one.likeness[part].min():.2f}" for one in found)
        yield [f"median and lowest MAC of those {said}", "-", *lowest]


@dataclass(frozen=True)
class Paired:
    """Plica's modes that are most like COMSOL's."""

    stiffness: float
    """m^2/s^2, E / density"""
    hertz: Floats
    errors: Floats
    """%"""
    likeness: Floats


def _paired(folder: Path, fold: Fold, published: Floats, nu: float) -> Paired:
    weight = density(folder)
    with tempfile.TemporaryDirectory() as work:
        path = write_fold(fold, Path(work) / "fold.msh", GAP)
        scene = m5.scene(path, plica.Tissue(E=weight, nu=nu, density=weight), mirror="fold")
        mesh = plica.build_mesh(scene.mesh)
        found = plica.eigenmodes(scene, COMPUTED, mesh=mesh)
    same = likeness(fold, np.asarray(mesh.points), found.shape)
    theirs, ours = linear_sum_assignment(-same)
    factor = fitted(found.frequency[ours], published)
    hertz = factor * found.frequency[ours]
    return Paired(factor**2, hertz, 100 * (hertz / published - 1), same[theirs, ours])


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--modefold", type=Path, metavar="DIR", required=True)
    chosen = parser.parse_args().modefold
    if not (chosen / "input" / "no_mem_mode.vtu").is_file():
        raise SystemExit(f"{chosen}: has no input/no_mem_mode.vtu; must be a clone of modeFold 1.3.")
    record(
        "modefold_modes",
        ["", "COMSOL", *(f"Plica, nu = {nu:g} (error; MAC)" for nu in RATIOS)],
        rows(chosen),
    )
