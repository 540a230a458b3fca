"""A mesh like another: `changed_mesh`."""

from __future__ import annotations

from typing import Any

from plica import _engine

__all__ = ["changed_mesh"]

_PARTS = ("points", "cells", "cell_layer", "cell_side", "layer_names", "surfaces", "node_sets")


def changed_mesh(mesh: _engine.TetMesh, **changes: Any) -> _engine.TetMesh:
    """The mesh with some of its parts, arguments of `TetMesh`, in place of its own."""
    return _engine.TetMesh(**{name: getattr(mesh, name) for name in _PARTS} | changes)
