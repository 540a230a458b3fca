"""The basis of a reduced run, stored with its results: a resumed run uses the same basis.

The newest basis from a full run is stored beside that run too, for the next voice near it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import Damaged, InvalidInput, StorageFailed
from plica.runs.build import basis_of
from plica.runs.full_run import motion_digest
from plica.scene.scene import Scene
from plica.storage.files import storage_errors
from plica.storage.hdf5 import put, put_text, write_image
from plica.storage.stored import Stored

__all__ = ["BASIS", "basis_seconds", "kept_basis", "write_basis"]

BASIS = "basis.h5"
_WITHOUT = (
    "initial",
    "output",
    "solver",
    "loads",
    "gravity",
    "time.step",
    "time.duration",
    "time.scheme",
    "airflow.subglottal_pressure",
    "airflow.rise",
    "airflow.air_density",
    "airflow.model",
    "airflow.coupling",
)
"""Keys of a scene that have no part in its basis."""


def kept_basis(
    directory: Path, scene: Scene, mesh: _engine.TetMesh, *, resumed: bool = False, shown: bool = False
) -> NDArray[np.float64]:
    """The vectors (3 n, any) of a scene from its run's directory, or from that of its full run; computed and
    stored in both if there are none.

    resumed: the run has states, which are coordinates in its basis; raises InvalidInput if that basis is
    missing. shown: print on standard error that a basis is computed, which takes time.
    """
    digest = _digest(scene, mesh)
    if resumed:
        return _required(directory / BASIS, digest)
    motion = _motion(scene)
    found = _whole(directory / BASIS, digest, motion)
    if found is not None:
        return found
    full_run = None if scene.reduction is None else scene.reduction.full_run
    shared = None if full_run is None else full_run / BASIS
    found = None if shared is None else _whole(shared, digest, motion)
    seconds = 0.0
    if found is None:
        begin = time.perf_counter()
        found = basis_of(scene, mesh, _print_notice if shown else None)
        seconds = time.perf_counter() - begin
        if shared is not None:
            _share(shared, found, digest, motion)
    _write(directory / BASIS, found, digest, motion, seconds)
    return found


def _whole(path: Path, digest: str, motion: str) -> NDArray[np.float64] | None:
    """The vectors in a file; None if there are none of this scene and motion, or they are damaged."""
    try:
        return _read(path, digest, motion)
    except Damaged:  # nothing was computed in it yet
        return None


def _share(path: Path, basis: NDArray[np.float64], digest: str, motion: str) -> None:
    """Store the basis for other voices where the full run lies, if that can be written.

    Several voices may do so at once: each has a draft of its own, and the last one stays.
    """
    with contextlib.suppress(StorageFailed, OSError), TemporaryDirectory(dir=path.parent) as drafts:
        _write(Path(drafts) / path.name, basis, digest, motion, 0.0)
        os.replace(Path(drafts) / path.name, path)


def _print_notice() -> None:
    print("plica: computing and storing the basis of [reduction]", file=sys.stderr, flush=True)


def basis_seconds(directory: Path) -> float:
    """Time (s) that the basis of a run took to compute; 0 if not stored."""
    with storage_errors(directory / BASIS, "read"), Stored(directory / BASIS) as file:
        return float(file.read("seconds"))


def write_basis(directory: Path, scene: Scene, mesh: _engine.TetMesh, basis: NDArray[np.float64]) -> None:
    """Store vectors (3 n, any) as those of this scene on this mesh."""
    _write(directory / BASIS, basis, _digest(scene, mesh), _motion(scene), 0.0)


def _required(path: Path, digest: str) -> NDArray[np.float64]:
    found = _read(path, digest, None)
    if found is None:
        raise InvalidInput(
            f"{path}: is missing, or of another mesh or tissue; must be the basis that the run "
            "started with, in which its states are coordinates. Start the scene in another directory."
        )
    return found


def _write(path: Path, basis: NDArray[np.float64], digest: str, motion: str, seconds: float) -> None:
    def fill(file: Any) -> None:
        put_text(file, "scene", digest)
        put_text(file, "motion", motion)
        put_text(file, "plica_version", _version())
        put(file, "seconds", seconds, "s")
        put(file, "basis", basis, "m")

    write_image(path, fill)


def _digest(scene: Scene, mesh: _engine.TetMesh) -> str:
    """Digest of everything that the basis may depend on: of the scene all but `_WITHOUT`."""
    said = scene.resolved()
    for key in _WITHOUT:
        table, _, name = key.rpartition(".")
        (said.get(table, {}) if table else said).pop(name, None)
    found = hashlib.sha256(json.dumps(said, sort_keys=True).encode())
    numbers = {"points": mesh.points, "cells": mesh.cells, "layers": mesh.cell_layer, "sides": mesh.cell_side}
    for kind, named in (("mesh", numbers), ("surface", mesh.surfaces), ("node set", mesh.node_sets)):
        for name, part in sorted(named.items()):
            array = np.ascontiguousarray(part)
            found.update(json.dumps([kind, name, array.dtype.str, array.shape]).encode() + array.tobytes())
    found.update(json.dumps(list(mesh.layer_names)).encode())
    return found.hexdigest()


def _version() -> str:
    """Of plica: another one may compute another basis of the same scene."""
    return str(_engine.build_info()["version"])


def _motion(scene: Scene) -> str:
    """Digest of the motion from which the vectors are computed; empty without one."""
    full_run = None if scene.reduction is None else scene.reduction.full_run
    return "" if full_run is None else motion_digest(full_run)


def _read(path: Path, digest: str, motion: str | None) -> NDArray[np.float64] | None:
    """The vectors in a file; None if there is none, or it is of another scene or motion. Raises Damaged."""
    if not path.exists():
        return None
    with Stored(path, hint="Start the scene in another directory") as file:
        if file.text("scene") != digest:
            return None
        if motion is not None and (motion, _version()) != (file.text("motion"), file.text("plica_version")):
            return None
        basis: NDArray[np.float64] = file.read("basis")
        return basis
