"""A recording corrected on a page: what the page is told, what comes of what it saves. Without a browser."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from conftest import MOVIE
from corrected_pages import page_content, saved, unpacked
from plica.commands.main import main
from plica.synthetic.glottis import SyntheticGlottis
from plica.video.analysis import analyse, load
from plica.video.errors import VideoError
from plica.video.files.corrections import read_corrections
from plica.video.report import corrections_page
from plica.video.results import _CHANGES
from plica.video.settings import Settings

pytestmark = pytest.mark.usefixtures("few_draws", "unrendered")


@pytest.fixture(scope="module")
def analysed(movie: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A recording with its glottis found, and its page; tests that change them take a copy."""
    where = tmp_path_factory.mktemp("corrected")
    assert main(["glottis", str(movie), "-o", str(where / "a"), "--fps", "4000", "--quiet"]) == 0
    page = where / "correct.html"
    assert main(["masks", str(where / "a"), "--page", str(page), "--frames", "3,40", "--quiet"]) == 0
    return where / "a", page


@pytest.fixture
def copy(analysed: tuple[Path, Path], tmp_path: Path) -> tuple[Path, Path]:
    shutil.copytree(analysed[0], tmp_path / "a")
    return tmp_path / "a", analysed[1]


def _glottis(movie: Path, directory: Path, *arguments: object) -> int:
    return main(["glottis", str(movie), "-o", str(directory), "--quiet", *map(str, arguments)])


def test_the_page_has_frames_masks_and_midline_of_the_analysis(analysed: tuple[Path, Path]) -> None:
    directory, page = analysed
    found, told = load(directory), page_content(page)
    widest = int(np.nanargmax(found.area.total))
    assert [frame["number"] for frame in told["frames"]] == sorted({3, 40, widest})
    for frame in told["frames"]:
        assert np.array_equal(unpacked(frame["mask"], told), found.mask(frame["number"]))
        assert not frame["drawn"]
    assert told["midline"] == pytest.approx(found.midline.ends, abs=0.005)
    assert told["recording"]["frames"] == 66
    assert (told["recording"]["height"], told["recording"]["width"]) == (95, 97)


def test_the_page_fetches_nothing(analysed: tuple[Path, Path]) -> None:
    text = analysed[1].read_text(encoding="utf-8")
    pictures = len(page_content(analysed[1])["frames"]) + 1  # and the whole first frame
    assert text.count("data:image/png;base64,") == pictures
    alone = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "", text)
    assert not re.search(r"https?:|src=|href=|import ", alone)


def test_a_page_takes_the_name_of_no_recording(analysed: tuple[Path, Path], tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=r"Masks: page = .*larynx.avi; must end in .html"):
        corrections_page.write_corrections_page(load(analysed[0]), [3], tmp_path / "larynx.avi")


def test_the_page_knows_which_settings_a_directory_keeps() -> None:
    assert set(corrections_page._KEPT) == set(_CHANGES)


def test_masks_midline_and_scale_arrive_in_the_analysis(copy: tuple[Path, Path], movie: Path) -> None:
    directory, page = copy
    glottis = SyntheticGlottis(MOVIE)
    masks = {3: glottis.mask(3), 40: np.roll(glottis.mask(40), 1, axis=1)}
    line = load(directory).midline.ends + np.array([0.5, 0, 0.5, 0])
    file = saved(page, directory / "c.json", masks=masks, midline=line.tolist(), mm_per_px=0.05)
    for _ in range(2):  # the second time nothing changes
        assert _glottis(movie, directory, "--corrections", file) == 0
        found = load(directory)
        assert found.drawn == [3, 40]
        for frame, mask in masks.items():
            assert np.array_equal(found.mask(frame), mask)
            assert found.area.total[frame] == pytest.approx(mask.sum())
        assert found.midline.ends == pytest.approx(line)
        assert found.settings.mm_per_px == 0.05
        assert found.settings.fps == 4000
        assert found.measures["glottal_area_max"].unit == "m^2"
    assert main(["masks", str(directory), "--page", str(directory / "again.html"), "--quiet"]) == 0
    again = page_content(directory / "again.html")
    assert [frame["number"] for frame in again["frames"] if frame["drawn"]] == [3, 40]
    assert again["mm_per_px"] == 0.05


def test_a_midline_that_is_dragged_moves_area_from_one_side_to_the_other(
    copy: tuple[Path, Path], movie: Path
) -> None:
    """By 4 px, as by one: beside the line in which the folds meet it is not drawn back to that."""
    directory, page = copy
    found = load(directory)
    line, area, amplitude = found.midline, found.area, found.measures["amplitude_left"].value
    for by in (1, 4):
        ends = (line.ends + np.array([by, 0, by, 0])).tolist()
        file = saved(page, directory / "c.json", midline=ends)
        assert _glottis(movie, directory, "--corrections", file) == 0
        found = load(directory)
        assert not found.midline.bow
        assert (found.area.left - area.left).max() > 0.6 * by * line.length
        assert found.area.total == pytest.approx(area.total)
        assert found.measures["amplitude_left"].value == pytest.approx(amplitude, abs=0.1)


