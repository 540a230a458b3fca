"""The basis of reduced scenes as a file: made once, for any number of scenes, stored with each run too."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.scene.held import fixed_components
from plica.scene.scene import Scene
from plica.storage.hdf5 import put, put_text, write_image
from plica.storage.stored import Stored

__all__ = ["BASIS", "kept_basis", "read_basis", "write_basis"]

BASIS = "basis.h5"
_AGAIN = "Make it again with: plica reduce RUN -o basis.h5"


def write_basis(path: Path, scene: Scene, mesh: _engine.TetMesh, basis: NDArray[np.float64]) -> None:
    """Store vectors (3 n, any) m as a basis of scenes with this mesh, these supports and this symmetry."""

    def fill(file: Any) -> None:
        for name, value in _marks(scene, mesh).items():
            put_text(file, name, value)
        put_text(file, "plica_version", str(_engine.build_info()["version"]))
        put(file, "basis", basis, "m")

    write_image(path, fill)


def read_basis(path: Path, scene: Scene, mesh: _engine.TetMesh, hint: str = _AGAIN) -> NDArray[np.float64]:
    """The vectors (3 n, any) m of a scene in a file of `write_basis`.

    Raises InvalidInput if there is none, or it is of another mesh, other supports or another symmetry, and
    Damaged.
    """
    if not path.is_file():
        raise InvalidInput(f"{path}: is missing; must be the basis of [reduction]. {hint}.")
    with Stored(path, hint=hint) as file:
        for name, value in _marks(scene, mesh).items():
            if (stored := file.text(name)) != value:
                own, other = (f" ({text})" if name == "symmetry" else "" for text in (value, stored))
                raise InvalidInput(
                    f"{path}: is a basis of another {name}{other}; must be of the scene's{own}. {hint}."
                )
        basis: NDArray[np.float64] = file.read("basis")
        return basis


def kept_basis(
    directory: Path, scene: Scene, mesh: _engine.TetMesh, *, resumed: bool = False
) -> NDArray[np.float64]:
    """The vectors (3 n, any) m of a reduced scene, from the file that it names, then stored with its run too.

    resumed: the run has states, which are coordinates in the basis that is stored with it.
    """
    own = directory / BASIS
    if resumed:
        hint = "The run's states are coordinates in it: start the scene in another directory"
        return read_basis(own, scene, mesh, hint)
    if scene.reduction is None:
        raise InvalidInput(f"{scene.source}: reduction is left out; must be given for a basis.")
    basis = read_basis(scene.reduction.basis, scene, mesh)
    write_basis(own, scene, mesh, basis)
    return basis


def _marks(scene: Scene, mesh: _engine.TetMesh) -> dict[str, str]:
    """What a basis must be of: coordinates have no meaning on another mesh, and what is held or mirrored
    would move."""
    return {
        "mesh": _digest(mesh.points, mesh.cells),
        "supports": _digest(fixed_components(scene, mesh)),
        "symmetry": scene.symmetry or "none",
    }


def _digest(*arrays: Any) -> str:
    found = hashlib.sha256()
    for one in arrays:
        array = np.ascontiguousarray(one)
        found.update(f"{array.dtype.str} {array.shape}".encode() + array.tobytes())
    return found.hexdigest()
