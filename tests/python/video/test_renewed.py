"""An analysis that was stopped goes on, and a changed setting or mask renews what stands on it alone."""

from __future__ import annotations

import csv
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from conftest import MOVIE
from plica.commands.main import main
from plica.synthetic.glottis import SyntheticGlottis
from plica.video import chain
from plica.video.analysis import analyse, load
from plica.video.errors import VideoError
from plica.video.files.image_file import read_image
from plica.video.glottis.segmenter import write_masks
from plica.video.report import page as report
from plica.video.settings import Settings


@pytest.mark.slow
def test_a_stopped_analysis_goes_on_and_ends_the_same(
    movie: Path, done: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(fps=4000.0, mm_per_px=0.05, preset="fast")
    calls = 0
    whole = chain.flow

    def stop(*args: object, **named: object) -> object:
        nonlocal calls
        calls += 1
        if calls == 20:
            raise KeyboardInterrupt
        return whole(*args, **named)

    monkeypatch.setattr(chain, "flow", stop)
    with pytest.raises(KeyboardInterrupt):
        analyse(movie, tmp_path, settings, progress=False)
    with h5py.File(tmp_path / "flow.h5") as file:
        assert np.count_nonzero(file["checksum"]) == 19
    assert not load(tmp_path).complete  # the glottis is there, the motion is not
    analyse(movie, tmp_path, settings, progress=False)
    assert calls == 20 + 65 - 19
    with h5py.File(tmp_path / "results.h5") as one, h5py.File(done / "results.h5") as other:
        names: list[str] = []
        other.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert {"drift/motion", "glottis/mask", "modes/patterns", "paths/places", "trust/confidence"} <= set(
            names
        )
        for name in names:
            assert np.array_equal(one[name][()], other[name][()], equal_nan=one[name].dtype.kind == "f"), name
    for name in ("flow/uv", "flow/round_trip", "flow/residual"):
        assert np.array_equal(load(tmp_path)[name], load(done)[name], equal_nan=True), name


@pytest.mark.usefixtures("few_draws")
def test_glottis_alone_is_gone_on_with_and_modes_are_printed(
    movie: Path, done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [str(movie), "-o", str(tmp_path), "--fps", "4000", "--mm-per-px", "0.05", "--preset", "fast"]
    assert main(["glottis", *arguments]) == 0
    said = capsys.readouterr().out
    assert "fundamental_frequency" in said
    assert said.index("left: left in the image; right: right in the image") > said.index("amplitude_left")
    with h5py.File(tmp_path / "results.h5") as file:
        assert set(file) == {"drift", "glottis", "sides", "checksums"}
    with (tmp_path / "waveforms.csv").open() as table:
        assert "mode_coefficients_1 (px)" not in next(csv.reader(table))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Kymograms" in page
    assert "Principal modes" not in page
    for name in ("report.html", "measures.json"):
        (tmp_path / name).unlink()
    assert main(["report", str(tmp_path)]) == 0
    assert main(["measures", str(tmp_path)]) == 0
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == page
    assert (tmp_path / "measures.json").exists()
    assert main(["modes", *arguments]) == 0
    said = capsys.readouterr().out
    with h5py.File(tmp_path / "results.h5") as one, h5py.File(done / "results.h5") as other:
        assert np.array_equal(one["modes/patterns"][:], other["modes/patterns"][:])
        share = 100 * one["modes/share"][0]
    assert f"   1 {share:6.2f} %" in said
    assert main(["glottis", *arguments, "--patient-left", "right"]) == 0
    assert "left: left in the image (the patient's right)" in capsys.readouterr().out


@pytest.mark.slow
def test_another_recording_or_setting_needs_another_directory(movie: Path, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "results.h5", "w") as file:
        file["waveforms"] = 1.0
    with pytest.raises(VideoError, match=r"results\.h5 is no analysis of a recording"):
        analyse(movie, tmp_path, progress=False)
    with pytest.raises(VideoError, match=r"is no analysis of a recording"):
        load(tmp_path)
    with pytest.raises(VideoError, match=r"has no results\.h5"):
        load(tmp_path / "none")
    (tmp_path / "swept").mkdir()
    (tmp_path / "swept" / "plan.json").write_text("{}")
    with pytest.raises(VideoError, match="holds a sweep"):
        analyse(movie, tmp_path / "swept", progress=False)
    done = analyse(movie, tmp_path / "a", until="glottis", progress=False)
    with pytest.raises(VideoError, match=r"preset is fast; must be video, as in the analysis in .*a,"):
        analyse(movie, tmp_path / "a", Settings(preset="fast"), progress=False)
    with pytest.raises(VideoError, match=r"region is 0,0,40,40; must be not given"):
        analyse(movie, tmp_path / "a", Settings(region=(0, 0, 40, 40)), progress=False)
    np.save(tmp_path / "other.npy", np.load(movie)[:60])
    with pytest.raises(VideoError, match=r"has 60 frames of 97 x 95 px, .*; must have 66 frames"):
        analyse(tmp_path / "other.npy", tmp_path / "a", progress=False)
    shutil.copy(movie, tmp_path / "moved.npy")  # the same recording elsewhere
    assert np.array_equal(
        analyse(tmp_path / "moved.npy", tmp_path / "a", until="glottis", progress=False).area.total,
        done.area.total,
    )
    assert load(tmp_path / "a").source == (tmp_path / "moved.npy").resolve()


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_what_is_said_of_a_recording_may_be_said_later(
    movie: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = analyse(movie, tmp_path, until="glottis", progress=False)
    assert first.units["area_total"] == "px^2"
    assert first.measures["fundamental_frequency"].unit == "1/frame"
    monkeypatch.delattr(chain, "learn")  # nothing is looked for again
    told = Settings(fps=4000, mm_per_px=0.1, patient_left="right", anterior="upper")
    again = analyse(movie, tmp_path, told, until="glottis", progress=False)
    assert again.units["area_total"] == "m^2"
    assert again.waveforms["area_total"] == pytest.approx(1e-4**2 * first.waveforms["area_total"], abs=0)
    page = report.write_report(again).read_text(encoding="utf-8")
    assert "right in the image (the patient&#39;s left)" in page
    assert "upper end (anterior)" in page
    kept = analyse(movie, tmp_path, Settings(mm_per_px=0.2), until="glottis", progress=False)
    assert (kept.settings.fps, kept.settings.mm_per_px) == (4000, 0.2)  # what was said stays


@pytest.mark.slow
def test_lines_and_modes_may_be_chosen_anew_without_the_flow(
    movie: Path, done: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(done, tmp_path / "a")
    monkeypatch.delattr(chain, "learn")
    monkeypatch.delattr(chain, "flow")
    before = load(done)
    x, y = before.midline.upper
    moved = (x + 0.8, y, *before.midline.lower)  # under a pixel: the flow was told as good a line
    chosen = Settings(preset="fast", midline=moved, kymogram=(0.5,), modes=3)
    found = analyse(movie, tmp_path / "a", chosen, progress=False)
    assert found.midline.upper == (x + 0.8, y)
    assert found.area.total == pytest.approx(before.area.total)
    assert found.area.left.sum() > before.area.left.sum()
    assert found.modes.share == pytest.approx(before.modes.share[:3])
    assert len(found["sides/kymogram"]) == 1
    with pytest.raises(VideoError, match=r"must have glottis on both of its sides"):
        analyse(movie, tmp_path / "a", Settings(preset="fast", midline=(2, 5, 2, 90)), progress=False)
    kept = analyse(movie, tmp_path / "a", Settings(preset="fast"), progress=False)  # as given before
    assert kept.midline.upper == (x + 0.8, y)
    assert kept.settings.kymogram == (0.5,)
    assert kept.modes.share.size == 3


def made(group: str, directory: Path) -> float:
    """When a group of results.h5 was made: a mark that a renewed one has not."""
    with h5py.File(directory / "results.h5", "a") as file:
        if "mark" not in file[group].attrs:
            file[group].attrs["mark"] = 1
            return 0
        return 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "renewed"),
    [
        ({"kymogram": (0.4,)}, {"sides"}),
        ({"modes": 2}, {"modes"}),
        ({"midline": (49.0, 14.0, 48.0, 80.0)}, {"sides", "trust", "paths", "modes"}),
        ({"fps": 2000.0}, set()),
    ],
)
def test_what_stands_on_a_setting_is_made_again_and_no_more(
    change: dict, renewed: set[str], movie: Path, done: Path, tmp_path: Path
) -> None:
    shutil.copytree(done, tmp_path / "a")
    groups = {"drift", "glottis", "sides", "trust", "paths", "modes"}
    assert not any(made(group, tmp_path / "a") for group in groups)
    analyse(movie, tmp_path / "a", Settings(preset="fast", **change), progress=False)
    assert {group for group in groups if not made(group, tmp_path / "a")} == renewed


@pytest.mark.slow
def test_a_flow_without_its_results_is_not_taken(movie: Path, done: Path, tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    shutil.copy(done / "flow.h5", tmp_path / "a" / "flow.h5")
    analyse(movie, tmp_path / "a", Settings(preset="robust"), until="glottis", progress=False)
    assert not (tmp_path / "a" / "flow.h5").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_a_drawn_mask_is_taken_and_only_what_stands_on_it_is_done_again(
    movie: Path, done: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(fps=4000.0, mm_per_px=0.05, preset="fast")
    shutil.copytree(done, tmp_path / "a")
    assert main(["masks", str(done), "-o", str(tmp_path / "drawn"), "--frames", "3,20", "--quiet"]) == 0
    assert sorted(path.name for path in (tmp_path / "drawn").iterdir()) == [
        f"{kind}_{frame}.png" for kind in ("frame", "mask") for frame in ("00003", "00020")
    ]
    assert np.array_equal(read_image(tmp_path / "drawn" / "mask_00003.png") > 127, load(done).mask(3))
    drawn = SyntheticGlottis(MOVIE).mask(20)
    drawn[40:50, :10] = True  # no glottis that anything would find
    Image.fromarray(255 * drawn.astype(np.uint8)).save(tmp_path / "drawn" / "mask_00020.png")
    calls = 0
    whole = chain.flow

    def count(*args: object, **named: object) -> object:
        nonlocal calls
        calls += 1
        return whole(*args, **named)

    monkeypatch.setattr(chain, "flow", count)
    before = load(done)
    found = analyse(movie, tmp_path / "a", settings, masks=tmp_path / "drawn", progress=False)
    assert found.drawn == [3, 20]
    assert np.array_equal(found.mask(20), drawn)
    assert np.array_equal(found.mask(3), before.mask(3))
    changed = [k for k in range(66) if not np.array_equal(found.mask(k), before.mask(k))]
    pairs = {pair for k in changed for pair in (k - 1, k) if 0 <= pair < 65}
    assert 20 in changed
    assert calls == len(pairs)
    for k in range(65):
        assert np.array_equal(found.flow(k), before.flow(k)) or k in pairs
    assert "masks drawn by hand: 2" in report.write_report(found).read_text(encoding="utf-8")
    kept = analyse(movie, tmp_path / "a", settings, progress=False)  # they need not be given again
    assert kept.drawn == [3, 20]
    assert calls == len(pairs)
    white = {7: np.ones((95, 97), dtype=bool)}
    with pytest.raises(VideoError, match=r"those drawn \(frames 3, 7, 20\); must leave tissue around"):
        analyse(movie, tmp_path / "a", settings, masks=white, progress=False)
    assert load(tmp_path / "a").complete  # nothing is lost by it
    with pytest.raises(VideoError, match=r"mask_00003\.png is there; must not be"):
        write_masks(tmp_path / "drawn", {3: (np.zeros((95, 97), np.float32), drawn)})
    more = analyse(movie, tmp_path / "a", settings, masks={5: before.mask(5)}, progress=False)
    assert more.drawn == [3, 5, 20]

    def stop(*args: object, **named: object) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr(chain, "flow", stop)
    with pytest.raises(KeyboardInterrupt):  # in a correction, which is then taken back
        analyse(movie, tmp_path / "a", settings, masks={9: before.mask(9) | drawn}, progress=False)
    monkeypatch.setattr(chain, "flow", whole)
    none = analyse(movie, tmp_path / "a", settings, masks={}, progress=False)
    assert none.drawn == []
    for name in ("flow/uv", "flow/round_trip", "flow/residual", "modes/coefficients"):
        assert np.array_equal(none[name], before[name], equal_nan=True)


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_a_killed_analysis_is_whole_and_goes_on(movie: Path, done: Path, tmp_path: Path) -> None:
    """It kills itself in its twentieth flow; every data set ends with the bits of one never stopped."""
    arguments = ["video", str(movie), "--fps", "4000", "--mm-per-px", "0.05", "--preset", "fast", "--quiet"]
    program = """
import os, signal, sys
from plica.commands.main import main
from plica.measures.waveforms import RECORDED
from plica.video import chain
whole, calls = chain.flow, 0
def flow(*arguments, **options):
    global calls
    calls += 1
    if calls == 20:
        os.kill(os.getpid(), signal.SIGKILL)
    return whole(*arguments, **options)
chain.flow = flow
sys.exit(main())
"""
    command = [sys.executable, "-c", program, *arguments, "-o", str(tmp_path)]
    assert subprocess.run(command, check=False).returncode == -9
    with h5py.File(tmp_path / "flow.h5", "r") as file:
        assert np.count_nonzero(file["checksum"]) == 19
    assert not load(tmp_path).complete
    assert main([*arguments, "-o", str(tmp_path)]) == 0
    for name in ("flow/uv", "flow/round_trip", "modes/patterns", "paths/places"):
        assert np.array_equal(load(tmp_path)[name], load(done)[name], equal_nan=True)
