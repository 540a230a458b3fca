"""Input that is no file, leaves its file, or is larger than any recording is refused in one sentence."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import meshio
import numpy as np
import pytest
import tifffile
from PIL import Image

import plica
from benchmarks.extremes.good_files import picture_file
from camera_files import cine, mraw
from flow_files import SETTINGS, block_scene, fields, flow_file
from plica.identify import Settings, identify
from plica.identify.observation.sources import open_motion
from plica.scene.mesh.file import read_mesh
from plica.storage import npz as module_npz
from plica.video.errors import VideoError
from plica.video.files import limits, photron, sources, tiff_file, video_file
from plica.video.files.image_file import read_image
from plica.video.files.recording import Recording
from plica.video.files.sources import open_source
from plica.video.motion.flow_file import read_flow

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


@pytest.mark.parametrize("link", [h5py.ExternalLink("other.med", "/ENS_MAA"), h5py.SoftLink("/elsewhere")])
def test_a_mesh_whose_data_lie_elsewhere_is_refused(tmp_path: Path, link: Any) -> None:
    path = tmp_path / "m.med"
    meshio.write(path, TETRAHEDRON)
    given = plica.MeshFile(file=path, unit="m")
    assert read_mesh(given, "scene").cells.shape == (1, 4)
    with h5py.File(path, "r+") as file:
        file.move("ENS_MAA", "kept")
        file["ENS_MAA"] = link
    with pytest.raises(plica.SceneError, match=r"m\.med: /ENS_MAA is a link to elsewhere"):
        read_mesh(given, "scene")


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


def pipe(path: Path) -> Path:
    os.mkfifo(path)
    return path


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("settings.toml", Settings.load),
        ("flow.npz", open_motion),
        ("flow.h5", open_motion),
        ("a.flo", read_flow),
        ("frame.png", read_image),
    ],
)
def test_a_pipe_is_no_input(tmp_path: Path, name: str, read: Callable[[Path], Any]) -> None:
    with pytest.raises(plica.InvalidInput, match=f"{name} is a pipe; must be a file"):
        read(pipe(tmp_path / name))


def test_a_table_of_pressures_is_no_pipe(tmp_path: Path) -> None:
    chosen = Settings(**SETTINGS | {"heights": (1e-3, 2e-3), "drive": pipe(tmp_path / "drive.csv")})
    source = flow_file(tmp_path / "flow.h5")
    with pytest.raises(plica.InvalidInput, match=r"drive\.csv is a pipe; must be a file"):
        identify(source, block_scene(), tmp_path / "out", chosen, progress=False)


def npz(path: Path, **arrays: Any) -> Path:
    np.savez(path, **arrays)
    return path


def rewritten(path: Path, change: Callable[[bytes], bytes]) -> Path:
    path.write_bytes(change(path.read_bytes()))
    return path


def test_an_archive_of_arrays_is_read_to_the_bit(tmp_path: Path) -> None:
    stored = fields()
    found = open_motion(npz(tmp_path / "a.npz", **stored))
    np.testing.assert_array_equal(found.flow(3), stored["flow"][3])
    assert found.fps == stored["fps"]
    np.savez_compressed(tmp_path / "b.npz", flow=np.asfortranarray(stored["flow"]))
    np.testing.assert_array_equal(open_motion(tmp_path / "b.npz").flow(3), stored["flow"][3])


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda p: rewritten(npz(p, flow=FRAMES), lambda b: b[:-40]), "cannot be read as NPZ"),
        (lambda p: rewritten(npz(p, flow=FRAMES), lambda b: b"\x80" * len(b)), "cannot be read as NPZ"),
        (lambda p: rewritten(npz(p, flow=FRAMES), lambda b: b[:400] + b"?" + b[401:]), "CRC-32"),
        (lambda p: npz(p, flow=np.array([{}])), "is no array of numbers"),
        (lambda p: stated(p, (4, 10**9, 10**9, 2)), "has not the size that it states"),
        (lambda p: stated(p, (-4, -20, 24)), "has not the size that it states|cannot be read as NPZ"),
    ],
)
def test_an_archive_that_is_none_or_states_another_size_is_refused(
    tmp_path: Path, make: Callable[[Path], Path], reason: str
) -> None:
    with pytest.raises(plica.InvalidInput, match=reason):
        open_motion(make(tmp_path / "a.npz"))


def stated(path: Path, shape: tuple[int, ...]) -> Path:
    """An archive whose array states a shape that it has not."""
    raw = io.BytesIO()
    header = {"shape": shape, "fortran_order": False, "descr": "|u1"}
    np.lib.format.write_array_header_1_0(raw, header)  # type: ignore[arg-type]
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("flow.npy", raw.getvalue() + FRAMES.tobytes())
    return path


def test_an_archive_that_unpacks_to_more_than_memory_holds_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module_npz, "_MOST", 1000)
    np.savez_compressed(tmp_path / "a.npz", flow=np.zeros((40, 20, 24)))
    with pytest.raises(plica.InvalidInput, match=r"must be at most 1e-06 GB. Store them as HDF5"):
        open_motion(tmp_path / "a.npz")


def tiff(path: Path) -> tuple[bytearray, list[int]]:
    """A stack, and where each of its pages names the next."""
    tifffile.imwrite(path, FRAMES, photometric="minisblack", metadata=None)
    content, places = bytearray(path.read_bytes()), [4]
    while at := int.from_bytes(content[places[-1] : places[-1] + 4], "little"):
        places.append(at + 2 + 12 * int.from_bytes(content[at : at + 2], "little"))
    return content, places


@pytest.mark.parametrize("to", [0, 1, 3])
def test_pages_that_lead_back_are_refused(tmp_path: Path, to: int) -> None:
    path = tmp_path / "a.tif"
    content, places = tiff(path)
    assert len(places) == len(FRAMES) + 1
    content[places[-1] : places[-1] + 4] = content[places[to] : places[to] + 4]
    path.write_bytes(content)
    with pytest.raises(VideoError, match="leads back to one before it"):
        open_source(path)
    with pytest.raises(plica.InvalidInput, match="leads back to one before it"):
        read_image(path)


def test_more_pages_than_a_recording_has_are_refused_before_they_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tiff(tmp_path / "a.tif")
    monkeypatch.setattr(tiff_file, "MOST_FRAMES", 3)
    with pytest.raises(VideoError, match="4 pages or more; must be at most 3"):
        open_source(tmp_path / "a.tif")


@pytest.mark.parametrize("suffix", [".tif", ".avi"])
def test_a_picture_larger_than_any_is_refused_before_it_is_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    path = picture_file(suffix, tmp_path)
    for module in (limits, tiff_file, video_file):
        monkeypatch.setattr(module, "MOST_PIXELS", 1000)
    monkeypatch.setattr(sources, "read_pixels", None)
    with pytest.raises(VideoError, match=r"must (be|have) at most 1000 px"):
        open_source(path)


@pytest.mark.parametrize(
    ("count", "reason"),
    [(1000, r"must have \d+ for the places of the 1000 frames"), (2**32 - 1, "must be at most 1000000")],
)
def test_a_cine_file_that_states_more_frames_than_it_can_hold_is_refused(
    tmp_path: Path, count: int, reason: str
) -> None:
    path = cine(tmp_path / "a.cine", FRAMES)
    content = bytearray(path.read_bytes())
    content[20:24] = count.to_bytes(4, "little")  # ImageCount
    path.write_bytes(content)
    with pytest.raises(VideoError, match=reason):
        open_source(path)


def test_a_photron_header_as_large_as_frames_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = mraw(tmp_path / "a.cih", FRAMES)
    monkeypatch.setattr(photron, "_MOST_HEADER", 100)
    with pytest.raises(VideoError, match=r"a\.cih has \d+ bytes; must be a header of at most 100"):
        open_source(path)
