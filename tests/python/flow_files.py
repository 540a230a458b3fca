"""Small recordings in files and scenes for them: what the tests of ``plica identify`` share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

import plica

SIZE = (4e-3, 6e-3, 3e-3)
SHAPE = (48, 40)
PAIRS = 10
FPS = 4000.0
CAMERA = plica.Camera(mm_per_px=0.15, width=SHAPE[1], height=SHAPE[0], centre=(2e-3, 3e-3, 3e-3))
SETTINGS: dict[str, Any] = {
    "surface": "x_max",
    "seen": "z_max",
    "from_rest": True,
    "coarser": "none",
    "spacing": 8.0,
    "parameters": ("body.E",),
}


def block_scene(**changes: Any) -> plica.Scene:
    """A block held below and at both ends."""
    parts: dict[str, Any] = {
        "time": plica.Stepping(step=125e-6, duration=125e-6),
        "supports": plica.Supports(fixed=("z_min", "y_min", "y_max")),
    }
    tissue = {"body": plica.Tissue(E=5e3, nu=0.4, viscosity=0.3)}
    return plica.Scene(plica.Block(size=SIZE, divisions=(1, 2, 1), order=2), tissue, **parts | changes)


def fields(**changes: Any) -> dict[str, Any]:
    """A flow that comes and goes, largest in the middle; None takes a field away."""
    height, width = SHAPE
    y, x = np.mgrid[:height, :width]
    shape = np.exp(-(((x - width / 2) / 12) ** 2) - ((y - height / 2) / 16) ** 2)
    wave = np.sin(2 * np.pi * 200 * np.arange(PAIRS) / FPS)
    flow = np.stack([wave[:, None, None] * shape, 0.3 * wave[:, None, None] * shape], axis=-1)
    made: dict[str, Any] = {
        "flow": flow.astype(np.float32),
        "visible": np.ones(flow.shape[:3], dtype=bool),
        "projection": CAMERA.projection,
        "fps": FPS,
    }
    return {name: value for name, value in (made | changes).items() if value is not None}


def flow_file(path: Path, **changes: Any) -> Path:
    """HDF5 with these fields."""
    with h5py.File(path, "w") as file:
        for name, value in fields(**changes).items():
            file[name] = value
    return path
