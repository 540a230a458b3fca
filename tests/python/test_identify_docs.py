"""The Python of docs/identification.md runs as it stands there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from flow_files import SETTINGS, block_scene, flow_file
from plica.cli import main
from plica.identify import identification

_DOCS = (Path(__file__).parents[2] / "docs" / "identification.md").read_text(encoding="utf-8")


def _block(number: int) -> str:
    return re.findall(r"```python\n(.*?)```", _DOCS, re.DOTALL)[number]


def test_the_first_lines_find_the_tissue(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As they stand there, in the directory in which ``plica examples scenes`` was called."""
    monkeypatch.chdir(tmp_path)
    assert main(["examples", "scenes"]) == 0
    names: dict[str, Any] = {}
    exec(compile(_block(0), "identification.md", "exec"), names)
    printed, posterior = capsys.readouterr().out, names["posterior"]
    assert all(name in printed for name in ("cover.mu_fibre", "body.mu_fibre", "body.viscosity", "gain"))
    tissue = names["scene"].tissue
    truth = [tissue["cover"].mu_fibre, tissue["body"].mu_fibre, tissue["body"].viscosity, 1.0]
    interval = posterior.interval(0.999)
    assert (interval[:, 0] < truth).all()
    assert (truth < interval[:, 1]).all()
    assert posterior.sd[1] < 0.2  # the body's is learned


@pytest.mark.slow
def test_the_lines_for_files_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    flow_file(tmp_path / "flow.h5")
    block_scene().save(tmp_path / "larynx.toml")
    chosen = ", ".join(f"{name}={value!r}" for name, value in SETTINGS.items())
    block = re.sub(r"Settings\(.*\)\n", f"Settings({chosen})\n", _block(1)).replace('"analysis"', '"flow.h5"')
    exec(compile(block, "identification.md", "exec"), {})
    assert "body.E" in capsys.readouterr().out
    assert identification.load(tmp_path / "tissue").picture.observed.shape[2] == 2
