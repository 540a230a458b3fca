"""Cases that are runs of a scene."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plica import _engine
from plica.runs.basis_file import read_basis
from plica.runs.build import build_simulation
from plica.runs.run import run
from plica.runs.scene_mesh import scene_mesh
from plica.runs.unstored import UnstoredRun
from plica.scene.number_key import number_key
from plica.scene.scene import Scene
from plica.sweep.subject import Changes, Fault, Key, Outcome, scene_files, statistics

__all__ = ["SceneCases"]


@dataclass(frozen=True, eq=False)
class SceneCases:
    """A scene, numbers of which change."""

    scene: Scene
    kind: Literal["run"] = field(default="run", init=False)
    recordings: tuple[str, ...] = field(default=(), init=False)

    def key(self, key: str, where: str) -> Key:
        """A number of the scene."""
        return number_key(self.scene, key, where)

    def record(self) -> dict[str, Any]:
        """Version, scene, and its files by their content."""
        scene = self.scene.resolved()
        files = scene_files(scene)
        return {"plica_version": str(_engine.build_info()["version"]), "scene": scene, "files": files}

    def save(self, directory: Path) -> None:
        """Write ``scene.toml``."""
        self.scene.save(directory / "scene.toml")

    def compute(self, changes: Changes, waveforms: tuple[str, ...], folder: Path | None) -> Outcome:
        """A run, whose folder is begun or continued if one is given."""
        scene = self.scene.replace(changes) if changes else self.scene
        made: Any = _unstored(scene) if folder is None else _stored(scene, folder)
        missing = [name for name in waveforms if name not in made.waveforms]
        if missing:
            raise Fault(f"the scene has no waveform {missing[0]}; must have it.")
        kept = ("time", *waveforms) if waveforms else ()
        return Outcome(
            {name: statistics(item) for name, item in made.measures.items()},
            cautions=tuple(dict.fromkeys(caution.name for caution in made.cautions)),
            waveforms={name: np.asarray(made.waveforms[name]) for name in kept},
        )


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
    simulation = build_simulation(scene, mesh, basis=basis, last_basis=_last_basis)
    names = [name for name in simulation.advance(0) if name not in _UNMEASURED]
    return UnstoredRun(scene, mesh, simulation, simulation.advance(scene.time.steps, names))


_UNMEASURED = ("section_area", "section_pressure")
"""Waveforms that no measure or caution reads, and of which each step has hundreds of numbers."""
_kept: dict[str, tuple[str, Any]] = {}
_last_basis = _engine.LastBasis()


def _last(kind: str, of: Any, make: Callable[[], Any]) -> Any:
    """What was made last, if it was of the same."""
    key = json.dumps(of, sort_keys=True)
    if kind not in _kept or _kept[kind][0] != key:
        _kept.pop(kind, None)
        _kept[kind] = key, make()
    return _kept[kind][1]
