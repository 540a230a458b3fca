"""What leaves an analysis as a file: a workbook, a file of MATLAB, and the light in each of them."""

from __future__ import annotations

import csv
import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pandas
import pytest
import xarray
from scipy.io import loadmat

import plica
from plica.commands.main import main
from plica.measures.catalogue import CATALOGUE
from plica.measures.waveforms import RECORDED
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import Analysis, analyse, load
from plica.video.light import light_of
from plica.video.matlab import write_matlab
from plica.video.praat import write_praat
from plica.video.settings import Settings
from plica.video.tables import write_tables
from plica.video.workbook import write_workbook

_STACK = SyntheticGlottis(
    Synthetic(height=128, width=112, frames=110, frequency=0.05, amplitude=(8, 5), opening=(3, 2), lag=0.8)
).stack()
_DIGITS = 1e-14  # relative; a workbook has 16 digits


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    where = tmp_path_factory.mktemp("leave")
    np.save(where / "film.npy", _STACK)
    settings = Settings(fps=4000, mm_per_px=0.05, correct_drift=False, label="=1+1", first=5)
    done = analyse(where / "film.npy", where / "found", settings, until="glottis", progress=False)
    for write in (write_tables, write_workbook, write_matlab, write_praat):
        write(done)
    return done


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """Thirty frames: no cycles, and no frame rate."""
    where = tmp_path_factory.mktemp("short")
    np.save(where / "film.npy", _STACK[:30])
    settings = Settings(correct_drift=False)
    done = analyse(where / "film.npy", where / "found", settings, until="glottis", progress=False)
    for write in (write_tables, write_workbook, write_matlab):
        write(done)
    return done


def _rows(found: Analysis, sheet: str) -> list[dict[str, Any]]:
    head, *rows = openpyxl.load_workbook(found.directory / "recording.xlsx")[sheet].values
    return [dict(zip(head, row, strict=True)) for row in rows]


def _matlab(found: Analysis) -> dict[str, Any]:
    return loadmat(found.directory / "recording.mat", simplify_cells=True)


