"""Runs: what is stored, what survives a kill, and that a continued run is the same run."""

from __future__ import annotations

import errno
import json
import os
import pickle
import random
import re
import resource
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import meshio
import numpy as np
import pytest

import plica
from plica import _engine
from plica.cli import main
from plica.measures.file import write_measures
from plica.phonation.measures.measure import measure
from plica.phonation.run import checkpoint

PROGRAM = """
import sys, plica
scene = plica.Scene.load(sys.argv[1])
plica.run(scene, sys.argv[2], resume="--resume" in sys.argv, progress=False)
"""


def start(scene: Path, directory: Path, *options: str, **settings: Any) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", PROGRAM, str(scene), str(directory), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **settings)


def data_sets(path: Path) -> dict[str, Any]:
    """Every data set but the wall time."""
    found: dict[str, Any] = {}
    with h5py.File(path, "r", locking=False) as file:
        file.visititems(
            lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None
        )
    del found["progress/seconds"]
    return found


def assert_identical(one: Path, other: Path) -> None:
    a, b = data_sets(one / "results.h5"), data_sets(other / "results.h5")
    assert a.keys() == b.keys()
    for name, values in a.items():
        one_array, other_array = np.asarray(values), np.asarray(b[name])
        if one_array.dtype == object:  # texts
            assert one_array.tolist() == other_array.tolist(), name
        else:
            assert one_array.tobytes() == other_array.tobytes(), name


def steps_stored(directory: Path) -> int:
    """Steps that the result file promises; -1 before there is one."""
    try:
        with h5py.File(directory / "results.h5", "r", locking=False) as file:
            return int(file["progress/steps"][()])
    except OSError:
        return -1


def kill_after(
    process: subprocess.Popen[str], directory: Path, steps: int, number: int = signal.SIGKILL
) -> bool:
    """Send a signal as soon as so many steps are stored; whether it ended the process."""
    until = time.monotonic() + 60
    while process.poll() is None and steps_stored(directory) < steps and time.monotonic() < until:
        time.sleep(0.002)
    process.send_signal(number)
    process.communicate()
    return process.returncode == -number


def longer(scene: plica.Scene, factor: int) -> plica.Scene:
    duration = scene.time.duration
    return plica.Scene.from_text(
        scene.text().replace(f"duration = {duration}", f"duration = {factor * duration}")
    )


