"""Plica simulates vibrating vocal folds in three dimensions and measures them in high-speed video.

A scene is composed of parts and run::

    import plica

    scene = plica.Scene.load("examples/normal_phonation.toml")
    run = plica.run(scene, "runs/normal")
    print(run.measures["fundamental_frequency"])

`plica.flow` finds the motion between two frames, `plica.video` analyses recordings, `plica.film` films runs.

All quantities are SI; a field of a part also takes a text with a unit, ``"0.8 kPa"``.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from plica import _engine

__version__: str = _engine.build_info()["version"]

_PARTS = {
    "plica._engine": ("build_info", "set_threads"),
    "plica.camera.pose": ("Camera",),
    "plica.errors": (
        "CautionWarning",
        "InvalidInput",
        "SceneError",
        "SolveFailed",
        "StepFailed",
        "StorageFailed",
    ),
    "plica.films": (
        "Film",
        "film",
        "write_film",
    ),
    "plica.runs.build": (
        "build_simulation",
        "equilibrium",
        "flow_equilibrium",
    ),
    "plica.runs.flow_equilibrium": ("FlowEquilibrium",),
    "plica.runs.reduce": ("reduce",),
    "plica.runs.results": ("Run",),
    "plica.runs.run": ("run",),
    "plica.runs.scene_mesh": ("scene_mesh",),
    "plica.scene.mesh.build": ("build_mesh",),
    "plica.scene.mesh.folds": ("Folds",),
    "plica.scene.mesh.lesion": (
        "Chink",
        "Lesion",
    ),
    "plica.scene.mesh.parts": (
        "Block",
        "Blocks",
        "Larynx",
        "LarynxOptions",
        "MeshFile",
        "Sides",
    ),
    "plica.scene.parts": (
        "Airflow",
        "Augmented",
        "Automatic",
        "Bernoulli",
        "CentralDifferences",
        "Cholesky",
        "ConjugateGradients",
        "Contact",
        "Coupling",
        "Course",
        "Cut",
        "Elliptic",
        "Extrapolated",
        "FiniteStrain",
        "FlowModel",
        "HilberHughesTaylor",
        "Initial",
        "Iterated",
        "Lagged",
        "LinearMethod",
        "Load",
        "Multipliers",
        "Newmark",
        "Nitsche",
        "Output",
        "Penalty",
        "Reduction",
        "Scheme",
        "SectionArea",
        "Solver",
        "Stepping",
        "Strain",
        "Supports",
        "ViscousSlit",
        "VolumePenalty",
    ),
    "plica.scene.posture": (
        "Muscles",
        "Posture",
    ),
    "plica.scene.scene": ("Scene",),
    "plica.scene.tissue": (
        "Tissue",
        "TissueSide",
    ),
    "plica.scene.tissue_presets": ("TISSUE_PRESETS",),
    "plica.scene.tubes": (
        "Trachea",
        "Tract",
    ),
    "plica.stability.modes": (
        "Eigenmodes",
        "eigenmodes",
    ),
    "plica.stability.offset": (
        "Offset",
        "offset",
    ),
    "plica.stability.onset": (
        "Onset",
        "growth",
        "onset",
    ),
    "plica.uncertainty": ("estimate_uncertainty",),
    "plica.video.motion.flow": ("flow",),
    "plica.viewer": ("write_view",),
}
"""Public names, by where they are; loaded when they are first asked for. `__init__.pyi` has their types."""

_MODULE_OF = {name: module for module, names in _PARTS.items() for name in names}
_PACKAGES = ("identify", "sweep", "video")

__all__ = sorted((*_MODULE_OF, *_PACKAGES, "__version__"))


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return import_module(f"plica.{name}")
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'plica' has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(_MODULE_OF[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
