"""A copy of a mesh with some parts changed."""

from __future__ import annotations

from typing import Any

from plica import _engine
from plica.scene.held import MeshArrays

__all__ = ["changed_mesh"]

_PARTS = ("points", "cells", "cell_layer", "cell_side", "layer_names", "surfaces", "node_sets", "rest")


def changed_mesh(mesh: MeshArrays, **changes: Any) -> _engine.TetMesh:
    """A copy of the mesh with some parts, arguments of `TetMesh`, replaced."""
    return _engine.TetMesh(**{name: getattr(mesh, name) for name in _PARTS} | changes)