def _csv(found: Analysis, name: str) -> tuple[list[str], list[dict[str, str]]]:
    with (found.directory / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return list(rows.fieldnames or ()), list(rows)


def _same(value: object, number: float | None) -> bool:
    if number is None:
        return value is None
    return isinstance(value, int | float) and value == pytest.approx(number, rel=_DIGITS)


def test_the_workbook_has_the_measures_as_numbers(found: Analysis) -> None:
    rows = _rows(found, "Measures")
    assert [row["name"] for row in rows] == list(found.measures)
    for row, item in zip(rows, found.measures.values(), strict=True):
        low, high = item.interval or (None, None)
        for name, number in (("value", item.value), ("low", low), ("high", high), ("spread", item.spread)):
            assert _same(row[name], number), (item.name, name)
        assert (row["unit"], row["cycles"]) == (item.unit, item.cycles)
        assert (row["note"] or "", row["cautions"] or "") == (item.note, "; ".join(item.cautions))
    assert found.measures["amplitude_left"].unit == "m"
    assert any(row["low"] is not None for row in rows)


@pytest.mark.parametrize("name", ["measures", "cycles", "folds", "waveforms"])
def test_a_sheet_has_the_columns_and_numbers_of_the_csv_file(found: Analysis, name: str) -> None:
    columns, written = _csv(found, name)
    rows = _rows(found, name.capitalize())
    assert list(rows[0]) == [column for column in columns if not column.startswith(("light", "recording"))]
    assert len(rows) == len(written)
    for row, texts in zip(rows, written, strict=True):
        for heading, value in row.items():
            text = texts[heading]
            assert _same(value, float(text)) if isinstance(value, int | float) else (value or "") == text


def test_units_stand_in_the_headings_of_the_sheets(found: Analysis, short: Analysis) -> None:
    assert {"start (s)", "frequency (Hz)", "amplitude_left (m)"} <= set(_rows(found, "Cycles")[0])
    book = openpyxl.load_workbook(short.directory / "recording.xlsx")
    assert [cell.value for cell in book["Cycles"][1]][:3] == [
        "start (frames)",
        "end (frames)",
        "frequency (1/frame)",
    ]
    assert "time (frames)" in _rows(short, "Waveforms")[0]
    assert "area_total (px^2)" in _rows(short, "Waveforms")[0]
    assert all(sheet.freeze_panes == "A2" and sheet["A1"].font.b for sheet in book)


def test_the_first_sheet_has_the_light_its_reasons_and_what_was_analysed(
    found: Analysis, short: Analysis
) -> None:
    for one, rate, first in ((found, 4000, 5), (short, None, 0)):
        light = light_of(one)
        sheet = openpyxl.load_workbook(one.directory / "recording.xlsx").worksheets[0]
        rows = [tuple(row) for row in sheet.values]
        assert sheet.title == "Light"
        assert rows[1] == ("light", light.shown)
        assert [text for what, text in rows if what == "reason"] == list(light.reasons)
        told = dict(rows)
        assert told["file"] == "film.npy"
        assert (told["frames"], told["frames_per_second"]) == (one.count, rate)
        assert (told["first_frame"], told["last_frame"]) == (first, first + one.count - 1)
        assert told["mm_per_px"] == one.settings.mm_per_px
        assert told["label"] == one.settings.label  # "=1+1" is no formula
    assert light_of(short).shown == "red"


def test_a_recording_without_cycles_has_empty_cells_and_says_why(short: Analysis) -> None:
    assert _rows(short, "Cycles") == _rows(short, "Folds") == []
    frequency = next(row for row in _rows(short, "Measures") if row["name"] == "fundamental_frequency")
    assert [frequency[name] for name in ("value", "low", "high", "spread")] == [None] * 4
    assert frequency["unit"] == "1/frame"
    assert frequency["note"] == short.measures["fundamental_frequency"].note != ""
    read = _matlab(short)
    assert np.isnan(read["measures"]["fundamental_frequency"]["value"])
    assert np.isnan(read["measures"]["fundamental_frequency"]["interval"]).all()
    assert read["cycles"]["start"].size == 0
    assert read["cycles"]["units"]["start"] == read["waveforms"]["units"]["time"] == "frames"
    assert read["settings"]["fps"].size == 0


def test_matlab_has_the_measures_and_waveforms_bit_by_bit(found: Analysis) -> None:
    read = _matlab(found)
    assert set(read) >= {"light", "measures", "cycles", "folds", "waveforms", "settings"}
    assert set(read["measures"]) == set(found.measures)
    for name, item in found.measures.items():
        entry = read["measures"][name]
        expected = [np.nan if value is None else value for value in (item.value, item.spread)]
        assert np.array_equal([entry["value"], entry["spread"]], expected, equal_nan=True)
        assert np.array_equal(entry["interval"], item.interval or (np.nan, np.nan), equal_nan=True)
        assert entry["unit"] == item.unit
        assert len(np.atleast_1d(entry["cautions"])) == len(item.cautions)
    for name, values in found.waveforms.items():
        if values.dtype.kind == "f":
            assert np.array_equal(read["waveforms"][name], values, equal_nan=True)
            assert read["waveforms"]["units"][name] == found.units[name]
    phases = [str(text) if np.size(text) else "" for text in read["waveforms"]["phase"]]
    assert phases == found.phase
    light = light_of(found)
    assert read["light"]["colour"] == light.shown
    assert np.atleast_1d(read["light"]["reasons"]).tolist() == list(light.reasons)
    assert read["settings"]["fps"] == 4000
    assert read["settings"]["correct_drift"] == 0
    assert read["cycles"]["frequency"] == pytest.approx(200, rel=0.02)


def test_names_in_the_file_of_matlab_are_names_of_matlab(found: Analysis) -> None:
    def named(content: dict[str, Any]) -> list[str]:
        inner = [name for value in content.values() if isinstance(value, dict) for name in named(value)]
        return [*(name for name in content if not name.startswith("__")), *inner]

    names = [*named(_matlab(found)), *RECORDED, *(one.name for one in CATALOGUE.values())]
    assert [name for name in names if not re.fullmatch(r"[A-Za-z]\w{0,62}", name, re.ASCII)] == []


def test_modes_are_matrices_in_matlab(done: Path, tmp_path: Path) -> None:
    shutil.copytree(done, tmp_path / "done")
    moved = load(tmp_path / "done")
    write_workbook(moved)
    write_matlab(moved)
    assert np.array_equal(
        _matlab(moved)["waveforms"]["mode_coefficients"], moved.waveforms["mode_coefficients"], equal_nan=True
    )
    last = _rows(moved, "Waveforms")[-1]
    assert last["mode_coefficients_1 (px)"] is None  # the last frame has no flow
    assert last["area_total (m^2)"] is not None


def test_each_file_has_the_light(found: Analysis) -> None:
    light, where = light_of(found), found.directory
    for name in ("measures", "cycles", "folds", "waveforms"):
        table = pandas.read_csv(where / f"{name}.csv", comment="#")
        assert set(table["light"]) == {light.shown}
    table = pandas.read_csv(where / "measures.csv")  # no comments: any reader
    assert set(table["light_reasons"]) == {light.said}
    assert set(table["recording"]) == {"=1+1"}
    assert table.set_index("name")["value"]["open_quotient"] == found.measures["open_quotient"].value
    told = json.loads((where / "light.json").read_text())
    assert (told["light"], told["reasons"]) == (light.shown, list(light.reasons))
    assert told["recording"]["frames"] == found.count
    told = json.loads((where / "measures.json").read_text())["recording"]
    assert (told["light"], told["light_reasons"]) == (light.shown, list(light.reasons))
    assert f'text = "{light.shown}: {light.said}"' in (where / "area.TextGrid").read_text()


def test_the_light_goes_with_the_waveforms_into_netcdf(found: Analysis, tmp_path: Path) -> None:
    table = found.to_xarray()
    table.to_netcdf(tmp_path / "a.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "a.nc", engine="scipy") as read:
        for attributes in (table.attrs, read.attrs):
            assert attributes["light"] == light_of(found).shown
            assert attributes["light_reasons"] == light_of(found).said
        assert read["area_total"].attrs["units"] == "m^2"


def test_a_file_that_cannot_be_written_is_one_sentence(found: Analysis, tmp_path: Path) -> None:
    shutil.copytree(found.directory, tmp_path / "found")
    copy = load(tmp_path / "found")
    for write, name in ((write_workbook, "recording.xlsx"), (write_matlab, "recording.mat")):
        before = (copy.directory / name).read_bytes()
        (copy.directory / f"{name}.part").mkdir()
        with pytest.raises(plica.StorageFailed, match=rf"{name}: cannot be written: Is a directory\.[^\n]*$"):
            write(copy)
        assert (copy.directory / name).read_bytes() == before


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_one_command_writes_them_for_one_and_for_many(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "a.npy", _STACK[:90])
    (tmp_path / "b.npy").write_bytes(b"nothing")
    command = ["glottis", str(tmp_path / "a.npy"), str(tmp_path / "b.npy"), "--fps", "4000", "--no-drift"]
    command += ["-o", str(tmp_path / "out"), "--quiet"]
    assert main(command) == 2
    table = tmp_path / "out" / "recordings.xlsx"
    wanted = [table, tmp_path / "out" / "a" / "recording.xlsx", tmp_path / "out" / "a" / "recording.mat"]
    assert not any(path.exists() for path in wanted)
    assert main([*command, "--xlsx", "--matlab"]) == 2  # what is wanted now and is not there is made
    assert all(path.exists() for path in wanted)
    capsys.readouterr()

    sheet = openpyxl.load_workbook(table)["Recordings"]
    head, good, bad = (list(row) for row in sheet.values)
    row, failed = dict(zip(head, good, strict=True)), dict(zip(head, bad, strict=True))
    with (tmp_path / "out" / "recordings.csv").open() as file:
        written = next(csv.DictReader(file))
    assert {name: str(value or "") for name, value in row.items() if not isinstance(value, float | int)} == {
        name: written[name] for name, value in row.items() if not isinstance(value, float | int)
    }
    for name, value in row.items():
        assert not isinstance(value, float) or _same(value, float(written[name]))
    assert row["light"] == light_of(load(tmp_path / "out" / "a")).shown
    low, value, high = (row[f"amplitude_left{end} (px)"] for end in (" low", "", " high"))
    assert low < value < high
    assert row["fundamental_frequency low (Hz)"] < 200 < row["fundamental_frequency high (Hz)"]
    ends = [name for name in head if re.search(r" (low|high)( \(|$)", name)]
    assert len(ends) > 20
    assert {re.sub(r" (low|high)( \(|$)", r"\2", name) for name in ends} <= set(head)
    assert failed["light"] is None
    assert "b.npy cannot be read" in failed["error"]

    one = tmp_path / "one"
    assert main(["glottis", str(tmp_path / "a.npy"), "--no-drift", "--quiet", "-o", str(one), "--xlsx"]) == 0
    assert (one / "recording.xlsx").exists()
    assert not (one / "recording.mat").exists()
    assert not (one / "recordings.xlsx").exists()


def test_without_openpyxl_nothing_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    np.save(tmp_path / "a.npy", _STACK[:9])
    for more in ([], ["--table"]):
        where = tmp_path / "out"
        assert main(["glottis", str(tmp_path / "a.npy"), "-o", str(where), "--xlsx", *more]) == 2
        error = capsys.readouterr().err
        assert error == (
            "plica: A workbook (--xlsx) needs openpyxl, which is not installed; must be: pip install "
            "'plica[xlsx]'.\n"
        )
        assert not where.exists()


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_files_of_earlier_settings_are_named(
    found: Analysis, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(found.directory, tmp_path / "found")
    command = [
        "glottis",
        str(found.source),
        "--no-drift",
        "--from",
        "5",
        "--quiet",
        "-o",
        str(tmp_path / "found"),
    ]
    assert main([*command, "--xlsx", "--matlab", "--praat"]) == 0
    assert "earlier settings" not in capsys.readouterr().err
    assert main([*command, "--fps", "2000", "--xlsx"]) == 0
    assert "area.wav, recording.mat in " in (said := capsys.readouterr().err)
    assert "of earlier settings; --praat --matlab writes anew" in said
    assert _rows(load(tmp_path / "found"), "Cycles")[0]["frequency (Hz)"] == pytest.approx(100, rel=0.02)
    assert main(command) == 0  # once more without the options
    assert "recording.xlsx" not in capsys.readouterr().err
