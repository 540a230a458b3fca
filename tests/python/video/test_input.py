"""Recordings, settings and result files that would give a wrong answer are refused in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import tifffile

import plica
from picture_files import (
    NAN,
    SHAPE,
    A,
    B,
    cut_pages,
    deep,
    encoded,
    frame,
    one_page_of_many,
    refused,
    stored,
    tiff,
    two_pages,
)
from plica.commands.arguments import joined
from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import Settings, load
from plica.video.errors import VideoError
from plica.video.files.recording import Recording

# ---- Recordings --------------------------------------------------------------------------------


def folder(path: Path, pictures: list[np.ndarray]) -> Path:
    path.mkdir()
    for index, picture in enumerate(pictures):
        stored(path / f"f{index}.png", picture)
    return path


def mixed_folder(path: Path) -> Path:
    return folder(path / "frames", [A, B, deep(A), B])


def mixed_stack(path: Path) -> Path:
    with tifffile.TiffWriter(path / "x.tif") as file:
        for picture in (A, B, deep(A), B):
            file.write(picture, photometric="minisblack")
    return path / "x.tif"


def two_channels(path: Path) -> Path:
    data = np.stack([np.stack([A, B])] * 4)
    return tiff(path / "x.tif", data, imagej=True, metadata={"axes": "TCYX"})


def pages_in_a_folder(path: Path) -> Path:
    made = folder(path / "frames", [A, B, A])
    (made / "f1.png").unlink()
    two_pages(made / "f1.tif")
    return made


def text_in_a_folder(path: Path) -> Path:
    made = folder(path / "frames", [A, B, A])
    (made / "f1.png").write_text("no picture")
    return made


def two_sizes(path: Path) -> Path:
    return folder(path / "frames", [A, B, A[:20]])


def cut_matroska(path: Path) -> Path:
    frames = np.stack([frame(time) for time in range(40)])
    whole, cut = encoded(path / "whole.mkv", frames, "ffv1", "gray"), path / "x.mkv"
    assert Recording.open(whole).count == 40
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    return cut


def saved(path: Path, frames: np.ndarray) -> Path:
    np.save(path / "x.npy", frames)
    return path / "x.npy"


DEPTH = "has 16-bit numbers; must have 8-bit numbers as"
RECORDINGS: dict[str, tuple[Callable[[Path], Path], str]] = {
    "depths in a folder": (mixed_folder, f"frame 2 (f2.png) {DEPTH} f0.png, or its grey levels mean"),
    "depths in a stack": (mixed_stack, f"x.tif: frame 2 {DEPTH} frame 0"),
    "many in one page": (lambda path: one_page_of_many(path / "x.tif"), "holds 3 pictures in 1 page"),
    "channels": (two_channels, "has the axes T = 4, C = 2; must have one, time."),
    "cut stack": (lambda path: cut_pages(path / "x.tif"), "and states more of them. It is cut off"),
    "cut Matroska": (cut_matroska, "s that it states. It is cut off: copy it again"),
    "pages in a folder": (pages_in_a_folder, "f1.tif has 2 frames; must have one."),
    "text in a folder": (text_in_a_folder, "f1.png is not a picture; must be"),
    "two sizes": (two_sizes, "frame 2 (f2.png) is 48 x 20 px; must be 48 x 32 px as f0.png"),
    "one frame": (lambda path: saved(path, A[None]), "has 1 frame; must be two or more"),
    "all alike": (lambda path: saved(path, np.full((4, *SHAPE), 9)), "every pixel is 9; must be an image"),
    "beyond single precision": (
        lambda path: saved(path, np.stack([A, B]) * 1e300),
        "frame 0: pixel (0, 0) is inf; must be finite",
    ),
    "not finite": (lambda path: saved(path, np.stack([A, NAN])), "frame 1: pixel (4, 3) is nan; must be"),
}


@pytest.mark.parametrize("kind", RECORDINGS)
def test_a_recording_that_would_mislead_is_refused_and_leaves_nothing(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, said = RECORDINGS[kind]
    source, out = make(tmp_path), tmp_path / "out"
    for command in ("glottis", "video", "modes"):
        assert said in refused([command, str(source), "-o", str(out), "--quiet"], capsys)
    assert not out.exists()


GLOTTIS = SyntheticGlottis(
    Synthetic(height=64, width=64, frames=24, amplitude=(4, 4), opening=(2, 2), frequency=0.12)
)


@pytest.fixture(scope="module")
def movie(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("movie") / "movie.npy"
    np.save(path, GLOTTIS.stack())
    return path


@pytest.mark.usefixtures("few_draws", "unrendered")
@pytest.mark.parametrize("drift", [[], ["--no-drift"], ["--no-drift", "--rotation", "-3"]])
def test_a_constant_frame_has_no_area_with_the_drift_taken_out_or_not(
    drift: list[str], tmp_path: Path
) -> None:
    frames = GLOTTIS.stack()
    frames[7] = 120
    np.save(tmp_path / "x.npy", frames)
    source = str(tmp_path / "x.npy")
    assert main(["glottis", source, "-o", str(tmp_path / "out"), "--quiet", *drift]) == 0
    area = load(tmp_path / "out").area.total
    assert np.flatnonzero(np.isnan(area)).tolist() == [7]


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_a_light_that_is_not_green_is_said_with_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "x.npy", GLOTTIS.stack()[:12])
    source = str(tmp_path / "x.npy")
    assert main(["glottis", source, "-o", str(tmp_path / "out"), "--quiet", "--no-drift"]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("plica: Caution: the recording's light is red. ")
    assert "No cycles were found" in said.err


# ---- Settings ----------------------------------------------------------------------------------

SETTINGS: dict[str, tuple[list[str], str]] = {
    "region before the frame": (["--region", "-5,0,40,40"], "region = -5, 0, 40, 40 px; must lie within"),
    "region beyond the frame": (["--region", "50,50,40,40"], "must lie within the frames of 64 x 64 px"),
    "place before the midline": (["--kymogram", "-1,0.5"], "kymogram = -1, 0.5; must be places in [0, 1]"),
    "midline of one point": (
        ["--midline", "-5,-5,-5,-5"],
        "ends = (-5.0, -5.0), (-5.0, -5.0) px; must be two",
    ),
    "midline beyond the frame": (
        ["--midline", "28,-400,28,900"],
        "Midline: 28, -400, 28, 900 px; must have its ends within the frames as used (turned and cut), "
        "x in [0, 63] and y in [0, 63]",
    ),
    "turned without end": (["--rotation", "1e9"], "rotation = 1e+09 degrees; must be in [-360, 360]"),
    "no frame rate": (["--fps", "0"], "fps = 0 frames/s; must be > 0 and finite"),
    "frame rate not a number": (["--fps", "nan"], "fps = nan frames/s; must be > 0"),
    "frame rate of nothing": (
        ["--fps", "1e-300"],
        "fps = 1e-300 frames/s; must be in [1, 1e+07]. Is it the rate of the camera",
    ),
    "negative pixel": (["--mm-per-px", "-1"], "mm_per_px = -1 mm a pixel; must be > 0"),
    "pixel in exponents": (["--mm-per-px", "-1e-2"], "mm_per_px = -0.01 mm a pixel; must be > 0"),
    "pixel beyond the earth": (
        ["--mm-per-px", "1e300"],
        "mm_per_px = 1e+300 mm a pixel; must be in [1e-05, 10]",
    ),
    "another preset": (["--preset", "fats"], 'preset = "fats"; must be one of robust'),
    "another end": (["--anterior", "up"], 'anterior = "up"; must be one of upper, lower'),
    "another side": (["--patient-left", "rihgt"], 'must be one of left, right. Did you mean "right"?'),
    "many modes": (["--modes", "100000"], "modes = 100000; must be at most 22 for 24 frames of 64 x 64 px"),
    "a mode too many": (["--modes", "23"], "modes = 23; must be at most 22"),
}


@pytest.mark.parametrize("kind", SETTINGS)
@pytest.mark.parametrize("command", ["glottis", "video", "modes"])
def test_a_setting_that_cannot_be_is_refused_before_anything_is_computed(
    command: str, kind: str, movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options, said = SETTINGS[kind]
    out = tmp_path / "out"
    assert said in refused([command, str(movie), "-o", str(out), *options], capsys)
    assert not out.exists()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"region": (1.5, 0, 40, 40)}, "must be 4 whole numbers"),
        ({"region": (float("inf"), 0, 40, 40)}, "must be 4 whole numbers"),
        ({"midline": "1234"}, "must be 4 numbers"),
        ({"modes": 2.5}, "modes = 2.5; must be a whole number"),
        ({"modes": True}, "modes = True; must be a whole number"),
        ({"modes": "6"}, "modes = '6'; must be a whole number"),
    ],
)
def test_a_setting_of_another_kind_is_not_bent_to_fit(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(VideoError, match=said):
        Settings(**settings)


def test_only_what_begins_with_a_minus_and_a_digit_is_joined_to_its_option() -> None:
    given = ["video", "x", "--region", "-5,0,9,9", "--quiet", "-o", "-1", "--rotation", "-.5", "--fps", "4"]
    assert joined(given) == [
        "video", "x", "--region=-5,0,9,9", "--quiet", "-o", "-1", "--rotation=-.5", "--fps", "4",
    ]  # fmt: skip


# ---- What is in the directory -------------------------------------------------------------------


def cut_results(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["x"] = np.zeros(1000)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def foreign(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["x"] = 1


RESULTS: dict[str, tuple[Callable[[Path], Any], str]] = {
    "text": (
        lambda path: path.write_text("nothing of the kind"),
        "is not an HDF5 file; must be",
    ),
    "no bytes": (lambda path: path.write_bytes(b""), "is not an HDF5 file; must be a result file of plica"),
    "cut": (cut_results, "is damaged or truncated; must be"),
    "of another program": (foreign, "must be"),
}


@pytest.mark.parametrize("kind", RESULTS)
def test_what_is_no_result_file_is_never_said_to_be_kept(
    kind: str, movie: Path, bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, said = RESULTS[kind]
    where, scene = tmp_path / "out", tmp_path / "s.toml"
    where.mkdir()
    bar.save(scene)
    bar.save(where / "scene.toml")
    make(where / "results.h5")
    before = (where / "results.h5").read_bytes()
    for arguments in (
        ["glottis", str(movie), "-o", str(where)],
        ["video", str(movie), "-o", str(where)],
        ["masks", str(where), "-o", str(tmp_path / "drawn")],
        ["report", str(where)],
        ["measures", str(where)],
        ["run", str(scene), "-o", str(where), "--resume"],
    ):
        text = refused(arguments, capsys)
        assert f"{where}/results.h5" in text
        assert said in text
        assert "is kept" not in text
        assert "directory" in text  # what to do
    assert (where / "results.h5").read_bytes() == before


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_a_flow_file_that_is_none_is_refused(
    movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["glottis", str(movie), "-o", str(tmp_path), "--quiet"]) == 0
    capsys.readouterr()
    (tmp_path / "flow.h5").write_text("nothing of the kind")
    said = refused(["video", str(movie), "-o", str(tmp_path), "--quiet"], capsys)
    assert "flow.h5: is not an HDF5 file" in said
