"""The programs of docs/sweeps.md, on a small scene and small recordings; its study files are read."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import plica
from plica.sweep import read_study
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from repository import ROOT
from typed_commands import python_blocks


@pytest.mark.usefixtures("here")
def test_the_program_runs(
    phonating: plica.Scene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    phonating.replace({"time.duration": "0.5 ms", "output.every": None}).save("voice.toml")
    program, _ = python_blocks("docs/sweeps.md")
    names = {"__name__": "__main__"}
    exec(compile(program, "sweeps.md", "exec"), names)
    assert "airflow.subglottal_pressure" in capsys.readouterr().out
    assert Path("sweeps/two/report.html").is_file()


@pytest.mark.usefixtures("here", "few_draws")
def test_the_program_of_recordings_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    _record(tmp_path / "day" / "anna.npy")
    _record(tmp_path / "day" / "berta.npy")
    _, program = python_blocks("docs/sweeps.md")
    exec(compile(program, "sweeps.md", "exec"), {"__name__": "__main__"})
    assert "open_quotient" in capsys.readouterr().out


def test_study_files_are_plans(phonating: plica.Scene, tmp_path: Path) -> None:
    """The three of the page: a scene, recordings, tissue."""
    blocks = re.findall(r"```toml\n(.*?)```", (ROOT / "docs/sweeps.md").read_text(), re.DOTALL)
    phonating.save(tmp_path / "voice.toml")
    phonating.replace({"contact": None, "initial": None}).save(tmp_path / "larynx.toml")
    for name in ("day/a.avi", "day/b.avi", "old/anna.cine", "anna/analysis", "berta/analysis"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    found = []
    for block in blocks:
        (tmp_path / "study.toml").write_text(block)
        found.append(read_study(tmp_path / "study.toml"))
    assert [plan.subject.kind for plan in found] == ["run", "recording", "identification"]
    assert [len(plan) for plan in found] == [128 * 4, 3 * 9, 2 * 6]


def _record(path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    drawn = Synthetic(height=56, width=48, frames=44, frequency=0.1, amplitude=(6, 5), opening=(2, 2))
    np.save(path, SyntheticGlottis(drawn).stack())
