"""A file that a command writes is there whole, or as it was before."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plica
from pictured_folds import pictured
from plica.commands.main import main
from plica.scene.mesh.summary import write_mesh
from plica.video.glottis.segmenter import write_masks

SCENE = plica.Scene.from_text(
    'mesh = { block = { size = ["4 mm", "4 mm", "4 mm"], divisions = [1, 1, 1] } }\n'
    'tissue = { body = { E = "10 kPa", nu = 0.4 } }\ntime = { step = "1 ms", duration = "1 ms" }\n'
)


def _larynx(folder: Path) -> None:
    folds, frames = pictured(), folder.parent / "frames"
    frames.mkdir()
    for name, picture in (("frame", folds.frame), ("mask", 255 * folds.mask)):
        Image.fromarray(picture.astype(np.uint8)).save(frames / f"{name}.png")
    given = [str(frames / "frame.png"), "--mask", str(frames / "mask.png"), "--order", "1"]
    code = main(["larynx", *given, "--r-in", "6.3 mm", "-o", str(folder / "scene.toml"), "--overwrite"])
    if code:
        raise plica.StorageFailed(str(code))


def _masks(folder: Path) -> None:
    grey = np.zeros((4, 5))
    write_masks(folder, {3: (grey, grey > 0)})


WRITERS: dict[str, tuple[Callable[[Path], object], tuple[str, ...]]] = {
    "scene": (lambda folder: SCENE.save(folder / "scene.toml"), ("scene.toml",)),
    "mesh": (lambda folder: write_mesh(plica.build_mesh(SCENE.mesh), folder / "mesh.vtu"), ("mesh.vtu",)),
    "mesh of two files": (
        lambda folder: write_mesh(plica.build_mesh(SCENE.mesh), folder / "mesh.xdmf"),
        ("mesh.h5", "mesh.xdmf"),
    ),
    "masks": (_masks, ("frame_00003.png", "mask_00003.png")),
    "larynx": (_larynx, ("scene.svg", "scene.toml")),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_is_written_under_another_name_first(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, names = WRITERS[name]
    folder = tmp_path / "out"
    folder.mkdir()
    for own in names:
        if name != "masks":  # which are never replaced
            (folder / own).write_text("before")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", full)
        with pytest.raises(plica.StorageFailed):
            write(folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "larynx"])
def test_nothing_but_the_files_is_left(name: str, tmp_path: Path) -> None:
    write, names = WRITERS[name]
    write(tmp_path)
    assert tuple(sorted(path.name for path in tmp_path.iterdir())) == names


def test_a_mesh_of_two_files_is_read_back(tmp_path: Path) -> None:
    import meshio

    mesh = plica.build_mesh(SCENE.mesh)
    write_mesh(mesh, tmp_path / "mesh.xdmf")
    np.testing.assert_array_equal(meshio.read(tmp_path / "mesh.xdmf").points, mesh.points)


def test_the_name_of_a_draft_is_written_in_one_place() -> None:
    package = Path(plica.__file__).parent
    assert [path.name for path in sorted(package.rglob("*.py")) if '".part"' in path.read_text()] == [
        "files.py"
    ]
