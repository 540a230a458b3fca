"""Files of every kind that a user gives, broken at random: read, or refused in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile

import plica
from benchmarks.extremes.broken import broken
from benchmarks.extremes.good_files import mesh_file, picture_file, scene_file
from camera_files import cine, mraw
from dicom_files import dicom, jpeg, rle
from flow_files import fields, flow_file
from picture_files import encoded
from plica.identify import Settings
from plica.identify.model.pressures import _table
from plica.identify.observation.sources import open_motion
from plica.scene.mesh.file import read_mesh
from plica.video.errors import VideoError
from plica.video.files.image_file import read_image
from plica.video.files.recording_date import file_date
from plica.video.files.sources import open_source
from plica.video.motion.flow_file import read_flow, write_flow
from stored_files import DAMAGES, flipped

FRAMES = np.random.default_rng(1).integers(0, 255, (4, 32, 48)).astype(np.uint8)
_ODD = (b"\0" * 8, b"\xff" * 8, b"\0\0\0\x7f" * 2, b"\x01" + 7 * b"\0", b"\0\0\0\0\0\x01\0\0")


def odd_header(whole: bytes, random: np.random.Generator) -> bytes:
    """With a number near the beginning that nobody means."""
    size = int(random.choice([1, 2, 4, 8]))
    at = int(random.integers(0, min(len(whole), 600) - size))
    return whole[:at] + _ODD[int(random.integers(len(_ODD)))][:size] + whole[at + size :]


WAYS = (broken, flipped, odd_header, odd_header, *DAMAGES.values())


def packed_stack(path: Path) -> Path:
    tifffile.imwrite(path, FRAMES, photometric="minisblack", compression="zlib", bigtiff=True)
    return path


def archive(path: Path) -> Path:
    np.savez(path, **fields())
    return path


def settings(path: Path) -> Path:
    path.write_text('[identify]\nparameters = ["body.E", {targets = "body.nu", log_sd = 0.4}]\nfps = 4000\n')
    return path


def pressures(path: Path) -> Path:
    path.write_text("time,p1,p2\n0,1,2\n0.1,2,3\n0.2,3,4\n")
    return path


def vectors(path: Path) -> Path:
    write_flow(path, np.ones((5, 6, 2)))
    return path


def mp4(path: Path, **tags: str) -> Path:
    return Path(encoded(path, FRAMES, "mpeg4", "yuv420p", **tags))


def frames(path: Path) -> None:
    source = open_source(path)
    if source.count < 1000:
        for _ in source.pixels(0, source.count):
            pass


def motion(path: Path) -> None:
    found = open_motion(path)
    for pair in range(min(found.pairs, 20)):
        found.flow(pair), found.visible(pair)


def mesh(path: Path) -> None:
    read_mesh(plica.MeshFile(file=path, unit="m", labels="gmsh:physical"), "scene")


GIVEN: list[tuple[Callable[[Path], Path], Callable[[Path], Any]]] = [
    *((lambda p, s=s: picture_file(s, p), frames) for s in (".avi", ".tif", ".npy", ".h5")),
    *((lambda p, s=s: picture_file(s, p), read_image) for s in (".png", ".jpg", ".bmp")),
    (lambda p: packed_stack(p / "packed.tif"), frames),
    (lambda p: mp4(p / "a.mp4"), frames),
    (lambda p: cine(p / "a.cine", FRAMES), frames),
    (lambda p: mraw(p / "a.cih", FRAMES), frames),
    (lambda p: mraw(p / "a.cihx", FRAMES), frames),
    (lambda p: dicom(p / "a.dcm", FRAMES), frames),
    (lambda p: jpeg(p / "a.dcm", FRAMES), frames),
    (lambda p: rle(p / "a.dcm", FRAMES.astype(np.uint16), stored=12), frames),
    (lambda p: vectors(p / "a.flo"), read_flow),
    (lambda p: mesh_file(".msh", p, file_format="gmsh22", binary=False), mesh),
    (lambda p: mesh_file(".msh", p, file_format="gmsh22", binary=True), mesh),
    (lambda p: mesh_file(".vtu", p), mesh),
    (scene_file, plica.Scene.load),
    (lambda p: settings(p / "settings.toml"), Settings.load),
    (lambda p: pressures(p / "drive.csv"), lambda p: _table(p, 2)),
    (lambda p: archive(p / "flow.npz"), motion),
    (lambda p: flow_file(p / "flow.h5"), motion),
]


@pytest.mark.filterwarnings("ignore")  # of the libraries that read formats
@pytest.mark.parametrize(("write", "read"), GIVEN)
def test_a_broken_file_is_read_or_refused_in_one_sentence(
    tmp_path: Path, write: Callable[[Path], Path], read: Callable[[Path], Any]
) -> None:
    path = write(tmp_path)
    content, random, said = path.read_bytes(), np.random.default_rng(28), list[Exception]()
    read(path)
    for _ in range(30):
        path.write_bytes(WAYS[int(random.integers(len(WAYS)))](content, random))
        try:
            read(path)
        except plica.InvalidInput as error:
            said.append(error)
    assert len(said) > 5
    for one in said:
        assert len(str(one)) < 900
        assert "\n" not in str(one) or isinstance(one, plica.SceneError)


def test_names_that_are_no_text_do_not_matter(tmp_path: Path) -> None:
    path = mp4(tmp_path / "a.mp4", title="abcdefgh")
    content = path.read_bytes()
    assert b"abcdefgh" in content
    path.write_bytes(content.replace(b"abcdefgh", b"abc\xedefgh"))
    assert open_source(path).count == len(FRAMES)
    assert file_date(path) is None


def test_a_colour_space_that_no_reader_has_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, FRAMES, photometric="minisblack", metadata=None)
    with tifffile.TiffFile(path) as stack:
        places = [page.tags["PhotometricInterpretation"].valueoffset for page in stack.pages]
    content = bytearray(path.read_bytes())
    content[places[2]] = 7
    path.write_bytes(content)
    with pytest.raises(VideoError, match=r"a\.tif: frame 2 cannot be decoded"):
        frames(path)
