"""Recordings: every format gives the same frames, every bad one a sentence that names what is wrong."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import tifffile
from PIL import Image
from scipy import ndimage

import plica
from picture_files import encoded
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.errors import VideoError
from plica.video.files.recording import Recording, Region
from plica.video.files.sources import read


def movie(frames: int = 6, height: int = 32, width: int = 48) -> np.ndarray:
    y, x = np.mgrid[0:height, 0:width]
    t = np.arange(frames)[:, None, None]
    return (127 + 100 * np.sin(0.2 * x + 0.3 * t) * np.cos(0.15 * y)).astype(np.uint8)


def store(directory: Path, kind: str, frames: np.ndarray) -> Path:
    path = directory / f"movie.{kind}"
    if kind == "npy":
        np.save(path, frames)
    elif kind == "tif":
        tifffile.imwrite(path, frames, photometric="minisblack")
    elif kind == "h5":
        with h5py.File(path, "w") as file:
            file["camera/frames"] = frames
            file["camera/time"] = np.arange(len(frames))
    elif kind == "mat":
        with h5py.File(path, "w") as file:
            file["video"] = frames.swapaxes(1, 2)  # MATLAB's (height, width, frames)
    elif kind == "folder":
        path.mkdir()
        for index, frame in enumerate(frames):
            Image.fromarray(frame).save(path / f"frame{index}.png")  # 2 sorts before 10
    else:
        encoded(path, frames, "ffv1", "gray")
    return path


@pytest.mark.parametrize("kind", ["npy", "tif", "h5", "mat", "folder", "mkv", "avi"])
def test_every_lossless_format_gives_the_same_frames(kind: str, tmp_path: Path) -> None:
    frames = movie(12)
    expected = Recording.open(store(tmp_path, "npy", frames))
    found = Recording.open(store(tmp_path, kind, frames) if kind != "npy" else tmp_path / "movie.npy")
    assert (found.count, found.shape) == (12, (32, 48))
    assert found.scale == expected.scale
    for one, other in zip(found.frames(), expected.frames(), strict=True):
        assert np.array_equal(one, other)
    assert np.array_equal(found.frame(-1), found.frame(11))


def test_colour_is_weighted_and_not_rounded(tmp_path: Path) -> None:
    colours = np.random.default_rng(1).integers(0, 256, (3, 20, 20, 3), dtype=np.uint8)
    np.save(tmp_path / "c.npy", colours)
    found = Recording.open(tmp_path / "c.npy")
    grey = colours @ np.array([0.2989, 0.5870, 0.1140])
    raw = next(read(found.source, 1, 2))
    assert raw == pytest.approx(grey[1], abs=1e-4)


def test_one_scale_holds_for_the_whole_recording(tmp_path: Path) -> None:
    frames = movie().astype(np.uint16) * 16  # twelve bits
    frames[3] = frames[3] // 2
    frames[0, 0, 0] = 65535  # a highlight sets nothing
    np.save(tmp_path / "f.npy", frames)
    found = Recording.open(tmp_path / "f.npy")
    low, high = np.percentile(frames, [0.5, 99.5])
    assert found.scale == (pytest.approx(low, abs=32), pytest.approx(high, abs=32))
    assert found.frame(3).mean() < 0.6 * found.frame(2).mean()
    assert found.frame(0)[0, 0] > 255


def test_region_and_rotation_cut_and_turn_the_frames(tmp_path: Path) -> None:
    path = store(tmp_path, "npy", movie(3, 64, 64))
    whole = Recording.open(path)
    part = Recording.open(path, region=Region(8, 16, 20, 40))
    assert part.shape == (40, 20)
    assert np.array_equal(part.frame(1), whole.frame(1)[16:56, 8:28])
    turned = Recording.open(path, rotation=90)
    assert turned.frame(0) == pytest.approx(np.rot90(whole.frame(0)), abs=1e-2)


def broken(directory: Path, kind: str) -> Path | None:
    """A recording with this fault."""
    frames, path = movie(), directory / "bad"
    match kind:
        case "missing":
            return directory / "none.avi"
        case "empty file":
            path = directory / "bad.mp4"
            path.write_bytes(b"")
        case "not a video":
            path = directory / "bad.avi"
            path.write_text("no video")
        case "unknown suffix":
            path = directory / "bad.xyz"
            path.write_text("?")
        case "cut off":
            whole = encoded(directory / "whole.avi", movie(40), "mjpeg", "yuvj420p")
            path = directory / "bad.avi"
            path.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
        case "one image":
            path = directory / "bad.png"
            Image.fromarray(frames[0]).save(path)
        case "empty folder":
            path.mkdir()
        case "one frame":
            path = store(directory, "npy", frames[:1])
        case "sizes differ":
            path = store(directory, "folder", frames)
            Image.fromarray(frames[0][:20]).save(path / "frame3.png")
        case "broken image":
            path = store(directory, "folder", frames)
            (path / "frame4.png").write_text("no image")
        case "NaN":
            some = frames.astype(float)
            some[2, 5, 7] = np.nan
            path = store(directory, "h5", some)
        case "frame missing":
            path = store(directory, "folder", frames)
            (path / "frame2.png").unlink()
        case "two datasets":
            path = store(directory, "h5", frames)
            with h5py.File(path, "a") as file:
                file["other"] = frames
        case "no dataset":
            path = directory / "bad.h5"
            with h5py.File(path, "w") as file:
                file["time"] = np.arange(3)
        case "not HDF5":
            path = directory / "bad.h5"
            path.write_text("no")
        case "not NumPy":
            path = directory / "bad.npy"
            path.write_text("no")
        case "four channels":
            path = store(directory, "npy", np.zeros((3, 20, 20, 2)))
        case "text":
            path = store(directory, "npy", np.full((3, 20, 20), "a"))
        case "tiny":
            path = store(directory, "npy", frames[:, :4, :4])
        case "zeros":
            path = store(directory, "npy", np.zeros_like(frames))
        case "saturated":
            some = np.full((4, 100, 100), 255, np.uint8)
            some[0, 0, 0] = 0
            path = store(directory, "npy", some)
        case "cut TIFF":
            whole = store(directory, "tif", frames)
            path = directory / "bad.tif"
            path.write_bytes(whole.read_bytes()[:200])
    return path


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("missing", "none.avi does not exist"),
        ("empty file", "is empty: 0 bytes"),
        ("not a video", "cannot be read as a video"),
        ("unknown suffix", "must be a folder of images or end in one of"),
        ("cut off", r"frame \d+ cannot be decoded|ends after \d+ frames; must have the 40"),
        ("one image", "is one image; must be two frames or more. Give its folder"),
        ("empty folder", "has no images; must have some of"),
        ("one frame", "has 1 frame; must be two or more"),
        ("sizes differ", r"frame 3 \(frame3.png\) is 48 x 20 px; must be 48 x 32 px as frame0.png"),
        ("broken image", "frame4.png is not a picture"),
        ("NaN", r"camera/frames: frame 2: pixel \(7, 5\) is nan; must be finite"),
        ("frame missing", "go from frame1.png to frame3.png; must be equally spaced"),
        ("two datasets", "2 datasets that can be frames: camera/frames, other; must be one"),
        ("no dataset", "0 datasets that can be frames; must be one"),
        ("not HDF5", "is not an HDF5 file"),
        ("not NumPy", "cannot be read as a NumPy array"),
        ("four channels", r"has shape \(3, 20, 20, 2\); must be \(frames, height, width\)"),
        ("text", "holds <U1; must be numbers"),
        ("tiny", "frames of 4 x 4 px; must be 16 x 16 px or more"),
        ("zeros", "every pixel is 0; must be an image"),
        ("saturated", "99 % of all pixels lie between"),
        ("cut TIFF", "ends after page 1 and states more of them. It is cut off"),
    ],
)
def test_a_bad_recording_is_one_sentence(kind: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=said) as caught:
        Recording.open(broken(tmp_path, kind))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"rotation": float("inf")}, "rotation = inf degrees; must be finite"),
        ({"scale": (200.0, 20.0)}, r"scale = \(200, 20\); must be two finite numbers, the lower one first"),
        ({"region": Region(30, 0, 30, 20)}, "must lie within the frames of 48 x 32 px"),
        ({"region": Region(0, 0, 8, 20)}, "must be at least 16 x 16 px"),
    ],
)
def test_a_bad_setting_is_one_sentence(settings: dict, said: str, tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=said):
        Recording.open(store(tmp_path, "npy", movie()), **settings)
    with pytest.raises(VideoError, match=r'dataset = "of" for movie\.npy; must be left out'):
        Recording.open(store(tmp_path, "npy", movie()), dataset="of")
    with pytest.raises(VideoError, match='no frames "of"; must be one of camera/frames'):
        Recording.open(store(tmp_path, "h5", movie()), dataset="of")


def test_memory_does_not_grow_with_the_frames(tmp_path: Path) -> None:
    import tracemalloc

    peaks = []
    for count in (20, 200):
        path = tmp_path / f"{count}.npy"
        np.save(path, np.tile(movie(20, 64, 64), (count // 20, 1, 1)))
        tracemalloc.start()
        for _ in Recording.open(path).frames():
            pass
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.5 * peaks[0]


@pytest.mark.slow
def test_blocks_of_a_compressed_video_leave_no_pattern_in_the_flow(tmp_path: Path) -> None:
    """MJPEG, which codes blocks of 8 x 8 px alone: the flow's error is the same in each column of a block."""
    glottis = SyntheticGlottis(
        Synthetic(height=160, width=160, frames=8, amplitude=(6, 6), opening=(3, 3), highlights=0)
    )
    frames = list(Recording.open(encoded(tmp_path / "m.avi", glottis.stack(), "mjpeg", "yuvj420p")).frames())
    error = np.zeros(8)
    for t in range(0, 7, 2):
        found = plica.flow(frames[t], frames[t + 1], preset="video", intensity=(0.0, 255.0)).flow
        truth, known = glottis.flow(t, t + 1)
        known &= ~ndimage.binary_dilation(glottis.mask(t) | glottis.mask(t + 1), iterations=6)
        known[:, :8] = known[:, -8:] = False
        distance = np.hypot(*np.moveaxis(found - truth, -1, 0))
        error += [distance[:, column::8][known[:, column::8]].mean() for column in range(8)]
    assert np.ptp(error) < 0.1 * error.mean()


def test_video_of_more_than_eight_bits_keeps_them(tmp_path: Path) -> None:
    frames = (movie(4).astype(np.uint16) * 100) + np.arange(4, dtype=np.uint16)[:, None, None]
    path = encoded(tmp_path / "deep.mkv", frames, "ffv1", "gray16le")
    raw = list(read(Recording.open(path).source, 0, 4))
    assert all(np.array_equal(one, other) for one, other in zip(raw, frames, strict=True))
