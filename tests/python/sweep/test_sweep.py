"""Sweeps that are computed, interrupted, continued and refused; a case is what a run is."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import distributed
import numpy as np
import pytest
import xarray

import plica
from plica.measures.catalogue import CATALOGUE
from plica.runs.build import build_simulation
from plica.storage.files import only_writer
from plica.sweep import Plan, Sweep, driver, scene_cases, store
from plica.sweep import run as sweep
from plica.sweep.case import CaseResult, Task, run_case
from plica.sweep.scene_cases import SceneCases
from sweeps import NU, E, assert_equal, in_pending

pytestmark = pytest.mark.usefixtures("here")


def _task(scene: plica.Scene, **given: Any) -> Task:
    fields = {"case": 0, "digest": "x", "changes": {}, "waveforms": (), "version": plica.__version__}
    return Task(subject=SceneCases(scene), **{**fields, **given})


@pytest.mark.parametrize("name", ["bar", "phonating"])
def test_a_case_is_what_a_run_is(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """Measures, cautions and waveforms, to the bit."""
    scene: plica.Scene = request.getfixturevalue(name)
    found = run_case(_task(scene, waveforms=("kinetic_energy",)))
    kept = run_case(_task(scene, folder=str(tmp_path / "kept")))
    whole = plica.run(scene, tmp_path / "run", progress=False)
    assert found.status == "done"
    assert found.measures == kept.measures
    assert found.measures == {
        name: (item.value, item.spread, item.uncertainty) for name, item in whole.measures.items()
    }
    assert found.cautions == tuple(one.name for one in whole.cautions)
    assert found.waveforms["kinetic_energy"].tobytes() == whole["kinetic_energy"].tobytes()
    assert found.waveforms["time"].tobytes() == whole.time.tobytes()


def test_a_sweep_has_each_case_at_its_place(plan: Plan, bar: plica.Scene, tmp_path: Path) -> None:
    found = sweep(plan, tmp_path / "sweep", progress=False)
    assert found.counts == {"waiting": 0, "done": 8, "refused": 2, "failed": 0}
    data = found.dataset
    assert dict(data.sizes) == {NU: 5, E: 2, "time": 40}
    assert {name: data[name].attrs["units"] for name in (NU, E, "time", "kinetic_energy")} == {
        NU: "1",
        E: "Pa",
        "time": "s",
        "kinetic_energy": "J",
    }
    own = plica.run(bar.replace({NU: 0.2, E: "20 kPa"}), tmp_path / "run", progress=False)
    at = data.sel({NU: 0.2, E: 20e3})
    for name in ("probe_amplitude", "kinetic_energy"):
        assert float(at[name]) == own.measures[name].value
    assert at["waveform_kinetic_energy"].values.tobytes() == own["kinetic_energy"].tobytes()
    assert np.isnan(data["kinetic_energy"].sel({NU: 0.5})).all()


def test_files_have_the_same_as_the_data_set(plan: Plan, tmp_path: Path) -> None:
    found = sweep(plan, tmp_path, progress=False)
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.load(), found.dataset.load())
    with xarray.open_zarr(tmp_path / "results.zarr", consolidated=False) as stored:
        assert stored[E].dims == ("case",)
        assert stored["kinetic_energy"].attrs["units"] == "J"
        assert stored["kinetic_energy"].values.tobytes() == found["kinetic_energy"].tobytes()
    head, *rows = (tmp_path / "cases.csv").read_text().splitlines()
    assert head.startswith("case,tissue.body.nu,tissue.body.E (Pa),status,message,seconds (s),cautions,")
    assert len(rows) == 10
    assert rows[9].startswith("9,0.5,20000.0,refused,")
    assert "must be < 0.5" in rows[9]


def test_names_of_columns_are_no_measures() -> None:
    assert not {"status", "message", "cautions", "caution_names", "seconds", "case"} & CATALOGUE.keys()


def test_a_case_that_fails_leaves_the_others(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = [plica.SolveFailed("no solution"), MemoryError(), RuntimeError("a fault"), None]

    def failing(scene: plica.Scene, *given: Any, **named: Any) -> Any:
        if scene.tissue["body"].E == 20e3 and (error := errors.pop(0)) is not None:
            raise error
        return build_simulation(scene, *given, **named)

    monkeypatch.setattr(scene_cases, "build_simulation", failing)
    found = sweep(plan, tmp_path, progress=False)
    assert found.status == [*["done", "failed"] * 3, "done", "done", "refused", "refused"]
    assert [message for _, status, message in found.without_result if status == "failed"] == [
        "no solution",
        "there is not enough memory. Use a coarser mesh, or fewer workers.",
        "RuntimeError: a fault",
    ]


def test_failed_cases_are_computed_again_if_asked_for(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those that were stored long since, too; the others are left as they are."""
    whole = sweep(plan, tmp_path / "whole", progress=False)
    wrong = [plan.changes(case) for case in (1, 3, 6)]

    def failing(scene: plica.Scene, *given: Any, **named: Any) -> Any:
        body = scene.tissue["body"]
        if {NU: body.nu, E: body.E} in wrong:
            raise MemoryError
        return build_simulation(scene, *given, **named)

    directory = tmp_path / "again"
    with monkeypatch.context() as patched:
        patched.setattr(scene_cases, "build_simulation", failing)
        found = sweep(plan, directory, first=7, progress=False)
        assert [number for number, status, _ in found.without_result] == [1, 3, 6]
        again = sweep(plan, directory, first=7, retry=True, progress=False)
        assert again.without_result == found.without_result
        assert in_pending(directory)[-1] == "000006.json"
    assert sweep(plan, directory, progress=False).counts["failed"] == 3
    seconds = Sweep.load(directory)["seconds"]
    found = sweep(plan, directory, retry=True, progress=False)
    assert_equal(found, whole)
    assert [k for k in range(10) if found["seconds"][k] != seconds[k]] == [1, 3, 6]
    with xarray.open_dataset(directory / "sweep.nc", engine="h5netcdf") as stored:
        assert (stored["message"].values == whole.dataset["message"].values).all()


