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

from typing import TYPE_CHECKING, Any

from plica._engine import build_info, set_threads
from plica.camera.pose import Camera
from plica.errors import CautionWarning, InvalidInput, SceneError, SolveFailed, StepFailed, StorageFailed
from plica.films import Film, film, write_film
from plica.runs.build import build_simulation, equilibrium, flow_equilibrium
from plica.runs.flow_equilibrium import FlowEquilibrium
from plica.runs.reduce import reduce
from plica.runs.results import Run
from plica.runs.run import run
from plica.runs.scene_mesh import scene_mesh
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.folds import Folds
from plica.scene.mesh.parts import Block, Blocks, Larynx, LarynxOptions, MeshFile, Sides
from plica.scene.parts import (
    Airflow,
    Augmented,
    Automatic,
    Bernoulli,
    CentralDifferences,
    Cholesky,
    ConjugateGradients,
    Contact,
    Coupling,
    Course,
    Cut,
    Elliptic,
    Extrapolated,
    FiniteStrain,
    FlowModel,
    HilberHughesTaylor,
    Initial,
    Iterated,
    Lagged,
    LinearMethod,
    Load,
    Multipliers,
    Newmark,
    Nitsche,
    Output,
    Penalty,
    Reduction,
    Scheme,
    SectionArea,
    Solver,
    Stepping,
    Strain,
    Supports,
    ViscousSlit,
    VolumePenalty,
)
from plica.scene.posture import Muscles, Posture
from plica.scene.scene import Scene
from plica.scene.tissue import Tissue, TissueSide
from plica.scene.tissue_presets import TISSUE_PRESETS
from plica.scene.tubes import Trachea, Tract
from plica.stability.modes import Eigenmodes, eigenmodes
from plica.stability.offset import Offset, offset
from plica.stability.onset import Onset, growth, onset
from plica.uncertainty import estimate_uncertainty

if TYPE_CHECKING:
    from plica.video.motion.flow import flow

__version__: str = build_info()["version"]

__all__ = [
    "TISSUE_PRESETS",
    "Airflow",
    "Augmented",
    "Automatic",
    "Bernoulli",
    "Block",
    "Blocks",
    "Camera",
    "CautionWarning",
    "CentralDifferences",
    "Cholesky",
    "ConjugateGradients",
    "Contact",
    "Coupling",
    "Course",
    "Cut",
    "Eigenmodes",
    "Elliptic",
    "Extrapolated",
    "Film",
    "FiniteStrain",
    "FlowEquilibrium",
    "FlowModel",
    "Folds",
    "HilberHughesTaylor",
    "Initial",
    "InvalidInput",
    "Iterated",
    "Lagged",
    "Larynx",
    "LarynxOptions",
    "LinearMethod",
    "Load",
    "MeshFile",
    "Multipliers",
    "Muscles",
    "Newmark",
    "Nitsche",
    "Offset",
    "Onset",
    "Output",
    "Penalty",
    "Posture",
    "Reduction",
    "Run",
    "Scene",
    "SceneError",
    "Scheme",
    "SectionArea",
    "Sides",
    "SolveFailed",
    "Solver",
    "StepFailed",
    "Stepping",
    "StorageFailed",
    "Strain",
    "Supports",
    "Tissue",
    "TissueSide",
    "Trachea",
    "Tract",
    "ViscousSlit",
    "VolumePenalty",
    "__version__",
    "build_info",
    "build_mesh",
    "build_simulation",
    "eigenmodes",
    "equilibrium",
    "estimate_uncertainty",
    "film",
    "flow",
    "flow_equilibrium",
    "growth",
    "offset",
    "onset",
    "reduce",
    "run",
    "scene_mesh",
    "set_threads",
    "write_film",
]


def __getattr__(name: str) -> Any:
    if name == "flow":  # simulations do not need the video package
        from plica.video.motion.flow import flow

        return flow
    raise AttributeError(f"module 'plica' has no attribute {name!r}")
