"""DICOM: every level is there, dark stays dark, rates and days are the file's, bad files are refused."""

from __future__ import annotations

import html
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
import pytest
import tifffile
from pydicom.encaps import encapsulate_extended
from pydicom.uid import (
    HEVCMP51,
    MPEG2MPHL,
    ExplicitVRBigEndian,
    ImplicitVRLittleEndian,
    JPEGBaseline8Bit,
)

from dicom_files import PATIENT, bitstream, dicom, jpeg, jpeg_2000, jpegs, rle, video
from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import Settings, VideoError, analyse, load
from plica.video.files.dicom_items import Item, Joined
from plica.video.files.sources import FrameSource, open_source, read

RANDOM = np.random.default_rng(7)
F = RANDOM.integers(0, 256, (3, 32, 47)).astype(np.uint8)
F[0].flat[:256] = np.arange(256)
DEEP = RANDOM.integers(0, 1 << 16, (44, 32, 48)).astype(np.uint16)
DEEP.flat[: 1 << 16] = np.arange(1 << 16)
COLOURS = RANDOM.integers(0, 256, (3, 32, 46, 3)).astype(np.uint8)
SMOOTH = (np.add.outer(np.arange(64), np.arange(96)) + np.arange(5)[:, None, None]).astype(np.uint8)


def pixels(source: FrameSource) -> np.ndarray:
    return np.stack([frame for _, frame in source.pixels(0, source.count)])


def stored(path: Path) -> np.ndarray:
    return pixels(open_source(path))


# ---- Levels ------------------------------------------------------------------------------------


@pytest.mark.parametrize("write", [dicom, rle, jpeg_2000])
@pytest.mark.parametrize("frames", [F, DEEP], ids=["8 bits", "16 bits"])
def test_every_level_is_that_of_the_source(
    write: Callable[..., Path], frames: np.ndarray, tmp_path: Path
) -> None:
    assert np.unique(frames).size == 1 << (8 * frames.dtype.itemsize)
    found = stored(write(tmp_path / "x.dcm", frames))
    assert found.dtype == frames.dtype
    assert np.array_equal(found, frames)


@pytest.mark.parametrize("syntax", [ImplicitVRLittleEndian, ExplicitVRBigEndian])
def test_every_transfer_syntax_without_compression_gives_the_same(syntax: str, tmp_path: Path) -> None:
    for frames in (F, DEEP, COLOURS):
        assert np.array_equal(stored(dicom(tmp_path / "x.dcm", frames, syntax=syntax)), frames)


def test_bytes_in_the_words_of_a_big_endian_file_are_in_their_order(tmp_path: Path) -> None:
    even = F[:, :, :46]
    swapped = even.reshape(-1, 2)[:, ::-1].tobytes()
    path = dicom(tmp_path / "x.dcm", even, syntax=ExplicitVRBigEndian, data=swapped)
    content = path.read_bytes()
    path.write_bytes(content.replace(b"\x7f\xe0\x00\x10OB", b"\x7f\xe0\x00\x10OW"))
    assert np.array_equal(stored(path), even)
    assert np.array_equal(pydicom.dcmread(path).pixel_array, even)  # a second reader


@pytest.mark.parametrize("planar", [0, 1])
@pytest.mark.parametrize("write", [dicom, rle])
def test_colours_stay_with_their_pixels(write: Callable[..., Path], planar: int, tmp_path: Path) -> None:
    one_by_one = {"data": np.moveaxis(COLOURS, 3, 1).tobytes()} if planar and write is dicom else {}
    path = write(tmp_path / "x.dcm", COLOURS, PlanarConfiguration=planar, **one_by_one)
    assert np.array_equal(stored(path), COLOURS)
    grey = np.stack(list(read(open_source(path), 0, 3)))
    assert grey == pytest.approx(COLOURS @ np.array([0.2989, 0.5870, 0.1140]), abs=1e-3)


def test_luminance_and_colour_difference_become_red_green_and_blue(tmp_path: Path) -> None:
    def converted(differences: np.ndarray) -> np.ndarray:
        y, blue, red = np.moveaxis(differences.astype(float), -1, 0)
        blue, red = blue - 128, red - 128
        rgb = np.stack([y + 1.402 * red, y - 0.344136 * blue - 0.714136 * red, y + 1.772 * blue], axis=-1)
        return np.asarray(np.clip(rgb, 0, 255))

    path = dicom(tmp_path / "x.dcm", COLOURS, PhotometricInterpretation="YBR_FULL")
    assert np.abs(stored(path) - converted(COLOURS)).max() < 1.01  # rounded once
    halved = np.repeat(COLOURS[:, :, ::2, 1:], 2, axis=2)
    full = np.concatenate([COLOURS[..., :1], halved], axis=3)
    pairs = COLOURS.reshape(3, 32, 23, 2, 3)
    data = np.concatenate([pairs[..., 0], pairs[:, :, :, 0, 1:]], axis=3).tobytes()
    path = dicom(tmp_path / "y.dcm", COLOURS, PhotometricInterpretation="YBR_FULL_422", data=data)
    assert np.abs(stored(path) - converted(full)).max() < 1.01