def test_a_run_stores_every_step_and_the_frames_asked_for(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    assert (run.status, run.steps, run.frames) == ("finished", 40, 9)
    np.testing.assert_allclose(run.time, 1e-4 * np.arange(1, 41), rtol=1e-12)
    np.testing.assert_allclose(run.fields["time"], 5e-4 * np.arange(9), rtol=1e-12)
    assert run.displacement.shape == (9, len(run.mesh.points), 3)
    probe = np.argmin(((run.mesh.points - [0.01, 0, 0]) ** 2).sum(axis=1))
    stored = run.displacement[:, probe]
    assert np.abs(stored).max() > 1e-6
    # the fields are stored in single precision
    np.testing.assert_allclose(stored[1:], run["probes"][4::5, 0], rtol=1e-6, atol=1e-12)
    assert not stored[0].any()
    np.testing.assert_array_equal(np.asarray(run.displacement)[-1], run.displacement[-1])
    assert run.scene == bar
    assert run.units["kinetic_energy"] == "J"
    assert not any(np.isnan(values).any() for values in run.values())


def test_a_loaded_run_is_the_run(bar: plica.Scene, tmp_path: Path) -> None:
    made = plica.run(bar, tmp_path / "run", progress=False)
    loaded = plica.Run.load(tmp_path / "run")
    assert set(loaded) == set(made)
    assert all(np.array_equal(loaded[name], made[name]) for name in made)
    assert plica.Scene.load(tmp_path / "run" / "scene.toml") == bar


def test_a_run_says_which_contact_solver_it_took(
    bar: plica.Scene, colliding: plica.Scene, tmp_path: Path
) -> None:
    assert "contact solver" not in plica.run(bar, tmp_path / "bar", progress=False).versions
    for asked, taken in {"auto": "condensed", "saddle": "saddle"}.items():
        data = colliding.resolved()
        data["contact"]["multipliers"]["solver"] = asked
        run = plica.run(plica.Scene.model_validate(data), tmp_path / asked, progress=False)
        assert run.versions["contact solver"] == taken


def test_without_fields_there_are_none(bar: plica.Scene, tmp_path: Path) -> None:
    scene = plica.Scene.from_text(bar.text().replace("every = 0.0005", ""))
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert run.fields == {}
    assert not (tmp_path / "run" / "fields.xdmf").exists()
    with pytest.raises(plica.InvalidInput, match=r"output\.every"):
        run.displacement  # noqa: B018
    with h5py.File(run.path, "r") as file:
        assert set(file) == {"mesh", "progress", "waveforms"}


def test_fields_can_begin_late(bar: plica.Scene, tmp_path: Path) -> None:
    scene = plica.Scene.from_text(bar.text().replace("start = 0.0", "start = 0.003"))
    run = plica.run(scene, tmp_path / "run", progress=False)
    np.testing.assert_allclose(run.fields["time"], [3e-3, 3.5e-3, 4e-3], rtol=1e-12)


def test_the_first_frame_is_the_state_at_the_start(phonating: plica.Scene, tmp_path: Path) -> None:
    opened = phonating.replace({"initial": plica.Initial(opening_displacement="0.3 mm")})
    run = plica.run(opened, tmp_path / "run", progress=False)
    simulation = plica.build_simulation(opened)
    np.testing.assert_array_equal(run.fields["time"][:2], [0.0, 2e-4])
    first = np.asarray(simulation.displacement, dtype=np.float32)
    assert np.abs(first).max() == pytest.approx(0.3e-3, rel=0.3)
    np.testing.assert_array_equal(run.displacement[0], first)
    assert not run.fields["contact_pressure"][0].any()
    grid = ElementTree.parse(tmp_path / "run" / "fields.xdmf").find(".//Grid[@Name='frame 0']/Time")
    assert grid is not None
    assert grid.get("Value") == "0"


def test_a_table_of_the_waveforms_has_a_row_a_step_without_probes(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    assert run["probes"].shape == (40, 0, 3)
    data = run.to_xarray()
    assert set(data) == set(run) - {"time", "probes"}
    assert len(data[["flow", "kinetic_energy"]].to_dataframe()) == 40
    assert len(data.to_dataframe()) == 40 * len(run.section_height) * 3


def test_what_was_measured_while_a_run_went_on_is_not_taken_for_its_measures(
    bar: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    half = measure(run.between(None, 0.5 * float(run.time[-1])))
    write_measures(half, tmp_path / "run" / "measures.json")
    assert half["steps"].value != run.steps
    assert plica.Run.load(tmp_path / "run").measures == measure(run).as_json()


def test_a_waveform_that_is_not_there_is_answered_with_the_nearest(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    with pytest.raises(KeyError) as missing:
        run["prbes"]
    assert isinstance(missing.value, plica.InvalidInput)
    assert str(missing.value).startswith(f'Run {tmp_path / "run"}: "prbes"; must be one of ')
    assert str(missing.value).endswith(' Did you mean "probes"?')
    assert all(name in str(missing.value) for name in run)
    assert run.get("flow") is None
    assert "flow" not in run


def test_an_xarray_has_the_waveforms_with_units(phonating: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    data = run.to_xarray()
    assert data["flow"].dims == ("time",)
    assert data["section_area"].dims == ("time", "section")
    assert data["coronal_left"].dims == ("time", "section", "component")
    assert data["contact_force_first"].dims == ("time", "component")
    assert data["flow"].attrs["units"] == "m^3/s"
    np.testing.assert_array_equal(data["section"], run.section_height)
    assert np.abs(run["flow"]).max() > 0


def test_steps_whose_coupling_does_not_converge_are_kept_and_counted(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    text = phonating.text().replace("max_sweeps = 40", "max_sweeps = 2")
    scene = plica.Scene.from_text(text.replace("freeze_after = 8", "freeze_after = 1"))
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert (run.status, run.steps) == ("finished", 40)
    converged, frozen = run["coupling_converged"] == 1, run["coupling_frozen"] == 1
    assert 0 < converged.sum() < 40
    np.testing.assert_array_equal(converged, run["coupling_residual"] <= 1e-5)
    np.testing.assert_array_equal(frozen, run["coupling_sweeps"] == 2)
    assert frozen[~converged].all()
    assert run.measures["coupling_converged_fraction"]["value"] == pytest.approx(converged.mean())
    assert run.measures["coupling_frozen_fraction"]["value"] == pytest.approx(frozen.mean())


def test_a_run_that_an_older_version_stored_is_opened_under_todays_names(
    colliding: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(colliding, tmp_path / "run", progress=False)
    new = run["largest_contact_pressure"]
    assert new.max() > 0
    with h5py.File(run.path, "r+") as file:
        file.move("waveforms/largest_contact_pressure", "waveforms/peak_contact_pressure")
    old = {"open_quotient": {"value": 0.6, "unit": "1", "spread": None, "cycles": 5, "note": "above 1 %"}}
    (tmp_path / "run" / "measures.json").write_text(json.dumps(old))
    run = plica.Run.load(tmp_path / "run")
    np.testing.assert_array_equal(run["largest_contact_pressure"], new)
    assert run.units["largest_contact_pressure"] == "Pa"
    assert "peak_contact_pressure" not in run
    assert run.measures["steps"]["value"] == run.steps  # measured anew: the file's have other definitions
    assert "open_quotient" not in run.measures
    with pytest.raises(plica.InvalidInput, match=r'"f0"; must be one of .*contact_impulse'):
        run.measures["f0"]


def test_paraviews_index_points_at_what_is_there(colliding: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(colliding, tmp_path / "run", progress=False)
    tree = ElementTree.parse(tmp_path / "run" / "fields.xdmf")
    grids = tree.findall(".//Grid[@GridType='Collection']/Grid")
    assert len(grids) == run.frames == 11
    with h5py.File(run.path, "r") as file:
        for item in tree.iter("DataItem"):
            if item.get("Format") == "HDF":
                name = (item.text or "").split(":")[1]
                assert file[name].shape == tuple(int(extent) for extent in item.get("Dimensions", "").split())
    assert {item.get("Name") for item in grids[0].findall("Attribute")} == {
        "displacement",
        "contact_pressure",
        "cell_layer",
        "cell_side",
    }


def test_an_occupied_directory_is_left_alone(bar: plica.Scene, tmp_path: Path) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    before = {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}
    with pytest.raises(plica.InvalidInput, match="--resume"):
        plica.run(bar, tmp_path / "run", progress=False)
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}


def test_a_run_is_continued_with_its_own_scene_only(bar: plica.Scene, tmp_path: Path) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    other = plica.Scene.from_text(bar.text().replace("nu = 0.3", "nu = 0.31"))
    with pytest.raises(plica.SceneError, match=r"tissue\.body\.nu = 0\.31; the run has 0\.3"):
        plica.run(other, tmp_path / "run", progress=False, resume=True)


class StopsAfter:
    """A simulation whose step number `last` + 1 fails, under a force that is not finite."""

    def __init__(self, last: int) -> None:
        self.last, self.made = last, _engine.Simulation

    def __call__(self, *args: Any, **fields: Any) -> Any:
        inner, last = self.made(*args, **fields), self.last

        class Stopping:
            def __getattr__(self, name: str) -> Any:
                return getattr(inner, name)

            def advance(self, steps: int) -> Any:
                good = last - inner.step_count
                if good >= steps:
                    return inner.advance(steps)
                waveforms = inner.advance(good)
                inner.set_external_force(np.full_like(inner.displacement, np.inf))
                with pytest.raises(plica.StepFailed) as failure:
                    inner.advance(steps - good)
                raise plica.StepFailed(str(failure.value), waveforms)

        return Stopping()


@pytest.mark.parametrize("last", [1, 17, 39])
def test_a_step_that_fails_costs_no_step_before_it(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, last: int
) -> None:
    whole = plica.run(bar, tmp_path / "whole", progress=False)
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(last))
    with pytest.raises(plica.SolveFailed, match=f"{last} of 40 steps are kept"):
        plica.run(bar, tmp_path / "run", progress=False)
    monkeypatch.undo()
    run = plica.Run.load(tmp_path / "run")
    assert (run.status, run.steps) == ("failed", last)
    assert run.failure.startswith(f"Step {last + 1} (t = ")
    assert all(np.array_equal(run[name], whole[name][:last]) for name in whole)
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def forget_waveform(directory: Path) -> None:
    """As if an older version had written the run, which did not record this yet."""
    with h5py.File(directory / "results.h5", "r+") as file:
        del file["waveforms/inverted_tissue"]


def forget_first_frame(directory: Path) -> None:
    """As if an older version had written the run, which did not store the state at t = 0."""
    with h5py.File(directory / "results.h5", "r+") as file:
        for name, values in [(name, values[1:]) for name, values in file["fields"].items()]:
            del file[f"fields/{name}"]
            file[f"fields/{name}"] = values


def forget_state(directory: Path) -> None:
    """As if an older version had written the checkpoints, which did not need this yet."""
    held = checkpoint.newest(directory)
    assert held is not None
    for slot in directory.glob("checkpoint-*.h5"):
        slot.unlink()
    state = {name: values for name, values in held.state.items() if name != "depth"}
    checkpoint.write(directory, checkpoint.Checkpoint(held.steps, held.scene, state))


def forget_digest(directory: Path) -> None:
    """As if an older version had written the checkpoints, which belonged to one duration."""
    held = checkpoint.newest(directory)
    assert held is not None
    for slot in directory.glob("checkpoint-*.h5"):
        slot.unlink()
    checkpoint.write(directory, checkpoint.Checkpoint(held.steps, "0" * 64, held.state))


@pytest.mark.parametrize(
    ("forget", "name"),
    [
        (forget_waveform, "inverted_tissue"),
        (forget_first_frame, "frame at t = 0"),
        (forget_state, "depth"),
        (forget_digest, "checkpoint of this scene"),
    ],
    ids=["waveform", "frame", "state", "digest"],
)
def test_a_run_of_an_older_version_is_not_continued_and_left_alone(
    bar: plica.Scene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    forget: Callable[[Path], None],
    name: str,
) -> None:
    directory = tmp_path / "run"
    bar.save(tmp_path / "scene.toml")
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(17))
    with pytest.raises(plica.SolveFailed):
        plica.run(bar, directory, progress=False)
    monkeypatch.undo()
    forget(directory)
    before = {path.name: path.read_bytes() for path in directory.iterdir()}
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(directory), "--resume", "--quiet"]) == 2
    assert capsys.readouterr().err == (
        f"plica: {directory}: cannot be continued: there is no {name} in it. "
        "An older version of plica wrote it. Run the scene anew into another directory.\n"
    )
    assert before == {path.name: path.read_bytes() for path in directory.iterdir()}


def test_a_step_that_comes_to_what_the_engine_refuses_has_failed(phonating: plica.Scene) -> None:
    simulation = plica.build_simulation(plica.Scene(**{**dict(phonating), "contact": None}))
    state = simulation.state()
    state["displacement"] = 1.5e308 * np.sign(state["velocity"])  # finite; the width of the glottis is not
    simulation.restore(state)
    with pytest.raises(plica.SolveFailed, match=r"Step 1 \(t = 5e-05 s\): Airflow: areas are not finite"):
        simulation.advance(3)


def failing(scene: plica.Scene, case: str) -> plica.Scene:
    """The larynx where it folds over itself, and contact finds no solution later."""
    fields = dict(scene)
    if case == "20 kPa":
        fields["airflow"] = plica.Airflow(subglottal_pressure="20 kPa")
    if case == "ten times softer":
        fields["initial"] = plica.Initial(opening_velocity=-2.0)
        fields["tissue"] = {
            layer: plica.Tissue.model_validate(
                tissue.model_dump(exclude_none=True)
                | {name: 0.1 * getattr(tissue, name) for name in ("E", "E_fibre", "mu_fibre")}
            )
            for layer, tissue in scene.tissue.items()
        }
    if case == "quadratic, 1e-9 m apart":
        fields["initial"] = plica.Initial(opening_velocity=-2.0, opening_displacement=-0.25e-3 + 0.5e-9)
        fields["mesh"] = scene.mesh.replace({"order": 2})
    return plica.Scene(**fields)


def test_advance_raises_at_once_and_hands_over_the_steps_before(phonating: plica.Scene) -> None:
    scene = failing(phonating, "20 kPa")
    one_by_one, at_once = plica.build_simulation(scene), plica.build_simulation(scene)
    steps: list[dict[str, Any]] = []
    alone: plica.StepFailed | None = None
    while alone is None:
        try:
            steps.append(one_by_one.advance(1))
        except plica.StepFailed as error:
            alone = error
    assert len(steps) > 10
    with pytest.raises(plica.SolveFailed) as together:
        at_once.advance(200)
    assert str(together.value) == str(alone)
    assert isinstance(together.value, plica.StepFailed)
    kept = together.value.waveforms
    assert set(kept) == set(steps[0])
    for name, values in kept.items():
        assert np.array_equal(values, np.concatenate([step[name] for step in steps]), equal_nan=True)
    assert at_once.step_count == len(steps)
    assert len(alone.waveforms["time"]) == 0
    again = pickle.loads(pickle.dumps(together.value))
    assert str(again) == str(together.value)
    assert np.array_equal(again.waveforms["time"], kept["time"])


@pytest.mark.parametrize(
    "case",
    ["20 kPa", "ten times softer", pytest.param("quadratic, 1e-9 m apart", marks=pytest.mark.slow)],
)
def test_a_failure_names_the_first_folded_tissue_and_when_also_after_a_resume(
    phonating: plica.Scene, case: str
) -> None:
    scene = failing(phonating, case)
    mesh = plica.build_mesh(scene.mesh)
    simulation = plica.build_simulation(scene, mesh)
    while not simulation.advance(1)["inverted_tissue"][0]:
        pass
    step = simulation.step_count
    x = np.asarray(mesh.points) + simulation.displacement
    cells = np.asarray(mesh.cells)
    expected = rf"First sign: at t = {step * 5e-5:g} s "
    resumed = plica.build_simulation(scene, mesh)
    resumed.restore(simulation.state())
    said = []
    for one in (simulation, resumed):
        with pytest.raises(plica.SolveFailed, match=expected) as failure:
            one.advance(200)
        assert one.step_count > step  # long before
        said.append(str(failure.value))
    assert said[0] == said[1]
    found = re.search(
        r"(\d+) tissue cells folded, the first cell (\d+) at \((\S+), (\S+), (\S+)\) m; (\d+) are now",
        said[0],
    )
    assert found is not None
    number, cell, *place, now = found.groups()
    if cells.shape[1] == 4:
        inverted = np.flatnonzero(_engine.signed_volumes(x, cells) <= 0)
        assert (int(number), int(cell)) == (len(inverted), inverted[0])
    assert np.array(place, float) == pytest.approx(x[cells[int(cell), :4]].mean(0), rel=1e-5)
    assert int(now) == int(failure.value.waveforms["inverted_tissue"][-1])


def write_cube(path: Path, *, bottom: tuple[int, int] = (11, 11)) -> None:
    """A cube with its tetrahedra labelled 1, the two triangles of its bottom as given, of its top 12."""
    cube = plica.build_mesh(plica.Block(size=(0.01, 0.01, 0.01), divisions=(1, 1, 1)))
    cells = [("tetra", np.asarray(cube.cells))]
    cells += [("triangle", np.concatenate([cube.surfaces["z_min"], cube.surfaces["z_max"]]))]
    labels = [np.ones(len(cells[0][1]), dtype=int), np.array([*bottom, 12, 12])]
    meshio.Mesh(np.asarray(cube.points), cells, cell_data={"label": labels}).write(path)


def on_a_file(file: str) -> plica.Scene:
    return plica.Scene(
        plica.MeshFile(file=file, layers={"body": 1}, surfaces={"bottom": 11, "ends": (11, 12)}),
        {"body": plica.Tissue(E=20e3, nu=0.3)},
        time=plica.Stepping(step=1e-4, duration=2e-3),
        supports=plica.Supports(fixed=["bottom"]),
        initial=plica.Initial(velocity={"body": (0.0, 0.0, 0.1)}),
    )


def test_a_scene_made_in_python_is_continued_from_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_cube(tmp_path / "cube.vtu")
    scene = on_a_file("cube.vtu")
    plica.run(scene, tmp_path / "whole", progress=False)
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(7))
    with pytest.raises(plica.SolveFailed):
        plica.run(scene, tmp_path / "run", progress=False)
    monkeypatch.undo()
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert plica.Run.load(tmp_path / "run").scene == scene
    plica.run(scene, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_a_run_is_not_continued_where_the_surfaces_have_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "cube.vtu"
    write_cube(path)
    scene = on_a_file(str(path))
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(7))
    with pytest.raises(plica.SolveFailed):
        plica.run(scene, tmp_path / "run", progress=False)
    monkeypatch.undo()
    write_cube(path, bottom=(11, 12))
    with pytest.raises(plica.SceneError, match="surfaces are not those of the run"):
        plica.run(scene, tmp_path / "run", progress=False, resume=True)


def test_a_finished_run_is_not_that_of_a_mesh_file_that_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "cube.vtu"
    write_cube(path)
    scene = on_a_file(str(path))
    run = plica.run(scene, tmp_path / "run", progress=False)
    write_cube(path, bottom=(11, 12))
    with pytest.raises(plica.SceneError, match="surfaces are not those of the run"):
        plica.run(scene, tmp_path / "run", progress=False, resume="if_there")
    path.unlink()  # nothing to compare with
    assert plica.run(scene, tmp_path / "run", progress=False, resume="if_there").steps == run.steps


def test_a_first_step_that_fails_leaves_nothing(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(0))
    with pytest.raises(plica.SolveFailed):
        plica.run(bar, tmp_path / "run", progress=False)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("damage", ["cut", "turned", "gone", "both"])
def test_a_damaged_checkpoint_is_passed_over(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    plica.run(bar, tmp_path / "whole", progress=False)
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(35))
    with pytest.raises(plica.SolveFailed):
        plica.run(bar, tmp_path / "run", progress=False)
    monkeypatch.undo()
    slots = sorted((tmp_path / "run").glob("checkpoint-*.h5"))
    assert len(slots) == 2
    held = checkpoint.newest(tmp_path / "run")
    assert held is not None
    assert held.steps == 35
    for slot in slots:
        with h5py.File(slot, "r") as file:
            newest = file.attrs["steps"] == 35
        if damage == "both":
            slot.write_bytes(b"")
        elif newest:
            content = bytearray(slot.read_bytes())
            if damage == "turned":
                with h5py.File(slot, "r+") as file:
                    file["state/velocity"][-1] += 1.0
            elif damage == "cut":
                slot.write_bytes(content[: len(content) // 2])
            else:
                slot.unlink()
    left = checkpoint.newest(tmp_path / "run")
    assert (left is None) == (damage == "both")
    assert left is None or left.steps == 30
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_one_process_at_a_time(bar: plica.Scene, tmp_path: Path) -> None:
    from plica.storage.files import only_writer

    (tmp_path / "run").mkdir()
    with only_writer(tmp_path / "run"), pytest.raises(plica.InvalidInput, match="another process"):
        plica.run(bar, tmp_path / "run", progress=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "factor", "moments"), [("bar", 10, 3), ("colliding", 5, 3), ("phonating", 4, 5)]
)
def test_a_killed_run_can_be_read_and_continues_to_identical_results(
    name: str, factor: int, moments: int, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    scene = longer(request.getfixturevalue(name), factor)
    total = scene.time.steps
    scene.save(tmp_path / "scene.toml")
    plica.run(scene, tmp_path / "whole", progress=False)
    whole = plica.Run.load(tmp_path / "whole")
    seed = random.Random(name)
    kills = 0
    for attempt in range(moments):
        directory = tmp_path / f"run{attempt}"
        process = start(tmp_path / "scene.toml", directory)
        kills += kill_after(process, directory, seed.randrange(1, total // 2))
        for _ in range(2):  # a second kill while it is being continued
            if steps_stored(directory) >= 0:
                run = plica.Run.load(directory)
                assert all(np.array_equal(run[name], whole[name][: run.steps]) for name in whole)
                assert np.array_equal(
                    np.asarray(run.displacement), np.asarray(whole.displacement)[: run.frames]
                )
            process = start(tmp_path / "scene.toml", directory, *(["--resume"] if directory.exists() else []))
            kill_after(process, directory, min(total - 1, steps_stored(directory) + seed.randrange(1, 20)))
        last = start(tmp_path / "scene.toml", directory, "--resume")
        _, said = last.communicate()
        assert last.returncode == 0, said
        assert_identical(directory, tmp_path / "whole")
    assert kills == moments  # each at its own moment, in the first half of the run


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_asked_to_stop_keeps_everything(bar: plica.Scene, tmp_path: Path, number: int) -> None:
    scene = longer(bar, 1000)
    scene.save(tmp_path / "scene.toml")
    process = start(tmp_path / "scene.toml", tmp_path / "run")
    kill_after(process, tmp_path / "run", 20, number)
    run = plica.Run.load(tmp_path / "run")
    assert run.status == "interrupted"
    assert 20 <= run.steps < scene.time.steps
    held = checkpoint.newest(tmp_path / "run")
    assert held is not None
    assert held.steps == run.steps


@pytest.mark.slow
def test_a_full_disk_is_one_sentence_and_leaves_nothing(bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "scene.toml")

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    command = [
        sys.executable,
        "-m",
        "plica.cli",
        "run",
        str(tmp_path / "scene.toml"),
        "-o",
        str(tmp_path / "run"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=limit, check=False)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "the results need" in done.stderr
    assert "File too large" in done.stderr
    assert not (tmp_path / "run").exists()


def test_a_file_that_cannot_be_replaced_stays_as_it_was(tmp_path: Path) -> None:
    from plica.storage.files import replaced

    def fill_the_disk(path: Path) -> None:
        path.write_text("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "file"
    path.write_text("old")
    with pytest.raises(plica.StorageFailed, match="file: cannot be written: No space left on device"):
        replaced(path, fill_the_disk)
    assert [(left.name, left.read_text()) for left in tmp_path.iterdir()] == [("file", "old")]


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_directory_that_cannot_be_written_is_one_sentence(bar: plica.Scene, tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(plica.StorageFailed, match="Permission denied"):
        plica.run(bar, tmp_path / "closed" / "run", progress=False)
