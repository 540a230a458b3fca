"""Airflow over a body at rest."""

from __future__ import annotations

from typing import Any

from plica import _engine as engine
from plica.verify.bodies.body import Body

__all__ = ["DENSITY", "PRESSURE", "ROUNDING", "at_rest"]

PRESSURE, DENSITY = 800.0, 1.23  # Pa, kg/m^3
ROUNDING = "round-off"


def at_rest(body: Body, **options: Any) -> tuple[engine.Simulation, dict[str, Any]]:
    """A step so short that nothing moves, and its waveforms."""
    air = engine.Airflow(**{"subglottal_pressure": PRESSURE, "air_density": DENSITY, **options})
    simulation = body.simulation(scheme=engine.Newmark(), step=1e-12, airflow=air)
    return simulation, simulation.advance(1)
