"""Engineering moduli of transversely isotropic tissue under traction, and Kelvin-Voigt creep (R11)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import exp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.verify.bodies.body import Body, free_block
from plica.verify.case import Case, Check

__all__ = ["CASES"]

E, NU, E_FIBRE, NU_FIBRE, MU_FIBRE = 3e3, 0.58, 20e3, 0.45, 40e3  # Pa; the fibre runs along y
SIZE = (0.010, 0.016, 0.007)  # m
TRACTION = 10.0  # Pa
ETA = 1e4  # Pa s
AXES = "xyz"


def strain_under(body: Body, loads: list[Any]) -> NDArray[np.float64]:
    """The mean strain (3, 3) of a block at rest under tractions, from the corners of its hull."""
    u = engine.equilibrium(
        body.mesh,
        [body.material],
        ["tissue"],
        np.zeros(len(body.mesh.cells), np.int32),
        body.fixed,
        loads=loads,
    )
    x = np.asarray(body.mesh.points)
    centred = x - x.mean(axis=0)
    gradient = np.linalg.lstsq(centred, u - u.mean(axis=0), rcond=None)[0].T
    return np.asarray(0.5 * (gradient + gradient.T))


def moduli() -> Iterator[Check]:
    """A block is stretched along and across its fibre, and sheared along and across it."""
    law = engine.TransverselyIsotropic(E, NU, E_FIBRE, NU_FIBRE, MU_FIBRE)
    free = free_block(law, SIZE, (2, 3, 2), 1)
    rollers = free.hold("x_min", 0).hold("y_min", 1).hold("z_min", 2)
    along = strain_under(rollers, [engine.Load(surface="y_max", traction=(0, TRACTION, 0))])
    across = strain_under(rollers, [engine.Load(surface="x_max", traction=(TRACTION, 0, 0))])
    found = {
        "E-fibre": ("modulus along the fibre", "Pa", TRACTION / along[1, 1], E_FIBRE),
        "nu-fibre": (
            "contraction across over stretch along the fibre",
            "1",
            -along[0, 0] / along[1, 1],
            NU_FIBRE,
        ),
        "E": ("modulus across the fibre", "Pa", TRACTION / across[0, 0], E),
        "nu": ("contraction across the fibre over stretch across it", "1", -across[2, 2] / across[0, 0], NU),
        "mu-fibre": ("shear modulus along the fibre", "Pa", shear(free, 0, 1), MU_FIBRE),
        "mu": ("shear modulus across the fibre, E / 2 (1 + nu)", "Pa", shear(free, 0, 2), E / (2 * (1 + NU))),
    }
    for name, (quantity, unit, value, reference) in found.items():
        yield Check(
            name=name,
            quantity=quantity,
            unit=unit,
            value=float(value),
            reference=reference,
            tolerance=1e-10,
            because="round-off of a solve with a condition number below 1e5",
        )


def shear(body: Body, i: int, j: int) -> float:
    """Shear stress over engineering shear strain, by tractions on four faces and six held components."""
    x = np.asarray(body.mesh.points)
    k = 3 - i - j
    fixed = np.zeros(x.shape, bool)
    corner = [np.flatnonzero(np.abs(x - at).max(axis=1) < 1e-9)[0] for at in supports(i, k)]
    fixed[corner[0]] = True
    fixed[corner[1], [j, k]] = True
    fixed[corner[2], j] = True
    loads = []
    for normal, along in ((i, j), (j, i)):
        for end, sign in (("max", 1), ("min", -1)):
            traction = tuple(sign * TRACTION * np.eye(3)[along])
            loads.append(engine.Load(surface=f"{AXES[normal]}_{end}", traction=traction))
    return TRACTION / (2 * float(strain_under(Body(body.mesh, body.material, fixed), loads)[i, j]))


def supports(i: int, k: int) -> list[NDArray[np.float64]]:
    """The origin, and the corners of the block along the axes i and k."""
    return [np.zeros(3), np.array(SIZE) * np.eye(3)[i], np.array(SIZE) * np.eye(3)[k]]


def creep(nu: float) -> Iterator[Check]:
    """A block under a constant traction; its density is so small that inertia plays no part."""
    modulus, step, steps = 20e3, 0.005, 100
    body = free_block(engine.Isotropic(modulus, nu), (0.01,) * 3, (1, 1, 1), 1, density=1.0, viscosity=ETA)
    body = body.hold("x_min", 0).hold("y_min", 1).hold("z_min", 2)
    simulation = body.simulation(
        scheme=engine.Newmark(),
        step=step,
        solver_tolerance=1e-12,
        loads=[engine.Load(surface="x_max", traction=(TRACTION, 0, 0))],
    )
    simulation.advance(steps)
    tau = ETA / modulus
    shape, volume = tau * (1 + nu), tau * (1 - 2 * nu)
    t = steps * step
    expected = (1 - 2 * nu) / 3 * (1 - exp(-t / volume)) + 2 * (1 + nu) / 3 * (1 - exp(-t / shape))
    strain = float(simulation.displacement[body.mesh.node_sets["x_max"], 0].mean()) / 0.01
    yield Check(
        name="strain",
        quantity="strain at t = eta / E over that at rest",
        value=strain * modulus / TRACTION,
        reference=expected,
        tolerance=1e-4,
        because="the trapezoidal rule, (h / tau)^2 / 12 = 8e-6 of the deviatoric part and ten times of what "
        "the load's first step has left",
    )


CASES = (
    Case(
        "moduli",
        "Tissue with fibres has the moduli and Poisson's ratios that it was given, along and across "
        "the fibre.",
        "definition of the engineering constants of transverse isotropy",
        moduli,
    ),
    Case(
        "creep-0",
        "Tissue with Poisson's ratio 0 creeps as a Kelvin-Voigt solid.",
        "R11: 1 - exp(-t E / eta)",
        partial(creep, 0.0),
    ),
    Case(
        "creep-0.45",
        "With Poisson's ratio 0.45 shape and volume creep each at its own rate (0.515 at t = eta / "
        "E, not 0.632).",
        "R11: deviatoric eta (1 + nu) / E, volumetric eta (1 - 2 nu) / E",
        partial(creep, 0.45),
    ),
)
