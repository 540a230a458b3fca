"""What a part of a scene costs where it is there and idle, and what importing a room of plica costs."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import at_most

__all__ = ["CASES", "UNNEEDED", "imported"]

Array = NDArray[np.float64]

_BARE: Mapping[str, Any] = {}
_AIRFLOW: Mapping[str, Any] = {"airflow": {"subglottal_pressure": 1e-9}}
_CONTACT: Mapping[str, Any] = {"contact": {"multipliers": {}}}
_FRICTION: Mapping[str, Any] = {"contact": {"multipliers": {}, "friction": 0.3}}
PARTS: Mapping[str, Mapping[str, Any]] = {
    "bare": _BARE,
    "airflow": _AIRFLOW,
    "contact": _CONTACT,
    "contact with friction": _FRICTION,
    "airflow and contact": {**_AIRFLOW, **_CONTACT},
    "loads": {"loads": [{"surface": "airway", "traction": [0, 0, 1e-12]}]},
}
"""Each too weak, or too far away, to change the motion."""
_LARYNX: Mapping[str, Mapping[str, Any]] = {
    "least": {
        "larynx": "thesis_coarse",
        "options": {"around": 8, "levels": [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], "body_rings": 1},
    },
    "coarse": {"larynx": "coarse"},
}


def _scene(level: Level, part: Mapping[str, Any]) -> Any:
    """Folds that are thrown open a little."""
    import plica

    viscosity = {"yes": 0.4, "no": 0.0}[str(level["viscosity"])]
    tissue = {"nu": 0.45, "viscosity": viscosity}
    layers = {"body": 20e3, "ligament": 3e3, "cover": 1e3}
    order = {"linear": 1, "quadratic": 2}[str(level["elements"])]
    return plica.Scene.model_validate(
        {
            "mesh": {**_LARYNX[str(level["larynx"])], "order": order},
            "tissue": {name: {"E": E, **tissue} for name, E in layers.items()},
            "initial": {"opening_velocity": 0.01},
            "time": {"step": 5e-5, "duration": 5e-5 * int(level["steps"])},
            **part,
        }
    )


def _steps(part: Mapping[str, Any], level: Level) -> Callable[[], Array]:
    """The first call makes the simulation, so that its memory counts; the later ones start it anew."""
    from plica.runs.build import build_simulation

    scene = _scene(level, part)
    made: list[Any] = []

    def run() -> Array:
        if not made:
            simulation = build_simulation(scene)
            made.extend((simulation, simulation.state()))
        simulation, start = made
        simulation.restore(start)
        return np.asarray(simulation.advance(scene.time.steps)["kinetic_energy"], float)

    return run


def _stored(level: Level) -> Callable[[], Array]:
    """A run with its directory, fields every tenth step."""
    import plica

    scene = _scene(level, {"output": {"every": 5e-4}})

    def run() -> Array:
        with tempfile.TemporaryDirectory() as directory:
            made = plica.run(scene, Path(directory) / "run", progress=False)
            return np.array(made.waveforms["kinetic_energy"], float)

    return run


def _levels(larynx: str, steps: int) -> tuple[Level, ...]:
    return tuple(
        {"larynx": larynx, "elements": elements, "viscosity": viscosity, "steps": steps}
        for elements in ("linear", "quadratic")
        for viscosity in ("no", "yes")
    )


def _changed(level: Level, found: Array, truth: Array) -> dict[str, float]:
    return {"energy": float(np.abs(found - truth).max() / truth.max())}


_HEAVY = (
    "scipy",
    "matplotlib",
    "meshio",
    "pint",
    "xarray",
    "pandas",
    "PIL",
    "av",
    "tifffile",
    "jinja2",
    "cv2",
)
_ROOMS = ("plica.video", "plica.identify", "plica.larynx_fit", "plica.report", "plica.verify")
UNNEEDED: Mapping[str, tuple[str, ...]] = {
    "plica": (*_HEAVY, *_ROOMS),
    "plica.commands.main": (*_HEAVY, *(room for room in _ROOMS if room != "plica.report")),
    "plica.video": ("matplotlib", "meshio", "pandas", "xarray", "cv2", "plica.identify", "plica.verify"),
    "plica.identify": ("matplotlib", "meshio", "pandas", "xarray", "cv2", "plica.verify"),
    "plica.sweep": ("matplotlib", "meshio", "pandas", "xarray", "SALib", "plica.video", "plica.verify"),
}
"""By module, what importing it must not bring."""


def imported(module: str) -> list[str]:
    """All modules that are there after a fresh interpreter has imported this one."""
    code = f"import sys, {module}; print(*sys.modules)"
    made = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return made.stdout.split()


def _unneeded(module: str, level: Level, found: list[str], truth: None) -> dict[str, float]:
    return {"unneeded": float(len([name for name in found if name in UNNEEDED[module]]))}


def _import_case(module: str) -> Case:
    name = "import" if module == "plica" else f"import-{module.rpartition('.')[2]}"
    return Case(
        name=name,
        does=f"A fresh Python imports {module}; beside it one that imports NumPy alone.",
        reference="the modules that it must not bring",
        errors={"unneeded": "such modules"},
        levels={"small": ({"module": module},), "full": ({"module": module},)},
        methods=(
            Method(module, lambda level: partial(imported, module)),
            Method("NumPy alone", lambda level: partial(imported, "numpy"), "numpy"),
        ),
        truth=lambda level: None,
        judge=partial(_unneeded, module),
        claims=(Claim(f"importing {module} brings nothing unneeded", at_most(module, 0.0, "unneeded")),),
        threads=(1,),
        own_process=False,
    )


CASES = (
    Case(
        name="parts",
        does="Steps of a larynx whose tissue swings freely, bare or with one part more that is idle.",
        reference="the bare motion",
        errors={"energy": "kinetic, largest difference over the largest"},
        levels={"small": _levels("least", 20)[-1:], "full": _levels("coarse", 100)},
        methods=(
            *(Method(name, partial(_steps, part)) for name, part in PARTS.items()),
            Method("stored, fields every tenth step", _stored),
        ),
        truth=lambda level: _steps(_BARE, level)(),
        judge=_changed,
        problem=("elements", "viscosity"),
        claims=tuple(
            Claim(f"{name}, idle, changes nothing", at_most(name, 1e-6, "energy"))
            for name in (*PARTS, "stored, fields every tenth step")
            if name != "bare"
        ),
        threads=(1,),
    ),
    _import_case("plica"),
    _import_case("plica.video"),
)
