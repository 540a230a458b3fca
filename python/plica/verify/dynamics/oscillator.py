"""One free unknown: spectral radii, free vibration, orders of the time schemes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import atan, cos, exp, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.verify.bodies.body import SCHEMES, Body, free_block
from plica.verify.case import Case, Check

__all__ = ["CASES"]

Array = NDArray[np.float64]

E, NU, ETA, SIDE = 20e3, 0.3, 0.5, 0.01  # Pa, -, Pa s, m
SWING, STIFF = 1e-4, 1e4  # m; Omega that stands for infinity
PERIODS, PER_PERIOD = 1.125, 320  # where neither u nor v stands still; steps of the coarser run


def oscillator(viscosity: float = 0.0) -> tuple[Body, float, float]:
    """A cube held but for one component of one corner; its angular frequency (1/s) and damping ratio."""
    cube = free_block(engine.Isotropic(E, NU), (SIDE,) * 3, (1, 1, 1), 1, viscosity=viscosity)
    fixed = np.ones_like(cube.fixed)
    fixed[0, 0] = False
    body = Body(cube.mesh, cube.material, fixed)
    parts = (body.assembly.mass(), body.assembly.viscosity(), body.assembly.stiffness())
    m, c, k = (float(body.on_free(part).toarray()[0, 0]) for part in parts)
    return body, sqrt(k / m), c / (2 * sqrt(k * m))


def states(body: Body, scheme: Any, step: float, start: tuple[float, float], steps: int) -> Array:
    """(steps, 3): u, h v and h^2 a of the unknown, from u and h v."""
    fields = np.zeros((2, *body.fixed.shape))
    fields[:, 0, 0] = start[0], start[1] / step
    simulation = body.simulation(
        scheme=scheme, step=step, solver_tolerance=1e-14, displacement=fields[0], velocity=fields[1]
    )
    found = []
    for _ in range(steps):
        simulation.advance(1)
        parts = (simulation.displacement, simulation.velocity, simulation.acceleration)
        found.append([float(part[0, 0]) * step**k for k, part in enumerate(parts)])
    return np.array(found)


def amplification(alpha: float, omega: float) -> float:
    """Spectral radius of a step of HHT on (u, h v, h^2 a): the balance of forces at n + 1 + alpha."""
    beta, gamma, w = (1 - alpha) ** 2 / 4, 0.5 - alpha, 1 + alpha
    lead = 1 + w * beta * omega**2
    A = np.zeros((3, 3))
    A[2] = -(omega**2) / lead * np.array([1.0, w, w * (0.5 - beta)])
    A[0] = np.array([1, 1, 0.5 - beta]) + beta * A[2]
    A[1] = np.array([0, 1, 1 - gamma]) + gamma * A[2]
    return float(np.abs(np.linalg.eigvals(A)).max())


def measured_radius(alpha: float, omega: float) -> float:
    """That of the map between the engine's states from the second step on, of three motions."""
    body, frequency, _ = oscillator()
    before, after = [], []
    for start in ((SWING, 0.0), (0.0, SWING), (SWING, SWING)):
        z = states(body, engine.HilberHughesTaylor(alpha=alpha), omega / frequency, start, 5)
        size = np.abs(z[1:-1]).max(axis=1, keepdims=True)
        before.append(z[1:-1] / size)
        after.append(z[2:] / size)
    old, new = np.concatenate(before), np.concatenate(after)
    unit = np.abs(old).max(axis=0)
    step = np.linalg.lstsq(old / unit, new / unit, rcond=None)[0].T
    return float(np.abs(np.linalg.eigvals(step)).max())


def spectral_radii() -> Iterator[Check]:
    for alpha in (-0.3, -0.1):
        yield Check(
            name=f"hht{alpha:g}-1",
            quantity=f"spectral radius of HHT({alpha:g}) at Omega = 1",
            value=measured_radius(alpha, 1.0),
            reference=amplification(alpha, 1.0),
            tolerance=1e-7,
            because="round-off of 1e-14 a step over the least singular value of the motions, 2e-5",
        )
    for name, alpha in (("hht-0.3", -0.3), ("hht-0.1", -0.1), ("hht-third", -1 / 3)):
        triple = name == "hht-third"
        yield Check(
            name=f"{name}-inf",
            quantity=f"spectral radius of HHT({alpha:.3g}) at Omega = 1e4",
            value=measured_radius(alpha, STIFF),
            reference=(1 + alpha) / (1 - alpha),
            tolerance=STIFF ** (-2 / 3) if triple else 1 / STIFF,
            because="the limit is a "
            f"{'triple' if triple else 'double'} root: O(Omega^-{'2/3' if triple else '1'})",
            of="unit",
        )


