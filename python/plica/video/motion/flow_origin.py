"""What found a stored flow, so that flows of two programs are never mixed.

A version number does not change with every edit, and constants are not all of an estimator. So a stored flow
keeps, beside its constants, a probe: what the same program finds of one small pair of frames that is given by
formulas, in which a slit opens. Programs that find the same motion in it are taken for the same.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from plica.storage.hdf5 import put, set_text
from plica.storage.stored import Stored
from plica.video.glottis.midline import Midline
from plica.video.motion.flow import PRESETS, FlowOptions, flow
from plica.video.motion.fold_edges import Folds

__all__ = ["FlowOrigin"]

_SIDE = 40  # px
_WAY = 1.6  # px that each fold moves
_SAME = 0.01  # px; libraries of another version round otherwise


@dataclass(frozen=True, eq=False)
class FlowOrigin:
    """The program that found a flow.

    Attributes
    ----------
    constants : dict
        Of `FlowOptions`, by name.
    probe : (h, w, 2) px
        The motion that it finds in the small pair.
    """

    constants: dict[str, Any]
    probe: npt.NDArray[np.float32]

    @classmethod
    def of(cls, preset: str) -> FlowOrigin:
        """This program's, with that preset."""
        options = PRESETS[preset]
        names = [name for name in dir(FlowOptions) if not name.startswith("_") and name != "validate"]
        return cls({name: getattr(options, name) for name in names}, _probe(preset))

    @classmethod
    def read(cls, file: Stored) -> FlowOrigin:
        """That of a stored flow."""
        return cls(json.loads(str(file.attribute("probe", "constants"))), file.read("probe"))

    def write(self, file: h5py.File) -> None:
        """Keep it beside the flow."""
        put(file, "probe", self.probe, "px: to the right, down")
        set_text(file["probe"], "constants", json.dumps(self.constants))

    def difference(self, other: FlowOrigin) -> str:
        """In what the other differs, for a sentence; empty where both find the same."""
        names = sorted(self.constants.keys() | other.constants.keys())
        said = [
            f"{name} {self.constants.get(name)} and {other.constants.get(name)}"
            for name in names
            if self.constants.get(name) != other.constants.get(name)
        ]
        if said:
            return ", ".join(said)
        if self.probe.shape != other.probe.shape:
            return "their versions of plica"
        off = float(np.abs(self.probe - other.probe).max())
        return "" if off <= _SAME else f"their versions of plica, by up to {off:.2g} px in one small pair"


@cache
def _probe(preset: str) -> npt.NDArray[np.float32]:
    """(h, w, 2) px found where two folds that touch part, the right one by a fifth less."""
    y, x = np.mgrid[0:_SIDE, 0:_SIDE].astype(float)
    off = x - (_SIDE - 1) / 2
    way = np.where(off < 0, -_WAY, 0.8 * _WAY)
    then = (np.abs(off) < np.abs(way)) & (y >= 6) & (y < _SIDE - 6)
    moved = off - way * ((y >= 6) & (y < _SIDE - 6))
    first, second = (
        140 + 30 * np.sin(0.9 * at + 0.3 * y) + 20 * np.cos(0.5 * at - 0.7 * y) for at in (off, moved)
    )
    middle = (_SIDE - 1) / 2
    folds = Folds(np.zeros_like(then), then, Midline((middle, 4.0), (middle, _SIDE - 4.0)))
    found = flow(first, np.where(then, 12.0, second), preset=preset, intensity=(0.0, 255.0), folds=folds)
    found.flow.setflags(write=False)
    return found.flow
