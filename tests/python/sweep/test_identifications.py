"""Sweeps of identification: a case is what the identification is; keys of settings and scene; corners."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from flow_files import SETTINGS, block_scene, fields, flow_file
from plica.identify import Settings, identify
from plica.sweep import Identifications, Plan, Sweep, read_study
from plica.sweep import run as sweep
from plica.sweep.case import Task, run_case

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture
def flows(tmp_path: Path) -> Path:
    """Two recordings of one tissue, the second with half as much again of motion, and a file that is none."""
    flow_file(tmp_path / "one.h5")
    flow_file(tmp_path / "two.h5", flow=1.5 * fields()["flow"])
    (tmp_path / "words.h5").write_text("hello")
    return tmp_path


def _subject(flows: Path, files: tuple[str, ...] = ("one.h5",), **changes: Any) -> Identifications:
    return Identifications(files, block_scene(), Settings(**SETTINGS | changes), base=flows)


def _task(subject: Identifications, changes: dict[str, Any], folder: Path | None = None) -> Task:
    kept = None if folder is None else str(folder)
    given: dict[str, Any] = {"subject": subject, "changes": changes, "folder": kept}
    return Task(case=0, digest="x", waveforms=(), version=plica.__version__, **given)


@pytest.mark.slow
def test_a_case_is_what_the_identification_is(flows: Path, tmp_path: Path) -> None:
    """Of changed settings and a changed scene, to the bit; a kept folder of a killed case is begun again."""
    own = identify(
        flows / "one.h5",
        block_scene().replace({"tissue.body.nu": 0.3}),
        tmp_path / "own",
        Settings(**SETTINGS | {"log_sd": 0.5}),
        progress=False,
    )
    task = _task(_subject(flows), {"identify.log_sd": 0.5, "tissue.body.nu": 0.3}, tmp_path / "kept")
    found, again = run_case(task), run_case(task)
    assert found.status == "done", found.message
    assert again.measures == found.measures
    parameter = own.measures["body.E"]
    assert found.measures == {
        "body.E": (parameter.value, None, parameter.uncertainty),
        "motion_explained": (own.picture.explained, None, None),
    }
    assert found.units == {"body.E": "Pa", "motion_explained": "1"}
    assert found.message == " ".join(own.warnings)
    assert "one_mesh" in found.cautions
    assert ("interval_refused" in found.cautions) == (not own.posterior.answered)


@pytest.mark.slow
def test_a_table_of_recordings_and_priors(flows: Path, tmp_path: Path) -> None:
    """A tighter prior holds the estimate nearer to its median; no tissue and no recording are refused."""
    subject = _subject(flows, ("one.h5", "words.h5"))
    vary = {"identify.log_sd": "0.1, 0.7", "tissue.body.nu": "0.4, 0.6"}
    found = sweep(Plan.make(subject, vary), tmp_path / "out", progress=False)
    assert found.status == ["done", "refused"] * 2 + ["refused"] * 4
    messages = [message for _, _, message in found.without_result]
    assert "tissue.body.nu = 0.6; must be < 0.5" in messages[0]
    assert "words.h5" in messages[2]
    tight, loose = found["body.E"][[0, 2]]
    assert abs(np.log(tight / 5e3)) < abs(np.log(loose / 5e3))
    assert found.measures == ("body.E", "motion_explained")
    assert found.dataset["body.E"].attrs["units"] == "Pa"
    head, first, *_ = found.text().splitlines()
    assert "body.E (kPa)" in head
    assert f"{1e-3 * tight:.5g}" in first
    assert_files(tmp_path / "out")


def assert_files(directory: Path) -> None:
    head = (directory / "cases.csv").read_text().splitlines()[0]
    assert ",body.E (Pa)," in head
    assert head.endswith(",motion_explained")
    again = Sweep.load(directory)
    assert json.loads(again.dataset.attrs["settings"])["log_sd"] == 0.7
    assert "[tissue.body]" in again.dataset.attrs["scene"]


@pytest.mark.parametrize(
    ("key", "why"),
    [
        ("identify.logsd", 'Did you mean "log_sd"'),
        ("identify.coarser", "must be a number to vary it"),
        ("log_sd", "log_sd is not known"),
        ("tissue.body.e", 'Did you mean "E"'),
        ("recording", "recording is not known"),
    ],
)
def test_a_key_is_of_the_settings_or_of_the_scene(key: str, why: str, flows: Path) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        Plan.make(_subject(flows), {key: "1"})
    assert why in str(error.value)


def test_keys_have_the_units_of_their_settings(flows: Path) -> None:
    plan = Plan.make(_subject(flows), {"identify.lead": "5, 6 ms", "identify.most_points": [60, 120]})
    assert plan.changes(0) == {"identify.lead": 0.005, "identify.most_points": 60}
    assert [key.unit for key in plan.keys] == ["s", ""]


def test_a_parameter_is_not_called_as_a_column_is(flows: Path) -> None:
    named = ({"targets": "body.E", "name": "seconds"},)
    with pytest.raises(plica.InvalidInput, match='a parameter is called "seconds"; must have another name'):
        _subject(flows, parameters=named)


def test_the_plan_is_of_all_files_by_content(flows: Path, tmp_path: Path) -> None:
    """The drive and the coarser scene, too, wherever they lie."""
    (tmp_path / "p.csv").write_text("time (s),Pa,Pa\n0,0,0\n1,1,1\n")
    block_scene().save(tmp_path / "coarse.toml")
    chosen = {"drive": tmp_path / "p.csv", "coarser": str(tmp_path / "coarse.toml")}
    before = Plan.make(_subject(flows, **chosen), {"identify.log_sd": [0.5]}).record
    assert (set(before["recordings"]), set(before["files"])) == ({"one"}, {"drive"})
    (tmp_path / "q.csv").write_text((tmp_path / "p.csv").read_text())
    block_scene().save(tmp_path / "other.toml")
    moved = {"drive": tmp_path / "q.csv", "coarser": str(tmp_path / "other.toml")}
    assert Plan.make(_subject(flows, **moved), {"identify.log_sd": [0.5]}).record == before
    (tmp_path / "q.csv").write_text("time (s),Pa,Pa\n0,0,0\n1,1,2\n")
    assert Plan.make(_subject(flows, **moved), {"identify.log_sd": [0.5]}).record != before


def test_a_study_with_scene_and_recordings_is_of_tissue(flows: Path) -> None:
    block_scene().save(flows / "block.toml")
    study = flows / "study.toml"
    study.write_text(
        'recordings = ["one.h5", "two.h5"]\nscene = "block.toml"\n[settings]\nsurface = "x_max"\n'
        '[vary]\nidentify.log_sd = "0.5, 0.7"\ntissue.body.nu = [0.3]\n'
    )
    plan = read_study(study)
    assert plan.subject.kind == "identification"
    assert plan.record["settings"]["surface"] == "x_max"
    assert plan.changes(3) == {"recording": "two", "identify.log_sd": 0.7, "tissue.body.nu": 0.3}
    study.write_text(study.read_text().replace('surface = "x_max"', "log_sd = -1"))
    with pytest.raises(plica.InvalidInput, match=r"study\.toml: settings\.log_sd = -1"):
        read_study(study)