def test_a_sweep_in_parts_is_the_whole_one(plan: Plan, tmp_path: Path) -> None:
    whole = sweep(plan, tmp_path / "whole", progress=False)
    for first in (3, 6):
        part = sweep(plan, tmp_path / "parts", first=first, progress=False)
        assert part.counts["waiting"] == 10 - first
        assert not (tmp_path / "parts" / "sweep.nc").exists()
    assert in_pending(tmp_path / "parts") == ["000004.json", "000004.npz", "000005.json", "000005.npz"]
    assert part["kinetic_energy"][:6].tobytes() == whole["kinetic_energy"][:6].tobytes()
    assert part.dataset["waveform_kinetic_energy"].values[:3].tobytes() == (
        whole.dataset["waveform_kinetic_energy"].values[:3].tobytes()
    )
    assert_equal(sweep(plan, tmp_path / "parts", progress=False), whole)
    assert in_pending(tmp_path / "parts") == []


class _Killed(BaseException):
    """What no code expects."""


@pytest.mark.parametrize(
    "at", [5, 12, *(pytest.param(at, marks=pytest.mark.slow) for at in range(1, 60) if at not in (5, 12))]
)
def test_a_kill_at_any_write_loses_nothing(
    at: int, bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before the at-th of what is written in turn: cases, columns of chunks, their syncs, what is removed."""
    plan = Plan.make(bar, {E: "10:50:6 kPa"}, waveforms=["kinetic_energy"])
    sweep(plan, tmp_path / "whole", progress=False)
    calls = [0]

    def counted(made: Any) -> Any:
        def call(*given: Any, **named: Any) -> Any:
            calls[0] += 1
            if calls[0] == at:
                raise _Killed
            return made(*given, **named)

        return call

    with monkeypatch.context() as patched:
        for owner, name in ((store, "write_json"), (store, "_written"), (os, "sync"), (Path, "unlink")):
            patched.setattr(owner, name, counted(getattr(owner, name)))
        with pytest.raises(_Killed):
            sweep(plan, tmp_path / "killed", progress=False)
    assert_equal(sweep(plan, tmp_path / "killed", progress=False), Sweep.load(tmp_path / "whole"))


def test_a_complete_sweep_computes_nothing_again(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = sweep(plan, tmp_path, progress=False)
    monkeypatch.setattr(driver, "cluster", None)
    assert_equal(sweep(plan, tmp_path, progress=False), done)


def test_a_changed_plan_is_refused_with_what_changed(plan: Plan, bar: plica.Scene, tmp_path: Path) -> None:
    sweep(plan, tmp_path, first=1, progress=False)
    vary = {NU: "0.1:0.5:5", E: "10, 20 kPa"}
    others = {
        "scene.time.duration: 0.004 before, 0.008 now": Plan.make(
            bar.replace({"time.duration": "8 ms"}), vary, waveforms=["kinetic_energy"]
        ),
        f"values: {E} of case 1: 20000 Pa before, 21000 Pa now": Plan.make(
            bar, {**vary, E: "10, 21 kPa"}, waveforms=["kinetic_energy"]
        ),
        "cases: 10 before, 15 now": Plan.make(bar, {**vary, E: "1, 2, 3 kPa"}, waveforms=["kinetic_energy"]),
        "waveforms": Plan.make(bar, vary),
    }
    before = sorted(tmp_path.rglob("*"))
    for what, other in others.items():
        with pytest.raises(plica.InvalidInput) as error:
            sweep(other, tmp_path, progress=False)
        assert "holds a sweep of another plan" in str(error.value)
        assert what in str(error.value)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_scheduler_that_does_not_answer_leaves_nothing_behind(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def cluster(workers: int | None, scheduler: str | None) -> Iterator[Any]:
        raise plica.StorageFailed(f"{scheduler}: no scheduler answers.")
        yield

    begun = tmp_path / "begun"
    sweep(plan, begun, first=1, progress=False)
    before = sorted(begun.rglob("*"))
    monkeypatch.setattr(driver, "cluster", cluster)
    for out in (tmp_path / "out", begun):
        with pytest.raises(plica.StorageFailed, match="no scheduler answers"):
            sweep(plan, out, scheduler="tcp://127.0.0.1:1", progress=False)
    assert not (tmp_path / "out").exists()
    assert sorted(begun.rglob("*")) == before
    sweep(plan, begun, first=1, scheduler="tcp://127.0.0.1:1", progress=False)  # nothing is left to compute


def test_a_sweep_s_directory_takes_no_run(plan: Plan, bar: plica.Scene, tmp_path: Path) -> None:
    sweep(plan, tmp_path, first=1, progress=False)
    before = {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    for resume in (False, True):
        with pytest.raises(plica.InvalidInput, match="holds a sweep; must be"):
            plica.run(bar, tmp_path, resume=resume)
    assert {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()} == before


def test_a_second_driver_is_refused(plan: Plan, tmp_path: Path) -> None:
    with only_writer(tmp_path), pytest.raises(plica.InvalidInput, match="another process is writing"):
        sweep(plan, tmp_path, progress=False)


def test_a_directory_with_something_else_is_refused(plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "results.h5").touch()
    with pytest.raises(plica.InvalidInput, match=r"holds results\.h5, and no sweep; must be new or empty"):
        sweep(plan, tmp_path, progress=False)
    with pytest.raises(plica.InvalidInput, match="a file; must be a directory"):
        sweep(plan, tmp_path / "results.h5", progress=False)
    with pytest.raises(plica.InvalidInput, match=r"holds a run or an analysis \(results"):
        Sweep.load(tmp_path)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"workers": 0}, "workers = 0; must be >= 1"),
        ({"workers": 2, "scheduler": "tcp://x:1"}, "workers = 2 with a scheduler"),
        ({"first": 0}, "first = 0; must be from 1 to the 10 cases"),
        ({"first": 11}, "first = 11; must be from 1 to the 10 cases"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(given: Any, why: str, plan: Plan, tmp_path: Path) -> None:
    with pytest.raises(plica.InvalidInput, match=why):
        sweep(plan, tmp_path / "new", progress=False, **given)
    assert not (tmp_path / "new").exists()


def test_what_no_case_can_have_ends_the_sweep(bar: plica.Scene, tmp_path: Path) -> None:
    plan = Plan.make(bar, {E: "10, 20 kPa"}, waveforms=["flow"])
    with pytest.raises(plica.InvalidInput, match="the scene has no waveform flow"):
        sweep(plan, tmp_path, progress=False)
    assert Sweep.load(tmp_path).counts["waiting"] == 2


def test_a_worker_of_another_version_ends_the_sweep(bar: plica.Scene) -> None:
    found = run_case(_task(bar, version="0.0"))
    assert found.fault == f"a worker has plica {plica.__version__}; must have 0.0, as the driver."


def test_runs_are_kept_if_asked_for(bar: plica.Scene, tmp_path: Path) -> None:
    plan = Plan.make(bar, {E: "10, 20 kPa"}, keep="runs")
    found = sweep(plan, tmp_path, progress=False)
    runs = [plica.Run.load(tmp_path / "runs" / f"{k:06d}") for k in (0, 1)]
    assert [run.scene.tissue["body"].E for run in runs] == [1e4, 2e4]
    assert found["kinetic_energy"].tolist() == [run.measures["kinetic_energy"].value for run in runs]


def test_a_damaged_case_is_not_taken(plan: Plan, tmp_path: Path) -> None:
    sweep(plan, tmp_path, first=1, progress=False)
    path = tmp_path / "pending" / "000000.json"
    path.write_text(path.read_text().replace('"done"', '"gone"'))
    with pytest.raises(plica.InvalidInput, match="its content is not what its checksum says"):
        sweep(plan, tmp_path, progress=False)


def test_a_case_of_another_plan_is_not_taken(plan: Plan, tmp_path: Path) -> None:
    sweep(plan, tmp_path, first=2, progress=False)
    folder = tmp_path / "pending"
    (folder / "000000.json").replace(folder / "000001.json")
    with pytest.raises(plica.InvalidInput, match="is of another case; must be of case 1 of this plan"):
        sweep(plan, tmp_path, progress=False)


def test_cases_whose_workers_are_killed_too_often_have_failed(
    plan: Plan, tmp_path: Path, client: Any
) -> None:

    class Future:
        status = "error"

        def exception(self) -> Exception:
            return distributed.KilledWorker("case", None, 20)

    one = driver._Driver(store.Store(_made(tmp_path), plan), client, driver.StopRequest(), shown=False)
    found = one._result(Future(), 3)
    assert isinstance(found, CaseResult)
    assert (found.case, found.status) == (3, "failed")
    assert found.message.startswith("20 workers that had it were killed")


def _made(directory: Path) -> Path:
    directory.mkdir(exist_ok=True)
    return directory
