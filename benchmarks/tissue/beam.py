"""Natural frequencies of the engine's matrices: a cantilever (R6) and the exact shear mode (R7).

R6: 20 x 1 x 1, nu = 0. Errors are relative to the value extrapolated from the finest quadratic meshes; its
distance to Euler-Bernoulli's beam is what shear and rotary inertia leave.
R7: block 10 x 7 x 16 mm, fibre along its length,
f = sqrt(mu'/rho) / (2 pi) sqrt(((2l-1) pi / 2D)^2 + (m pi / T)^2), damping ratio eta omega / (4 mu').
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.verify.tissue.modes import (
    BEAM_E,
    DENSITY,
    ETA,
    MU_FIBRE,
    SHEAR_MODES,
    SLENDER,
    bending,
    exact_shear,
    shear_mode,
    slender_beam,
)

NAMES = {1: "linear", 2: "quadratic"}


def cantilever() -> None:
    betas = np.array([1.875104, 4.694091, 7.854757])
    theory = betas**2 / (2 * np.pi * SLENDER**2) * np.sqrt(BEAM_E / DENSITY / 12.0)
    meshes = {
        1: [(20, 1, 1), (40, 2, 2), (80, 4, 4), (160, 8, 8)],
        2: [(10, 1, 1), (20, 1, 1), (40, 2, 2), (80, 4, 4)],
    }
    found: dict[tuple[int, tuple[int, int, int]], np.ndarray] = {}
    unknowns: dict[tuple[int, tuple[int, int, int]], int] = {}
    for order, divisions in ((o, d) for o, many in meshes.items() for d in many):
        body = slender_beam(divisions, order)
        found[order, divisions] = bending(body)
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


def shear_modes() -> Iterator[list[str]]:
    """A row for each mesh."""
    for order, levels in ((1, (2, 4, 8)), (2, (1, 2, 4))):
        before = np.full(3, np.nan)
        for k in levels:
            modes = {shape: shear_mode(order, k, *shape) for shape in SHEAR_MODES}
            errors = [omega / exact_shear(*shape) - 1 for shape, (omega, _) in modes.items()]
            damping = modes[1, 0][1] / (ETA * exact_shear(1, 0) / (4 * MU_FIBRE))
            orders = np.log2(before / np.array(errors))
            before = np.array(errors)
            cells = [cell for e, o in zip(errors, orders, strict=True) for cell in (f"{e:.2e}", f"{o:.2f}")]
            shown = ["" if cell == "nan" else cell for cell in cells]
            yield [NAMES[order], f"{2 * k}x{k}x{2 * k}", *shown, f"{damping:.5f}"]


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    cantilever()
    heads = [head for shape in ("1,0", "2,0", "1,1") for head in (f"f({shape}) error", "order")]
    record("shear_mode", ["elements", "cells", *heads, "damping ratio, of exact"], shear_modes())
