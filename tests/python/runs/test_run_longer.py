"""A run that goes on: with a longer duration, from a script that is run again, from the name of its scene."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from interrupted_runs import StopsAfter, assert_identical, longer
from plica import _engine
from plica.commands.main import main
from plica.runs import checkpoint


def files(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in directory.iterdir()}


@pytest.mark.parametrize("name", ["bar", "colliding", "phonating"])
def test_a_finished_run_that_continues_is_the_run_that_had_the_longer_duration(
    name: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    short: plica.Scene = request.getfixturevalue(name)
    # off the rhythm of frames (5 or 4 steps) and checkpoints (10)
    short = short.replace({"time.duration": 17 * short.time.step})
    long = short.replace({"time.duration": 43 * short.time.step})
    begun = plica.run(short, tmp_path / "run", progress=False)
    assert (begun.status, begun.steps) == ("finished", 17)
    gone_on = plica.run(long, tmp_path / "run", progress=False, resume=True)
    whole = plica.run(long, tmp_path / "whole", progress=False)
    assert (gone_on.status, gone_on.steps) == ("finished", 43)
    assert_identical(tmp_path / "run", tmp_path / "whole")
    with h5py.File(gone_on.path) as one, h5py.File(whole.path) as other:
        assert dict(one.attrs) == dict(other.attrs)
        found: list[str] = []
        other.visit(found.append)
        assert all(dict(one[name].attrs) == dict(other[name].attrs) for name in found)
    for made in ("scene.toml", "fields.xdmf"):
        assert (tmp_path / "run" / made).read_bytes() == (tmp_path / "whole" / made).read_bytes()


def test_a_run_continues_from_its_last_step(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    short = bar.replace({"time.duration": "1.7 ms"})
    plica.run(short, tmp_path / "run", progress=False)
    begun: list[int] = []

    class Counting:
        def __init__(self, inner: Any) -> None:
            self.inner = inner

        def __getattr__(self, name: str) -> Any:
            return getattr(self.inner, name)

        def advance(self, steps: int) -> Any:
            if steps:
                begun.append(self.inner.step_count)
            return self.inner.advance(steps)

    made = _engine.Simulation
    monkeypatch.setattr(_engine, "Simulation", lambda **parts: Counting(made(**parts)))
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert begun[0] == 17


def test_fields_that_begin_after_a_short_run_are_stored_by_the_longer_one(
    bar: plica.Scene, tmp_path: Path
) -> None:
    late = bar.replace({"output.start": "3 ms"})
    assert plica.run(late.replace({"time.duration": "2 ms"}), tmp_path / "run", progress=False).fields == {}
    plica.run(late, tmp_path / "run", progress=False, resume=True)
    plica.run(late, tmp_path / "whole", progress=False)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_a_run_that_failed_or_lost_its_checkpoints_continues_to_the_same_results(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = bar.replace({"time.duration": "6 ms"})
    plica.run(long, tmp_path / "whole", progress=False)
    with monkeypatch.context() as patch:
        patch.setattr(_engine, "Simulation", StopsAfter(17))
        with pytest.raises(plica.SolveFailed):
            plica.run(bar, tmp_path / "failed", progress=False)
    plica.run(bar, tmp_path / "lost", progress=False)
    for slot in (tmp_path / "lost").glob("checkpoint-*.h5"):
        slot.unlink()
    for name in ("failed", "lost"):
        plica.run(long, tmp_path / name, progress=False, resume=True)
        assert_identical(tmp_path / name, tmp_path / "whole")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"time.duration": "3 ms"},
            r"time\.duration = 0\.003, the run has 0\.004; must be the scene that started the run",
        ),
        ({"time.duration": "8 ms", "tissue.body.nu": 0.31}, r"tissue\.body\.nu = 0\.31, the run has 0\.3;"),
        ({"time.duration": "8 ms", "time.step": "50 us"}, r"time\.step = 5e-05, the run has 0\.0001;"),
        (
            {"time.duration": "8 ms", "tissue.body": {"nu": 0.31, "viscosity": 2.0}, "output.every": None},
            r"nu = 0\.31, the run has 0\.3; tissue\.body\.viscosity = 2\.0, .*; output\.every is missing",
        ),
        ({"time.duration": "8 ms", "output.every": None}, r"output\.every is missing, the run has 0\.0005;"),
    ],
)
def test_a_shorter_duration_or_another_change_is_refused_and_nothing_is_touched(
    bar: plica.Scene, tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    before = files(tmp_path / "run")
    for resume in (True, "if_there"):
        with pytest.raises(plica.SceneError, match=message):
            plica.run(bar.replace(changes), tmp_path / "run", progress=False, resume=resume)
    assert files(tmp_path / "run") == before


@pytest.mark.slow
def test_what_described_the_shorter_run_goes_when_it_continues(bar: plica.Scene, tmp_path: Path) -> None:
    bar.replace({"time.duration": "2 ms"}).save(tmp_path / "s.toml")
    command = ["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"]
    assert main(command) == 0
    described = {"measures.json", "waveforms.csv", "report.html"}
    assert described <= files(tmp_path / "run").keys()
    run = plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert not described & files(tmp_path / "run").keys()
    assert run.measures["steps"].value == 40
    bar.replace({"time.duration": "5 ms"}).save(tmp_path / "s.toml")
    assert main([*command, "--resume"]) == 0
    assert plica.Run.load(tmp_path / "run").measures["steps"].value == 50


class Killed(BaseException):
    """As SIGKILL: nothing runs after it."""


@pytest.mark.parametrize("moment", range(6))
def test_a_stop_at_any_replacement_while_a_run_is_lengthened_loses_nothing(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: int
) -> None:
    long = bar.replace({"time.duration": "4.3 ms"})
    short = bar.replace({"time.duration": "1.7 ms"})
    plica.run(long, tmp_path / "whole", progress=False)
    plica.run(short, tmp_path / "run", progress=False)
    whole = plica.Run.load(tmp_path / "whole")
    calls = 0
    replace: Callable[..., None] = os.replace

    def stopping(*paths: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == moment // 2 + 1:
            if moment % 2:
                replace(*paths)
            raise Killed
        replace(*paths)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", stopping)
        with pytest.raises(Killed):
            plica.run(long, tmp_path / "run", progress=False, resume=True)
    left = plica.Run.load(tmp_path / "run")
    assert left.steps >= 17
    assert all(np.array_equal(left[name], whole[name][: left.steps]) for name in whole)
    assert np.array_equal(np.asarray(left.displacement), np.asarray(whole.displacement)[: left.frames])
    held = checkpoint.newest(tmp_path / "run")
    assert held is not None
    assert held.steps >= 17
    plica.run(long, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_a_full_disk_leaves_the_shorter_run_as_it_was(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    before = files(tmp_path / "run")

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "posix_fallocate", full)
        with pytest.raises(plica.StorageFailed, match=r"the results need .* or a shorter time\.duration\.$"):
            plica.run(longer(bar, 2), tmp_path / "run", progress=False, resume=True)
    assert files(tmp_path / "run") == before


def test_a_checkpoint_of_a_run_that_is_gone_is_not_continued(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plica.run(bar, tmp_path / "whole", progress=False)
    plica.run(bar, tmp_path / "run", progress=False)
    (tmp_path / "run" / "results.h5").unlink()
    (tmp_path / "run" / "scene.toml").unlink()
    with monkeypatch.context() as patch:
        patch.setattr(_engine, "Simulation", StopsAfter(7))
        with pytest.raises(plica.SolveFailed):
            plica.run(bar, tmp_path / "run", progress=False)
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_the_same_script_runs_again(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    again: dict[str, Any] = {"progress": False, "resume": "if_there"}
    first = plica.run(bar, tmp_path / "run", **again)
    before = files(tmp_path / "run")
    second = plica.run(bar, tmp_path / "run", **again)
    assert (first.steps, second.steps, second.status) == (40, 40, "finished")
    assert files(tmp_path / "run") == before
    with monkeypatch.context() as patch:
        patch.setattr(_engine, "Simulation", StopsAfter(7))
        with pytest.raises(plica.SolveFailed):
            plica.run(bar, tmp_path / "stopped", **again)
    assert plica.run(bar, tmp_path / "stopped", **again).status == "finished"
    assert_identical(tmp_path / "stopped", tmp_path / "run")
    wrong: Any = "always"
    with pytest.raises(
        plica.InvalidInput, match=r'Run: resume = "always"; must be True, False or "if_there"'
    ):
        plica.run(bar, tmp_path / "other", resume=wrong)
    assert not (tmp_path / "other").exists()


def test_a_scene_is_run_by_the_name_of_its_file(bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "s1.toml")
    plica.run(bar, tmp_path / "whole", progress=False)
    for name in (str(tmp_path / "s1.toml"), tmp_path / "s1.toml"):
        plica.run(name, tmp_path / "run", progress=False, resume="if_there")
    assert_identical(tmp_path / "run", tmp_path / "whole")
    with pytest.raises(plica.SceneError, match=r"s2\.toml: there is no such file"):
        plica.run(str(tmp_path / "s2.toml"), tmp_path / "other", progress=False)
