"""Sweeps of recordings: a case is what the analysis is; units, words, and recordings that cannot be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import plica
from plica import video
from plica.commands.main import main
from plica.measures.catalogue import CATALOGUE
from plica.sweep import Identifications, Plan, Recordings, Sweep, indices, read_study, recording_cases
from plica.sweep import run as sweep
from plica.sweep.case import Task, run_case
from plica.sweep.subject import RESERVED
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from sweeps import assert_equal

pytestmark = pytest.mark.usefixtures("here", "few_draws")

SETTINGS = video.Settings(fps=4000, mm_per_px=0.05, correct_drift=False)
PERIODS = {"anna": 0.1, "berta": 0.125}


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings, and a file that is none."""
    folder = tmp_path_factory.mktemp("day")
    for name, frequency in PERIODS.items():
        drawn = Synthetic(
            height=56, width=48, frames=44, frequency=frequency, amplitude=(6, 5), opening=(2, 2)
        )
        np.save(folder / f"{name}.npy", SyntheticGlottis(drawn).stack())
    (folder / "words.npy").write_text("hello")
    return folder


def _anna(day: Path, settings: video.Settings = SETTINGS) -> Recordings:
    return Recordings([day / "anna.npy"], settings, until="glottis")


def test_a_case_is_what_the_analysis_is(day: Path, tmp_path: Path) -> None:
    """Measures to the bit, kept or not, of the settings that the case has."""
    chosen = video.Settings(fps=4000, mm_per_px=0.05, correct_drift=False, rotation=3.0, first=2, last=41)
    found = video.analyse(day / "anna.npy", tmp_path / "own", chosen, until="glottis", progress=False)
    task: dict[str, Any] = {"case": 0, "digest": "x", "waveforms": (), "version": plica.__version__}
    task |= {"subject": _anna(day), "changes": {"rotation": 3.0, "first": 2, "last": 41}}
    one, kept = (run_case(Task(**task, folder=folder)) for folder in (None, str(tmp_path / "kept")))
    assert one.status == "done", one.message
    assert one.measures == kept.measures
    assert one.measures == {
        name: tuple(
            None if value is None or not np.isfinite(value) else value
            for value in (item.value, item.spread, item.uncertainty)
        )
        for name, item in found.measures.items()
    }
    assert one.units == {name: item.unit for name, item in found.measures.items()}
    assert video.load(tmp_path / "kept").settings == chosen


def test_rate_and_size_scale_what_they_must_and_nothing_else(day: Path, tmp_path: Path) -> None:
    """Twice the frame rate is twice the frequency, twice the pixel four times the area: to the bit."""
    vary = {"fps": "2, 4 kHz", "mm_per_px": [0.05, 0.1]}
    found = sweep(Plan.make(_anna(day), vary), tmp_path, progress=False)
    data = found.dataset
    assert dict(data.sizes) == {"fps": 2, "mm_per_px": 2}
    pitch, area, quotient = (
        data[name].values for name in ("fundamental_frequency", "glottal_area_max", "open_quotient")
    )
    assert (pitch[1] == 2 * pitch[0]).all()
    assert (area[:, 1] == 4 * area[:, 0]).all()
    assert np.ptp(quotient) == 0
    assert pitch[1, 0] == pytest.approx(4000 * PERIODS["anna"], rel=2e-3)  # what is drawn


def test_recordings_alone_are_a_plan_and_a_stopped_one_goes_on(day: Path, tmp_path: Path) -> None:
    def plan() -> Plan:
        return Plan.make(Recordings(["anna.npy", "berta.npy"], SETTINGS, until="glottis", base=day), {})

    whole = sweep(plan(), tmp_path / "whole", progress=False)
    assert whole.keys == ("recording",)
    part = sweep(plan(), tmp_path / "parts", first=1, progress=False)
    assert part.status == ["done", "waiting"]
    assert part.unit("fundamental_frequency") == "Hz"
    assert_equal(sweep(plan(), tmp_path / "parts", progress=False), whole)


