"""The file that the page of corrections saves: what is in it, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plica.video.errors import VideoError
from plica.video.files.corrections import VIEW, read_corrections, runs_of
from plica.video.files.recording import Recording, Region

HEIGHT, WIDTH = 20, 30
NO_MASK = [HEIGHT * WIDTH]


def _content(**changes: Any) -> dict[str, Any]:
    """A whole file; None leaves an entry out."""
    content: dict[str, Any] = {
        "plica_corrections": 1,
        "recording": {"name": "a.npy", "frames": 9, "width": WIDTH, "height": HEIGHT, "grey": ["1", "250"]},
        "view": dict.fromkeys(VIEW) | {"rotation": 0, "correct_drift": True},
        "mm_per_px": 0.05,
    }
    return {name: value for name, value in (content | changes).items() if value is not None}


def _written(path: Path, **changes: Any) -> Path:
    path.write_text(json.dumps(_content(**changes)))
    return path


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "corrections.json"


def test_runs_are_read_as_the_mask_that_they_are_of(file: Path) -> None:
    rng = np.random.default_rng(4)
    masks = [rng.random((HEIGHT, WIDTH)) < share for share in (0.0, 0.1, 0.6, 1.0)]
    read = read_corrections(_written(file, masks={str(k): runs_of(mask) for k, mask in enumerate(masks)}))
    assert sorted(read.masks) == [0, 1, 2, 3]
    for k, mask in enumerate(masks):
        assert read.masks[k].dtype == bool
        assert np.array_equal(read.masks[k], mask)


def test_only_what_was_corrected_is_in_it(file: Path) -> None:
    read = read_corrections(_written(file))
    assert (read.masks, read.midline, read.region) == ({}, None, None)
    assert read.settings == {"mm_per_px": 0.05}
    read = read_corrections(_written(file, mm_per_px=None, midline=[3, 1.5, 4, 18]))
    assert read.settings == {"midline": (3.0, 1.5, 4.0, 18.0)}


@pytest.mark.parametrize("before", [None, [4, 2, WIDTH, HEIGHT]])
@pytest.mark.parametrize("region", [[6, 3, 20, 16], [0, 0, 40, 30]])
def test_masks_and_midline_are_moved_to_another_region(
    before: list[int] | None, region: list[int], file: Path
) -> None:
    """A mark in the turned frame stays where it is, whichever region it is seen in."""
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[9, 12] = mask[10, 11:14] = True
    view = _content()["view"] | {"region": before}
    masks = {"5": runs_of(mask)}
    midline = [12.25, 7, 11.5, 14]
    read = read_corrections(_written(file, masks=masks, midline=midline, region=region, view=view))
    left, top = (before or [0, 0])[:2]
    seen = np.argwhere(read.masks[5]) + region[1::-1]
    assert read.masks[5].shape == (region[3], region[2])
    assert np.array_equal(seen, np.argwhere(mask) + np.array([top, left]))
    assert read.midline is not None
    moved = np.array(read.midline) + 2 * region[:2]
    assert moved == pytest.approx(np.array(midline) + np.array([left, top, left, top]))


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        (b"", "is empty: 0 bytes; must be JSON"),
        (b" \n", "is empty: 2 bytes"),
        (b"GIF89a", "is no JSON"),
        (b'{"plica_corrections": 1', "is no JSON"),
        (b"\xff\xfe\x00", "is no JSON"),
        (b"[" * 100_000, "is no JSON"),
        (b"[1, 2]", "is JSON without plica_corrections"),
        (b'{"masks": {}}', "is JSON without plica_corrections"),
    ],
)
def test_what_no_page_saved_is_refused(raw: bytes, said: str, file: Path) -> None:
    file.write_bytes(raw)
    with pytest.raises(VideoError, match=said) as error:
        read_corrections(file)
    assert str(error.value).startswith("Corrections: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"plica_corrections": 2}, "plica_corrections = 2; must be 1"),
        ({"plica_corrections": "one"}, 'plica_corrections = "one"; must be 1'),
        ({"plica_corrections": True}, "plica_corrections = true; must be 1"),
        ({"mask": {}}, 'has "mask"; must be one of .*Did you mean "masks"?'),
        ({"recording": None}, "recording = null; must have name, frames, width"),
        ({"recording": {"name": "a.npy"}}, 'recording = {"name": "a.npy"}; must have'),
        ({"view": None}, "view = null; must have rotation"),
        ({"mm_per_px": None}, "has no masks, midline, region or mm_per_px; must have one"),
        ({"masks": [1]}, r"masks = \[1\]; must be masks by their frames"),
        ({"masks": {"9": NO_MASK}}, r"mask of frame 9; must be one in \[0, 9\)"),
        ({"masks": {"-1": NO_MASK}}, r"mask of frame -1; must be one in"),
        ({"masks": {"9" * 5000: NO_MASK}}, "must be one in"),
        ({"masks": {"two": NO_MASK}}, "mask of frame two; must be one in"),
        ({"masks": {"2": NO_MASK, "02": NO_MASK}}, "frame 2 has two masks; must have one"),
        ({"masks": {"2": [500]}}, "has 500 pixels; must have 600, of a frame of 30 x 20 px"),
        ({"masks": {"2": [10**30]}}, "must have 600"),
        ({"masks": {"2": [700, -100]}}, "must be numbers of pixels, whole and 0 or more"),
        ({"masks": {"2": [599.5, 0.5]}}, "must be numbers of pixels, whole and 0 or more"),
        ({"masks": {"2": "data:image/png"}}, "must be numbers of pixels"),
        ({"midline": [1, 2, 3]}, r"midline = \[1, 2, 3\]; must be four numbers"),
        ({"midline": [1, 2, 3, float("nan")]}, "must be four numbers"),
        ({"midline": [1, 2, 3, 19.5]}, r"midline = 1, 2, 3, 19.5 px; must have its ends within the frame"),
        ({"midline": [-0.5, 2, 3, 19]}, r"x in \[0, 29\] and y in \[0, 19\]"),
        ({"region": [0, 0, 20.5, 20]}, "region = .*; must be four whole numbers"),
        ({"region": [0, -1, 20, 20]}, "must begin at 0 or more and be at least 16 x 16 px"),
        ({"region": [0, 0, 20, 15]}, "must begin at 0 or more and be at least 16 x 16 px"),
        ({"midline": [1, 2, 3, 19], "region": [2, 0, 20, 20]}, "midline within the region 2, 0, 20, 20 = -1"),
        ({"mm_per_px": 0}, "mm_per_px = 0 mm; must be a number > 0"),
        ({"mm_per_px": -0.1}, "mm_per_px = -0.1 mm; must be a number > 0"),
        ({"mm_per_px": "0.05"}, 'mm_per_px = "0.05" mm; must be a number > 0'),
        ({"mm_per_px": float("inf")}, "must be a number > 0"),
    ],
)
def test_a_wrong_entry_is_refused_with_its_name_and_value(
    changes: dict[str, Any], said: str, file: Path
) -> None:
    with pytest.raises(VideoError, match=said) as error:
        read_corrections(_written(file, **changes))
    text = str(error.value)
    assert text.startswith("Corrections: ")
    assert "corrections.json" in text
    assert "must" in text
    assert len(text) < 400
    assert "\n" not in text


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(VideoError, match="does not exist; must be the file that the page saved"):
        read_corrections(tmp_path / "nowhere.json")
    with pytest.raises(VideoError, match=r"is a folder; must be a file. Masks in a folder are given with"):
        read_corrections(tmp_path)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, None),
        ({"name": "b.npy"}, "is of the recording b.npy; must be of a.npy, the one given"),
        ({"frames": 8}, "with 8 frames; must be of .*a.npy, which has 9 frames"),
        ({"width": 31}, "with frames of 31 x 20 px; must be of .*a.npy, which has frames of 30 x 20 px"),
        ({"height": 21}, "with frames of 30 x 21 px"),
        ({"grey": ["1", "251"]}, "with grey levels 1 to 251; must be of .* 1 to 250"),
    ],
)
def test_corrections_of_another_recording_are_refused(
    changes: dict[str, Any], said: str | None, file: Path, tmp_path: Path
) -> None:
    np.save(tmp_path / "a.npy", np.arange(9 * HEIGHT * WIDTH).reshape(9, HEIGHT, WIDTH) % 256)
    recording = Recording.open(tmp_path / "a.npy", scale=(1.0, 250.0))
    whose = _content()["recording"] | changes
    read = read_corrections(_written(file, recording=whose))
    if said is None:
        read.require(tmp_path / "a.npy", recording)
        return
    with pytest.raises(VideoError, match=said):
        read.require(tmp_path / "a.npy", recording)


def test_corrections_of_another_region_are_of_that_region(file: Path, tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(9 * HEIGHT * WIDTH).reshape(9, HEIGHT, WIDTH) % 256)
    read = read_corrections(_written(file, region=[5, 2, 17, 16]))
    recording = Recording.open(tmp_path / "a.npy", scale=(1.0, 250.0), region=Region(5, 2, 17, 16))
    read.require(tmp_path / "a.npy", recording)
