"""Natural frequencies: a cantilever (R6), the exact shear mode and its damping (R7), a block (R8)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh

from plica import _engine as engine
from plica.verify.bodies.body import Body, free_block
from plica.verify.case import Case, Check, worst

__all__ = [
    "BEAM_E",
    "CASES",
    "DENSITY",
    "ETA",
    "MU_FIBRE",
    "SHEAR_MODES",
    "SLENDER",
    "bending",
    "exact_shear",
    "per_cell",
    "shear_block",
    "shear_mode",
    "slender_beam",
]

Array = NDArray[np.float64]

DENSITY = 1040.0  # kg/m^3
DEEP, THICK, LONG = 10e-3, 7e-3, 16e-3  # m: R7 and R8
MU_FIBRE, ETA = 10e3, 0.5  # Pa, Pa s
BEAM_E, SLENDER = 20e3, 20.0  # Pa; length over width
SHEAR_MODES = ((1, 0), (2, 0), (1, 1))


def lowest(body: Body, count: int, near: float = 0.0) -> tuple[Array, Array]:
    """Angular frequencies nearest to `near` (rad/s) and their modes."""
    M, K = (body.on_free(m) for m in (body.assembly.mass(), body.assembly.stiffness()))
    start = np.random.default_rng(1).normal(size=len(body.free))
    values, modes = eigsh(K, k=count, M=M, sigma=near**2, v0=start)
    order = np.argsort(values)
    return np.sqrt(values[order]), modes[:, order]


def timoshenko(number: int) -> float:
    """Hz, of a clamped beam 20 x 1 x 1 with nu = 0: shear coefficient 5/6.

    The state (w, psi, Q, M) obeys w' = psi + Q / (kappa G A), psi' = M / (E I), Q' = -rho A omega^2 w,
    M' = -Q - rho I omega^2 psi; Q and M vanish at the free end where a determinant does.
    """
    area, inertia, shear = 1.0, 1 / 12, 5 / 6 * BEAM_E / 2

    def at_end(omega: float) -> float:
        slope = np.zeros((4, 4))
        slope[0, 1], slope[0, 2], slope[1, 3] = 1, 1 / shear, 1 / (BEAM_E * inertia)
        slope[2, 0], slope[3, 1], slope[3, 2] = -DENSITY * area * omega**2, -DENSITY * inertia * omega**2, -1
        return float(np.linalg.det(expm(slope * SLENDER)[2:, 2:]))

    beta = (1.875104, 4.694091, 7.854757)[number]
    slender = (beta / SLENDER) ** 2 * sqrt(BEAM_E * inertia / (DENSITY * area))
    return float(brentq(at_end, 0.9 * slender, slender, xtol=1e-12 * slender)) / (2 * pi)


def cantilever() -> Iterator[Check]:
    """The diagonals of the cells set the two planes of bending apart: the mean of each pair."""
    coarse, fine = (bending(slender_beam((20 * n, n, n), 2)) for n in (1, 2))
    for k in range(3):
        yield Check(
            name=f"f{k + 1}",
            quantity=f"bending frequency {k + 1}",
            unit="Hz",
            value=float(fine[k]),
            reference=timoshenko(k),
            tolerance=float(abs(coarse[k] / fine[k] - 1)) / 3,
            because="a third of the change from the mesh half as fine, which bounds the error at "
            "order 2 or better",
        )


def slender_beam(divisions: tuple[int, int, int], order: int) -> Body:
    """R6's: 20 x 1 x 1, nu = 0, clamped at x = 0."""
    law = engine.Isotropic(BEAM_E, 0.0)
    return free_block(law, (SLENDER, 1, 1), divisions, order, density=DENSITY).hold("x_min")


def bending(body: Body) -> Array:
    """Hz, the lowest three of a clamped beam; torsion and stretching do not bend."""
    omegas, modes = lowest(body, 9)
    tip = np.asarray(body.mesh.node_sets["x_max"])
    found = []
    for omega, mode in zip(omegas, modes.T, strict=True):
        at_tip = body.field(mode)[tip].mean(axis=0)
        if np.hypot(at_tip[1], at_tip[2]) > 0.2 * np.abs(mode).max():
            found.append(omega / (2 * pi))
    return np.asarray(np.array(found[:6]).reshape(3, 2).mean(axis=1))


def shear_block(order: int, cells: int) -> Body:
    """R7's: u_y free but at x = 0, the others held there and at both ends of the fibre."""
    law = engine.TransverselyIsotropic(20e3, 0.45, 40e3, 0.3, MU_FIBRE)
    size, divisions = (DEEP, LONG, THICK), (2 * cells, cells, 2 * cells)
    body = free_block(law, size, divisions, order, density=DENSITY, viscosity=ETA)
    return body.hold("x_min").hold("y_min", 0, 2).hold("y_max", 0, 2)


def exact_shear(half: int, across: int) -> float:
    """rad/s."""
    return sqrt(MU_FIBRE / DENSITY) * sqrt(
        ((2 * half - 1) * pi / (2 * DEEP)) ** 2 + (across * pi / THICK) ** 2
    )


