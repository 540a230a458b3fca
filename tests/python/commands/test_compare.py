"""plica compare: two analyses beside each other, of synthetic recordings with a known change; refusals."""

from __future__ import annotations

import base64
import csv
import io
import json
import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import wavfile

import plica
from analytic_run import Phonation
from plica.commands.main import main
from plica.errors import InvalidInput
from plica.report.comparison import comparison_table, write_comparison
from plica.report.page import pdf_of, render, require_pdf
from plica.report.run.comparison import compare_runs, sheet_of_runs
from plica.storage.files import write_text
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import Settings, VideoError, analyse, compare, load
from plica.video.report.comparison_page import sheet_of

_BEFORE = {
    "height": 80,
    "width": 80,
    "frames": 130,
    "frequency": 0.05,
    "amplitude": (6, 6),
    "opening": (2.5, 2.5),
    "highlights": 1,
    "jitter": 0.01,
    "shimmer": 0.02,
}
_AFTER = {**_BEFORE, "frequency": 0.055, "amplitude": (5, 5), "opening": (3.5, 3.5), "seed": 5}
_KNOWN = {"fps": 4000, "mm_per_px": 0.05, "correct_drift": False}


def analysed(where: Path, options: dict, **settings: object) -> Path:
    where.mkdir()
    np.save(where / "movie.npy", SyntheticGlottis(Synthetic(**options)).stack())
    analyse(where / "movie.npy", where, Settings(**_KNOWN | settings), until="glottis", progress=False)
    return where


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    where = tmp_path_factory.mktemp("two")
    message = {"patient_left": "right", "anterior": "upper"}
    before = analysed(
        where / "before", _BEFORE, label="patient 12, <before>", recorded="2026-03-01", **message
    )
    return before, analysed(where / "after", _AFTER, recorded="2026-05-01", **message)


def with_settings(source: Path, where: Path, **settings: object) -> Path:
    """A copy of an analysis with other settings."""
    shutil.copytree(source, where)
    analyse(source / "movie.npy", where, Settings(**_KNOWN | settings), until="glottis", progress=False)
    return where


@pytest.mark.slow
def test_the_interval_of_a_known_change_holds_it(two: tuple[Path, Path]) -> None:
    found = {change.name: change for change in compare(*two).changes}
    true = {
        "fundamental_frequency": (0.055 - 0.05) * 4000,
        "period": (1 / 0.055 - 1 / 0.05) / 4000,
        # Open above 5 % of the largest width o + a: where sin > (0.05 (o + a) - o) / a.
        "open_quotient": (np.arcsin(3.075 / 5) - np.arcsin(2.075 / 6)) / np.pi,
        "amplitude_left": 0.0,  # half of the largest width in both, as the folds meet
        "left_right_phase": 0.0,
    }
    for name, value in true.items():
        low, high = found[name].interval
        assert low <= value <= high, name
    for name in ("fundamental_frequency", "period", "open_quotient"):
        assert found[name].beyond_scatter
    assert not found["amplitude_left"].beyond_scatter
    assert found["cycles_found"].withheld == "of the recording, not of the voice"


