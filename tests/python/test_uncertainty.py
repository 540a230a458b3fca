"""The uncertainty of a run: what is computed, kept, said and refused."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from conftest import THESIS_TISSUE, TINY_LARYNX
from plica import _engine
from plica.cli import main
from plica.measures.cycles import Cycles
from plica.measures.measure import Measures, whole
from plica.phonation.run import store
from plica.uncertainty import estimate, sample
from plica.uncertainty.plan import PlannedLevel
from plica.uncertainty.sample import Sampled
from plica.uncertainty.start import kept_start, widest_opening
from test_run import StopsAfter


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
    said = capsys.readouterr()
    found = plica.Run.load(ringing).uncertainty
    assert found is not None
    assert json.loads((ringing / "uncertainty.json").read_text()) == found.as_json()
    with (ringing / "uncertainty.csv").open() as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    item = found.measures["probe_amplitude"]
    assert float(rows["probe_amplitude"]["numerical"]) == item.numerical
    assert rows["probe_amplitude"]["mesh_verdict"] == "not estimated"
    assert rows["probe_amplitude"]["mesh"] == ""
    assert "the error of the mesh is not estimated: it was not asked for" in said.out
    assert "2 levels from the start of the scene: about" in said.err
    assert "440 steps of 100 us" in said.err
    page = (ringing / "report.html").read_text()
    assert "numerical uncertainty" in page
    assert found.source in page
    assert "(step alone)" in page
    assert "The error of the mesh is not estimated: it was not asked for." in page
    before = page
    assert main(["report", str(ringing)]) == 0
    assert (ringing / "report.html").read_text() == before


def test_a_run_that_goes_on_has_no_uncertainty_of_the_shorter_one(ringing: Path) -> None:
    plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    scene = plica.Run.load(ringing).scene.replace({"time.duration": "50 ms"})
    plica.run(scene, ringing, resume=True, progress=False)
    assert not (ringing / "uncertainty.json").exists()
    assert not (ringing / "uncertainty.csv").exists()
    found = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    assert found.steps == 250
    assert found.levels[0]["steps"] == 500


def test_a_call_that_was_stopped_goes_on_and_computes_nothing_twice(
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
    assert "stopped after 3 of 440 steps. The same command goes on from there." in capsys.readouterr().err


def test_a_level_without_a_solution_is_left_out_and_said(
    ringing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(17))
    found = plica.estimate_uncertainty(ringing, mesh="none", progress=False)
    assert found.levels == []
    assert found.source == "No level could be computed: nothing is known of the numerical error."
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


def test_a_run_that_did_not_finish_is_refused(ringing: Path) -> None:
    for status, word in ((store.FAILED, "failed"), (store.INTERRUPTED, "interrupted")):
        with h5py.File(ringing / "results.h5", "r+") as file:
            file["progress/status"][()] = status
        with pytest.raises(plica.InvalidInput, match=f"its run is {word} after 220 of 220 steps"):
            plica.estimate_uncertainty(ringing)


def test_a_run_of_another_version_is_refused(ringing: Path) -> None:
    with h5py.File(ringing / "results.h5", "r+") as file:
        file.attrs["plica_version"] = "0.0.1"
    with pytest.raises(plica.InvalidInput, match=r"computed by plica 0\.0\.1; must be .* Run the scene anew"):
        plica.estimate_uncertainty(ringing)


def test_a_budget_that_is_none_is_refused(ringing: Path) -> None:
    for budget in (-1.0, float("nan")):
        with pytest.raises(plica.InvalidInput, match=r"budget = .*; must be >= 0"):
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


def test_a_mesh_file_is_refined_uniformly(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(10.0, 2.0, 2.0), divisions=(4, 1, 1))
    meshio.Mesh(np.asarray(mesh.points), [("tetra", np.asarray(mesh.cells))]).write(tmp_path / "bar.vtu")
    scene = plica.Scene(
        plica.MeshFile(
            file=tmp_path / "bar.vtu",
            unit="1 mm",
            surfaces={"left": {"plane": {"point": (0, 0, 0), "normal": (1, 0, 0)}}},
        ),
        {"body": plica.Tissue(E="20 kPa", nu=0.3)},
        time=plica.Stepping(step="0.1 ms", duration="2 ms"),
        supports=plica.Supports(fixed=["left"]),
        initial=plica.Initial(velocity={"body": (0.0, 0.0, 0.1)}),
        output=plica.Output(probes=[("10 mm", 0.0, 0.0)]),
    )
    plica.run(scene, tmp_path / "run", progress=False)
    found = plica.estimate_uncertainty(tmp_path / "run", progress=False)
    assert found.levels[1]["cells"] == 8 * len(mesh.cells)
    mesh_part = found.waveforms["probes.relative_error"].mesh
    assert mesh_part is not None
    assert mesh_part.verdict == "two levels"
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(10.0, 2.0, 3.0), divisions=(4, 1, 1))
    meshio.Mesh(np.asarray(mesh.points), [("tetra", np.asarray(mesh.cells))]).write(tmp_path / "bar.vtu")
    with pytest.raises(plica.SceneError, match="its points are not those of the run"):
        plica.estimate_uncertainty(tmp_path / "run", progress=False)


def test_a_level_on_a_mesh_file_that_changed_is_computed_anew(bar: plica.Scene, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    (tmp_path / "own").mkdir()
    finer = bar.replace({"mesh": _bar_file(meshio, tmp_path, (8, 2, 2))})
    own = bar.replace({"mesh": _bar_file(meshio, tmp_path / "own", (4, 1, 1))})
    plica.run(own, tmp_path / "run", progress=False)
    first = plica.estimate_uncertainty(tmp_path / "run", mesh=finer, progress=False)
    _bar_file(meshio, tmp_path, (10, 2, 2))
    second = plica.estimate_uncertainty(tmp_path / "run", mesh=finer, progress=False)
    assert [level["name"] for level in first.levels] == [level["name"] for level in second.levels]
    assert [level["cells"] for level in first.levels if level["kind"] == "mesh"] == [8 * 2 * 2 * 6]
    assert [level["cells"] for level in second.levels if level["kind"] == "mesh"] == [10 * 2 * 2 * 6]


def _bar_file(meshio: Any, folder: Path, divisions: tuple[int, int, int]) -> plica.MeshFile:
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(10.0, 2.0, 2.0), divisions=divisions)
    meshio.Mesh(np.asarray(mesh.points), [("tetra", np.asarray(mesh.cells))]).write(folder / "bar.vtu")
    return plica.MeshFile(
        file=folder / "bar.vtu",
        unit="1 mm",
        surfaces={"x_min": {"plane": {"point": (0, 0, 0), "normal": (1, 0, 0)}}},
    )


def test_a_mesh_on_which_a_trial_step_fails_is_left_out_and_said(
    ringing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(3))
    found = plica.estimate_uncertainty(ringing, progress=False)
    said = [remark for remark in found.remarks if "left out, a step of its trial failed: " in remark]
    assert [remark.partition(" is left out")[0] for remark in said] == [
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


def test_that_the_error_of_a_basis_is_not_seen_is_said(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = "the error of the reduction's basis is in no uncertainty here"
    plica.run(bar, tmp_path / "full", progress=False)
    full = plica.estimate_uncertainty(tmp_path / "full", mesh="none", progress=False)
    assert not any(said in remark for remark in full.remarks)
    plica.run(
        bar.replace({"reduction": {"modes": 10, "contact_vectors": 0}}), tmp_path / "run", progress=False
    )
    assert main(["uncertainty", str(tmp_path / "run"), "--mesh", "none"]) == 0
    assert said in capsys.readouterr().out
    assert said in (tmp_path / "run" / "uncertainty.json").read_text()
    assert said[1:] in (tmp_path / "run" / "report.html").read_text().replace("&#39;", "'")


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


@pytest.fixture(scope="module")
def voice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The directory of a voice of a very coarse larynx that has settled."""
    scene = plica.Scene(
        plica.Larynx(larynx="thesis_coarse", options=plica.LarynxOptions(**TINY_LARYNX)),
        {layer: plica.Tissue(**fields) for layer, fields in THESIS_TISSUE.items()},
        time=plica.Stepping(step="0.1 ms", duration="0.15 s"),
        airflow=plica.Airflow(subglottal_pressure="1.55 kPa", area=plica.Cut(sections=40)),
        contact=plica.Multipliers(),
        initial=plica.Initial(opening_velocity=0.1),
        output=plica.Output(checkpoint_every="50 ms"),
    )
    directory = tmp_path_factory.mktemp("voice") / "run"
    plica.run(scene, directory, progress=False)
    return directory