def test_only_a_scale_keeps_the_masks_that_were_drawn(copy: tuple[Path, Path], movie: Path) -> None:
    directory, page = copy
    mask = {3: SyntheticGlottis(MOVIE).mask(3)}
    assert _glottis(movie, directory, "--corrections", saved(page, directory / "c.json", masks=mask)) == 0
    scale = saved(page, directory / "c.json", mm_per_px=0.04)
    assert _glottis(movie, directory, "--corrections", scale) == 0
    assert load(directory).drawn == [3]
    assert load(directory).settings.mm_per_px == 0.04


def test_another_region_takes_another_directory(
    copy: tuple[Path, Path], movie: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    directory, page = copy
    x, y, width, height = region = [10, 6, 80, 84]
    mask = SyntheticGlottis(MOVIE).mask(3)
    file = saved(page, directory / "c.json", masks={3: mask}, region=region)
    before = (directory / "results.h5").read_bytes()
    assert _glottis(movie, directory, "--corrections", file) == 2
    error = capsys.readouterr().err
    assert "region is 10,6,80,84; must be not given, as in the analysis" in error
    assert "Choose another directory" in error
    assert (directory / "results.h5").read_bytes() == before
    other = directory.parent / "a_region"
    assert _glottis(movie, other, "--corrections", file) == 0
    assert np.array_equal(load(other).mask(3), mask[y : y + height, x : x + width])


def test_a_midline_may_come_with_the_masks_that_make_it_right(
    copy: tuple[Path, Path], movie: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All that was found lies to one side of the line; the masks that say so come with it."""
    directory, page = copy
    ends = load(directory).midline.ends + np.array([22, 0, 22, 0])
    alone = saved(page, directory / "c.json", midline=ends.tolist())
    before = (directory / "results.h5").read_bytes()
    assert _glottis(movie, directory, "--corrections", alone) == 2
    assert "must have glottis on both of its sides" in capsys.readouterr().err
    assert (directory / "results.h5").read_bytes() == before
    moved = np.roll(SyntheticGlottis(MOVIE).mask(3), 22, axis=1)
    moved |= SyntheticGlottis(MOVIE).mask(3)
    file = saved(page, directory / "c.json", midline=ends.tolist(), masks={3: moved})
    assert _glottis(movie, directory, "--corrections", file) == 0
    assert load(directory).midline.ends == pytest.approx(ends, abs=0.01)


def test_masks_that_tell_nothing_change_nothing(
    copy: tuple[Path, Path], movie: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor does the midline beside them, which alone would be taken."""
    directory, page = copy
    line = load(directory).midline.ends + np.array([0.5, 0, 0.5, 0])
    tissue = np.zeros((95, 97), bool)
    tissue[5:20, 5:20] = True
    file = saved(page, directory / "c.json", masks={3: tissue}, midline=line.tolist())
    before = (directory / "results.h5").read_bytes()
    assert _glottis(movie, directory, "--corrections", file) == 2
    assert "Masks: what is drawn" in capsys.readouterr().err
    assert (directory / "results.h5").read_bytes() == before


@pytest.mark.parametrize(
    ("corrected", "arguments", "said"),
    [
        ({"midline": [48, 10, 48, 80]}, ["--midline", "47,10,47,80"], "Leave --midline out"),
        ({"mm_per_px": 0.05}, ["--mm-per-px", "0.04"], "mm_per_px = 0.05, and 0.04 is given"),
        ({"region": [0, 0, 90, 90]}, ["--region", "0,0,80,80"], "region = 0, 0, 90, 90, and 0, 0, 80, 80 is"),
        ({"mm_per_px": 0.05}, ["--masks", "drawn"], "--masks: not allowed with argument --corrections"),
        ({"mm_per_px": 0.05}, ["--no-masks"], "--no-masks: not allowed with argument --corrections"),
        (
            {"mm_per_px": 0.05},
            ["--rotation", "4"],
            "drawn on frames with rotation = 0.0; must be 4.0, as given",
        ),
        ({"mm_per_px": 0.05}, ["--from", "2"], "drawn on frames with first = not given; must be 2, as given"),
        (
            {"mm_per_px": 0.05},
            ["--region", "0,0,80,80"],
            "region = not given; must be 0, 0, 80, 80, as given",
        ),
        (
            {"mm_per_px": 50},
            [],
            "mm_per_px = 50 mm a pixel; must be in [1e-05, 10]. Is it the size of one pixel, in mm?",
        ),
        (
            {"region": [20, 0, 90, 90]},
            [],
            "region = 20, 0, 90, 90 px; must lie within the frames of 97 x 95 px",
        ),
        ({"midline": [10, 50, 90, 60]}, [], "Midline: it runs 83 degrees from the vertical"),
    ],
)
def test_what_contradicts_the_options_is_refused(
    corrected: dict[str, Any],
    arguments: list[str],
    said: str,
    copy: tuple[Path, Path],
    movie: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    directory, page = copy
    file = saved(page, directory / "c.json", **corrected)
    before = (directory / "results.h5").read_bytes()
    code = _code(lambda: _glottis(movie, directory, "--corrections", file, *arguments))
    assert code == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.startswith("plica: ") or "usage" in error
    assert (directory / "results.h5").read_bytes() == before


def test_corrections_of_another_recording_change_nothing(
    copy: tuple[Path, Path], movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    directory, page = copy
    file = saved(page, directory / "c.json", mm_per_px=0.05)
    other = tmp_path / "other" / movie.name  # the camera calls all of its recordings alike
    other.parent.mkdir()
    np.save(other, np.clip(np.load(movie) * 0.9, 0, 255))
    before = (directory / "results.h5").read_bytes()
    assert _glottis(other, directory, "--corrections", file) == 2
    assert "with grey levels" in capsys.readouterr().err
    assert (directory / "results.h5").read_bytes() == before
    shutil.copy(movie, tmp_path / "renamed.npy")
    assert _glottis(tmp_path / "renamed.npy", directory, "--corrections", file) == 2
    assert "is of the recording glottis.npy; must be of renamed.npy" in capsys.readouterr().err
    assert main(["glottis", str(movie), str(other), "-o", str(tmp_path), "--corrections", str(file)]) == 2
    assert "for 2 recordings; must be for one" in capsys.readouterr().err


def test_python_takes_corrections_as_masks(copy: tuple[Path, Path], movie: Path) -> None:
    directory, page = copy
    mask = SyntheticGlottis(MOVIE).mask(3)
    read = read_corrections(saved(page, directory / "c.json", masks={3: mask}, mm_per_px=0.05))
    found = analyse(movie, directory, Settings(), masks=read, until="glottis", progress=False)
    assert found.settings.mm_per_px == 0.05
    assert np.array_equal(found.mask(3), mask)


@pytest.mark.slow
def test_a_scale_leaves_the_motion_and_a_mask_has_it_found_again(
    done: Path, movie: Path, tmp_path: Path
) -> None:
    directory = tmp_path / "a"
    shutil.copytree(done, directory)
    page = tmp_path / "correct.html"
    assert main(["masks", str(directory), "--page", str(page), "--frames", "3", "--quiet"]) == 0
    told = page_content(page)
    assert told["command"] == f"plica video {movie}"
    assert [option["word"] for option in told["options"] if not option["kept"]] == ["--preset=fast"]
    before = load(directory)["flow/uv"]
    scale = saved(page, tmp_path / "c.json", mm_per_px=0.04)
    command = ["video", str(movie), "-o", str(directory), "--preset", "fast", "--quiet", "--corrections"]
    assert main([*command, str(scale)]) == 0
    assert np.array_equal(load(directory)["flow/uv"], before)
    assert load(directory).settings.mm_per_px == 0.04
    mask = load(directory).mask(3)
    trip = load(directory).round_trip(3)
    mask[:, 1:] |= mask[:, :-1]
    seen = ~ndimage.binary_dilation(mask, iterations=2)  # nothing is said of motion beside the glottis
    assert main([*command, str(saved(page, tmp_path / "c.json", masks={3: mask}))]) == 0
    found = load(directory)
    assert np.array_equal(found.mask(3), mask)
    assert found.complete
    assert np.array_equal(np.isnan(found.round_trip(3)[..., 0]), np.isnan(trip[..., 0]) | ~seen)
    assert seen[mask].sum() == 0


def test_where_nothing_was_found_a_page_is_drawn_on_all_the_same(tmp_path: Path) -> None:
    glottis = SyntheticGlottis(MOVIE)
    stack = np.stack([np.where(glottis.mask(t), 118, frame) for t, frame in enumerate(glottis.frames())])
    np.save(tmp_path / "faint.npy", stack)
    assert _glottis(tmp_path / "faint.npy", tmp_path / "a", "--no-drift") == 2
    page = tmp_path / "correct.html"
    assert main(["masks", str(tmp_path / "a"), "--page", str(page), "--quiet"]) == 0
    told = page_content(page)
    assert told["midline"] is None
    assert [option["word"] for option in told["options"]] == ["--no-drift"]
    wide = int(np.argmax([sum(glottis.area(t)) for t in range(20)]))
    file = saved(page, tmp_path / "c.json", masks={wide: glottis.mask(wide)})
    _glottis(tmp_path / "faint.npy", tmp_path / "a", "--no-drift", "--corrections", file)
    assert np.array_equal(load(tmp_path / "a", needs="glottis").mask(wide), glottis.mask(wide))
    assert json.loads(file.read_text())["view"]["correct_drift"] is False


def _code(run: Callable[[], int]) -> int:
    """The exit code, by return or by the parser's exit."""
    try:
        return run()
    except SystemExit as stop:
        return int(str(stop.code))
