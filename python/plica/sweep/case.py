"""One case of a sweep, as a worker computes it."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plica import _engine
from plica.errors import CautionWarning, Damaged, InvalidInput, SolveFailed, StorageFailed
from plica.measures.measure import Measure
from plica.measures.record import Array
from plica.runs.basis_file import read_basis
from plica.runs.build import build_simulation
from plica.runs.run import run
from plica.runs.scene_mesh import scene_mesh
from plica.runs.unstored import UnstoredRun
from plica.scene.scene import Scene

__all__ = ["STATISTICS", "CaseResult", "Status", "Task", "run_case"]

Status = Literal["waiting", "done", "refused", "failed"]
STATISTICS = ("value", "spread", "uncertainty")
"""What is kept of each measure."""


@dataclass(frozen=True)
class Task:
    """What a worker is told: all that a case needs.

    Attributes
    ----------
    case : int
        Its number, from 0.
    digest : str
        What it is of (`Plan.case_digest`).
    scene : Scene
        That of the plan.
    changes : mapping
        What is changed in it.
    waveforms : tuple of str
        To return.
    version : str
        Of Plica, as the driver's.
    folder : str or None
        Where its run is kept.
    """

    case: int
    digest: str
    scene: Scene
    changes: Mapping[str, float | int]
    waveforms: tuple[str, ...]
    version: str
    folder: str | None = None


@dataclass(frozen=True)
class CaseResult:
    """What a case gave.

    Attributes
    ----------
    case, digest
        Of its task.
    status : {"done", "refused", "failed"}
        Refused: there is no such scene. Failed: it could not be computed.
    message : str
        Why it has no measures.
    seconds : float
        Wall time.
    cautions : tuple of str
        Names, docs/cautions.md.
    measures : mapping
        Name to value, spread and uncertainty, in SI; None where there is none.
    waveforms : mapping
        With `time`, if any were asked for.
    fault : str
        Why the sweep cannot go on at all; empty if it can.
    """

    case: int
    digest: str
    status: Status
    message: str = ""
    seconds: float = 0.0
    cautions: tuple[str, ...] = ()
    measures: Mapping[str, tuple[float | None, float | None, float | None]] = field(default_factory=dict)
    waveforms: Mapping[str, Array] = field(default_factory=dict)
    fault: str = ""


def run_case(task: Task) -> CaseResult:
    """Compute a case on one thread; what goes wrong is its status, and raises nothing."""
    begun = time.monotonic()

    def ended(status: Status, message: str = "", **found: Any) -> CaseResult:
        seconds = time.monotonic() - begun
        return CaseResult(task.case, task.digest, status, message, seconds=seconds, **found)

    own = str(_engine.build_info()["version"])
    if own != task.version:
        return ended("failed", fault=f"a worker has plica {own}; must have {task.version}, as the driver.")
    _engine.set_threads(1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CautionWarning)  # counted, by name
            scene = task.scene.replace(task.changes) if task.changes else task.scene
            made = _unstored(scene) if task.folder is None else _stored(scene, Path(task.folder))
            missing = [name for name in task.waveforms if name not in made.waveforms]
            if missing:
                return ended("failed", fault=f"the scene has no waveform {missing[0]}; must have it.")
            kept = ("time", *task.waveforms) if task.waveforms else ()
            return ended(
                "done",
                cautions=tuple(dict.fromkeys(caution.name for caution in made.cautions)),
                measures={name: _statistics(item) for name, item in made.measures.items()},
                waveforms={name: np.asarray(made.waveforms[name]) for name in kept},
            )
    except (Damaged, StorageFailed) as error:
        return ended("failed", fault=str(error))
    except SolveFailed as error:
        return ended("failed", str(error))
    except InvalidInput as error:
        return ended("refused", str(error).replace("Scene.replace: ", ""))
    except MemoryError:
        return ended("failed", "there is not enough memory. Use a coarser mesh, or fewer workers.")
    except Exception as error:  # of this case alone, as far as anyone knows
        return ended("failed", f"{type(error).__name__}: {error}")


def _statistics(item: Measure) -> tuple[float | None, float | None, float | None]:
    found = (item.value, item.spread, item.uncertainty)
    value, spread, uncertainty = (
        None if one is None or not np.isfinite(one) else float(one) for one in found
    )
    return value, spread, uncertainty


def _stored(scene: Scene, folder: Path) -> Any:
    """A run folder, begun or continued."""
    return run(scene, folder, resume="if_there", progress=False)


def _unstored(scene: Scene) -> UnstoredRun:
    resolved = scene.resolved()
    of_mesh = {name: resolved.get(name) for name in ("mesh", "posture")}
    if scene.posture is not None:
        of_mesh |= {name: resolved.get(name) for name in ("tissue", "supports")}
    mesh = _last("mesh", of_mesh, lambda: scene_mesh(scene))
    basis = None
    if (reduction := scene.reduction) is not None:
        of_basis = {**of_mesh, **{name: resolved.get(name) for name in ("supports", "symmetry", "reduction")}}
        basis = _last("basis", of_basis, lambda: read_basis(reduction.basis, scene, mesh))
    simulation = build_simulation(scene, mesh, basis=basis)
    names = [name for name in simulation.advance(0) if name not in _UNMEASURED]
    return UnstoredRun(scene, mesh, simulation, simulation.advance(scene.time.steps, names))


_UNMEASURED = ("section_area", "section_pressure")
"""Waveforms that no measure or caution reads, and of which each step has hundreds of numbers."""
_kept: dict[str, tuple[str, Any]] = {}


def _last(kind: str, of: Any, make: Callable[[], Any]) -> Any:
    """What was made last, if it was of the same."""
    key = json.dumps(of, sort_keys=True)
    if kind not in _kept or _kept[kind][0] != key:
        _kept.pop(kind, None)
        _kept[kind] = key, make()
    return _kept[kind][1]
