"""Commands that are killed before they stored anything can be resumed, and repeated."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import plica
from flow_files import SETTINGS, block_scene, flow_file
from plica.identify import Settings, identify
from repository import ROOT

_KILLED = """
import os, signal, sys
from pathlib import Path
import plica
from plica.identify import Settings, identify
from plica.identify.estimator import iterates
from plica.runs import store
from plica.storage import files
from flow_files import SETTINGS

command, scene, directory, source, instant = sys.argv[1:]
def kill(*given, **named):
    os.kill(os.getpid(), signal.SIGKILL)
if instant == "first result":
    iterates.Iterates.add = kill
    files.os.replace = kill  # the draft is written, not renamed
elif instant == "draft":
    files.os.replace = kill
if command == "run":
    plica.run(plica.Scene.load(scene), directory, progress=False)
else:
    identify(source, scene, directory, Settings(**SETTINGS), progress=False)
"""


def _kill(tmp_path: Path, command: str, directory: Path, instant: str) -> None:
    given = [command, str(tmp_path / "scene.toml"), str(directory), str(tmp_path / "flow.h5"), instant]
    done = subprocess.run(
        [sys.executable, "-c", _KILLED, *given],
        cwd=ROOT / "tests" / "python",
        capture_output=True,
        check=False,
    )
    assert done.returncode == -signal.SIGKILL, done.stderr.decode()
    assert directory.is_dir()  # it was killed after it had begun


@pytest.mark.slow
@pytest.mark.parametrize("instant", ["first result", "draft"])
def test_an_estimate_killed_before_its_first_iterate_is_resumed_or_repeated(
    tmp_path: Path, instant: str
) -> None:
    block_scene().save(tmp_path / "scene.toml")
    flow = flow_file(tmp_path / "flow.h5")
    settings, scene = Settings(**SETTINGS), tmp_path / "scene.toml"
    whole = identify(flow, scene, tmp_path / "whole", settings, progress=False).posterior
    for resume in (True, False):
        _kill(tmp_path, "identify", tmp_path / "killed", instant)
        assert not (tmp_path / "killed" / "iterates.json").exists()
        found = identify(flow, scene, tmp_path / "killed", settings, resume=resume, progress=False)
        assert np.array_equal(found.posterior.mean, whole.mean)
        assert np.array_equal(found.posterior.covariance, whole.covariance)
        shutil.rmtree(tmp_path / "killed")


@pytest.mark.slow
@pytest.mark.parametrize("resume", [True, False])
def test_a_run_killed_before_it_stored_its_scene_is_resumed_or_repeated(tmp_path: Path, resume: bool) -> None:
    scene = block_scene(time=plica.Stepping(step=125e-6, duration=5 * 125e-6))
    scene.save(tmp_path / "scene.toml")
    _kill(tmp_path, "run", tmp_path / "killed", "draft")
    assert not (tmp_path / "killed" / "scene.toml").exists()
    run = plica.run(scene, tmp_path / "killed", resume=resume, progress=False)
    assert run.status == "finished"


def test_a_directory_without_a_trace_of_the_command_is_not_resumed(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").touch()
    for directory in (tmp_path / "missing", tmp_path / "other"):
        with pytest.raises(plica.InvalidInput, match="without --resume"):
            plica.run(block_scene(), directory, resume=True, progress=False)
        with pytest.raises(plica.InvalidInput, match="without --resume"):
            identify(
                flow_file(tmp_path / "flow.h5"),
                block_scene(),
                directory,
                Settings(**SETTINGS),
                resume=True,
                progress=False,
            )
