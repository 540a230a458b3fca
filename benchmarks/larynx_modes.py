"""Natural frequencies of the parametric larynx, outer wall held: linear and quadratic tetrahedra.

The tissue is that of examples/thesis.toml, with the shear modulus across the fibre as printed, E / (1 +
nu), so that the figures can be held against those an independent linear-element code gave for the symmetric
modes: 232.5, 270.9, 355.0, 410.0 Hz with 5,400 unknowns (a quarter of the larynx) and 218.8, 259.5, 328.3,
377.3 Hz with 90,000. A mode is symmetric where the folds move as mirror images.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import eigsh
from scipy.spatial import cKDTree

import plica
from plica.phonation.run.build import build_simulation
from plica.phonation.scene.mesh_source import build_mesh

SCENE = Path(__file__).parents[1] / "examples" / "thesis.toml"
MESHES = {
    "coarse": {},
    "medium": {},
    "demo": {"around": 16, "levels": [2, 1, 1, 2, 1, 6, 1, 2, 1, 2]},
}


def modes(
    name: str, options: dict[str, object], order: int, count: int = 8
) -> tuple[int, list[tuple[float, bool]]]:
    """Free unknowns, and (frequency Hz, symmetric) of the lowest modes."""
    scene = plica.Scene.load(SCENE)
    preset = "coarse" if name == "demo" else name
    larynx = plica.Larynx(larynx=preset, order=order, options=options)
    bare = plica.Scene(larynx, scene.tissue, supports=scene.supports, time=scene.time)
    mesh = build_mesh(bare.mesh, bare.source)
    simulation = build_simulation(bare, mesh)
    points = np.asarray(mesh.points)
    n = points.size
    fixed = np.zeros(points.shape, bool)
    fixed[mesh.node_sets["wall"]] = True
    free = np.flatnonzero(~fixed.ravel())
    K, M = (
        csr_array(m, shape=(n, n))[free][:, free].tocsc() for m in (simulation.stiffness, simulation.mass)
    )
    values, vectors = eigsh(K, count, M, sigma=0.0)
    mirror = cKDTree(points).query(points * [-1, 1, 1])[1]
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        u = np.zeros(n)
        u[free] = vector
        u = u.reshape(-1, 3)
        found.append((float(np.sqrt(value) / 2 / np.pi), bool((u * u[mirror] * [-1, 1, 1]).sum() > 0)))
    return free.size, found


def main() -> None:
    print("| mesh | order | unknowns | symmetric modes (Hz) | antisymmetric (Hz) |")
    print("| --- | --- | --- | --- | --- |")
    for name, order in (("coarse", 1), ("medium", 1), ("coarse", 2), ("demo", 2)):
        unknowns, found = modes(name, MESHES[name], order)
        texts = [
            ", ".join(f"{f:.1f}" for f, symmetric in found if symmetric is side) for side in (True, False)
        ]
        print(f"| {name} | {order} | {unknowns} | {texts[0]} | {texts[1]} |")


if __name__ == "__main__":
    main()