def test_a_list_is_of_each_recording(day: Path, tmp_path: Path) -> None:
    """Over cases, whose recordings are a column of text."""
    recorded = Recordings(["anna.npy", "berta.npy"], SETTINGS, until="glottis", base=day)
    plan = Plan.make(recorded, {"rotation": [0.0, 5.0], "first": [0, 2]}, design="list")
    assert [plan.changes(case) for case in (1, 2)] == [
        {"recording": "anna", "rotation": 5.0, "first": 2},
        {"recording": "berta", "rotation": 0.0, "first": 0},
    ]
    found = sweep(plan, tmp_path, progress=False)
    assert found.dataset["recording"].values.tolist() == ["anna", "anna", "berta", "berta"]
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.load(), found.dataset.load())
    assert (tmp_path / "cases.csv").read_text().splitlines()[2].startswith("1,anna,5.0,2.0,done,")


def test_what_is_in_a_recording_counts_not_where_it_lies(day: Path, tmp_path: Path) -> None:
    own = tmp_path / "elsewhere"
    own.mkdir()
    (own / "anna.npy").write_bytes((day / "anna.npy").read_bytes())
    sweep(Plan.make(_anna(day), {"rotation": [0.0]}), tmp_path / "out", progress=False)
    again = Plan.make(_anna(own), {"rotation": [0.0]})
    sweep(again, tmp_path / "out", progress=False)
    changed = np.load(own / "anna.npy")
    changed[3, 5, 7] += 1
    np.save(own / "anna.npy", changed)
    for other, what in (
        (Plan.make(_anna(own), {"rotation": [0.0]}), "recordings.anna"),
        (Plan.make(_anna(day, video.Settings(fps=3000)), {"rotation": [0.0]}), "settings.fps"),
        (Plan.make(Recordings([day / "anna.npy"], SETTINGS), {"rotation": [0.0]}), "settings.until"),
    ):
        with pytest.raises(plica.InvalidInput, match=r"holds a sweep of another plan") as error:
            sweep(other, tmp_path / "out", progress=False)
        assert what in str(error.value)


def test_a_corner_that_no_recording_has_is_refused(day: Path, tmp_path: Path) -> None:
    found = sweep(Plan.make(_anna(day), {"last": [43, 44]}), tmp_path, progress=False)
    assert found.status == ["done", "refused"]
    assert "frames 0 to 44; must be two or more, in [0, 43]" in found.without_result[0][2]


def test_words_and_entries_of_lists_are_varied(day: Path, tmp_path: Path) -> None:
    settings = video.Settings(fps=4000, region=(0, 0, 48, 56), midline=(24, 5, 24, 50), correct_drift=False)
    plan = Plan.make(
        _anna(day, settings),
        {"correct_drift": [False, True], "midline[0]": "22, 24", "region[3]": [52, 56]},
    )
    assert plan.changes(0) == {"correct_drift": "false", "midline[0]": 22.0, "region[3]": 52}
    subject = plan.subject
    assert isinstance(subject, Recordings)
    assert subject._changed(plan.changes(7)).correct_drift
    made = subject._changed(plan.changes(0))
    assert (made.correct_drift, made.midline, made.region) == (False, (22, 5, 24, 50), (0, 0, 48, 52))
    assert made.fps == 4000
    with pytest.raises(plica.InvalidInput, match=r"preset = \"vidoe\".*Did you mean \"video\""):
        Plan.make(_anna(day), {"preset": "vidoe"})
    assert sweep(plan, tmp_path, first=1, progress=False).unit("amplitude_left") == "px"


def test_one_drawn_design_of_a_recording_has_its_place(day: Path, tmp_path: Path) -> None:
    plan = Plan.make(_anna(day), {"mm_per_px": "0.04:0.06"}, design="sobol", samples=2)
    found = sweep(plan, tmp_path, progress=False)
    assert found.status == ["done"] * 6
    of = indices(found, "glottal_area_max")
    assert {(one.key, one.kind) for one in of.found} == {
        ("mm_per_px", "first order"),
        ("mm_per_px", "total"),
    }


