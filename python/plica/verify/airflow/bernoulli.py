"""Bernoulli's flow (R12) through a larynx at rest."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.verify.airflow.rest import DENSITY, PRESSURE, ROUNDING, at_rest
from plica.verify.bodies.body import Body
from plica.verify.case import Case, Check, worst, zero

__all__ = ["CASES"]

Array = NDArray[np.float64]


def larynx() -> tuple[Body, Array]:
    """The thesis's larynx, and its ellipses: heights and half the minor axes (m)."""
    preset = engine.larynx_preset("thesis_coarse")
    mesh = engine.larynx_mesh(**preset)
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[mesh.node_sets["wall"]] = True
    return Body(mesh, engine.Material(engine.Isotropic(20e3, 0.45), 1040.0), fixed), np.asarray(
        preset["sections"]
    )


def bernoulli() -> Iterator[Check]:
    body, ellipses = larynx()
    options = {"model": engine.Bernoulli(), "area": engine.Elliptic()}
    simulation, found = at_rest(body, **options)
    heights = np.asarray(simulation.section_height)
    area = pi * 7e-3 * np.interp(heights, ellipses[:, 0], ellipses[:, 1])
    least = int(np.argmax(area <= area.min() * (1 + 1e-9)))
    yield Check(
        name="area",
        quantity="least section area at rest",
        unit="m^2",
        value=float(found["minimum_area"][0]),
        reference=pi * 0.25e-3 * 7e-3,
        tolerance=1e-12,
        because=ROUNDING,
    )
    value, reference = worst(found["section_area"][0], area)
    yield Check(
        name="areas",
        quantity="area of the section that is furthest off",
        unit="m^2",
        value=value,
        reference=reference,
        tolerance=1e-12,
        because=ROUNDING,
    )
    yield Check(
        name="flow",
        quantity="flow at rest at 800 Pa",
        unit="m^3/s",
        value=float(found["flow"][0]),
        reference=sqrt(2 * PRESSURE / DENSITY) * pi * 0.25e-3 * 7e-3,
        tolerance=1e-12,
        because=ROUNDING,
    )
    value, reference = worst(
        found["section_pressure"][0, :least], PRESSURE * (1 - (area[least] / area[:least]) ** 2)
    )
    yield Check(
        name="pressure",
        quantity="pressure in the section upstream that is furthest off",
        unit="Pa",
        value=value,
        reference=reference,
        tolerance=1e-12,
        because=ROUNDING,
    )
    yield zero(
        name="downstream",
        quantity="largest pressure from the least section on, over the subglottal one",
        value=float(np.abs(found["section_pressure"][0, least:]).max()) / PRESSURE,
        tolerance=1e-11,
        because="round-off of five areas that are equal",
    )
    _, thin = at_rest(body, air_density=1.14, **options)
    yield Check(
        name="jet",
        quantity="speed of the jet in air of 1.14 kg/m^3",
        unit="m/s",
        value=float(thin["flow"][0] / thin["minimum_area"][0]),
        reference=37.463,
        tolerance=0.5e-3 / 37.463,
        because="half a unit of the reference's last digit",
    )


CASES = (
    Case(
        "bernoulli",
        "Through a larynx at rest flows what Bernoulli's law lets through, and its pressure falls as "
        "the law says.",
        "R12: sqrt(2 p / rho) A_min, p (1 - (A_min / A)^2); 800 Pa, 1.14 kg/m^3: 37.463 m/s",
        bernoulli,
    ),
)
