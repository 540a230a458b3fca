"""What `pip install plica` brings is enough to simulate and to measure, and what needs more says what."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import plica
from complaints import refused
from plica.commands.main import main
from plica.video.analysis import load

_EXTRAS = ("av", "meshio", "tifffile", "xarray", "openpyxl", "onnxruntime", "pycine", "pydicom", "weasyprint")
_SCENE = """
tissue = "thesis_corrected"
symmetry = "quarter"
mesh = { larynx = "coarse" }
airflow = { subglottal_pressure = "0.8 kPa" }
time = { step = "100 us", duration = "1 ms" }
"""


@pytest.fixture(autouse=True)
def base(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [*sys.modules]:
        if name.partition(".")[0] in _EXTRAS:
            monkeypatch.delitem(sys.modules, name)
    for name in _EXTRAS:
        monkeypatch.setitem(sys.modules, name, None)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_voice_is_run_and_reported(tmp_path: Path) -> None:
    scene, out = tmp_path / "scene.toml", tmp_path / "run"
    scene.write_text(_SCENE, encoding="utf-8")
    assert main(["run", str(scene), "-o", str(out), "--quiet"]) == 0
    assert (out / "report.html").stat().st_size > 10_000
    with pytest.raises(plica.InvalidInput, match=r"^Run.to_xarray needs xarray, .*'plica\[xarray\]'\.$"):
        plica.Run.load(out).to_xarray()


def test_a_recording_in_an_array_or_in_pictures_is_measured(tmp_path: Path) -> None:
    from PIL import Image

    y, x = np.mgrid[0:64, 0:48]
    folder = tmp_path / "pictures"
    folder.mkdir()
    frames = np.full((40, 64, 48), 180, np.uint8)
    for k, frame in enumerate(frames):
        frame[((x - 24) / max(1e-3, 6 * np.sin(0.6 * k))) ** 2 + ((y - 32) / 24) ** 2 < 1] = 20
        Image.fromarray(frame).save(folder / f"{k:03d}.png")
    np.save(tmp_path / "film.npy", frames)
    areas = []
    for source in (tmp_path / "film.npy", folder):
        out = tmp_path / f"{source.name}-out"
        assert main(["glottis", str(source), "--fps", "4000", "-o", str(out), "--quiet", "--no-drift"]) == 0
        areas.append(load(out).area)
    assert areas[0].left == pytest.approx(areas[1].left)
    assert areas[0].total.max() > 100


@pytest.mark.parametrize(
    ("command", "name", "said"),
    [
        ("glottis", "x.avi", r"Recording: x.avi needs PyAV, .*'plica\[video\]'"),
        ("glottis", "x.tif", r"x.tif needs tifffile, .*'plica\[video\]'"),
        ("mesh", "x.toml", r"mesh.file = \S*x.msh needs meshio, .*'plica\[mesh\]'"),
    ],
)
def test_what_needs_more_says_what(
    command: str, name: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begin = {"x.avi": b"RIFF\0\0\0\0AVI " + bytes(500), "x.tif": b"II*\0" + bytes(500)}
    begin["x.toml"] = _SCENE.replace('larynx = "coarse"', 'file = "x.msh", layers = { body = 1 }').encode()
    (tmp_path / name).write_bytes(begin[name])
    (tmp_path / "x.msh").write_text("$MeshFormat\n", encoding="utf-8")
    more = [] if command == "mesh" else ["--fps", "4000", "-o", str(tmp_path / "out")]
    error = refused([command, str(tmp_path / name), *more], capsys)
    assert len(error.strip().splitlines()) == 1
    assert re.search(said, error), error
