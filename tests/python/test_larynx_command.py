"""``plica larynx``: what it writes is a scene's mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plica
from pictured_folds import pictured
from plica.cli import main

_TISSUE = """
[tissue.body]
E = "20 kPa"
nu = 0.45
[tissue.ligament]
E = "3 kPa"
nu = 0.45
[tissue.cover]
E = "1 kPa"
nu = 0.45
[time]
step = "50 us"
duration = "1 ms"
"""


@pytest.fixture
def picture(tmp_path: Path) -> tuple[str, str]:
    """Paths of a frame and of its mask."""
    folds = pictured()
    paths = str(tmp_path / "frame.png"), str(tmp_path / "mask.png")
    Image.fromarray(folds.frame.astype(np.uint8)).save(paths[0])
    Image.fromarray(folds.mask.astype(np.uint8) * 255).save(paths[1])
    return paths


def test_the_table_it_writes_begins_a_scene(
    picture: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frame, mask = picture
    out = tmp_path / "scene.toml"
    asked = ["--mask", mask, "--r-in", "6.3 mm", "--l-occ", "0.2 mm", "--order", "1", "-o", str(out)]
    assert main(["larynx", frame, *asked]) == 0
    said = capsys.readouterr().out
    assert "contour error: mean 0." in said
    assert "r_in 6.300 mm, r_out 7.300 mm, l_occ 0.200 mm" in said
    assert out.with_suffix(".svg").read_text().startswith("<svg")
    out.write_text(out.read_text() + _TISSUE)
    scene = plica.Scene.load(out)
    mesh = plica.build_mesh(scene.mesh)
    points = np.asarray(mesh.points)[np.unique(mesh.surfaces["airway"])]
    assert points[:, 1].max() == pytest.approx(6.3e-3)
    slit = points[(np.abs(points[:, 2] + 2e-3) < 1.9e-3) & (np.abs(points[:, 1]) < 1e-9)]
    np.testing.assert_allclose(np.abs(slit[:, 0]), 0.4e-3, atol=0.02e-3)  # a third of a pixel


def test_wrong_calls_are_refused_in_one_sentence(
    picture: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frame, mask = picture
    out = tmp_path / "mesh.toml"
    for asked, told in (
        ([frame, "--mask", mask], "must be one of both"),
        ([frame, "--mask", mask, "--mm-per-px", "0"], "mm_per_px = 0.0 mm"),
        ([frame, "--frame", "3", "--mm-per-px", "0.06"], "is for analyses"),
        ([str(tmp_path), "--mm-per-px", "0.06"], "must have --frame N"),
        ([str(tmp_path / "none.png"), "--mm-per-px", "0.06"], "No such file"),
    ):
        assert main(["larynx", *asked, "-o", str(out)]) == 2
        assert told in capsys.readouterr().err
    assert not out.exists()
