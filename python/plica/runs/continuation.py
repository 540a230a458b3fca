"""Check that a scene may continue the run in a directory: the same scene, or one with a longer duration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plica import _engine
from plica.errors import InvalidInput, SceneError
from plica.runs.results import Run
from plica.scene.problems import differences
from plica.scene.scene import Scene
from plica.storage.files import refuse_sweep, storage_errors

__all__ = ["has_all", "holds_run", "require_mesh"]


def holds_run(directory: Path) -> bool:
    """Whether the directory has a run; raises InvalidInput if it is not a directory, or one of a sweep."""
    if directory.exists() and not directory.is_dir():
        raise InvalidInput(f"{directory}: must be a directory; it is a file.")
    with storage_errors(directory, "read"):
        refuse_sweep(directory)
        return (directory / "scene.toml").exists() or (directory / "results.h5").exists()


def has_all(directory: Path, scene: Scene) -> bool:
    """Whether the run in a directory has all steps of a scene that may continue it.

    Raises SceneError if they differ in anything but a longer duration.
    """
    existing = Run.load(directory) if (directory / "results.h5").exists() else None
    held = Scene.load(directory / "scene.toml") if existing is None else existing.scene
    stored, given = held.resolved(), scene.resolved()
    if scene.time.steps > held.time.steps:
        stored["time"]["duration"] = given["time"]["duration"]
    different = _differences(stored, given)
    if different:
        raise SceneError(
            f"{scene.source}: {different}; must be the scene that started the run, or one with a longer "
            "time.duration. Start another run in another directory."
        )
    return existing is not None and existing.status == "finished" and existing.steps == scene.time.steps


def require_mesh(directory: Path, scene: Scene, mesh: _engine.TetMesh) -> None:
    """Raise SceneError if the mesh built for a scene is not that of the run in a directory."""
    stored = Run.load(directory).mesh
    for name in ("points", "cells", "cell_layer", "cell_side", "surfaces", "node_sets"):
        if not _same(getattr(stored, name), getattr(mesh, name)):
            raise SceneError(
                f"{scene.source}: mesh: its {name} are not those of the run; must be the same. Has the mesh "
                "changed? Start another run in another directory."
            )


def _same(stored: Any, given: Any) -> bool:
    """Whether arrays, or mappings of arrays, are equal."""
    if isinstance(stored, dict):
        return stored.keys() == given.keys() and all(_same(stored[name], given[name]) for name in stored)
    return np.array_equal(stored, np.asarray(given))


def _differences(stored: Any, given: Any) -> str:
    """``time.step = 1e-05, the run has 5e-05`` for each key that differs, joined by "; "."""
    found = []
    for key, before, now in differences(stored, given):
        given_text = f"{key} is missing" if now is None else f"{key} = {now}"
        found.append(f"{given_text}, the run has {'none' if before is None else before}")
    return "; ".join(found)