def test_levels_of_a_settled_voice_begin_in_its_orbit(voice: Path) -> None:
    found = plica.estimate_uncertainty(voice, mesh="none", progress=False)
    run = plica.Run.load(voice)
    frequency = found.measures["fundamental_frequency"]
    assert frequency.value == run.measures["fundamental_frequency"]["value"]
    assert frequency.step is not None
    assert set(frequency.step.values) == {"run", "step-2", "step-4"}
    assert found.waveforms == {}
    assert "from the settled voice at 150" in found.source
    assert "kinetic_energy" not in found.measures  # of the end of the run alone
    # a voice at the edge of contact: at smaller steps its folds do not touch
    assert found.measures["contact_impulse"].numerical is None
    assert any("contact_impulse" in remark for remark in found.remarks)
    assert all(level["steps"] < 2 * run.steps for level in found.levels)
    from_rest = plica.run(run.scene.replace({"time.step": "50 us"}), voice / "half", progress=False)
    assert frequency.step.values["step-2"] == pytest.approx(
        from_rest.measures["fundamental_frequency"]["value"], rel=5e-3
    )


def test_a_voice_goes_on_where_it_was_stopped_at_the_same_state(voice: Path) -> None:
    first = plica.estimate_uncertainty(voice, mesh="none", progress=False)
    for slot in voice.glob("checkpoint-*.h5"):
        slot.unlink()  # the state is kept with the levels
    for left in (voice / "uncertainty" / "orbit-step-4").iterdir():
        left.unlink()
    again = plica.estimate_uncertainty(voice, mesh="none", progress=False)
    assert again.measures == first.measures