@pytest.mark.parametrize(
    ("vary", "given", "why"),
    [
        ({"threshold": [1]}, {}, "threshold; must be one of fps, mm_per_px"),
        ({"presett": ["video"]}, {}, 'Did you mean "preset"'),
        ({"fps": [1]}, {"settings": video.Settings()}, "fps is varied, and not given in the settings"),
        ({"midline[0]": [1]}, {}, "midline has 0 entries, from [0]; must be given in the settings"),
        ({"rotation": [1]}, {"design": "sobol", "samples": 2}, 'must have a range, e.g. "0.4:1.2 kPa"'),
        ({"rotation": [1]}, {"waveforms": ["flow"]}, "waveforms of recordings; must be left out"),
        ({"rotation": "5"}, {}, "must be a number in degrees or a text with a unit of that kind"),
        ({"fps": "4000"}, {}, "the text has no unit"),
        ({"first": [1.5]}, {}, "must be whole numbers"),
        ({}, {}, "no key is varied"),
        ({}, {"files": ["anna.npy", "berta.npy"], "design": "latin_hypercube"}, "no key is varied"),
    ],
)
def test_what_makes_no_plan_is_refused(
    vary: dict[str, Any], given: dict[str, Any], why: str, day: Path
) -> None:
    chosen = dict(given)
    files, settings = chosen.pop("files", ["anna.npy"]), chosen.pop("settings", SETTINGS)
    with pytest.raises(plica.InvalidInput) as error:
        Plan.make(Recordings(files, settings, base=day), vary, **chosen)
    assert why in str(error.value)


@pytest.mark.parametrize(
    ("files", "given", "why"),
    [
        ([], {}, "recordings is empty"),
        (["*.avi"], {}, 'nothing fits "*.avi"'),
        (["none.npy"], {}, "none.npy does not exist"),
        (["anna.npy", "a*.npy"], {}, "anna.npy is given twice"),
        (["anna.npy"], {"until": "end"}, 'until = "end"; must be glottis or modes'),
        (["anna.npy"], {"settings": video.Settings(label="before")}, "label is given; must be left out"),
    ],
)
def test_recordings_that_are_none_are_refused(
    files: list[str], given: dict[str, Any], why: str, day: Path
) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        Recordings(files, base=day, **given)
    assert why in str(error.value)


def test_sensitivity_is_of_one_voice(day: Path) -> None:
    with pytest.raises(plica.InvalidInput, match="with 2 recordings; must be of one"):
        Plan.make(
            Recordings(["anna.npy", "berta.npy"], base=day),
            {"rotation": "-5:5 deg"},
            design="morris",
            samples=2,
        )


def test_recordings_of_one_name_are_told_by_their_paths(tmp_path: Path) -> None:
    for folder in ("x", "y"):
        (tmp_path / folder).mkdir()
        np.save(tmp_path / folder / "a.npy", np.zeros((2, 4, 4)))
    assert Recordings(["*/a.npy"], base=tmp_path).recordings == ("x/a.npy", "y/a.npy")
    assert Recordings(["x/a.npy"], base=tmp_path).recordings == ("a",)