@pytest.mark.parametrize("write", [dicom, rle])
def test_white_that_is_zero_is_turned(write: Callable[..., Path], tmp_path: Path) -> None:
    twelve = DEEP[:3] >> 4
    path = write(tmp_path / "x.dcm", 4095 - twelve, stored=12, PhotometricInterpretation="MONOCHROME1")
    assert np.array_equal(stored(path), twelve)


@pytest.mark.parametrize("high", [11, 13, 15])
def test_twelve_bits_anywhere_in_sixteen_are_the_same_levels(high: int, tmp_path: Path) -> None:
    twelve = DEEP[:3] >> 4
    source = open_source(dicom(tmp_path / "x.dcm", twelve << (high - 11), stored=12, HighBit=high))
    assert np.array_equal(pixels(source), twelve)
    assert source.camera is not None
    assert source.camera.bits == 12


def test_what_is_for_showing_changes_no_level(tmp_path: Path) -> None:
    shown = {"WindowCenter": 40, "WindowWidth": 20, "RescaleSlope": 2, "RescaleIntercept": -1000}
    path = dicom(tmp_path / "x.dcm", F, **shown)
    found = pydicom.dcmread(path)
    for element, kind, value in (
        (0x10, "US", 32),
        (0x11, "US", 47),
        (0x102, "US", 0),
        (0x3000, "OW", b"\xff" * 188),
    ):
        found.add_new(0x60000000 + element, kind, value)
    found.save_as(path)
    assert np.array_equal(stored(path), F)


def test_an_overlay_in_unused_bits_is_no_brightness(tmp_path: Path) -> None:
    twelve = DEEP[:3] >> 4
    path = dicom(tmp_path / "x.dcm", twelve | 0x8000, stored=12)
    with pytest.raises(VideoError, match="frame 0 has bits beyond the 12 that BitsStored and HighBit = 11"):
        stored(path)
    found = pydicom.dcmread(path)
    found.add_new(0x60000100, "US", 16)
    found.add_new(0x60000102, "US", 15)
    found.save_as(path)
    assert np.array_equal(stored(path), twelve)


@pytest.mark.parametrize("table", [True, False])
@pytest.mark.parametrize("pieces", [1, 3])
def test_jpeg_frames_are_found_however_they_are_cut(table: bool, pieces: int, tmp_path: Path) -> None:
    found = stored(jpeg(tmp_path / "x.dcm", SMOOTH, table=table, pieces=pieces))
    assert np.abs(found.astype(int) - SMOOTH).max() < 4
    assert [int(np.median(frame.astype(int) - SMOOTH[0])) for frame in found] == [0, 1, 2, 3, 4]


def test_an_extended_table_of_offsets_is_followed(tmp_path: Path) -> None:
    data, offsets, lengths = encapsulate_extended(jpegs(SMOOTH, quality=95))
    how = {"ExtendedOffsetTable": offsets, "ExtendedOffsetTableLengths": lengths}
    found = stored(dicom(tmp_path / "x.dcm", SMOOTH, syntax=JPEGBaseline8Bit, data=data, **how))
    assert np.abs(found.astype(int) - SMOOTH).max() < 4


