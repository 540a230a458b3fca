"""The Python of the docs on identification, on filters and on image and mesh runs as it stands there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from flow_files import SETTINGS, block_scene, flow_file
from plica.commands.main import main
from plica.identify import identification, kalman_filter
from repository import ROOT


def _block(number: int, page: str = "identification.md") -> str:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```", text, re.DOTALL)[number]


def _run(page: str, where: Path, monkeypatch: pytest.MonkeyPatch, number: int = 0) -> dict[str, Any]:
    """What lines of a page leave, where ``plica examples scenes`` was called."""
    monkeypatch.chdir(where)
    assert main(["examples", "scenes"]) == 0
    names: dict[str, Any] = {}
    exec(compile(_block(number, page), page, "exec"), names)
    return names


def test_the_lines_for_arrays_find_the_tissue(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    names = _run("identification.md", tmp_path, monkeypatch, 1)
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
    block = re.sub(r"Settings\(.*\)\n", f"Settings({chosen})\n", _block(0)).replace('"analysis"', '"flow.h5"')
    exec(compile(block, "identification.md", "exec"), {})
    assert "body.E" in capsys.readouterr().out
    assert identification.load(tmp_path / "tissue").picture.observed.shape[2] == 2


def test_the_lines_for_a_filter_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = _run("identification_filter.md", tmp_path, monkeypatch)
    assert names["f"].shape == (names["frames"], names["model"].states)
    after = kalman_filter(names["better"], names["y"], names["f"]).log_likelihood
    assert after > names["filtered"].log_likelihood


def test_the_lines_for_a_larynx_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An ellipse of 7 and 100 px, at 0.06 mm a pixel."""
    names = _run("image_mesh.md", tmp_path, monkeypatch)
    section = names["fitted"].section
    assert section.half_width == pytest.approx(7 * 0.06e-3, abs=0.4 * 0.06e-3)  # 0.4 px: docs/image_mesh.md
    assert section.r_in == pytest.approx(100 * 0.06e-3, abs=0.06e-3)
    assert names["scene"].mesh == names["fitted"].larynx