def shear_mode(order: int, cells: int, half: int, across: int) -> tuple[float, float]:
    """Angular frequency and damping ratio of the mode of this shape."""
    body = shear_block(order, cells)
    x = np.asarray(body.mesh.points)
    shape = np.zeros(x.shape)
    shape[:, 1] = np.sin((2 * half - 1) * pi / (2 * DEEP) * x[:, 0]) * np.cos(across * pi / THICK * x[:, 2])
    M, C = (body.on_free(m) for m in (body.assembly.mass(), body.assembly.viscosity()))
    omegas, modes = lowest(body, 12, exact_shear(half, across))
    best = int(np.argmax(np.abs(modes.T @ (M @ shape.ravel()[body.free]))))
    mode = modes[:, best]
    return float(omegas[best]), float(mode @ (C @ mode)) / (2 * float(omegas[best]))


def per_cell(cells: int, half: int, across: int) -> float:
    """Wave number times the largest edge of a cell across the fibre."""
    return exact_shear(half, across) / sqrt(MU_FIBRE / DENSITY) * DEEP / (2 * cells)


def shear_frequencies() -> Iterator[Check]:
    """On quadratic elements, 4 x 2 x 4 cells."""
    for half, across in SHEAR_MODES:
        yield Check(
            name=f"f{half}{across}",
            quantity=f"shear mode l = {half}, m = {across}",
            unit="Hz",
            value=shear_mode(2, 2, half, across)[0] / (2 * pi),
            reference=exact_shear(half, across) / (2 * pi),
            tolerance=per_cell(2, half, across) ** 4 / 1440,
            because="(k h)^4 / 1440, what quadratic elements of a cell's length leave in one dimension",
        )


def shear_order(order: int) -> Iterator[Check]:
    """log2 of the ratio of the frequency errors on two meshes."""
    cells = (4, 8) if order == 1 else (2, 4)
    exact = exact_shear(1, 0)
    coarse, fine = (shear_mode(order, n, 1, 0)[0] / exact - 1 for n in cells)
    yield Check(
        name="order",
        quantity="observed order of the frequency's error",
        value=float(np.log2(coarse / fine)),
        reference=2.0 * order,
        tolerance=float(np.log2(1 + per_cell(cells[0], 1, 0) ** 2)),
        because="log2(1 + (k h)^2): the error's next term, on the coarser mesh",
        of="unit",
    )


def shear_damping() -> Iterator[Check]:
    """Of the lowest of these modes."""
    _, ratio = shear_mode(2, 2, 1, 0)
    yield Check(
        name="ratio",
        quantity="damping ratio of the shear mode",
        value=ratio,
        reference=ETA * exact_shear(1, 0) / (4 * MU_FIBRE),
        tolerance=2 * per_cell(2, 1, 0) ** 4 / 1440,
        because="twice that of the frequency: a quotient of squares of the mode",
    )


BLOCKS: dict[str, tuple[Any, tuple[float, float, float, float]]] = {
    "isotropic": (engine.Isotropic(29e3, 0.45), (95.04, 166.9, 168.7, 177.1)),
    "fibre": (engine.TransverselyIsotropic(20e3, 0.45, 40e3, 0.3, 10e3), (91.15, 140.3, 150.7, 168.4)),
    "stiff-fibre": (
        engine.TransverselyIsotropic(10e3, 0.45, 200e3, 0.45, 20e3),
        (126.96, 147.9, 154.4, 202.4),
    ),
}


def clamped(name: str) -> Iterator[Check]:
    """R8: fixed on x = 0 and at both ends of the fibre."""
    law, published = BLOCKS[name]
    body = free_block(law, (DEEP, LONG, THICK), (6, 10, 4), 2, density=DENSITY)
    omegas, _ = lowest(body.hold("x_min").hold("y_min").hold("y_max"), 4)
    value, reference = worst(omegas / (2 * pi), published)
    yield Check(
        name="frequencies",
        quantity="of the four lowest natural frequencies the one that is furthest off",
        unit="Hz",
        value=value,
        reference=reference,
        tolerance=0.01,
        because="the reference, of elements of order 4, lies above the true value by up to 1 %: "
        "clamped edges "
        "are singular",
    )


CASES = (
    Case(
        "cantilever",
        "A slender beam bends at the frequencies of Timoshenko's beam, which are Euler and "
        "Bernoulli's but for shear "
        "and rotary inertia.",
        "R6; Timoshenko's equations with shear coefficient 5/6, integrated by a matrix exponential",
        cantilever,
    ),
    Case(
        "shear-mode",
        "Transversely isotropic tissue vibrates in shear along its fibre at exactly known frequencies.",
        "R7: sqrt(mu'/rho) sqrt(((2l-1) pi / 2D)^2 + (m pi / T)^2) / 2 pi",
        shear_frequencies,
    ),
    Case(
        "shear-order-linear",
        "The frequency error of linear tetrahedra falls with the square of the edge.",
        "R7",
        partial(shear_order, 1),
    ),
    Case(
        "shear-order-quadratic",
        "The frequency error of quadratic tetrahedra falls with the fourth power of the edge.",
        "R7",
        partial(shear_order, 2),
    ),
    Case(
        "shear-damping",
        "Viscosity damps the shear mode as the tensor of strain rates says, half of what engineering "
        "rates would.",
        "R7, R11: eta omega / (4 mu')",
        shear_damping,
    ),
    *(
        Case(
            f"block-{name}",
            "A block of tissue clamped on three sides has the natural frequencies of an independent "
            "code of order 4.",
            "R8, computed with an independent code",
            partial(clamped, name),
        )
        for name in BLOCKS
    ),
)
