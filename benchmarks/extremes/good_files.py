"""Good files of every kind, to be broken."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plica import _engine as engine

__all__ = ["SCENE", "mesh_file", "picture_file", "scene_file"]

SCENE = """
[mesh.blocks.a]
size = [10e-3, 2e-3, 2e-3]
divisions = [3, 1, 1]
[mesh.blocks.b]
corner = [10.1e-3, 0, 0]
size = [10e-3, 2e-3, 2e-3]
divisions = [3, 1, 1]
[tissue.a]
E = 20e3
nu = 0.3
viscosity = 0.5
[tissue.b]
E = 20e3
nu = 0.3
E_fibre = 30e3
nu_fibre = 0.3
mu_fibre = 10e3
fibre = [0, 1, 0]
[[loads]]
surface = "a.x_min"
traction = [0, 0, 5]
frequency = 100
[contact]
first = "a.x_max"
second = "b.x_min"
friction = 0.3
[contact.augmented]
stiffness = 1
growth = 10
[initial.velocity]
a = [0.5, 0, 0]
[time]
step = 50e-6
duration = 4e-4
scheme = { newmark = { beta = 0.25, gamma = 0.5 } }
"""


def scene_file(directory: Path) -> Path:
    """Two bars that collide, with a load, friction and fibres."""
    path = directory / "scene.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def mesh_file(suffix: str, directory: Path, **options: Any) -> Path:
    """A block whose cells are labelled 1 and whose face x_min is labelled 10; `options` go to meshio."""
    import meshio

    block = engine.block_mesh(corner=(0, 0, 0), size=(1e-2, 1e-2, 1e-2), divisions=(2, 1, 1))
    cells, face = np.asarray(block.cells), np.asarray(block.surfaces["x_min"])
    mesh = meshio.Mesh(
        np.asarray(block.points),
        [("tetra", cells), ("triangle", face)],
        cell_data={"gmsh:physical": [np.ones(len(cells), int), np.full(len(face), 10)]}
        | (
            {"gmsh:geometrical": [np.ones(len(cells), int), np.ones(len(face), int)]}
            if suffix == ".msh"
            else {}
        ),
    )
    path = directory / f"mesh{suffix}"
    meshio.write(path, mesh, **options)
    return path


def _frames() -> np.ndarray:
    """(4, 32, 48), uint8: waves that move."""
    y, x = np.mgrid[:32, :48]
    shifts = 0.3 * np.arange(4)[:, None, None]
    frames: np.ndarray = (127 + 100 * np.sin(0.2 * x + shifts) * np.cos(0.3 * y)).astype(np.uint8)
    return frames


def picture_file(suffix: str, directory: Path) -> Path:
    """A recording of four frames, or, where the format has one picture, the first of them."""
    path = directory / f"picture{suffix}"
    if suffix == ".npy":
        np.save(path, _frames())
    elif suffix == ".tif":
        import tifffile

        tifffile.imwrite(path, _frames(), photometric="minisblack")
    elif suffix == ".h5":
        import h5py

        with h5py.File(path, "w") as file:
            file["frames"] = _frames()
    elif suffix == ".avi":
        import av

        with av.open(str(path), "w") as made:
            stream = made.add_stream("mjpeg", rate=25)
            stream.width, stream.height, stream.pix_fmt = 48, 32, "yuvj420p"
            for frame in _frames():
                for packet in stream.encode(
                    av.VideoFrame.from_ndarray(np.repeat(frame[..., None], 3, 2), "rgb24")
                ):
                    made.mux(packet)
            made.mux(stream.encode())
    else:
        from PIL import Image

        Image.fromarray(_frames()[0]).save(path)
    return path
