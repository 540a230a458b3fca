"""The protocol of a mesh that measures use, of the engine or stored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from plica.measures.record import Array

__all__ = ["MeshData"]


class MeshData(Protocol):
    """A mesh in its reference position."""

    @property
    def points(self) -> Array:
        """(n, 3) m, reference positions."""

    @property
    def cells(self) -> Array:
        """(m, 4) or (m, 10) node numbers."""

    @property
    def cell_layer(self) -> Array:
        """(m) position in `layer_names`."""

    @property
    def layer_names(self) -> Sequence[str]:
        """Names of the layers, e.g. body, ligament, cover."""

    @property
    def surfaces(self) -> Mapping[str, Array]:
        """Named boundary faces, (f, 3) or (f, 6) node numbers."""