def test_recordings_of_other_units_are_refused(day: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a camera's file, which has its rate, among others: never two units in a column."""
    subject = _anna(day, video.Settings(correct_drift=False))
    assert subject.scale == (False, False)
    monkeypatch.setitem(vars(subject), "scale", (True, False))
    found = run_case(
        Task(case=0, digest="x", subject=subject, changes={}, waveforms=(), version=plica.__version__)
    )
    assert found.status == "refused"
    assert "the frame rate of anna.npy is not known, that of others known; must be alike" in found.message


def test_a_light_that_is_not_green_is_a_caution(day: Path, tmp_path: Path) -> None:
    """Of half of a cycle nothing is measured."""
    subject = _anna(day, video.Settings(fps=4000, correct_drift=False))
    found = sweep(Plan.make(subject, {"last": [6, 43]}), tmp_path, progress=False)
    assert found.columns["caution_names"].tolist() == ["light_red", ""]
    assert "No cycles were found" in str(found.columns["message"][0])
    assert np.isnan(found["open_quotient"][0])


def test_names_of_columns_and_keys_are_no_measures() -> None:
    assert not {*RESERVED, *recording_cases._KNOWN} & CATALOGUE.keys()


_STUDY = """
recordings = ["*.npy"]
until = "glottis"
[settings]
fps = 4000
correct_drift = false
[vary]
rotation = "0, 5 deg"
"""


def test_a_study_of_many_recordings_is_one_table(
    day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each at its place, one that cannot be read isolated, the names as text in all files; computed and shown
    by the command, and the plan that Python makes of the same."""
    study, out = day / "study.toml", tmp_path / "out"
    study.write_text(_STUDY)
    for _ in range(2):
        assert main(["sweep", str(study), "-o", str(out), "--quiet"]) == 1
        assert "2 of 6 cases have no result (2 refused, 0 failed); case 4" in capsys.readouterr().err
    page = (out / "report.html").read_text()
    assert "Sweep of recordings: all combinations" in page
    assert "<svg" in page
    assert main(["sweep", str(out), "--table"]) == 0
    table = capsys.readouterr().out.splitlines()
    assert table[0].split()[:5] == ["case", "recording", "rotation", "(degrees)", "status"]
    assert table[4].split()[:4] == ["3", "berta", "5", "done"]
    assert Sweep.load(out).record["settings"]["until"] == "glottis"

    settings = video.Settings(fps=4000, correct_drift=False)
    plan = Plan.make(Recordings(["*.npy"], settings, until="glottis", base=day), {"rotation": "0, 5 deg"})
    assert plan.changes(3) == {"recording": "berta", "rotation": 5.0}
    found = sweep(plan, out, progress=False)
    assert found.status == ["done"] * 4 + ["refused"] * 2
    assert {case for case, _, _ in found.without_result} == {4, 5}
    assert all("words.npy cannot be read" in message for _, _, message in found.without_result)
    data = found.dataset
    assert data["recording"].values.tolist() == ["anna", "berta", "words"]
    for name, frequency in PERIODS.items():
        seen = data["fundamental_frequency"].sel(recording=name).values
        assert seen == pytest.approx(4000 * frequency, rel=5e-3)
    head, *rows = (out / "cases.csv").read_text().splitlines()
    assert head.startswith(
        "case,recording,rotation (degrees),status,message,seconds (s),cautions,caution_names,"
    )
    assert [row.split(",")[1] for row in rows] == ["anna"] * 2 + ["berta"] * 2 + ["words"] * 2
    with xarray.open_dataset(out / "sweep.nc", engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.load(), found.dataset.load())
    with xarray.open_zarr(out / "results.zarr", consolidated=False) as stored:
        assert stored["recording"].values.tolist() == ["anna", "anna", "berta", "berta", "words", "words"]
    paths = (out / "sources.csv").read_text().splitlines()
    assert paths[1] == f"anna,{day / 'anna.npy'}"


def test_a_recording_is_no_scene(day: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    typed = ["sweep", str(day / "anna.npy"), "--vary", "rotation=1", "-o", str(tmp_path / "out")]
    assert main(typed) == 2
    assert "Recordings are named in a study file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (('until = "glottis"', 'scene = "x.toml"\nuntil = "glottis"'), "until is given; must be left out"),
        (("fps = 4000", "fsp = 4000"), 'settings.fsp is not known. Did you mean "fps"'),
        (('["*.npy"]', '"*.npy"'), 'recordings = "*.npy"; must be a list of texts'),
        (('recordings = ["*.npy"]\n', ""), "scene is missing; must be there, or recordings"),
        (("fps = 4000", "fps = -1"), "fps = -1 frames/s; must be > 0"),
    ],
)
def test_a_wrong_study_is_refused(change: tuple[str, str], why: str, day: Path, tmp_path: Path) -> None:
    (tmp_path / "a.npy").write_bytes((day / "anna.npy").read_bytes())
    path = tmp_path / "study.toml"
    path.write_text(_STUDY.replace(*change))
    with pytest.raises(plica.InvalidInput) as error:
        read_study(path)
    assert why in str(error.value)


def test_settings_without_recordings_are_refused(bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "bar.toml")
    (tmp_path / "study.toml").write_text(
        'scene = "bar.toml"\n[settings]\nfps = 1\n[vary]\ntissue.body.E = "1 kPa"'
    )
    with pytest.raises(plica.InvalidInput, match="settings are given; must be left out"):
        read_study(tmp_path / "study.toml")
    with pytest.raises(plica.InvalidInput, match="does not exist"):
        Identifications(["analysis"], bar, base=tmp_path)
