"""The engine's tubes of a scene, and their resonances."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plica import _engine
from plica.errors import InvalidInput
from plica.measures.formants import Formant, TractResponse
from plica.measures.record import Floats
from plica.runs.options import engine_options
from plica.scene.parts import Airflow
from plica.scene.scene import Scene
from plica.scene.tubes import Trachea, Tract

__all__ = ["known_tract", "tract_formants", "tract_response", "tubes_of"]

_ELEMENT = 4e-3  # m, the longest element of a tube in the engine
_MOST = 500  # elements whose resonances are found: 2 m, in some 2 s, with the third power of their number


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
    storage, rates = np.asarray(system.storage), np.asarray(system.rates)
    wall = tract.wall.yielding
    own = 0.0 if wall is None else np.sqrt(wall.stiffness / wall.mass) / (2 * np.pi)
    return TractResponse(storage, rates, _outflow(tract, rates), own)


def _outflow(tract: Tract, rates: Floats) -> Floats:
    """(m) c of the flow at the lips, c x: through the resistance of its end, and beside it the inertance of
    one that is open; where the end is held, in the last element."""
    found = np.zeros(len(rates))
    if tract.end.closed is not None:
        return found
    groups = 2 if tract.wall.yielding is None else 4  # pressures, flows; flows and volumes of walls
    held = tract.end.reflecting is not None and tract.end.reflecting.reflection == 1
    nodes = -(-len(rates) // groups)
    if held:
        found[2 * nodes - 1] = 1.0
        return found
    found[nodes - 1] = -rates[nodes - 1, nodes - 1]
    if tract.end.open is not None:
        found[-1] = 1.0
    return found


def _elements(tract: Tract) -> int:
    return sum(math.ceil(length / _ELEMENT * (1 - 1e-12)) for length in tract.profile[0])


def known_tract(scene: Scene) -> TractResponse | str | None:
    """What a scene's vocal tract does to the flow that enters it; why it is not known; None without one."""
    if scene.tract is None or scene.airflow is None:
        return None
    if (count := _elements(scene.tract)) > _MOST:
        return (
            f"the tract has {count} elements; resonances are found of at most {_MOST}, 2 m in parts of 4 mm"
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
            f"tract: has {count} elements of at most 4 mm; must have at most {_MOST} for its formants. "
            "Shorten it, or give it fewer parts."
        )
    return tract_response(tract, airflow).formants(highest)
