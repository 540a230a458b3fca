"""A very coarse larynx, which several subjects look at."""

from __future__ import annotations

from typing import Any

import plica
from plica.runs.build import build_simulation
from plica.runs.scene_mesh import scene_mesh

__all__ = ["AIR", "PRESSURE", "larynx_scene", "larynx_simulation"]

PRESSURE, AIR = 800.0, 1.23  # Pa, kg/m^3


def larynx_scene(**parts: Any) -> plica.Scene:
    """Folds of some 4000 unknowns with the tissue "thesis_corrected"; airflow and contact as given."""
    options = plica.LarynxOptions(around=8, levels=[1, 1, 1, 1, 1, 2, 1, 1, 1, 1], body_rings=1)
    given: dict[str, Any] = {"time": plica.Stepping(step=5e-5, duration=2e-3)}
    return plica.Scene(
        plica.Larynx(larynx="thesis_coarse", options=options), "thesis_corrected", **given | parts
    )


def larynx_simulation(scene: plica.Scene) -> tuple[Any, Any]:
    """Its mesh and the simulation of it."""
    mesh = scene_mesh(scene)
    return mesh, build_simulation(scene, mesh)
