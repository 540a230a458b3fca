"""The Python of docs/identification.md runs as it stands there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flow_files import SETTINGS, block_scene, flow_file
from layered_block import STEP, layered_mesh, layered_model, layered_scene, simulated
from plica.identify import identification

_DOCS = (Path(__file__).parents[2] / "docs" / "identification.md").read_text(encoding="utf-8")


def _block(number: int) -> str:
    return re.findall(r"```python\n(.*?)```", _DOCS, re.DOTALL)[number]


@pytest.mark.slow
def test_ten_lines_find_the_tissue(capsys: pytest.CaptureFixture[str]) -> None:
    lines = _block(0).splitlines()
    assert len(lines) <= 12
    mesh, frames = layered_mesh(), 24
    x, y = np.meshgrid([0.5e-3, 2e-3, 3.5e-3], [1e-3, 3e-3, 5e-3])
    t = STEP * (np.arange(5 * frames) + 0.7)
    wave = 200 * np.column_stack([np.sin(2 * np.pi * f * t) for f in (150, 390, 260)])
    block = (
        _block(0)
        .replace('"airway", camera', '"z_max", camera')
        .replace('"airway", heights', '"x_max", heights')
    )
    names: dict[str, Any] = {
        "mesh": mesh,
        "scene": layered_scene(),
        "image": np.column_stack([x.ravel(), y.ravel()]),
        "heights": [0.0, 1.5e-3, 3e-3],
        "pressure": wave,
        "flow": np.random.default_rng(0).normal(0, 0.05, (frames, 9, 2)),
    }
    made = layered_model(["cover.E_fibre"], np.ones((frames, 12, 2)))
    names["flow"] += simulated(made, np.random.default_rng(1))[:, :9]
    exec(compile(block, "identification.md", "exec"), names)
    assert "cover.mu_fibre" in capsys.readouterr().out
    assert np.isfinite(names["posterior"].interval()).all()


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
