"""Input that is no file, leaves its file, or is larger than any recording is refused in one sentence."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import meshio
import numpy as np
import pytest
from PIL import Image

import plica
from plica.phonation.scene.mesh_file import read_mesh
from plica.video.errors import VideoError
from plica.video.recording import Recording
from plica.video.sources import open_source

FRAMES = np.random.default_rng(1).integers(0, 255, (4, 20, 24)).astype(np.uint8)
TETRAHEDRON = meshio.Mesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), [("tetra", np.array([[0, 1, 2, 3]]))]
)


@pytest.mark.parametrize("name", ["a.avi", "a.npy", "a.tif", "a.h5", "a.cine"])
def test_a_pipe_is_no_recording(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(VideoError, match=rf"{name} is a pipe; must be a file"):
        open_source(tmp_path / name)


def test_a_pipe_among_pictures_and_beside_a_header_is_refused(tmp_path: Path) -> None:
    for index in range(2):
        Image.fromarray(FRAMES[index]).save(tmp_path / f"{index}.png")
    os.mkfifo(tmp_path / "2.png")
    with pytest.raises(VideoError, match=r"2\.png is a pipe"):
        Recording.open(tmp_path)
    (tmp_path / "b.cih").write_text("Total Frame : 4\n")
    os.mkfifo(tmp_path / "b.mraw")
    with pytest.raises(VideoError, match=r"b\.mraw is a pipe"):
        open_source(tmp_path / "b.cih")


def test_a_pipe_is_no_scene_and_no_mesh(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scene.toml")
    with pytest.raises(plica.InvalidInput, match=r"scene\.toml is a pipe; must be a file"):
        plica.Scene.load(tmp_path / "scene.toml")
    os.mkfifo(tmp_path / "m.msh")
    with pytest.raises(plica.InvalidInput, match=r"m\.msh is a pipe; must be a file"):
        read_mesh(plica.MeshFile(file=tmp_path / "m.msh", unit="m"), "scene")


def external(path: Path) -> None:
    """Frames that lie in another file."""
    FRAMES.tofile(path.with_name("secret"))
    with h5py.File(path, "w") as file:
        where = [(str(path.with_name("secret")), 0, FRAMES.nbytes)]
        file.create_dataset("frames", FRAMES.shape, FRAMES.dtype, external=where)


def virtual(path: Path) -> None:
    """Frames that are those of another file."""
    with h5py.File(path.with_name("other.h5"), "w") as file:
        file["frames"] = FRAMES
    layout = h5py.VirtualLayout(FRAMES.shape, FRAMES.dtype)
    layout[:] = h5py.VirtualSource(path.with_name("other.h5"), "frames", FRAMES.shape)
    with h5py.File(path, "w") as file:
        file.create_virtual_dataset("frames", layout)


def never_filled(path: Path) -> None:
    """Ten million frames that were not stored."""
    with h5py.File(path, "w") as file:
        file.create_dataset("frames", (10_000_000, 20, 24), np.uint8, chunks=(1, 20, 24))


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (external, "has its data in another file"),
        (virtual, "has its data in another file"),
        (never_filled, "10000000 frames or more; must be at most 1000000|states 4800 MB"),
    ],
)
def test_frames_that_are_not_in_the_file_are_refused(
    tmp_path: Path, make: Callable[[Path], Any], reason: str
) -> None:
    make(tmp_path / "a.h5")
    with pytest.raises(VideoError, match=reason):
        Recording.open(tmp_path / "a.h5")


def test_a_run_whose_data_lie_elsewhere_is_refused(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar.replace({"time.duration": "1 ms"}), tmp_path / "run", progress=False)
    with h5py.File(run.path, "r+") as file:
        file.move("waveforms", "kept")
        file["waveforms"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/waveforms")
    for again in (lambda: plica.Run.load(run.directory), lambda: plica.run(bar, run.directory, resume=True)):
        with pytest.raises(plica.InvalidInput, match="/waveforms is a link to elsewhere"):
            again()


def test_ten_million_frames_of_a_sparse_file_are_refused(tmp_path: Path) -> None:
    frames = np.lib.format.open_memmap(tmp_path / "a.npy", "w+", np.uint8, (10_000_000, 20, 24))
    del frames
    with pytest.raises(VideoError, match="10000000 frames or more; must be at most 1000000"):
        Recording.open(tmp_path / "a.npy")


def test_a_digit_that_is_no_decimal_is_a_letter_of_a_pictures_name(tmp_path: Path) -> None:
    for index in range(3):
        Image.fromarray(FRAMES[index]).save(tmp_path / f"1²{index}.png")
    source = open_source(tmp_path)
    assert source.count == 3
    assert [np.array_equal(frame, FRAMES[k]) for k, (_, frame) in enumerate(source.pixels(0, 3))] == [
        True
    ] * 3


@pytest.mark.parametrize("node", [0, -2, 9])
def test_a_gmsh_element_with_a_node_that_is_not_there_is_named(tmp_path: Path, node: int) -> None:
    path = tmp_path / "m.msh"
    meshio.write(path, TETRAHEDRON, file_format="gmsh22", binary=False)
    text = path.read_text()
    assert read_mesh(plica.MeshFile(file=path, unit="m"), "scene").cells.shape == (1, 4)
    at = text.index("$Elements")
    path.write_text(text[:at] + text[at:].replace(" 1 2 3 4\n", f" 1 2 3 {node}\n"))
    with pytest.raises(plica.InvalidInput, match=rf"element 1 has node {node}; must be a node of the file"):
        read_mesh(plica.MeshFile(file=path, unit="m"), "scene")
