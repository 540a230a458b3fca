"""The label and the day of a recording: as told, as its file says, in every place where they belong."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from picture_files import encoded
from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import Settings, VideoError, load
from plica.video.files.recording_date import file_date

_OPTIONS = Synthetic(
    height=64, width=64, frames=48, frequency=0.0813, amplitude=(5, 5), opening=(2, 2), highlights=1
)


def film(path: Path, **tags: str) -> Path:
    codec, pixels = ("mjpeg", "yuvj420p") if path.suffix == ".avi" else ("mpeg4", "yuv420p")
    return Path(encoded(path, np.zeros((3, 32, 32, 3), np.uint8), codec, pixels, **tags))


def test_the_day_in_a_file_is_found_with_the_tag_that_names_it(tmp_path: Path) -> None:
    movie = film(tmp_path / "a.mp4", creation_time="2026-03-01T23:59:58.000000Z")
    assert file_date(movie) == ("2026-03-01", "creation_time")
    stack = tmp_path / "a.tif"
    tifffile.imwrite(
        stack, np.zeros((3, 20, 20), np.uint8), photometric="minisblack", datetime="2024:05:06 07:08:09"
    )
    assert file_date(stack) == ("2024-05-06", "DateTime")
    (tmp_path / "frames").mkdir()
    tags = Image.Exif()
    tags.get_ifd(0x8769)[36867] = "2023:01:02 03:04:05"
    tags[306] = "2025:01:02 03:04:05"  # stored anew
    Image.new("L", (20, 20)).save(tmp_path / "frames" / "f_1.png", exif=tags)
    assert file_date(tmp_path / "frames") == ("2023-01-02", "DateTimeOriginal")


@pytest.mark.parametrize(
    "text", ["1904-01-01T00:00:00Z", "1970-01-01T00:00:00Z", "2999-01-01", "2026-02-30", "spring"]
)
def test_a_day_that_no_clock_has_shown_is_none(text: str, tmp_path: Path) -> None:
    movie = film(tmp_path / "a.mkv", creation_time=text)
    assert file_date(movie) is None


def test_what_has_no_day_has_none(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((3, 20, 20)))
    assert file_date(tmp_path / "a.npy") is None
    assert file_date(film(tmp_path / "a.avi")) is None
    (tmp_path / "none").mkdir()
    assert file_date(tmp_path / "none") is None


@pytest.mark.parametrize(
    ("told", "kept"),
    [
        ("20260301", "2026-03-01"),
        ("2026-W09-7", "2026-03-01"),
        ("20260301T103000", "2026-03-01T10:30:00"),
        ("2026-03-01T10:30", "2026-03-01T10:30"),
        ("2026-03-01", "2026-03-01"),
    ],
)
def test_a_day_is_kept_so_that_days_compare_as_text(told: str, kept: str) -> None:
    assert Settings(recorded=told).recorded == kept


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"recorded": "01.03.2026"}, r"recorded = '01.03.2026'; must be a date, year first: 2026-03-01"),
        ({"recorded": "2026-02-30"}, r"must be a date"),
        ({"recorded": ""}, r"must be a date"),
        ({"recorded": 20260301}, r"must be a date"),
        ({"recorded": "2999-03-01"}, r"recorded = 2999-03-01; must not be in the future"),
        ({"label": ""}, r"label = ''; must be one line of text"),
        ({"label": "  "}, r"must be one line of text"),
        ({"label": "a\nb"}, r"must be one line of text"),
        ({"label": 12}, r"label = 12; must be one line of text"),
        ({"label": "x" * 121}, r"has 121 characters; must be 120 or fewer"),
    ],
)
def test_a_label_or_a_day_that_is_none_is_refused(given: dict, said: str) -> None:
    with pytest.raises(VideoError, match=said):
        Settings(**given)


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_label_and_day_are_in_page_and_tables_and_are_kept(tmp_path: Path) -> None:
    stack = SyntheticGlottis(_OPTIONS).stack()
    movie, where = tmp_path / "a.tif", tmp_path / "a"
    tifffile.imwrite(movie, stack, photometric="minisblack", datetime="2024:05:06 07:08:09")
    command = ["glottis", str(movie), "-o", str(where), "--no-drift", "--quiet"]
    assert main(command) == 0
    page = (where / "report.html").read_text(encoding="utf-8")
    assert "<h1>a.tif</h1>" in page
    assert "recorded 2024-05-06 (by the file&#39;s DateTime)" in page
    told = json.loads((where / "measures.json").read_text())["recording"]
    assert set(told) == {"recorded", "recorded_by", "light", "light_reasons"}
    assert (told["recorded"], told["recorded_by"]) == ("2024-05-06", "DateTime")
    assert main([*command, "--label", "patient 12, <before>", "--recorded", "2026-03-01"]) == 0
    assert main(command) == 0  # what was said stays
    found = load(where)
    assert found.described == {"label": "patient 12, <before>", "recorded": "2026-03-01"}
    page = (where / "report.html").read_text(encoding="utf-8")
    assert "<h1>patient 12, &lt;before&gt;</h1>" in page
    assert "a.tif; recorded 2026-03-01;" in page
    assert "--recorded=2026-03-01" in page
    assert set(json.loads((where / "measures.json").read_text())) - {"recording"} == set(found.measures)
    lines = (where / "waveforms.csv").read_text().splitlines()
    assert lines[:2] == ["# label: patient 12, <before>", "# recorded: 2026-03-01"]
    assert lines[2].startswith("time")


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_what_is_not_known_is_not_shown(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", SyntheticGlottis(_OPTIONS).stack())
    assert main(["glottis", str(tmp_path / "a.npy"), "-o", str(tmp_path / "a"), "--no-drift", "--quiet"]) == 0
    assert "recorded" not in (tmp_path / "a" / "report.html").read_text(encoding="utf-8")
    told = json.loads((tmp_path / "a" / "measures.json").read_text())["recording"]
    assert set(told) == {"light", "light_reasons"}
    assert (tmp_path / "a" / "waveforms.csv").read_text().startswith("time")
