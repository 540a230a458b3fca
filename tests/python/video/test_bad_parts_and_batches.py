"""Parts of a recording and batches of recordings that cannot be: what is said, and what is kept."""

from __future__ import annotations

import contextlib
import csv
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from plica.commands.main import main
from plica.commands.recordings import analyse_each
from plica.synthetic.glottis import Synthetic, SyntheticGlottis

pytestmark = pytest.mark.usefixtures("few_draws", "unrendered")

_STACK = SyntheticGlottis(
    Synthetic(height=64, width=56, frames=30, frequency=0.1, amplitude=(6, 5), opening=(3, 2))
).stack()


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two recordings of thirty frames, and files that are none."""
    monkeypatch.chdir(tmp_path)
    for folder in ("x", "y", "empty"):
        Path(folder).mkdir()
    for name in ("a", "c", "x/b", "y/b"):
        np.save(f"{name}.npy", _STACK)
    Path("words.npy").write_text("hello")
    Path("nothing.npy").write_bytes(b"")
    Path("list.txt").write_text("a.npy")
    np.save("one.npy", _STACK[:1])
    np.save("flat.npy", _STACK[0])
    np.save("four.npy", _STACK[None])
    holes = _STACK.astype(float)
    holes[3, 5, 7] = np.nan
    np.save("holes.npy", holes)
    return tmp_path


def _run(*arguments: str) -> int:
    try:
        return main(["glottis", *arguments, "--no-drift", "--quiet"])
    except SystemExit as stop:
        return int(str(stop.code))


_PART = [
    (["--from", "-1"], "first = -1; must be the number of a frame, 0 or more"),
    (["--from", "30"], "frames 30 to 29; must be two or more, in [0, 29]: a.npy has 30 frames"),
    (["--from", "29"], "frames 29 to 29; must be two or more"),
    (["--from", "1000000000000"], "frames 1000000000000 to 29; must be two or more"),
    (["--to", "30"], "frames 0 to 30; must be two or more, in [0, 29]"),
    (["--from", "5", "--to", "1000"], "frames 5 to 1000; must be two or more, in [0, 29]"),
    (["--to", "0"], "argument --to: 0; must be a whole number from 1"),
    (["--to", "-1"], "argument --to: -1; must be a whole number from 1"),
    (
        ["--from", "10", "--to", "9"],
        "first = 10, last = 9 (--from, --to); the last must come after the first",
    ),
    (["--from", "5", "--to", "5"], "first = 5, last = 5 (--from, --to); the last must come after the first"),
    (["--from", "-3", "--to", "9"], "first = -3; must be the number of a frame, 0 or more"),
    (["--from", "1.5"], "argument --from: 1.5; must be a whole number"),
    (["--to", "2.0"], "argument --to: 2.0; must be a whole number"),
    (["--from", "second"], "argument --from: second; must be a whole number"),
    (["--from", "nan"], "argument --from: nan; must be a whole number"),
    (["--to", "inf"], "argument --to: inf; must be a whole number"),
    (["--from", ""], "argument --from: ; must be a whole number"),
    (["--from", "1e3"], "argument --from: 1e3; must be a whole number"),
    (["--from", "0:9"], "argument --from: 0:9; must be a whole number"),
    (["--to"], "argument --to: expected one argument"),
    (["--from", "5", "--masks", "nowhere"], "nowhere is no folder; must be one with mask_N.png in it"),
    (["--from", "28", "--to", "29"], "no frame has a glottis; must have one"),
]


@pytest.mark.parametrize(("part", "sentence"), _PART, ids=[" ".join(part) for part, _ in _PART])
def test_a_part_that_cannot_be_is_one_error(
    here: Path, capsys: pytest.CaptureFixture[str], part: list[str], sentence: str
) -> None:
    assert _run("a.npy", "-o", "out", *part) == 2
    assert sentence in capsys.readouterr().err.splitlines()[-1]


def test_another_part_is_not_analysed_into_the_results_of_one(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _run("a.npy", "-o", "out", "--from", "3") == 0
    before = (here / "out" / "results.h5").read_bytes()
    capsys.readouterr()
    assert _run("a.npy", "-o", "out", "--from", "4") == 2
    assert "first" in capsys.readouterr().err
    assert (here / "out" / "results.h5").read_bytes() == before


_REFUSED = [
    (["x/b.npy", "y/b.npy"], "b.npy; must be the only recording called b.npy"),
    (["a.npy", "a.npy"], "a.npy; must be the only recording called a.npy"),
    (["a.npy", "./a.npy"], "must be the only recording called a.npy"),
    (["a.npy", "c.npy", "--masks", "x"], "Masks: x for 2 recordings; must be for one"),
    (["a.npy", "c.npy", "--corrections", "list.txt"], "list.txt for 2 recordings; must be for one"),
    (["a.npy", "c.npy", "--from", "5", "--to", "4"], "the last must come after the first"),
    (["--table"], "the following arguments are required: FILE"),
]


@pytest.mark.parametrize(
    ("given", "sentence"),
    _REFUSED,
    ids=[" ".join(given) for given, _ in _REFUSED],
)
def test_recordings_that_cannot_be_together_are_one_error(
    here: Path, capsys: pytest.CaptureFixture[str], given: list[str], sentence: str
) -> None:
    assert _run(*given, "-o", "out") == 2
    assert sentence in capsys.readouterr().err


_BROKEN = {
    "nowhere.npy": "nowhere.npy does not exist",
    "*.avi": "*.avi does not exist",
    "words.npy": "words.npy cannot be read as a NumPy array",
    "nothing.npy": "nothing.npy is empty: 0 bytes",
    "empty": "the folder empty has no images",
    "list.txt": "list.txt; must be a folder of images or end in one of",
    "one.npy": "one.npy has 1 frame; must be two or more",
    "flat.npy": "flat.npy has shape (64, 56); must be (frames, height, width)",
    "four.npy": "four.npy has shape (1, 30, 64, 56); must be (frames, height, width)",
    "holes.npy": "frame 3: pixel (7, 5) is nan; must be finite",
}


def test_a_broken_recording_is_a_row_and_the_others_are_analysed(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _run(*_BROKEN, "a.npy", "-o", "out") == 2
    said = capsys.readouterr().err.splitlines()
    with (here / "out" / "recordings.csv").open() as file:
        *failed, analysed = csv.DictReader(file)
    for line, row, sentence in zip(said, failed, _BROKEN.values(), strict=False):
        assert sentence in line
        assert sentence in row["error"]
        assert not row["light"]
    assert len(said) >= len(failed) == len(_BROKEN)
    assert not analysed["error"]
    assert analysed["light"] in ("green", "amber", "red")


def test_a_part_that_one_recording_has_not_is_its_error_alone(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save("short.npy", _STACK[:8])
    assert _run("short.npy", "a.npy", "--from", "10", "-o", "out") == 2
    assert "short.npy has 8 frames" in capsys.readouterr().err
    with (here / "out" / "recordings.csv").open() as file:
        failed, analysed = csv.DictReader(file)
    assert "frames 10 to 7" in failed["error"]
    assert analysed["frames"] == "20"


def test_a_stopped_repetition_leaves_the_rows_that_were_there(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sources, out = [Path("a.npy"), Path("b.npy"), Path("c.npy")], here / "out"

    def until(stop: Path | None) -> Callable[[Path, Path], str]:
        def one(source: Path, folder: Path) -> str:
            if source == stop:
                raise KeyboardInterrupt
            return source.name

        return one

    def rows() -> list[str]:
        with (out / "recordings.csv").open() as file:
            return [row["frames"] for row in csv.DictReader(file)]

    monkeypatch.setattr("plica.video.report.table.row_of", lambda found: {"frames": found})
    for stop, left in (
        (Path("c.npy"), ["a.npy", "b.npy"]),
        (Path("b.npy"), ["a.npy", "b.npy"]),
        (None, ["a.npy", "b.npy", "c.npy"]),
    ):
        with contextlib.suppress(KeyboardInterrupt):
            analyse_each(sources, out, until(stop), quiet=True)  # type: ignore[arg-type]
        assert rows() == left
    analyse_each(sources[1:], out, until(None), quiet=True)  # type: ignore[arg-type]
    assert rows() == ["b.npy", "c.npy"]


@pytest.mark.parametrize(
    ("where", "reason"), [("list.txt", "File exists"), ("list.txt/sub", "Not a directory")]
)
def test_a_place_that_is_no_folder_is_one_error(
    here: Path, capsys: pytest.CaptureFixture[str], where: str, reason: str
) -> None:
    assert _run("a.npy", "c.npy", "-o", where) == 1
    assert capsys.readouterr().err == f"plica: {where}: cannot be written: {reason}.\n"
    assert Path("list.txt").read_text() == "a.npy"


def test_a_recording_that_was_exchanged_is_not_taken_for_the_analysed_one(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _run("a.npy", "c.npy", "-o", "out") == 0
    shutil.copy("holes.npy", "c.npy")
    capsys.readouterr()
    assert _run("a.npy", "c.npy", "-o", "out") == 2
    assert "c.npy" in capsys.readouterr().err
