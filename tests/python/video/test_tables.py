"""Tables of cycles and of the folds, what Praat opens, and many recordings with one command."""

from __future__ import annotations

import csv
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import Analysis, analyse, load
from plica.video.errors import VideoError
from plica.video.praat import text_grid, write_praat
from plica.video.settings import Settings
from plica.video.tables import cycles_table, folds_table, write_tables

_GLOTTIS = SyntheticGlottis(
    Synthetic(height=128, width=112, frames=110, frequency=0.05, amplitude=(8, 5), opening=(3, 2), lag=0.8)
)
_SETTINGS = Settings(fps=4000, correct_drift=False)


@cache
def _stack() -> np.ndarray:
    return _GLOTTIS.stack()


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    where = tmp_path_factory.mktemp("tables")
    np.save(where / "film.npy", _stack())
    return analyse(where / "film.npy", where / "found", _SETTINGS, until="glottis", progress=False)


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """Thirty frames: no cycles, and no frame rate."""
    where = tmp_path_factory.mktemp("short")
    np.save(where / "film.npy", _stack()[:30])
    unknown = Settings(correct_drift=False)
    return analyse(where / "film.npy", where / "found", unknown, until="glottis", progress=False)


def test_cycles_are_those_of_the_voice(found: Analysis) -> None:
    table = cycles_table(found)
    assert table["frequency (Hz)"] == pytest.approx(200, rel=0.02)
    assert table["start (s)"][1:].tolist() == table["end (s)"][:-1].tolist()
    assert table["amplitude_left (px)"].mean() == pytest.approx(
        found.measures["amplitude_left"].value, abs=0.05
    )
    assert (table["used"] == 1).all()
    assert {len(values) for values in table.values()} == {found.cycles.count}


def test_an_analysis_of_the_glottis_alone_says_what_it_lacks(found: Analysis) -> None:
    with pytest.raises(VideoError, match="stops at the glottis; must have modes"):
        load(found.directory, needs="modes")


def test_amplitudes_and_phases_along_the_folds_are_the_true_ones(found: Analysis) -> None:
    table = folds_table(found)
    rows = found.midline.points(
        np.stack([found.midline.length * table["place"], 0 * table["place"]], axis=1)
    )[:, 1]
    middle = np.abs(table["place"] - 0.5) < 0.3
    for side, name in enumerate(("left", "right")):
        edges = np.array([_GLOTTIS.edge(side, rows[middle], t) for t in range(20, 60)])
        true = np.ptp(edges, axis=0) / 2
        assert table[f"amplitude_{name} (px)"][middle] == pytest.approx(true, abs=0.75)
    phase = np.unwrap(table["phase_left (rad)"][middle])
    lag = np.polyfit(table["place"][middle], phase, 1)[0] * found.midline.length / (0.7 * 128)
    assert lag == pytest.approx(0.8, abs=0.25) or lag == pytest.approx(-0.8, abs=0.25)
    assert table["open_share"][middle].max() < 1
    assert table["open_share"].min() >= 0


def test_a_recording_without_cycles_has_tables_without_rows(short: Analysis) -> None:
    write_tables(short)
    for name in ("cycles", "folds"):
        assert len((short.directory / f"{name}.csv").read_text().splitlines()) == 1


def test_praat_has_the_area_and_intervals_that_cover_all_of_it(found: Analysis) -> None:
    sound, grid = write_praat(found)
    rate, samples = wavfile.read(sound)
    assert (rate, samples.size, samples.max()) == (4000, found.count, 1)
    text = grid.read_text()
    ends = [float(value) for value in re.findall(r"^ {12}xm(?:in|ax) = (.*)$", text, re.MULTILINE)]
    assert ends[0] == 0
    assert max(ends) == found.count / 4000
    assert len(re.findall(r'text = "\d+"', text)) == found.cycles.count


def test_intervals_of_a_text_grid_leave_no_gap() -> None:
    text = text_grid(1.0, {"a": [(0.2, 0.4, "x"), (0.4, 0.6, "y")]})
    assert re.findall(r'xmin = (\S+)\n +xmax = (\S+)\n +text = "(.*)"', text) == [
        ("0.0", "0.2", ""),
        ("0.2", "0.4", "x"),
        ("0.4", "0.6", "y"),
        ("0.6", "1.0", ""),
    ]


def test_praat_without_a_frame_rate_is_refused(short: Analysis) -> None:
    with pytest.raises(VideoError, match="fps is unknown; must be a whole number"):
        write_praat(short)


def test_a_part_of_a_recording_is_what_it_is_by_itself(tmp_path: Path) -> None:
    stack = _stack()
    np.save(tmp_path / "whole.npy", stack)
    np.save(tmp_path / "part.npy", np.concatenate([stack[20:60]]))
    part = Settings(fps=4000, correct_drift=False, first=20, last=59)
    one = analyse(tmp_path / "whole.npy", tmp_path / "one", part, until="glottis", progress=False)
    other = analyse(tmp_path / "part.npy", tmp_path / "other", _SETTINGS, until="glottis", progress=False)
    assert one.count == 40
    assert np.array_equal(one.area.total, other.area.total)
    for first, last, said in ((0, 110, "has 110 frames"), (109, None, "two or more")):
        wrong = Settings(first=first, last=last)
        with pytest.raises(VideoError, match=said):
            analyse(tmp_path / "whole.npy", tmp_path / "wrong", wrong, until="glottis", progress=False)
    for wrong in ({"first": -1}, {"first": 2.5}, {"first": 9, "last": 9}):
        with pytest.raises(VideoError, match="first"):
            Settings(**wrong)


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_several_recordings_have_a_folder_each_and_one_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stack = _stack()
    for name in ("a", "b"):
        np.save(tmp_path / f"{name}.npy", stack[:90])
    (tmp_path / "c.npy").write_bytes(b"nothing")
    command = ["glottis", *(str(tmp_path / f"{name}.npy") for name in "acb"), "--fps", "4000", "--no-drift"]
    command += ["-o", str(tmp_path / "out"), "--quiet"]
    assert main(command) == 2
    assert "c.npy cannot be read" in capsys.readouterr().err
    with (tmp_path / "out" / "recordings.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [Path(row["recording"]).name for row in rows] == ["a.npy", "c.npy", "b.npy"]
    assert rows[1]["error"]
    assert rows[0]["light"] in ("green", "amber", "red")
    assert rows[0]["light_reasons"]
    assert "jitter" in rows[0]["not_to_write_down"].split(", ")  # of four cycles
    assert float(rows[0]["fundamental_frequency (Hz)"]) == pytest.approx(200, rel=0.02)
    assert float(rows[0]["amplitude_left low (px)"]) < float(rows[0]["amplitude_left high (px)"])

    page = tmp_path / "out" / "a" / "report.html"
    written = page.stat().st_mtime_ns
    assert main(command) == 2
    assert page.stat().st_mtime_ns == written  # what is done is not done again
    assert main([*command, "--praat"]) == 2
    assert (page.parent / "area.wav").exists()  # but what is wanted now and is not there is made


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_a_part_may_begin_with_the_first_frame(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", _stack()[:90])
    part = ["--from", "0", "--to", "79", "--no-drift", "--quiet"]
    assert main(["glottis", str(tmp_path / "a.npy"), *part, "-o", str(tmp_path / "out")]) == 0
    assert load(tmp_path / "out").count == 80
