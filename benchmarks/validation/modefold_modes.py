"""The modes of modeFold's silicone fold, by COMSOL and by Plica.

    python -m benchmarks.validation.modefold_modes --modefold DIR     3 minutes

DIR is a clone of github.com/yossie333/modeFold_v1.3; nothing of it is kept, and without it nothing is done.
Fitted: E / density on modes 1 to 6, for each Poisson's ratio. Judged: modes 7 to 20, and shapes (MAC: 1 where
shapes are the same). Assumed: isotropic, one layer, held at the wall and both ends. Record: `modefold_modes`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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
RATIOS = (0.3, 0.4, 0.45, 0.49)
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
    """(k) MAC of shapes (k, n, 3) at nodes (n, 3) m and those of the file, mode by mode."""
    depth = fold.section[:, 0].max()
    lateral = depth + GAP / 2 - fold.section[:, 0]
    places = np.stack(
        np.broadcast_arrays(lateral, fold.levels[:, None] - fold.levels.mean(), fold.section[:, 1])
    )
    places = 1e-3 * np.moveaxis(places, 0, -1).reshape(-1, 3)
    right = np.flatnonzero(mesh_points[:, 0] > 0)
    from scipy.spatial import cKDTree

    away, rows = cKDTree(mesh_points[right]).query(places)
    assert away.max() < 1e-7
    ours = shapes[:, right[rows]] * (-1, 1, 1)
    theirs = fold.modes.reshape(len(fold.modes), -1, 3)
    products = [
        np.vdot(a, b) ** 2 / (np.vdot(a, a) * np.vdot(b, b)) for a, b in zip(ours, theirs, strict=True)
    ]
    return np.array(products)


def rows(folder: Path) -> Iterator[list[object]]:
    fold, published = read_fold(folder), read_frequencies(folder)
    weight = density(folder)
    frequencies, same, stiffness = [], [], []
    for nu in RATIOS:
        with tempfile.TemporaryDirectory() as work:
            path = write_fold(fold, Path(work) / "fold.msh", GAP)
            scene = m5.scene(path, plica.Tissue(E=weight, nu=nu, density=weight), mirror="fold")
            mesh = plica.build_mesh(scene.mesh)
            found = plica.eigenmodes(scene, len(published), mesh=mesh)
        factor = fitted(found.frequency, published)
        frequencies.append(factor * found.frequency)
        stiffness.append(factor**2)
        same.append(likeness(fold, np.asarray(mesh.points), found.shape))
    yield ["E / density (m^2/s^2)", "-", *(f"{value:.2f}" for value in stiffness)]
    for k, hertz in enumerate(published):
        cells = [
            f"{f[k]:.1f} ({100 * (f[k] / hertz - 1):+.1f} %; {mac[k]:.2f})"
            for f, mac in zip(frequencies, same, strict=True)
        ]
        yield [f"mode {k + 1} (Hz), {'fitted' if k < FITTED else 'judged'}", f"{hertz:.1f}", *cells]
    for said, part in (("fitted", slice(0, FITTED)), ("judged", slice(FITTED, None))):
        errors = [100 * rms(f[part] / published[part] - 1) for f in frequencies]
        yield [f"rms error of the modes that are {said} (%)", "-", *(f"{error:.1f}" for error in errors)]


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