def free_vibration() -> Iterator[Check]:
    """The trapezoidal rule turns a mode by 2 atan(omega h / 2) a step, and keeps its energy."""
    omega, steps = 0.3, 1000
    body, frequency, _ = oscillator()
    fields = np.zeros(body.fixed.shape)
    fields[0, 0] = SWING
    simulation = body.simulation(
        scheme=engine.Newmark(), step=omega / frequency, solver_tolerance=1e-14, displacement=fields
    )
    result = simulation.advance(steps)
    turned = steps * 2 * atan(omega / 2)
    yield Check(
        name="displacement",
        quantity="displacement after 1000 steps, over that at the start",
        value=float(simulation.displacement[0, 0]) / SWING,
        reference=cos(turned),
        tolerance=1e-9,
        because="round-off of 1e-14 a step, summed twice over 1000 steps",
        of="unit",
    )
    k = float(body.on_free(body.assembly.stiffness()).toarray()[0, 0])
    yield Check(
        name="energy",
        quantity="energy after 1000 steps",
        unit="J",
        value=float(result["kinetic_energy"][-1] + result["elastic_energy"][-1]),
        reference=0.5 * k * SWING**2,
        tolerance=1e-10,
        because="round-off of 1e-14 a step over 1000 steps",
    )


def errors(scheme: Any, per_period: int, periods: float) -> Array:
    """Of u, v / omega and a / omega^2 after so many periods of the damped motion, over the swing."""
    body, frequency, ratio = oscillator(ETA)
    step = 2 * pi / frequency / per_period
    steps = round(per_period * periods)
    t = steps * step
    decay, swing = ratio * frequency, frequency * sqrt(1 - ratio**2)
    u = exp(-decay * t) * (cos(swing * t) + decay / swing * sin(swing * t))
    v = -exp(-decay * t) * frequency**2 / swing * sin(swing * t)
    exact = np.array([u, v, -2 * decay * v - frequency**2 * u])
    found = states(body, scheme, step, (SWING, 0.0), steps)[-1] / SWING
    return np.asarray(np.abs(found / step ** np.arange(3) - exact) / frequency ** np.arange(3))


ORDERS: dict[str, tuple[str, tuple[tuple[str, float], ...]]] = {
    "trapezoidal": ("trapezoidal", (("displacement", 2.0), ("velocity", 2.0))),
    "hht": ("HHT(-0.3)", (("displacement", 2.0), ("velocity", 2.0), ("acceleration", 1.0))),
    "newmark": ("Newmark(1, 3/2)", (("displacement", 1.0), ("velocity", 1.0))),
}


def order(name: str) -> Iterator[Check]:
    """log2 of the ratio of the errors of two steps."""
    scheme, expected = SCHEMES[ORDERS[name][0]], ORDERS[name][1]
    coarse, fine = (errors(scheme, n, PERIODS) for n in (PER_PERIOD, 2 * PER_PERIOD))
    for k, (part, reference) in enumerate(expected):
        yield Check(
            name=part,
            quantity=f"observed order of the {part}",
            value=float(np.log2(coarse[k] / fine[k])),
            reference=reference,
            tolerance=float(np.log2(1 + (2 * pi) ** 2 * PERIODS / (2 * PER_PERIOD))),
            because="log2(1 + omega h omega t / 2), the error's next term on the coarser step",
            of="unit",
        )


CASES = (
    Case(
        "spectral-radius",
        "A step of HHT damps what vibrates slowly and fast as much as its published spectral radii say.",
        "Hilber, Hughes and Taylor 1977: amplification matrix (0.989384, 0.993847), and (1 + alpha) "
        "/ (1 - alpha)",
        spectral_radii,
    ),
    Case(
        "free-vibration",
        "The trapezoidal rule keeps the energy of free vibration and shortens its frequency as known.",
        "u_n = u_0 cos(2 n atan(omega h / 2))",
        free_vibration,
    ),
    *(
        Case(
            f"order-{name}",
            f"On damped free vibration {scheme} converges at its known order.",
            "exp(-zeta omega t) (cos(omega_d t) + zeta omega / omega_d sin(omega_d t))",
            partial(order, name),
        )
        for name, (scheme, _) in ORDERS.items()
    ),
)
