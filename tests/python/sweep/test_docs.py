"""The program of docs/sweeps.md, on a small scene."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica
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
    (program,) = python_blocks("docs/sweeps.md")
    names = {"__name__": "__main__"}
    exec(compile(program, "sweeps.md", "exec"), names)
    assert "airflow.subglottal_pressure" in capsys.readouterr().out
    assert Path("sweeps/two/report.html").is_file()
