"""The engine's tubes of a scene, and their resonances."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plica import _engine
from plica.errors import InvalidInput
from plica.measures.formants import Formant, TractResponse
from plica.runs.options import engine_options
from plica.scene.parts import Airflow
from plica.scene.scene import Scene
from plica.scene.tubes import Trachea, Tract

__all__ = ["known_tract", "tract_formants", "tract_response", "tubes_of"]

_ELEMENT = _engine.SeenTube.longest_element  # m
_MOST = 500  # elements whose resonances are found, in some 2 s, with the third power of their number


def tubes_of(scene: Scene) -> dict[str, _engine.Tube]:
    """Those that the scene has: "trachea", "tract"."""
    tubes = {}
    if scene.trachea is not None:
        tubes["trachea"] = _tube(scene.trachea, engine_options(scene.trachea.supply.choice))
    if scene.tract is not None:
        tubes["tract"] = _tube(scene.tract, _end(scene.tract))
    return tubes


def _tube(tube: Tract | Trachea, end: Any) -> _engine.Tube:
    length, area = tube.profile
    yielding = tube.wall.yielding
    return _engine.Tube(
        length=length,
        area=area,
        end=end,
        wall=None if yielding is None else engine_options(yielding),
        friction_frequency=tube.friction_frequency,
    )


def _end(tract: Tract) -> Any:
    if tract.end.reflecting is not None:
        return _engine.PressureSupply(reflection=tract.end.reflecting.reflection)
    return _engine.Radiation() if tract.end.open is not None else _engine.FlowSupply()


def tract_response(tract: Tract, airflow: Airflow) -> TractResponse:
    """What the vocal tract does to the flow that enters it."""
    tubes = {"trachea": None, "tract": _tube(tract, _end(tract))}
    system = _engine.tract(engine_options(airflow, **tubes))
    storage, rates, outflow = (np.asarray(x) for x in (system.storage, system.rates, system.outflow))
    wall = tract.wall.yielding
    own = 0.0 if wall is None else np.sqrt(wall.stiffness / wall.mass) / (2 * np.pi)
    return TractResponse(storage, rates, outflow, own)


def _elements(tract: Tract) -> int:
    return sum(math.ceil(length / _ELEMENT * (1 - 1e-12)) for length in tract.profile[0])


def known_tract(scene: Scene) -> TractResponse | str | None:
    """What a scene's vocal tract does to the flow that enters it; why it is not known; None without one."""
    if scene.tract is None or scene.airflow is None:
        return None
    if (count := _elements(scene.tract)) > _MOST:
        return (
            f"the tract has {count} elements; resonances are found of at most {_MOST}, "
            f"{_MOST * _ELEMENT:g} m in parts of {_ELEMENT * 1e3:g} mm"
        )
    return tract_response(scene.tract, scene.airflow)


def tract_formants(tract: Tract, airflow: Airflow, highest: float = 5000.0) -> tuple[Formant, ...]:
    """The formants of a vocal tract over a closed glottis, up to this frequency (Hz).

    Raises
    ------
    InvalidInput
        For a tract of more than 500 elements.
    """
    if (count := _elements(tract)) > _MOST:
        raise InvalidInput(
            f"tract: has {count} elements of at most {_ELEMENT * 1e3:g} mm; must have at most {_MOST} for "
            "its formants. Shorten it, or give it fewer parts."
        )
    return tract_response(tract, airflow).formants(highest)
