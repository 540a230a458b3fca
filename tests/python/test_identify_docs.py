"""The Python of docs/identification.md runs as it stands there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from conftest import THESIS_TISSUE
from flow_files import SETTINGS, block_scene, flow_file
from layered_block import STEP, simulated
from plica.identify import MotionModel, identification

CHOSEN = ("cover.E_fibre", "cover.mu_fibre", "cover.viscosity")
_DOCS = (Path(__file__).parents[2] / "docs" / "identification.md").read_text(encoding="utf-8")


def _block(number: int) -> str:
    return re.findall(r"```python\n(.*?)```", _DOCS, re.DOTALL)[number]


@pytest.mark.slow
def test_ten_lines_find_the_tissue(capsys: pytest.CaptureFixture[str]) -> None:
    """Of a cover alone; beside it lies a body that nothing moves, as boxes come in pairs."""
    block = _block(0).replace('"airway", camera', '"cover.z_max", camera')
    block = block.replace('"airway", heights', '"cover.x_max", heights')
    assert len(block.splitlines()) <= 12
    size, far = (4e-3, 6e-3, 3e-3), (0, 0, -9e-3)
    boxes = {
        "cover": plica.Block(size=size, divisions=(1, 2, 2)),
        "body": plica.Block(corner=far, size=size),
    }
    scene = plica.Scene(
        plica.Blocks(blocks=boxes, order=2),
        {name: plica.Tissue(**THESIS_TISSUE[name]) for name in boxes},
        time=plica.Stepping(step=STEP, duration=STEP),
        supports=plica.Supports(fixed=("cover.z_min", "cover.y_min", "cover.y_max", "body.z_min")),
    )
    frames = 40
    x, y = np.meshgrid([0.5e-3, 2e-3, 3.5e-3], [1e-3, 3e-3, 5e-3])
    t = STEP * (np.arange(5 * frames) + 0.7)
    names: dict[str, Any] = {
        "mesh": plica.build_mesh(scene.mesh),
        "scene": scene,
        "image": np.column_stack([x.ravel(), y.ravel()]),
        "heights": [0.0, 1.5e-3, 3e-3],
        "pressure": 200 * np.column_stack([np.sin(2 * np.pi * f * t) for f in (150, 390, 260)]),
    }
    lines = block.splitlines()
    flow = np.ones((frames, 9, 2))  # of the same model, at the scene's values
    head = "\n".join(lines[: next(k for k, line in enumerate(lines) if line.startswith("names"))])
    made = names | {"flow": flow}
    exec(head, made)
    values = [THESIS_TISSUE["cover"][name] for name in ("E_fibre", "mu_fibre", "viscosity")]
    model = MotionModel(scene, list(CHOSEN), made["seen"], made["forcing"])
    names["flow"] = simulated(model, np.random.default_rng(1), pressure=20.0)
    exec(compile(block, "identification.md", "exec"), names)
    printed = capsys.readouterr().out
    assert all(name in printed for name in CHOSEN)
    interval = names["posterior"].interval(0.999)
    assert (interval[:3, 0] < values).all()
    assert (values < interval[:3, 1]).all()


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
