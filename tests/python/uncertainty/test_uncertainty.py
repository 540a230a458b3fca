"""The uncertainty of a run: what is computed, stored, reported and refused."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plica
from interrupted_runs import StopsAfter
from plica import _engine
from plica.commands.main import main
from plica.measures.cycles import Cycles
from plica.measures.measure import Measures, whole
from plica.runs import store
from plica.uncertainty import estimate, sample
from plica.uncertainty.level import PlannedLevel
from plica.uncertainty.plan import plan_levels
from plica.uncertainty.start import Start, _identity, _write, kept_start, widest_opening
from stored_files import rewrite_text, set_status


@pytest.fixture
def ringing(bar: plica.Scene, tmp_path: Path) -> Path:
    """The directory of a finished run of a bar that swings for a while."""
    scene = bar.replace(
        {
            "mesh.divisions": (4, 2, 2),
            "tissue.body.nu": 0.0,
            "tissue.body.viscosity": 1.0,
            "initial.velocity": {"body": (0.1, 0.0, 0.0)},
            "time.step": "0.2 ms",
            "time.duration": "44 ms",
            "output.every": None,
            "output.checkpoint_every": "0.1 s",
        }
    )
    plica.run(scene, tmp_path / "run", progress=False)
    return tmp_path / "run"


def test_frequency_of_a_rod_holds_that_of_the_continuum(ringing: Path) -> None:
    found = plica.estimate_uncertainty(ringing, progress=False)
    frequency = found.measures["fundamental_frequency"]
    exact = np.sqrt(20e3 / plica.Run.load(ringing).scene.tissue["body"].density) / (4 * 0.01)
    assert frequency.step is not None
    assert frequency.mesh is not None
    assert frequency.numerical is not None
    assert frequency.numerical == frequency.step.uncertainty + frequency.mesh.uncertainty
    assert 0 < abs(frequency.value - exact) < frequency.numerical < 0.2 * exact
    assert set(frequency.step.values) == {"run", "step-2", "step-4"}
    assert set(frequency.mesh.values) == {"run", "mesh-1.5", "mesh-0.5"}
    assert found.waveforms["probes.relative_error"].numerical is not None
    assert "1/2 of the step" in found.source
    assert "from the start of the scene" in found.source


def test_what_was_found_is_stored_read_and_shown(ringing: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert plica.Run.load(ringing).uncertainty is None
    assert main(["uncertainty", str(ringing), "--mesh", "none"]) == 0
    message = capsys.readouterr()
    found = plica.Run.load(ringing).uncertainty
    assert found is not None
    stored = json.loads((ringing / "uncertainty.json").read_text())
    assert stored.pop("checksum").startswith("crc32 ")
    assert stored == found.as_json()
    with (ringing / "uncertainty.csv").open() as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    item = found.measures["probe_amplitude"]
    assert float(rows["probe_amplitude"]["numerical"]) == item.numerical
    assert rows["probe_amplitude"]["mesh_verdict"] == "not estimated"
    assert rows["probe_amplitude"]["mesh"] == ""
    assert "the error of the mesh is not estimated: it was not requested" in message.out
    assert "2 levels from the start of the scene: about" in message.err
    assert "440 steps of 100 us" in message.err
    assert message.err.count(" steps of ") == 2  # the plan, once
    assert re.findall(r"^plica: step / \d$", message.err, re.MULTILINE) == [
        "plica: step / 2",
        "plica: step / 4",
    ]
    page = (ringing / "report.html").read_text()
    assert "numerical uncertainty" in page
    assert found.source in page
    assert "(step alone)" in page
    assert "The error of the mesh is not estimated: it was not requested." in page
    before = page
    assert main(["report", str(ringing)]) == 0
    assert (ringing / "report.html").read_text() == before


def test_a_run_that_continues_has_no_uncertainty_of_the_shorter_one(ringing: Path) -> None:
    plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    scene = plica.Run.load(ringing).scene.replace({"time.duration": "50 ms"})
    plica.run(scene, ringing, resume=True, progress=False)
    assert not (ringing / "uncertainty.json").exists()
    assert not (ringing / "uncertainty.csv").exists()
    found = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    assert found.steps == 250
    assert found.levels[0]["steps"] == 500


def test_a_call_that_was_stopped_continues_and_computes_nothing_twice(
    ringing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = estimate.run_from
    calls: list[str] = []

    def stopped(scene: Any, directory: Path, *parts: Any, **options: Any) -> Any:
        calls.append(directory.name)
        if len(calls) == 2:
            raise KeyboardInterrupt("stopped after 3 of 440 steps")
        return made(scene, directory, *parts, **options)

    with monkeypatch.context() as patch:
        patch.setattr(estimate, "run_from", stopped)
        with pytest.raises(KeyboardInterrupt):
            plica.estimate_uncertainty(ringing, progress=False)
    first = (ringing / "uncertainty" / "step-2" / "results.h5").read_bytes()
    found = plica.estimate_uncertainty(ringing, progress=False)
    assert (ringing / "uncertainty" / "step-2" / "results.h5").read_bytes() == first
    assert calls[0] == "step-2"

    def refuses(**parts: Any) -> Any:
        raise AssertionError("a level was computed again")

    monkeypatch.setattr(_engine, "Simulation", refuses)
    again = plica.estimate_uncertainty(ringing, progress=False)
    assert again == found


def test_ctrl_c_says_how_to_go_on(
    ringing: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(*parts: Any, **options: Any) -> Any:
        raise KeyboardInterrupt("stopped after 3 of 440 steps")

    monkeypatch.setattr(estimate, "run_from", stopped)
    assert main(["uncertainty", str(ringing), "--quiet"]) == 130
    assert "stopped after 3 of 440 steps. Repeat the same command to continue." in capsys.readouterr().err


def test_a_level_without_a_solution_is_left_out_and_said(
    ringing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(17))
    found = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    assert found.levels == []
    assert found.source == "No level could be computed: the numerical error is unknown."
    assert "step-2 failed and is left out" in found.remarks[-2]
    assert found.measures["fundamental_frequency"].numerical is None


def test_a_level_whose_scene_cannot_be_used_is_left_out_and_said(
    ringing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*parts: Any, **options: Any) -> Any:
        raise plica.SceneError("finer.toml: mesh: it cannot be used.")

    monkeypatch.setattr(estimate, "run_from", refuses)
    found = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    assert found.levels == []
    assert "step-2 failed and is left out: finer.toml: mesh: it cannot be used." in found.remarks


def test_more_than_the_budget_is_left_out_and_said(ringing: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plica.uncertainty.plan.least_budget", 0.0)
    found = plica.estimate_uncertainty(ringing, budget=0.0, progress=False)
    assert [level["name"] for level in found.levels] == ["step-2"]
    assert any("step / 4 is left out" in remark for remark in found.remarks)
    assert any(
        remark.startswith("the error of the mesh is not estimated: allow more") for remark in found.remarks
    )


def test_a_directory_without_a_run_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["uncertainty", str(tmp_path)]) == 2
    assert "there is no run in it" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_supplied_flow_is_refused_by_name(phonating: plica.Scene, tmp_path: Path) -> None:
    """Its levels begin in the voice, where no flow can begin in still air."""
    trachea = {"uniform": {"length": 0.15, "area": 2e-4}, "supply": {"flow": {"flow": 2e-4}}}
    scene = phonating.replace({"trachea": trachea, "airflow.rise": "1 ms"})
    run: Any = SimpleNamespace(scene=scene)
    any_other: Any = SimpleNamespace()
    with pytest.raises(plica.InvalidInput, match=r"trachea\.supply is a flow; must be a pressure"):
        plan_levels(run, any_other, any_other, tmp_path, budget=1.0, other="auto")


def test_a_run_that_did_not_finish_is_refused(ringing: Path) -> None:
    for status, word in ((store.FAILED, "failed"), (store.INTERRUPTED, "interrupted")):
        set_status(ringing / "results.h5", status)
        with pytest.raises(plica.InvalidInput, match=f"its run is {word} after 220 of 220 steps"):
            plica.estimate_uncertainty(ringing)


def test_a_run_of_another_version_is_refused(ringing: Path) -> None:
    rewrite_text(ringing / "results.h5", "plica_version", "0.0.1")
    with pytest.raises(
        plica.InvalidInput, match=r"computed by plica 0\.0\.1; must be .* Run the scene again"
    ):
        plica.estimate_uncertainty(ringing)


def test_a_budget_that_is_none_is_refused(ringing: Path) -> None:
    for budget in (-1.0, float("nan")):
        with pytest.raises(plica.InvalidInput, match=r"budget = .*; must be a number in"):
            plica.estimate_uncertainty(ringing, budget=budget)


def test_too_few_cycles_leave_no_frequency_and_a_comparison_of_waveforms(
    bar: plica.Scene, tmp_path: Path
) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    found = plica.estimate_uncertainty(tmp_path / "run", mesh="none", progress=False)
    assert "fundamental_frequency" not in found.measures
    assert found.waveforms["probes.relative_error"].step is not None


def test_collisions_are_compared_too(colliding: plica.Scene, tmp_path: Path) -> None:
    plica.run(colliding, tmp_path / "run", progress=False)
    found = plica.estimate_uncertainty(tmp_path / "run", mesh="none", progress=False)
    duration = found.measures.get("contact_duration")
    assert duration is not None
    assert duration.numerical is not None
    assert duration.numerical >= colliding.time.step
    assert found.waveforms["contact_force_first.peak"].numerical is not None
    pressure = found.measures["peak_contact_pressure"].step
    assert pressure is not None
    assert pressure.verdict == "no convergence"  # its surfaces have mass


def test_a_mesh_on_which_a_trial_step_fails_is_left_out_and_said(
    ringing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(3))
    found = plica.estimate_uncertainty(ringing, progress=False)
    message = [remark for remark in found.remarks if "left out, a step of its trial failed: " in remark]
    assert [remark.partition(" is left out")[0] for remark in message] == [
        "a mesh with edges 0.67 times as long",
        "a mesh with edges 2 times as long",
    ]


def test_another_scene_in_place_of_the_run_has_levels_of_its_own(
    ringing: Path, bar: plica.Scene, tmp_path: Path
) -> None:
    first = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    scene = plica.Run.load(ringing).scene.replace({"tissue.body.E": "30 kPa", "time.duration": "36 ms"})
    for name in ("results.h5", "scene.toml", "checkpoint-a.h5", "checkpoint-b.h5"):
        (ringing / name).unlink(missing_ok=True)
    plica.run(scene, ringing, progress=False)
    plica.run(scene, tmp_path / "fresh", progress=False)
    second = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    assert second.measures != first.measures
    assert (
        second.measures
        == plica.estimate_uncertainty(tmp_path / "fresh", mesh="none", progress=False).measures
    )


def test_angles_about_half_a_turn_scatter_by_their_distance_on_the_circle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    apart = iter([0.01, -0.01] * 4)  # rad, from half a turn

    def measured(run: Any, cycles: Cycles) -> Measures:
        angle = np.pi + next(apart)
        return Measures([whole("left_right_phase", (angle + np.pi) % (2 * np.pi) - np.pi)])

    monkeypatch.setattr(sample, "measure", measured)
    run: Any = None
    means = Measures([whole("left_right_phase", np.pi)])
    found = sample._scatter(run, Cycles(np.arange(17.0)), means)
    t = 2.364624  # Student's, 97.5 % of seven degrees of freedom
    assert found["left_right_phase"] == pytest.approx(t * 0.01 / np.sqrt(7), rel=1e-6)


@pytest.mark.parametrize(("duration", "opens"), [("1 ms", True), ("1.5 ms", False)])
def test_the_widest_opening_is_a_state_of_the_run(
    duration: str, opens: bool, phonating: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(phonating.replace({"time.duration": duration}), tmp_path / "run", progress=False)
    start = widest_opening(run)
    assert start is not None
    assert start.time >= run.time[-1]
    longer = plica.run(phonating.replace({"time.duration": "4 ms"}), tmp_path / "longer", progress=False)
    area = np.asarray(longer.waveforms["minimum_area"])
    assert (area[run.steps] > area[run.steps - 1]) == opens  # where the checkpoint is
    widest = int(np.argmin(np.abs(longer.time - start.time)))
    assert area[widest - 1] <= area[widest] >= area[widest + 1]
    assert start.displacement.shape == start.velocity.shape == run.mesh.points.shape
    (tmp_path / "run" / "checkpoint-a.h5").unlink()
    (tmp_path / "run" / "checkpoint-b.h5").unlink()
    assert widest_opening(run) is None


def test_a_damaged_state_is_one_sentence_and_one_of_another_version_goes(tmp_path: Path) -> None:
    path = tmp_path / "uncertainty" / "start.h5"
    path.parent.mkdir()
    scene = SimpleNamespace(digest=lambda: "scene")
    run: Any = SimpleNamespace(scene=scene, steps=3, versions={"plica": "1"}, directory=tmp_path)
    _write(Start(0.5, np.ones((2, 3)), np.zeros((2, 3))), _identity(run), path)
    held = kept_start(run, path)
    assert held is not None
    assert held.time == 0.5
    run.versions["plica"] = "2"
    assert kept_start(run, path) is None  # there is no checkpoint to find one by
    assert not path.exists()
    path.write_bytes(b"no HDF5")
    with pytest.raises(plica.InvalidInput, match=r"start\.h5: is not .* Remove the directory"):
        kept_start(run, path)


def test_a_level_of_another_version_is_computed_anew(bar: plica.Scene, tmp_path: Path) -> None:
    level = PlannedLevel("step-2", "step", 2, bar)
    made = estimate._made(level, tmp_path / "step-2", (None, None), shown=False)
    rewrite_text(made.path, "plica_version", "0.0.1")
    again = estimate._made(level, tmp_path / "step-2", (None, None), shown=False)
    assert again.versions["plica"] == plica.__version__
