"""``plica larynx``: what it writes is a scene's mesh."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import plica
from pictured_folds import pictured
from plica.commands.main import main
from plica.synthetic import Synthetic, SyntheticGlottis

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
    message = capsys.readouterr().out
    assert "contour error: mean 0." in message
    assert "r_in 6.300 mm, r_out 7.300 mm, l_occ 0.200 mm" in message
    assert out.with_suffix(".svg").read_text().startswith("<svg")
    written = out.read_text()
    assert main(["larynx", frame, *asked]) == 2  # it may have become a scene since
    assert f"{out}, {out.with_suffix('.svg')} would be overwritten" in capsys.readouterr().err
    assert out.read_text() == written
    out.write_text(written + 'tissue = "thesis_corrected"\ntime = { step = "50 us", duration = "1 ms" }\n')
    assert plica.Scene.load(out).time.steps == 20  # keys below the mesh are the scene's
    out.write_text(written + _TISSUE)
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
    out, nothing = tmp_path / "mesh.toml", str(tmp_path / "none.png")
    for asked, expected in (
        ([frame, "--mask", mask], "plica: --mm-per-px = None, --r-in = None; must be exactly one of the two"),
        ([frame, "--mask", mask, "--mm-per-px", "0"], "plica: --mm-per-px = 0.0 mm"),
        ([frame, "--frame", "3", "--mm-per-px", "0.06"], "is for analyses"),
        ([str(tmp_path), "--mm-per-px", "0.06"], "must come with --frame N"),
        ([nothing, "--mm-per-px", "0.06"], f"plica: {nothing} cannot be read: No such file"),
        ([frame, "--mm-per-px", "0.06", "--heights", "3,2,1,0,-1,-2"], "plica: --heights[1] = 0.002 m; must"),
    ):
        assert main(["larynx", *asked, "-o", str(out)]) == 2
        assert expected in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.slow
def test_an_analysis_gives_mask_and_scale(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = Synthetic(
        height=128, width=97, frames=24, frequency=0.0813, amplitude=(3, 3), opening=(6, 6), highlights=2
    )
    np.save(tmp_path / "glottis.npy", SyntheticGlottis(options).stack())
    asked = ["--fps", "4000", "--mm-per-px", "0.05", "--anterior", "lower", "--preset", "fast", "--quiet"]
    assert main(["video", str(tmp_path / "glottis.npy"), *asked, "-o", str(tmp_path / "done")]) == 0
    out = tmp_path / "mesh.toml"
    assert main(["larynx", str(tmp_path / "done"), "--frame", "0", "-o", str(out)]) == 0
    message = capsys.readouterr().out
    assert "0.05 mm per pixel" in message
    anterior, posterior = (float(y) for y in re.findall(r"(?:A|P0) \([\d.]+, ([\d.]+)\)", message))
    assert posterior < 0.3 * 128 < 0.7 * 128 < anterior
    assert main(["larynx", str(tmp_path / "done"), "--frame", "99", "-o", str(out), "--overwrite"]) == 2
    assert "frame 99" in capsys.readouterr().err
