"""Natural frequencies of the engine's matrices: a cantilever (R6) and the exact shear mode (R7).

R6: 20 x 1 x 1, nu = 0. Errors are relative to the value extrapolated from the finest quadratic meshes; its
distance to Euler-Bernoulli's beam is what shear and rotary inertia leave.
R7: block 10 x 7 x 16 mm, fibre along its length,
f = sqrt(mu'/rho) / (2 pi) sqrt(((2l-1) pi / 2D)^2 + (m pi / T)^2), damping ratio eta omega / (4 mu').
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.sparse.linalg import eigsh

from benchmarks.harness.study import record, script_parser
from plica import _engine as engine
from plica.verify.bodies.body import Body, held

NAMES = {1: "linear", 2: "quadratic"}


def matrices(body: Body) -> list[Any]:
    """M, K (and C) on the free unknowns."""
    sim = body.simulation(scheme=engine.Newmark(), step=1e-4)
    return [body.on_free(m) for m in (sim.mass, sim.stiffness, sim.viscosity) if m]


def block(size: tuple[float, float, float], divisions: tuple[int, int, int], order: int) -> Any:
    mesh = engine.block_mesh(corner=(0, 0, 0), size=size, divisions=divisions)
    return engine.to_quadratic(mesh) if order == 2 else mesh


def cantilever() -> None:
    E, density, length = 20e3, 1040.0, 20.0
    material = engine.Material(engine.Isotropic(E, 0.0), density=density, viscosity=0.0)
    betas = np.array([1.875104, 4.694091, 7.854757])
    theory = betas**2 / (2 * np.pi * length**2) * np.sqrt(E / density / 12.0)
    meshes = {
        1: [(20, 1, 1), (40, 2, 2), (80, 4, 4), (160, 8, 8)],
        2: [(10, 1, 1), (20, 1, 1), (40, 2, 2), (80, 4, 4)],
    }
    found: dict[tuple[int, tuple[int, int, int]], np.ndarray] = {}
    unknowns: dict[tuple[int, tuple[int, int, int]], int] = {}
    for order, divisions in ((o, d) for o, many in meshes.items() for d in many):
        mesh = block((length, 1.0, 1.0), divisions, order)
        body = Body(mesh, material, held(mesh, "x_min"))
        mass, stiffness = matrices(body)
        values, modes = eigsh(stiffness, k=9, M=mass, sigma=0.0)
        # Bending along y and z come in pairs; torsion and stretching do not bend.
        bending = []
        for value, mode in zip(values, modes.T, strict=True):
            tip = body.field(mode)[np.abs(mesh.points[:, 0] - length) < 1e-9].mean(axis=0)
            if np.hypot(tip[1], tip[2]) > 0.2 * np.abs(mode).max():
                bending.append(np.sqrt(value) / 2 / np.pi)
        # The diagonals of the cells set the two planes apart: the mean of a pair.
        found[order, divisions] = np.array(bending[:6]).reshape(3, 2).mean(axis=1)
        unknowns[order, divisions] = len(body.free)
    coarse, fine = found[2, (40, 2, 2)], found[2, (80, 4, 4)]
    coarser = found[2, (20, 1, 1)]
    rates = np.log2((coarser - coarse) / (coarse - fine))
    exact = fine - (coarse - fine) / (2**rates - 1)
    rows = []
    for order, many in meshes.items():
        before = None
        for divisions in many:
            errors = found[order, divisions] / exact - 1
            rate = (
                "" if before is None or divisions == (20, 1, 1) else f"{np.log2(before[0] / errors[0]):.2f}"
            )
            before = errors
            off = [f"{100 * e:.3f} %" for e in errors]
            rows.append([NAMES[order], "x".join(map(str, divisions)), unknowns[order, divisions], *off, rate])
    limits = ", ".join(f"{f:.7f}" for f in exact)
    beam = ", ".join(f"{100 * (f / t - 1):+.3f}" for f, t in zip(exact, theory, strict=True))
    orders = ", ".join(f"{r:.2f}" for r in rates)
    note = f"Extrapolated: {limits} Hz, with orders {orders}; to beam theory {beam} %."
    columns = ["elements", "cells", "unknowns", "f1 error", "f2 error", "f3 error", "order in f1"]
    record("cantilever", columns, rows, note)


def shear_mode() -> Iterator[list[str]]:
    """A row for each mesh."""
    depth, thick, length, mu, density, eta = 10e-3, 7e-3, 16e-3, 10e3, 1040.0, 0.5
    material = engine.Material(
        engine.TransverselyIsotropic(20e3, 0.45, 40e3, 0.3, mu), density=density, viscosity=eta
    )
    for order, levels in ((1, (2, 4, 8)), (2, (1, 2, 4))):
        before = np.full(3, np.nan)
        for k in levels:
            divisions = (2 * k, k, 2 * k)  # D, L (y, the fibre), T
            mesh = block((depth, length, thick), divisions, order)
            x, y, z = np.asarray(mesh.points).T
            fixed = np.zeros((len(x), 3), bool)
            fixed[x < 1e-9] = True
            ends = (y < 1e-9) | (y > length - 1e-9)
            fixed[np.ix_(ends, [0, 2])] = True
            body = Body(mesh, material, fixed)
            mass, stiffness, viscosity = matrices(body)
            errors, damping = [], 0.0
            for half, m in ((1, 0), (2, 0), (1, 1)):
                a, b = (2 * half - 1) * np.pi / (2 * depth), m * np.pi / thick
                omega = np.sqrt(mu / density * (a**2 + b**2))
                shape = np.zeros((len(x), 3))
                shape[:, 1] = np.sin(a * x) * np.cos(b * z)
                exact = shape.ravel()[body.free]
                values, modes = eigsh(stiffness, k=12, M=mass, sigma=omega**2)
                overlap = np.abs(modes.T @ (mass @ exact)) / np.sqrt(exact @ (mass @ exact))
                best = int(np.argmax(overlap))
                found, mode = np.sqrt(values[best]), modes[:, best]
                errors.append(found / omega - 1)
                if (half, m) == (1, 0):
                    damping = mode @ (viscosity @ mode) / (2 * found) / (eta * omega / (4 * mu))
            orders = np.log2(before / np.array(errors))
            before = np.array(errors)
            cells = [cell for e, o in zip(errors, orders, strict=True) for cell in (f"{e:.2e}", f"{o:.2f}")]
            shown = ["" if cell == "nan" else cell for cell in cells]
            yield [NAMES[order], "x".join(map(str, divisions)), *shown, f"{damping:.5f}"]


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    cantilever()
    heads = [head for shape in ("1,0", "2,0", "1,1") for head in (f"f({shape}) error", "order")]
    record("shear_mode", ["elements", "cells", *heads, "damping ratio, of exact"], shear_mode())