def test_the_command_leaves_a_page_and_tables(
    two: tuple[Path, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    request: pytest.FixtureRequest,
) -> None:
    assert main(["compare", *map(str, two), "-o", str(tmp_path / "change")]) == 0
    message = capsys.readouterr().out
    assert re.search(r"^fundamental_frequency .* \[\+.* to \+.*\] \*", message, re.MULTILINE)
    page = (tmp_path / "change" / "comparison.html").read_text(encoding="utf-8")
    for text in ("patient 12, &lt;before&gt;", "2026-03-01", "Kymograms at 0.5", "Phonovibrograms", "is up"):
        assert text in page
    assert page.count('<svg role="img"') == 4
    assert page.count('id="') == len(set(re.findall(r'id="([^"]*)"', page)))
    stored = json.loads((tmp_path / "change" / "comparison.json").read_text())
    entry = stored["measures"]["open_quotient"]
    assert entry["difference"] == pytest.approx(entry["after"]["value"] - entry["before"]["value"])
    assert entry["interval"][0] < entry["difference"] < entry["interval"][1]
    assert "bootstrap" in stored["method"]
    with (tmp_path / "change" / "comparison.csv").open() as file:
        lines = [line for line in file if not line.startswith("#")]
    rows = {row["measure"]: row for row in csv.DictReader(lines)}
    assert float(rows["open_quotient"]["difference from"]) == entry["interval"][0]
    assert rows["cycles_used"]["not compared"] == "of the recording, not of the voice"
    request.getfixturevalue("few_draws")
    assert main(["compare", *map(str, two), "--quiet"]) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_what_is_not_known_is_not_compared_and_how_to_mend_it_is_reported(
    two: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "bare").mkdir()
    np.save(tmp_path / "bare" / "movie.npy", np.load(two[0] / "movie.npy"))
    bare = analyse(
        tmp_path / "bare" / "movie.npy",
        tmp_path / "bare",
        Settings(correct_drift=False),
        until="glottis",
        progress=False,
    )
    found = compare(bare, two[1])
    reasons = {change.name: change.withheld for change in found.changes}
    assert reasons["glottal_area_max"] == "the size of a pixel is not known before (--mm-per-px)"
    assert reasons["fundamental_frequency"] == "the frame rate is not known before (--fps)"
    assert reasons["left_right_phase"].endswith("is not known before (--patient-left)")
    for name in ("open_quotient", "jitter", "glottal_area_max_relative", "glottal_gap_index"):
        assert reasons[name] == ""
    assert any("(before; --anterior)" in remark for remark in found.remarks)
    assert len(sheet_of(found).sections[0][1]) == 4
    assert "px" in comparison_table(found.changes)
    assert compare(bare, bare).remarks[0].startswith("Both are the same analysis: every difference is 0")
    assert all(not change.beyond_scatter for change in compare(bare, bare).changes)
    assert all(change.withheld or change.difference == 0 for change in compare(bare, bare).changes)
    assert {one.withheld for one in compare(bare, bare).changes if one.name == "period"} == {
        "the frame rate is not known before and after (--fps)"
    }


@pytest.mark.usefixtures("few_draws")
def test_a_glottis_found_by_other_means_is_minded(two: tuple[Path, Path], tmp_path: Path) -> None:
    pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    from onnx_models import darker

    one, other = (
        analysed(tmp_path / name, _AFTER, segmenter=str(darker(tmp_path / f"{name}.onnx", level=level)))
        for name, level in (("one", 0.3), ("other", 0.25))
    )
    remarks = compare(two[0], one).remarks
    message = [text for text in remarks if text.startswith("The glottis was found by different means")]
    assert len(message) == 1
    assert "(before by its edges and its darkness; after by the network one.onnx, " in message[0]
    assert message[0].endswith("): outlines may differ by that alone.")
    assert "before by the network one.onnx" in " ".join(compare(one, other).remarks)
    assert load(one).segmenter != load(other).segmenter
    for same in ((one, one), two):
        assert "different means" not in " ".join(compare(*same).remarks)


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_a_picture_turned_about_is_compared_side_by_side(two: tuple[Path, Path], tmp_path: Path) -> None:
    """The same larynx through an endoscope that is turned by half a turn: nothing has changed."""
    uneven = {**_BEFORE, "amplitude": (6, 4.5), "phase": (0.0, 0.4)}
    upright = analysed(tmp_path / "a", uneven, patient_left="right", anterior="upper")
    (tmp_path / "b").mkdir()
    np.save(tmp_path / "b" / "movie.npy", np.load(upright / "movie.npy")[:, ::-1, ::-1])
    turned = Settings(**_KNOWN, patient_left="left", anterior="lower")
    other = analyse(tmp_path / "b" / "movie.npy", tmp_path / "b", turned, until="glottis", progress=False)
    for change in compare(upright, other).changes:
        if not change.withheld and change.name in ("amplitude_ratio", "left_right_phase", "area_asymmetry"):
            assert abs(change.difference) < 0.02
            assert abs(change.before.value - (change.name == "amplitude_ratio")) > 0.05


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_doubts_of_either_side_are_minded(two: tuple[Path, Path], tmp_path: Path) -> None:
    found = compare(*two[::-1])
    assert any("AFTER on 2026-03-01, which is earlier" in remark for remark in found.remarks)
    again = with_settings(two[0], tmp_path / "again", fps=8000)
    assert any(
        remark.startswith("Both are of the same recording") for remark in compare(two[0], again).remarks
    )
    (two[0] / "movie.npy").rename(tmp_path / "gone.npy")
    try:
        sheet = sheet_of(compare(*two))
    finally:
        (tmp_path / "gone.npy").rename(two[0] / "movie.npy")
    assert sheet.sections == []
    assert "There are no pictures:" in sheet.remarks[-1]


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_what_cannot_be_compared_is_refused_in_one_sentence(
    two: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "results.h5").write_bytes(b"no HDF5 at all")
    shutil.copytree(two[0], tmp_path / "begun")
    with h5py.File(tmp_path / "begun" / "results.h5", "a") as file:
        del file["sides"]
    (tmp_path / "run").mkdir()
    with h5py.File(tmp_path / "run" / "results.h5", "w") as file:
        file["waveforms"] = 1.0
    (tmp_path / "file").write_text("")
    first = str(two[0])
    for arguments, message in (
        ([first, str(tmp_path / "none")], "none is not a directory; must be the directory of an analysis"),
        ([str(tmp_path / "empty"), first], "empty has no results.h5"),
        ([first, str(tmp_path / "broken")], "is not an HDF5 file; must be a result file of plica"),
        ([first, str(tmp_path / "begun")], "is not finished. Start it again: it goes on"),
        ([first, str(tmp_path / "run")], "and " + str(tmp_path / "run") + " a run; must be of the same kind"),
        ([str(tmp_path / "run"), first], "a run; must be of the same kind"),
        ([first, first, "--pdf"], "--pdf is given without -o"),
        ([first, first], "are the same directory; must be different"),
    ):
        assert main(["compare", *arguments]) == 2, arguments
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1
    assert main(["compare", first, str(two[1]), "-o", str(tmp_path / "file"), "--quiet"]) == 1
    assert "file: cannot be written" in capsys.readouterr().err
    with pytest.raises(InvalidInput, match=r"Compare: before is int; must be the directory of an analysis"):
        compare(3, first)  # type: ignore[arg-type]
    with pytest.raises(VideoError, match=r"has no results\.h5"):
        compare(first, tmp_path / "none")


def test_runs_are_compared_without_intervals_and_whole_ones_only(tmp_path: Path) -> None:
    base = Phonation(frequency=213.7, vertical_lag=0.6)
    one, other = base.run(), Phonation(frequency=230.0, vertical_lag=0.6).run()
    found = compare_runs([one, other], [tmp_path / "one", tmp_path / "other"])
    changes = {change.name: change for change in found.changes}
    assert changes["fundamental_frequency"].difference == pytest.approx(230 - 213.7, abs=0.2)
    assert all(change.interval is None for change in found.changes)
    assert comparison_table(found.changes).splitlines()[0].endswith("after - before notes")
    text = write_comparison(sheet_of_runs(found), tmp_path).read_text(encoding="utf-8")
    assert "Before. " in text
    assert "No difference has an interval" in text
    ids = re.findall(r' id="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    unfinished = type(one)(**{**vars(one), "time": one.time[:700]})
    with pytest.raises(InvalidInput, match=r"has 700 of 1200 steps; must be finished"):
        compare_runs([one, unfinished], [tmp_path / "one", tmp_path / "other"])


@pytest.mark.usefixtures("unrendered")
def test_both_sounds_are_heard_at_one_full_scale_and_seen_in_one_picture(tmp_path: Path) -> None:
    """The second flow is four times as large: 12 dB, in samples and in the picture."""
    one = Phonation(frequency=213.7, impulse=0.0).run()
    louder = {**one.waveforms, "flow": 4.0 * np.asarray(one.waveforms["flow"])}
    other = type(one)(**{**vars(one), "waveforms": louder})
    sheet = sheet_of_runs(compare_runs([one, other], [tmp_path / "one", tmp_path / "other"]))
    assert [heading for heading, _ in sheet.sections[:2]] == ["Flow of both", "Sound of both"]
    files = [base64.b64decode(player.uri.partition("base64,")[2]) for player in sheet.players]
    (rate, quiet), (same_rate, loud) = (wavfile.read(io.BytesIO(file)) for file in files)
    assert rate == same_rate
    assert 4.0 * quiet.astype(float) == pytest.approx(loud.astype(float), abs=3)
    assert np.abs(loud).max() > 2**15 / 5
    scales = [re.findall(r"full scale (\S+) Pa", player.caption)[0] for player in sheet.players]
    assert scales[0] == scales[1]
    assert [player.caption[:7] for player in sheet.players] == ["Before.", "After. "]
    text = write_comparison(sheet, tmp_path).read_text(encoding="utf-8")
    assert text.count("<audio") == 2
    assert "<td>none</td><td>none</td>" in text  # tubes


@pytest.mark.usefixtures("unrendered")
def test_runs_without_cycles_or_sound_are_compared_by_what_they_have(tmp_path: Path) -> None:
    one = Phonation(frequency=213.7, impulse=0.0).run()
    still = {**one.waveforms, "flow": np.zeros(one.time.size), "minimum_area": np.zeros(one.time.size)}
    other = type(one)(**{**vars(one), "waveforms": still})
    sheet = sheet_of_runs(compare_runs([one, other], [tmp_path / "one", tmp_path / "other"]))
    assert not {"Flow of both", "Sound of both"} & {heading for heading, _ in sheet.sections}
    assert sheet.players == ()


def test_a_comparison_says_where_and_of_how_many(tmp_path: Path) -> None:
    runs = [Phonation(frequency=213.7).run(), Phonation(frequency=213.7, gap=0.3e-3).run()]
    table = comparison_table(compare_runs(runs, [tmp_path / "one", tmp_path / "other"]).changes)
    notes = dict(re.findall(r"^\((\d+)\) (.*)$", table, re.MULTILINE))
    for name, said in (("amplitude_left", "both: at z = "), ("inverted_tissue_max", "both: of 1 cells")):
        (numbers,) = re.findall(rf"^{name} .*\(([\d, ]+)\)$", table, re.MULTILINE)
        assert any(notes[number].startswith(said) for number in numbers.split(", "))


@pytest.mark.parametrize("turned", [False, True])
def test_a_flow_that_falls_as_the_pressure_rises_is_said(turned: bool, tmp_path: Path) -> None:
    low = Phonation(subglottal_pressure=1000.0).run()
    # By Bernoulli, 1.2 kPa gives 1.095 times the flow of 1 kPa; a peak area of 0.55 for 0.75 mm, 0.80 times.
    for amplitude, names in ((0.5e-3, []), (0.3e-3, ["peak flow", "mean flow"])):
        high = Phonation(subglottal_pressure=1200.0, amplitude_left=amplitude, amplitude_right=amplitude)
        two = [high.run(), low] if turned else [low, high.run()]
        said = [text for text in compare_runs(two, [tmp_path, tmp_path / "b"]).remarks if "flow" in text]
        assert len(said) == bool(names)
        for name in names:
            assert re.search(rf"{name} falls from [\d.]+ ml/s to [\d.]+ ml/s", said[0], re.IGNORECASE)
        if said:
            assert re.search(r"pressure rises from 1(\.0*)? kPa to 1\.20* kPa", said[0])


@pytest.mark.slow
def test_stored_runs_are_compared_by_the_command(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("one", "other"):
        plica.run(bar, tmp_path / name, progress=False)
    command = ["compare", str(tmp_path / "one"), str(tmp_path / "other"), "-o", str(tmp_path / "change")]
    assert main(command) == 0
    assert re.search(r"^kinetic_energy .* 0(\.0*)?$", capsys.readouterr().out, re.MULTILINE)
    stored = json.loads((tmp_path / "change" / "comparison.json").read_text())
    assert stored["measures"]["kinetic_energy"]["difference"] == 0
    assert "interval" not in stored["measures"]["kinetic_energy"]


def test_a_pdf_needs_its_library_before_anything_is_computed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    np.save(tmp_path / "a.npy", np.zeros((9, 32, 32)))
    where = tmp_path / "a"
    for arguments in (
        ["video", str(tmp_path / "a.npy"), "-o", str(where), "--pdf"],
        ["report", str(where), "--pdf"],
        ["compare", str(where), str(where), "-o", str(where), "--pdf"],
    ):
        assert main(arguments) == 2
        error = capsys.readouterr().err
        assert "(--pdf) needs WeasyPrint, which is not installed; must be: pip install 'plica[pdf]'" in error
        assert not where.exists()


def test_a_page_is_paged_with_a_running_header_that_nothing_can_end(tmp_path: Path) -> None:
    try:
        weasyprint = require_pdf()
    except InvalidInput as error:
        pytest.skip(str(error))
    label = 'patient "12" \\ </style> {%'
    text = render("report/comparison.html.j2", **page_values(label))
    assert "</style> {%" not in text.split("</style>")[0]
    pages = weasyprint.HTML(string=text).render().pages
    assert len(pages) > 1
    page = write_text(text, tmp_path / "comparison.html")
    assert pdf_of(page).read_bytes().startswith(b"%PDF-")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["comparison.html", "comparison.pdf"]


def page_values(label: str) -> dict:
    from plica.report.comparison import Sheet

    sheet = Sheet((label, "b"), ({}, {}), [f"Remark {k}." for k in range(120)], [], "plica compare a b")
    return {
        "title": label,
        "running": label,
        "sheet": sheet,
        "facts": [("label", (label, "b"))],
        "groups": {},
        "notes": [],
        "beyond": 0,
        "compared": 0,
        "method": "",
        "version": "1",
    }
