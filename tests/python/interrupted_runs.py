"""Runs that are killed, that fail after so many steps, and whether two runs are the same."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from plica import _engine

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
    for name in ("steps", "frames", "status", "message", "waveforms"):
        found[f"progress/{name}"] = found["progress"][name].copy()
    del found["progress"]
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
            return int(file["progress"]["steps"].min())
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


def assert_resumes_to_the_bit(scene: plica.Scene, folder: Path, steps: int) -> None:
    """A run that is killed after so many steps, and goes on, is the one that nobody killed."""
    scene.save(folder / "scene.toml")
    plica.run(scene, folder / "whole", progress=False)
    killed = folder / "killed"
    assert kill_after(start(folder / "scene.toml", killed), killed, steps)
    ended = start(folder / "scene.toml", killed, "--resume")
    ended.communicate()
    assert ended.returncode == 0
    assert_identical(folder / "whole", killed)


def longer(scene: plica.Scene, factor: int) -> plica.Scene:
    duration = scene.time.duration
    return plica.Scene.from_text(
        scene.text().replace(f"duration = {duration}", f"duration = {factor * duration}")
    )


class StopsAfter:
    """A simulation whose step number `last` + 1 fails, under a force whose square is not finite."""

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
                inner.set_external_force(np.full_like(inner.displacement, 1e300))
                with pytest.raises(plica.StepFailed) as failure:
                    inner.advance(steps - good)
                raise plica.StepFailed(str(failure.value), waveforms)

        return Stopping()


def killed(scene: plica.Scene, folder: Path, after: int) -> int:
    """Steps of the run in folder/run, of this scene for 30 times its 40 steps, killed after so many."""
    longer(scene, 30).save(folder / "scene.toml")
    process = start(folder / "scene.toml", folder / "run")
    assert kill_after(process, folder / "run", after)
    steps = plica.Run.load(folder / "run").steps
    assert after <= steps < 1200
    return steps
