"""A recording through the whole chain: results, report, resume, refusals."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from plica.cli import main
from plica.video import analysis, report
from plica.video.analysis import Settings, analyse, load
from plica.video.errors import VideoError
from plica.video.synthetic import Synthetic, SyntheticGlottis

_OPTIONS = Synthetic(
    height=96, width=96, frames=66, frequency=0.0813, amplitude=(5, 5), opening=(2, 2), highlights=2
)


@pytest.fixture(scope="module")
def movie(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("movie") / "glottis.npy"
    np.save(path, SyntheticGlottis(_OPTIONS).stack())
    return path


@pytest.fixture(scope="module")
def done(movie: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("done")
    arguments = ["video", str(movie), "--fps", "4000", "--mm-per-px", "0.05", "--preset", "fast", "--quiet"]
    assert main([*arguments, "-o", str(where)]) == 0
    return where


@pytest.mark.slow
def test_the_command_leaves_measures_tables_and_a_report(done: Path) -> None:
    found = load(done)
    assert found.measures["fundamental_frequency"].value == pytest.approx(0.0813 * 4000, abs=2)
    assert abs(found.measures["phase_asymmetry"].value) < 0.1
    collisions = [k for k, flags in enumerate(found.flags) if "collision" in flags]
    assert len(collisions) >= 4  # once a cycle
    assert all(found.area.total[k] < found.area.total[k - 1] for k in collisions)
    assert json.loads((done / "measures.json").read_text())["fundamental_frequency"]["unit"] == "Hz"
    with (done / "waveforms.csv").open() as file:
        rows = list(csv.reader(file))
    assert len(rows) == 67
    assert len({len(row) for row in rows}) == 1
    page = (done / "report.html").read_text(encoding="utf-8")
    text_alone = re.sub(r"data:image/[a-z]+;base64,[A-Za-z0-9+/=]+", "", page)
    assert "http" not in text_alone.replace("http://www.w3.org", "")  # fetches nothing
    for text in ("Fundamental frequency", "Open quotient", "Kymogram", "mode 1", "--fps 4000"):
        assert text in page
    assert page.count("data:image/jpeg") > 20


@pytest.mark.slow
def test_the_first_mode_is_the_opening_of_both_folds(done: Path) -> None:
    with h5py.File(done / "results.h5") as file:
        share, symmetry = file["modes/share"][:], file["modes/symmetry"][:]
        uv = file["flow/uv"][:]
        tissue = file["glottis/tissue"][:]
    assert share[0] > 0.5
    assert symmetry[0] > 0.9
    glottis = SyntheticGlottis(_OPTIONS)
    errors = []
    for t in range(1, 60, 7):
        truth, known = glottis.flow(t, t + 1)
        errors.append(np.hypot(*np.moveaxis(uv[t] - truth, -1, 0))[known & tissue].mean())
    assert np.mean(errors) < 0.15


@pytest.mark.slow
def test_a_stopped_analysis_goes_on_and_ends_the_same(
    movie: Path, done: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(fps=4000.0, mm_per_px=0.05, preset="fast")
    calls = 0
    whole = analysis.flow

    def stop(*args: object, **named: object) -> object:
        nonlocal calls
        calls += 1
        if calls == 20:
            raise KeyboardInterrupt
        return whole(*args, **named)

    monkeypatch.setattr(analysis, "flow", stop)
    with pytest.raises(KeyboardInterrupt):
        analyse(movie, tmp_path, settings, progress=False)
    with h5py.File(tmp_path / "results.h5") as file:
        assert file["flow"].attrs["done"] == 19
    with pytest.raises(VideoError, match="not finished"):
        load(tmp_path)
    analyse(movie, tmp_path, settings, progress=False)
    assert calls == 20 + 65 - 19
    with h5py.File(tmp_path / "results.h5") as one, h5py.File(done / "results.h5") as other:
        for name in ("flow/uv", "modes/patterns", "glottis/left", "paths/places"):
            assert np.array_equal(one[name][:], other[name][:], equal_nan=True)


@pytest.mark.slow
def test_the_report_draws_the_outline_on_the_frame_that_it_belongs_to(tmp_path: Path) -> None:
    """The camera moves by 6 px: masks are those of frames without that motion."""
    stack = SyntheticGlottis(_OPTIONS).stack()
    moved = np.stack([np.roll(frame, min(k // 4, 6), axis=1) for k, frame in enumerate(stack)])
    np.save(tmp_path / "moved.npy", moved)
    analyse(tmp_path / "moved.npy", tmp_path, Settings(preset="fast"), until="glottis", progress=False)
    with h5py.File(tmp_path / "results.h5") as file:
        assert file["frames/drift"][-1, 0] == pytest.approx(6, abs=0.5)
        areas = file["glottis/left"][:] + file["glottis/right"][:]
        wide = 30 + int(np.argmax(areas[30:]))
        mask = file["glottis/mask"][wide]
        image = report._overlays(load(tmp_path), tmp_path / "moved.npy", file, np.array([wide]))[0]
    grey = (image[..., 0] == image[..., 1]) & (image[..., 1] == image[..., 2])
    assert image[mask & grey].mean() < 40
    assert image[~mask & grey].mean() > 80


@pytest.mark.slow
def test_glottis_alone_is_gone_on_with_and_modes_are_printed(
    movie: Path, done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [str(movie), "-o", str(tmp_path), "--fps", "4000", "--mm-per-px", "0.05", "--preset", "fast"]
    assert main(["glottis", *arguments]) == 0
    assert "fundamental_frequency" in capsys.readouterr().out
    with h5py.File(tmp_path / "results.h5") as file:
        assert set(file) == {"frames", "glottis"}
    with (tmp_path / "waveforms.csv").open() as table:
        assert "mode 1 (px)" not in next(csv.reader(table))
    assert main(["modes", *arguments]) == 0
    said = capsys.readouterr().out
    with h5py.File(tmp_path / "results.h5") as one, h5py.File(done / "results.h5") as other:
        assert np.array_equal(one["modes/patterns"][:], other["modes/patterns"][:])
        share = 100 * one["modes/share"][0]
    assert f"   1 {share:6.2f} %" in said
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--fps", "-4000"], "fps = -4000; must be > 0"),
        (["--preset", "fats"], 'preset = "fats"; must be one of robust'),
        (["--region", "0,0,500,500"], "must lie within the frames of 96 x 96 px"),
    ],
)
def test_a_bad_setting_ends_in_one_sentence(
    arguments: list[str], said: str, movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["video", str(movie), "-o", str(tmp_path / "out"), "--quiet", *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_another_recording_or_setting_needs_another_directory(movie: Path, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file.attrs["source"] = "elsewhere.avi"
    with pytest.raises(VideoError, match=r"holds an analysis with another source, elsewhere\.avi"):
        analyse(movie, tmp_path, progress=False)
    with pytest.raises(VideoError, match=r"has no results\.h5"):
        load(tmp_path / "none")