def test_colours_of_jpeg_are_red_green_and_blue_also_where_the_file_calls_them_so(tmp_path: Path) -> None:
    colours = np.stack([SMOOTH, 255 - SMOOTH, SMOOTH // 2], axis=-1)
    for kind in ("YBR_FULL_422", "RGB"):  # its own marker says what they are
        found = stored(jpeg(tmp_path / "x.dcm", colours, PhotometricInterpretation=kind))
        assert np.abs(found.astype(int) - colours).mean() < 2


@pytest.mark.parametrize(
    ("codec", "container", "syntax"),
    [
        ("libx264", "mp4", None),
        ("libx264", "mpegts", None),
        ("libx264", "h264", None),
        ("mpeg2video", "mpeg2video", MPEG2MPHL),
        ("libx265", "hevc", HEVCMP51),
    ],
)
@pytest.mark.parametrize("pieces", [1, 4])
def test_a_video_inside_is_read_as_one_in_a_file(
    codec: str, container: str, syntax: str | None, pieces: int, tmp_path: Path
) -> None:
    data = bitstream(SMOOTH, codec, container)
    path = video(tmp_path / "x.dcm", SMOOTH, data, pieces=pieces, **({"syntax": syntax} if syntax else {}))
    found = open_source(path)
    (tmp_path / "x.mkv").write_bytes(data)
    assert np.array_equal(pixels(found), stored(tmp_path / "x.mkv"))
    assert np.abs(pixels(found)[..., 0].astype(int) - SMOOTH).mean() < 3
    assert found.camera is not None
    assert found.camera.date == "2024-03-05"


def test_pieces_of_a_file_are_one_stream_wherever_it_is_read(tmp_path: Path) -> None:
    content = RANDOM.bytes(60_000)
    (tmp_path / "x").write_bytes(content)
    pieces = [Item(100, 30_000), Item(40_000, 0), Item(40_000, 1), Item(50_000, 9_999)]
    whole = b"".join(content[place : place + length] for place, length in pieces)
    with io.BufferedReader(Joined(tmp_path / "x", pieces)) as stream:
        assert stream.read() == whole
        for begin in RANDOM.integers(0, len(whole), 50):
            assert stream.seek(int(begin)) == begin
            assert stream.read(12_000) == whole[begin : begin + 12_000]
        assert stream.seek(-10, io.SEEK_END) == len(whole) - 10
        assert stream.read() == whole[-10:]


def test_frames_are_read_one_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    native = np.frombuffer

    def counted(data: bytes, *rest: Any, **more: Any) -> np.ndarray:
        asked.append(len(data))
        return native(data, *rest, **more)

    source = open_source(dicom(tmp_path / "x.dcm", DEEP))
    monkeypatch.setattr(np, "frombuffer", counted)
    frames = source.pixels(40, 44)
    assert asked == []
    assert np.array_equal(next(frames)[1], DEEP[40])
    assert asked == [32 * 48 * 2]


@pytest.mark.parametrize("name", ["IM0001", "1.2.840.1234", "x.DCM"])
def test_it_is_known_by_its_content(name: str, tmp_path: Path) -> None:
    assert np.array_equal(stored(dicom(tmp_path / name, F)), F)


# ---- Rate, size, day ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("said", "fps", "unused"),
    [
        ({"FrameTime": "0.25"}, 4000, ""),
        ({"CineRate": 2000, "RecommendedDisplayFrameRate": 25}, 2000, ""),
        ({"FrameTimeVector": ["0", "0.5", "0.5"], "CineRate": 30}, 2000, ""),
        ({"FrameTime": "0.256", "CineRate": 3906}, 3906.25, ""),
        ({"RecommendedDisplayFrameRate": 200}, 200, ""),
        ({"FrameTime": "40"}, None, "states 25 frames/s (FrameTime), below 200: taken for the rate at which"),
        ({"CineRate": 199}, None, "states 199 frames/s (CineRate), below 200"),
        ({"FrameTimeVector": ["0", "33", "33"]}, None, "states 30.303 frames/s (FrameTimeVector), below 200"),
        (
            {"FrameTime": "0.25", "CineRate": 2000},
            None,
            "4000 (FrameTime) and 2000 (CineRate) frames/s, which",
        ),
        ({"FrameTime": "1e-6"}, None, "states 1e+09 frames/s (FrameTime), above 1e+06: no camera's"),
        ({"FrameTime": "0"}, None, ""),
        ({}, None, ""),
    ],
)
def test_a_rate_is_the_cameras_where_it_is_that_of_high_speed(
    said: dict[str, Any], fps: float | None, unused: str, tmp_path: Path
) -> None:
    camera = open_source(dicom(tmp_path / "x.dcm", F, **said)).camera
    assert camera is not None
    assert camera.fps == (None if fps is None else pytest.approx(fps, rel=1e-9))
    assert unused in camera.unused.get("fps", "")
    assert bool(camera.unused) == bool(unused)


@pytest.mark.parametrize("keyword", ["PixelSpacing", "ImagerPixelSpacing", "NominalScannedPixelSpacing"])
def test_the_size_of_a_pixel_is_told_and_not_taken(keyword: str, tmp_path: Path) -> None:
    camera = open_source(dicom(tmp_path / "x.dcm", F, **{keyword: ["0.05", "0.05"]})).camera
    assert camera is not None
    assert f"states 0.05 mm/px ({keyword}), not for which distance" in camera.unused["mm_per_px"]


@pytest.mark.parametrize(
    ("said", "day"),
    [
        ({"AcquisitionDateTime": "20240229101500.5+0100", "ContentDate": "20240301"}, "2024-02-29"),
        ({"AcquisitionDateTime": "", "ContentDate": "20240301"}, "2024-03-01"),
        ({"StudyDate": "20240304"}, "2024-03-04"),
        ({"StudyDate": ""}, None),
    ],
)
def test_the_day_is_that_of_the_recording(said: dict[str, str], day: str | None, tmp_path: Path) -> None:
    camera = open_source(dicom(tmp_path / "x.dcm", F, **said)).camera
    assert camera is not None
    assert camera.date == day


# ---- Analyses ----------------------------------------------------------------------------------

GLOTTIS = SyntheticGlottis(
    Synthetic(height=64, width=64, frames=42, amplitude=(4, 4), opening=(2, 2), frequency=0.12, texture=10)
).stack()
GLOTTIS_12 = GLOTTIS.astype(np.uint16) * 16 + (GLOTTIS >> 4)


def _analysed(source: Path, out: Path, *options: str) -> Any:
    assert main(["glottis", str(source), "-o", str(out), "--no-drift", "--quiet", *options]) == 0
    return load(out)


@pytest.mark.usefixtures("few_draws", "unrendered")
@pytest.mark.parametrize("frames", [GLOTTIS, GLOTTIS_12], ids=["8 bits", "12 bits"])
def test_an_analysis_is_that_of_the_same_frames_in_another_file_to_the_bit(
    frames: np.ndarray, tmp_path: Path
) -> None:
    source = dicom(
        tmp_path / "x.dcm", frames, stored=12 if frames.dtype == np.uint16 else 8, FrameTime="0.25"
    )
    np.save(tmp_path / "x.npy", frames)
    tifffile.imwrite(tmp_path / "x.tif", frames, photometric="minisblack")
    found = _analysed(source, tmp_path / "dicom")
    assert found.settings.fps == 4000
    assert found.measures["fundamental_frequency"].value == pytest.approx(480, rel=0.03)
    same = Settings(fps=4000, correct_drift=False)
    for suffix in ("npy", "tif"):
        other = analyse(tmp_path / f"x.{suffix}", tmp_path / suffix, same, until="glottis", progress=False)
        for name in ("glottis/mask", "glottis/coverage", "sides/left", "sides/right", "sides/kymogram"):
            assert np.array_equal(found[name], other[name], equal_nan=True), name
        assert {name: item.value for name, item in found.measures.items()} == {
            name: item.value for name, item in other.measures.items()
        }


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_a_rate_of_playing_is_shown_with_a_caution_and_not_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = dicom(tmp_path / "x.dcm", GLOTTIS, CineRate=30, PixelSpacing=["0.05", "0.05"])
    found = _analysed(source, tmp_path / "out")
    assert found.settings.fps is None
    assert found.settings.mm_per_px is None
    said = capsys.readouterr().err
    page = html.unescape((tmp_path / "out" / "report.html").read_text())
    for text in (
        "the file states 30 frames/s (CineRate), below 200",
        "the file states 0.05 mm/px (PixelSpacing)",
    ):
        assert text in said
        assert text in page
    assert "Give --fps" in said
    assert "Give --mm-per-px" in said
    found = _analysed(source, tmp_path / "out", "--fps", "2000", "--mm-per-px", "0.1")
    assert (found.settings.fps, found.settings.mm_per_px) == (2000, 0.1)
    assert "the file states" not in capsys.readouterr().err


@pytest.mark.usefixtures("few_draws")
def test_nobody_is_named_in_what_an_analysis_writes(tmp_path: Path) -> None:
    source = dicom(tmp_path / "x.dcm", GLOTTIS, FrameTime="0.25")
    out = tmp_path / "out"
    _analysed(source, out, "--xlsx", "--matlab", "--praat")
    words = [*PATIENT.values(), "Müller", "Änne", "Weiß", "A77", "1.2.826.0.1.3680043.8.498.1"]
    files = [path for path in out.rglob("*") if path.is_file()]
    assert len(files) > 8
    for path in files:
        content = path.read_bytes()
        for word in words:
            assert word.encode("utf-8") not in content, (path.name, word)
            assert word.encode("latin-1") not in content, (path.name, word)