def test_a_voice_that_goes_on_has_a_state_and_levels_of_its_own(voice: Path, tmp_path: Path) -> None:
    longer = tmp_path / "run"
    shutil.copytree(voice, longer)
    plica.estimate_uncertainty(longer, mesh="none", budget=0.0, progress=False)
    with h5py.File(longer / "uncertainty" / "start.h5") as file:
        before = float(file.attrs["time"])
    energy = plica.Run.load(longer / "uncertainty" / "orbit-step-2").waveforms["kinetic_energy"][0]
    mine = longer / "uncertainty" / "orbit-notes"
    mine.mkdir()
    plica.run(
        plica.Run.load(longer).scene.replace({"time.duration": "0.2 s"}), longer, resume=True, progress=False
    )
    found = plica.estimate_uncertainty(longer, mesh="none", budget=0.0, progress=False)
    with h5py.File(longer / "uncertainty" / "start.h5") as file:
        after = float(file.attrs["time"])
    assert before < 0.2 <= after
    level = plica.Run.load(longer / "uncertainty" / "orbit-step-2")
    assert level.waveforms["kinetic_energy"][0] != energy  # it began anew
    assert f"from the settled voice at {1e3 * after:.4g} ms" in found.source
    assert mine.is_dir()


@pytest.mark.parametrize("settles_after", [1, 2, 3, 9])
def test_a_level_that_has_not_settled_goes_on_twice_and_no_more(
    settles_after: int, bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lengths: list[int] = []

    class Made:
        def __init__(self, steps: int) -> None:
            self.steps = steps

        def between(self, start: float, end: None) -> Made:
            return self

    def continued(level: PlannedLevel, *parts: Any, **options: Any) -> Any:
        lengths.append(level.scene.time.steps)
        return Made(level.scene.time.steps)

    def sampled(run: Any, *, of_cycles: bool) -> Sampled:
        settled = len(lengths) >= settles_after
        return Sampled(Cycles(np.arange(10.0), verdict="steady" if settled else "changing"), {})

    monkeypatch.setattr(estimate, "_continued", continued)
    monkeypatch.setattr(estimate, "sampled", sampled)
    monkeypatch.setattr(estimate, "fields_of", lambda *parts: (None, None))
    own = Sampled(Cycles(1e-3 * np.arange(10)), {})  # nine cycles of ten steps
    level = PlannedLevel("step-2", "step", 2, bar)
    start: Any = object()
    run: Any = None
    made = estimate._run_level(level, run, own, start, tmp_path, shown=False)
    assert lengths == [40, 130, 220][: min(settles_after, 3)]
    assert made.found.cycles.settled == (settles_after <= 3)


def test_a_second_call_makes_a_level_no_longer_than_the_first(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = 40

    class Made:
        @property
        def steps(self) -> int:
            return held

        def between(self, start: float, end: None) -> Made:
            return self

    def continued(level: PlannedLevel, *parts: Any, **options: Any) -> Any:
        nonlocal held
        held = max(held, level.scene.time.steps)
        return Made()

    changing = Sampled(Cycles(np.arange(10.0), verdict="changing"), {})
    monkeypatch.setattr(estimate, "_continued", continued)
    monkeypatch.setattr(estimate, "sampled", lambda run, *, of_cycles: changing)
    monkeypatch.setattr(estimate, "fields_of", lambda *parts: (None, None))
    own = Sampled(Cycles(1e-3 * np.arange(10)), {})
    level = PlannedLevel("step-2", "step", 2, bar)
    start: Any = object()
    run: Any = None
    for _ in range(2):
        estimate._run_level(level, run, own, start, tmp_path, shown=False)
        assert held == 40 + 2 * 90


def test_a_damaged_state_is_one_sentence_and_one_of_another_version_goes(tmp_path: Path) -> None:
    path = tmp_path / "uncertainty" / "start.h5"
    path.parent.mkdir()
    scene = SimpleNamespace(digest=lambda: "scene")
    run: Any = SimpleNamespace(scene=scene, steps=3, versions={"plica": "1"}, directory=tmp_path)
    with h5py.File(path, "w") as file:
        file.attrs.update({"scene": "scene", "steps": 3, "plica": "1", "time": 0.5})
        file["displacement"], file["velocity"] = np.ones((2, 3)), np.zeros((2, 3))
    held = kept_start(run, path)
    assert held is not None
    assert held.time == 0.5
    run.versions["plica"] = "2"
    assert kept_start(run, path) is None  # there is no checkpoint to find one by
    assert not path.exists()
    path.write_bytes(b"no HDF5")
    with pytest.raises(plica.InvalidInput, match=r"start\.h5: is damaged; must be .* Remove the directory"):
        kept_start(run, path)


def test_a_level_of_another_version_is_computed_anew(bar: plica.Scene, tmp_path: Path) -> None:
    level = PlannedLevel("step-2", "step", 2, bar)
    made = estimate._made(level, tmp_path / "step-2", (None, None), shown=False)
    with h5py.File(made.path, "r+") as file:
        file.attrs["plica_version"] = "0.0.1"
    again = estimate._made(level, tmp_path / "step-2", (None, None), shown=False)
    assert again.versions["plica"] == plica.__version__
