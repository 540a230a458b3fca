"""Sweeps in processes: workers and drivers that are killed, two drivers, long cases, another scheduler."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import distributed
import numpy as np
import psutil
import pytest

import plica
from plica.sweep import Plan, Sweep
from plica.sweep import run as sweep
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from sweeps import E, assert_equal, in_pending

_CASES = 12


@pytest.fixture
def scene(bar: plica.Scene, tmp_path: Path) -> Path:
    """Of which a case takes some tenths of a second."""
    path = tmp_path / "bar.toml"
    bar.replace({"time.duration": "1.5 s", "output.every": None}).save(path)
    return path


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """Of a recording that is turned: a case takes some tenths of a second, too."""
    drawn = Synthetic(height=56, width=48, frames=44, frequency=0.1, amplitude=(6, 5), opening=(2, 2))
    np.save(tmp_path / "anna.npy", SyntheticGlottis(drawn).stack())
    path = tmp_path / "study.toml"
    path.write_text(
        'recordings = ["anna.npy"]\nuntil = "glottis"\n[settings]\nfps = 4000\ncorrect_drift = false\n'
        f'[vary]\nrotation = "0:11:{_CASES} deg"\n'
    )
    return path


def _start(source: Path, directory: Path, cases: int = _CASES, **environment: str) -> subprocess.Popen[str]:
    varied = [] if source.name == "study.toml" else ["--vary", f"{E}=10:20:{cases} kPa"]
    command = [sys.executable, "-m", "plica.commands.main", "sweep", str(source), *varied]
    return subprocess.Popen(
        [*command, "-o", str(directory), "--workers", "2"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
    )


def _workers(driver: int) -> list[psutil.Process]:
    """The processes that compute: the forks of the driver's server."""
    try:
        return [worker for server in _servers(driver) for worker in server.children()]
    except psutil.NoSuchProcess:
        return []


def _servers(driver: int) -> list[psutil.Process]:
    below = psutil.Process(driver).children()
    return [one for one in below if "multiprocessing.forkserver" in " ".join(one.cmdline())]


def _until(fact: Callable[[], Any], seconds: float = 120.0) -> Any:
    end = time.monotonic() + seconds
    while not (found := fact()):
        assert time.monotonic() < end
        time.sleep(0.02)
    return found


def _ended(directory: Path) -> int:
    return len(in_pending(directory)) if (directory / "pending").exists() else 0


def _reference(scene: Path, directory: Path) -> Sweep:
    whole = _start(scene, directory)
    _, said = whole.communicate()
    assert whole.returncode == 0, said
    return Sweep.load(directory)


@pytest.mark.slow
@pytest.mark.parametrize("of", ["scene", "study"])
def test_killed_workers_and_a_killed_driver_change_nothing(
    of: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    source: Path = request.getfixturevalue(of)
    directory = tmp_path / "killed"
    driver = _start(source, directory)
    for cases in (1, 3):  # each time the first of the workers
        _until(lambda cases=cases: _ended(directory) >= cases and len(_workers(driver.pid)) == 2)
        _workers(driver.pid)[0].kill()
    _until(lambda: _ended(directory) >= 5)
    assert driver.poll() is None
    (server,) = _servers(driver.pid)
    assert server.num_threads() == 1  # a fork would lose others, with the locks that they hold
    started = [server, *_workers(driver.pid)]
    driver.send_signal(signal.SIGKILL)
    driver.communicate()
    assert driver.returncode == -signal.SIGKILL
    psutil.wait_procs(started, timeout=60)
    assert [one for one in started if one.is_running()] == []
    assert 0 < Sweep.load(directory).counts["done"] < _CASES

    again = _start(source, directory)
    _, said = again.communicate()
    assert again.returncode == 0, said
    found = Sweep.load(directory)
    assert found.counts["done"] == _CASES
    assert_equal(found, _reference(source, tmp_path / "whole"))


@pytest.mark.slow
def test_a_stopped_sweep_says_how_to_continue_and_a_second_driver_is_refused(
    scene: Path, tmp_path: Path
) -> None:
    directory = tmp_path / "stopped"
    driver = _start(scene, directory, 500)
    _until(lambda: _ended(directory) >= 1)
    second = _start(scene, directory, 500)
    _, said = second.communicate()
    assert second.returncode == 2
    assert "another process is writing to this directory" in said
    driver.send_signal(signal.SIGINT)
    _, said = driver.communicate()
    assert driver.returncode == 130
    assert "of 500 cases. Repeat the same command to continue." in said
    assert 0 < Sweep.load(directory).counts["done"] < 500


@pytest.mark.slow
def test_a_case_may_be_longer_than_a_scheduler_waits_for_a_sign_of_life(
    bar: plica.Scene, tmp_path: Path
) -> None:
    """As one of ten minutes, where a worker is given up after five."""
    bar.replace({"time.duration": "20 s", "output.every": None}).save(tmp_path / "bar.toml")
    limit = {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "1s"}
    driver = _start(tmp_path / "bar.toml", tmp_path / "long", 4, **limit)
    _, said = driver.communicate()
    assert driver.returncode == 0, said
    found = Sweep.load(tmp_path / "long")
    assert found.counts["done"] == 4
    assert found["seconds"].max() > 2.0


def test_workers_of_a_scheduler_compute_if_they_have_one_thread(bar: plica.Scene, tmp_path: Path) -> None:
    plan = Plan.make(bar, {E: "10, 20 kPa"})
    for threads in (1, 2):
        with distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=threads,
            processes=False,
            protocol="tcp",
            dashboard_address=":0",
        ) as local:
            if threads == 1:
                found = sweep(plan, tmp_path / "one", scheduler=local.scheduler_address, progress=False)
                assert found.counts["done"] == 2
                continue
            with pytest.raises(plica.InvalidInput, match=r"has 2 threads; must have 1\. Start workers with"):
                sweep(plan, tmp_path / "two", scheduler=local.scheduler_address, progress=False)


@pytest.mark.slow
def test_a_scheduler_that_is_not_there_is_named(bar: plica.Scene, tmp_path: Path) -> None:
    with pytest.raises(plica.StorageFailed, match=r"tcp://127\.0\.0\.1:9: no scheduler answers"):
        sweep(Plan.make(bar, {E: "10 kPa"}), tmp_path, scheduler="tcp://127.0.0.1:9", progress=False)


@pytest.mark.slow
def test_a_script_without_a_main_part_is_told(bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "bar.toml")
    script = tmp_path / "script.py"
    text = f'from plica import sweep\nplan = sweep.Plan.make("bar.toml", {{"{E}": "10, 20 kPa"}})\n'
    script.write_text(f'{text}sweep.run(plan, "out", workers=1, progress=False)\n')
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode != 0
    last = done.stderr.strip().splitlines()[-1]
    assert "no worker starts" in last
    assert last.endswith('In a script put the sweep below: if __name__ == "__main__":')
    assert "it is begun in one of its own workers" in done.stderr
