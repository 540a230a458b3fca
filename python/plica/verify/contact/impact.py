"""Bars that strike a wall or each other (R1, R3)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import sqrt

import numpy as np

from plica.verify.bodies.bars import PROBLEMS
from plica.verify.bodies.combinations import Combination
from plica.verify.bodies.impact import measure
from plica.verify.case import Case, Check, zero

__all__ = ["CASES", "ELEMENTS", "FIRST", "FRONT", "RECOMMENDED", "SOLVES", "front"]

RECOMMENDED = Combination("multipliers", "trapezoidal", "redistributed")
ELEMENTS, SOLVES = 100, 1e-10
FRONT = "a jump that has run through n elements is smeared over some n^(1/3) of them by dispersion"
FIRST = "first order in the edge: 1 / 100 of the bar"


def front(steps: float) -> float:
    """The width of a front after so many elements, over the way."""
    return float(steps ** (1 / 3) / steps)


def bars(name: str, pressure: float, duration: float) -> Iterator[Check]:
    """Two equal bars: pressure (Pa) and duration (s), of two ways through a bar."""
    steps = 2 * ELEMENTS
    problem = PROBLEMS[name](ELEMENTS)
    exact, found = problem.exact, measure(problem, RECOMMENDED, SOLVES)
    lasted = exact.end - exact.begin
    mean = float(exact.pressure(np.array([0.5 * (exact.begin + exact.end)]))[0])
    yield Check(
        name="pressure",
        quantity="median contact pressure",
        unit="Pa",
        value=found["plateau"] * mean,
        reference=pressure,
        tolerance=1 / ELEMENTS,
        because=FIRST,
    )
    yield Check(
        name="duration",
        quantity="duration of the contact",
        unit="s",
        value=found["duration"] * lasted,
        reference=duration,
        tolerance=front(steps),
        because=FRONT,
    )
    yield Check(
        name="impulse",
        quantity="impulse per area",
        unit="N s/m^2",
        value=found["impulse"] * mean * lasted,
        reference=pressure * duration,
        tolerance=1 / ELEMENTS,
        because=FIRST,
    )
    yield Check(
        name="rebound",
        quantity="velocity after the impact over that before",
        value=found["rebound"],
        reference=1.0,
        tolerance=front(steps),
        because=f"{FRONT}, and goes on as vibration",
    )
    if name == "R3":
        yield from sound(found)


def sound(found: dict[str, float]) -> Iterator[Check]:
    """What must hold in any impact."""
    yield zero(
        name="balance",
        quantity="largest sum of the forces on both sides, over the largest force",
        value=found["force sum"],
        tolerance=1e-14,
        because="round-off",
    )
    yield zero(
        name="sign",
        quantity="largest pull of a multiplier (zero or below: none pulls)",
        unit="N",
        value=max(found["largest multiplier"], 0.0),
        tolerance=0.0,
        because="complementarity: lambda <= 0",
    )
    yield zero(
        name="penetration",
        quantity="deepest overlap, in edges",
        value=found["penetration"],
        tolerance=2e-5,
        because="the gap's tolerance, 1e-5 edges, of the two sides",
    )


def periodic() -> Iterator[Check]:
    """R1 over one period of 3 s; energies are per area."""
    problem = PROBLEMS["R1"](ELEMENTS)
    found = measure(problem, RECOMMENDED, SOLVES)
    yield Check(
        name="force",
        quantity="median contact force per area",
        unit="Pa",
        value=found["plateau"] * 0.5,
        reference=0.5,
        tolerance=1 / ELEMENTS,
        because=FIRST,
    )
    yield Check(
        name="duration",
        quantity="duration of the contact",
        unit="s",
        value=found["duration"] * 1.0,
        reference=1.0,
        tolerance=front(ELEMENTS),
        because=FRONT,
    )
    yield Check(
        name="energy",
        quantity="energy after a period per area",
        unit="J/m^2",
        value=found["energy end"] / 8,
        reference=1 / 8,
        tolerance=2 / ELEMENTS,
        because="the strained end springs free in the first step: its element's share, 1 / 100, and "
        "dispersion",
    )
    yield zero(
        name="motion",
        quantity="error of the displacement (root mean square), over its size",
        value=found["displacement"],
        tolerance=2 / ELEMENTS,
        because="first order in the edge, 1 / 100, of the field and of its size at the contact",
    )
    yield from sound(found)


CASES = (
    Case(
        "periodic-bar",
        "A strained bar that is let go beside a wall presses on it for the middle third of each period.",
        "R1, Dabaghi et al., arXiv 1601.00778: force 1/2 for 1 < t < 2, energy 1/8",
        periodic,
    ),
    Case(
        "equal-bars",
        "Two equal soft bars that meet at 1 m/s exchange their velocities.",
        "R3: rho c v / 2 for 2 L / c: 2280.35 Pa, 4.5607 ms",
        partial(bars, "R3", sqrt(20e3 * 1040) / 2, 0.02 / sqrt(20e3 / 1040)),
    ),
    Case(
        "stiff-bars",
        "Two stiff bars that meet at 35 m/s each exchange their velocities.",
        "rho c v = 49.4975 MPa for 2 L / c = 3.81838 ms",
        partial(bars, "bars", 49.4975e6, 3.81838e-3),
    ),
    Case(
        "stiff-bars-0.3",
        "Stiff bars between rollers, with Poisson's ratio 0.3, collide with the wave speed of the "
        "constrained modulus.",
        "rho c v = 57.4289 MPa for 2 L / c = 3.29103 ms, c of E (1 - nu) / ((1 + nu) (1 - 2 nu))",
        partial(bars, "bars-0.3", 57.4289e6, 3.29103e-3),
    ),
)
