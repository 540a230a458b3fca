"""Plica simulates vibrating vocal folds: tissue, airflow and collision in three dimensions.

A scene is composed of parts and run::

    import plica

    scene = plica.Scene.load("examples/normal_phonation.toml")
    run = plica.run(scene, "runs/normal")
    print(run.measures["fundamental_frequency"])

All quantities are SI; a field of a part also takes a text with a unit, ``"0.8 kPa"``.
"""

from __future__ import annotations

from plica._engine import build_info, set_threads
from plica.errors import InvalidInput, SceneError, SolveFailed, StorageFailed
from plica.phonation.build import build_simulation, equilibrium
from plica.phonation.mesh_parts import Block, Blocks, Larynx, LarynxOptions, MeshFile, Sides
from plica.phonation.mesh_source import build_mesh
from plica.phonation.parts import (
    Airflow,
    Augmented,
    Contact,
    Coupling,
    Extrapolated,
    HilberHughesTaylor,
    Initial,
    Iterated,
    Lagged,
    Load,
    Multipliers,
    Newmark,
    Nitsche,
    Output,
    Penalty,
    Scheme,
    Solver,
    Stepping,
    Supports,
    VolumePenalty,
)
from plica.phonation.results import Run
from plica.phonation.run import run
from plica.phonation.scene import Scene
from plica.phonation.tissue import Tissue, TissueSide
from plica.video.flow import flow

__version__: str = build_info()["version"]

__all__ = [
    "Airflow",
    "Augmented",
    "Block",
    "Blocks",
    "Contact",
    "Coupling",
    "Extrapolated",
    "HilberHughesTaylor",
    "Initial",
    "InvalidInput",
    "Iterated",
    "Lagged",
    "Larynx",
    "LarynxOptions",
    "Load",
    "MeshFile",
    "Multipliers",
    "Newmark",
    "Nitsche",
    "Output",
    "Penalty",
    "Run",
    "Scene",
    "SceneError",
    "Scheme",
    "Sides",
    "SolveFailed",
    "Solver",
    "Stepping",
    "StorageFailed",
    "Supports",
    "Tissue",
    "TissueSide",
    "VolumePenalty",
    "__version__",
    "build_info",
    "build_mesh",
    "build_simulation",
    "equilibrium",
    "flow",
    "run",
    "set_threads",
]
