"""What a film is written to, what it refuses, and its command."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from filmed_folds import PIXEL, FilmedFolds, folds, moved, shifted, voiced
from picture_files import refused
from plica.commands.main import main
from plica.films import Clip
from plica.video import Recording
from repository import ROOT

SMALL = plica.Camera(width=48, height=64)
TIMES = np.arange(5) * 0.5e-3


def small(**changed: Any) -> Clip:
    return plica.film(moved(voiced(), TIMES), SMALL, **changed)


@pytest.mark.parametrize("name", ["clip.avi", "clip.npy", "clip.h5"])
def test_plica_video_reads_every_frame_as_it_was_taken(tmp_path: Path, name: str) -> None:
    clip = small()
    written = plica.write_film(clip, tmp_path / name)
    assert sorted(written) == sorted(tmp_path.iterdir())
    dataset = "frames" if name == "clip.h5" else None
    recording = Recording.open(tmp_path / name, dataset=dataset, scale=(0, 255))
    assert recording.count == clip.count == 5
    for k, frame in enumerate(recording.frames()):
        np.testing.assert_array_equal(frame, clip.frame(k))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", ["clip.avi", "clip.npy", "clip.h5"])
def test_a_film_that_is_stopped_leaves_nothing_and_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, number: signal.Signals
) -> None:
    clip, frame = small(), Clip.frame

    def stopping(self: Clip, index: int) -> Any:
        if index == 2:
            os.kill(os.getpid(), number)
        return frame(self, index)

    monkeypatch.setattr(Clip, "frame", stopping)
    with pytest.raises(KeyboardInterrupt, match=r"\d of 5 frames"):
        plica.write_film(clip, tmp_path / name)
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(Clip, "frame", frame)
    assert plica.write_film(clip, tmp_path / name) == sorted(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["clip.npy", "clip.h5"])
def test_the_truth_is_stored_with_its_units(tmp_path: Path, name: str) -> None:
    run = moved(voiced(), np.arange(9) * 0.25e-3)
    clip = plica.film(run, SMALL, exposure="0.2 ms", fps=1000)
    plica.write_film(clip, tmp_path / name)
    with h5py.File(tmp_path / (name if name == "clip.h5" else "clip.truth.h5")) as file:
        assert file.attrs["fps"] == 1000
        assert file.attrs["mm_per_px"] == 0.06
        assert file["camera"].attrs["width"] == 48
        assert file["film"].attrs["exposure"] == 0.2e-3
        assert ("frames" in file) == (name == "clip.h5")
        shapes = {
            key: (data.shape, data.attrs["units"].decode())
            for key, data in file.items()
            if hasattr(data, "shape")
        }
        n = clip.count
        for key, expected in {
            "time": ((n,), "s"),
            "flow": ((n - 1, 64, 48, 2), "px"),
            "visible": ((n - 1, 64, 48), "1"),
            "glottis": ((n, 64, 48), "1"),
            "glottal_area": ((n,), "m^2"),
            "projection": ((3, 4), "px, px, m"),
        }.items():
            assert shapes[key] == expected
        for k in range(n):
            np.testing.assert_array_equal(file["glottis"][k], clip.glottis(k))
            assert file["glottal_area"][k] == pytest.approx(clip.glottis(k).sum() * PIXEL**2)
        flow, visible = clip.flow(n - 2)
        np.testing.assert_array_equal(file["flow"][n - 2], flow)
        np.testing.assert_array_equal(file["visible"][n - 2], visible)
        # What a pixel shows, at rest there, moved and projected, is that pixel again.
        place = clip.material(0)
        y, x = np.argwhere(np.isfinite(place[..., 0]))[::40].T
        still = plica.film(moved(shifted(), TIMES), SMALL).material(0)[y, x]
        p = file["projection"][()]
        np.testing.assert_allclose(p[:2, :3] @ still.T + p[:2, 3:], np.stack([x, y]), atol=1e-9)


def test_frames_fall_on_stored_instants_unless_asked_otherwise() -> None:
    run = moved(voiced(), 3e-3 + np.arange(21) * 0.1e-3)
    clip = plica.film(run, SMALL)
    np.testing.assert_allclose(clip.time, run.fields["time"], rtol=1e-9)
    assert clip.fps == 10_000
    clip = plica.film(run, SMALL, fps=4000, start="3.5 ms", end=0.0046)
    np.testing.assert_allclose(clip.time, [3.5e-3, 3.75e-3, 4e-3, 4.25e-3, 4.5e-3])
    clip = plica.film(run, SMALL, exposure="100 us")  # half of it before and after
    assert clip.time[0] == pytest.approx(3.1e-3)
    assert clip.time[-1] == pytest.approx(4.9e-3)
    assert len(clip) == clip.count == 19


def _without(run: FilmedFolds) -> FilmedFolds:
    return FilmedFolds(run.mesh, {})


def _broken() -> FilmedFolds:
    run = moved(voiced(), TIMES)
    run.fields["displacement"][1, 7] = np.nan
    return run


def _uneven() -> FilmedFolds:
    return moved(voiced(), [0, 1e-3, 3e-3])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: plica.film(_without(moved(voiced(), TIMES))),
            "stored fields = 0; must be >= 2. Set output.every",
        ),
        (lambda: plica.film(moved(voiced(), [0.0])), "stored fields = 1; must be >= 2"),
        (lambda: plica.film(_uneven()), "0.001 to 0.002 s apart; must be even"),
        (lambda: plica.film(_broken()).frame(1), "the stored field at 0.0005 s is not finite"),
        (
            lambda: small(fps=4000),
            "fps = 4000 /s; must be <= 2000 /s, the rate at which the run stored its fields",
        ),
        (lambda: small(fps=900), "stored fields = 5; must be >= 7 to interpolate"),
        (
            lambda: plica.film(moved(voiced(), np.arange(20) * 1.3e-3), SMALL, fps=500),
            "is uncertain by .* px; must be at most 0.25 px. Store fields more often",
        ),
        (lambda: small(fps=1000, exposure="2 ms"), "exposure = 0.002 s; must be at most 1 / fps = 0.001 s"),
        (lambda: small(exposure="0.6 ms"), "exposure = 0.0006 s; must be at most 1 / fps = 0.0005 s"),
        (lambda: small(start="1.9 ms", end="1 ms"), r"Film: end = 0.001 s; must be > start = 0.0019 s."),
        (lambda: small(start="1.9 ms"), "frames = 1, at 2000 /s from 0.0019 s to 0.002 s; must be >= 2"),
        (lambda: small(start="1 s"), r"start = 1 s; must be in \[0, 0.002\] s"),
        (lambda: small(end="5 ms"), r"end = 0.005 s; must be in \[0, 0.002\] s"),
        (lambda: small(exposure="1 mm"), 'exposure = "1 mm"; must be .* "mm" has another dimension'),
        (lambda: small(grain=0.25), r"grain = 0.25 m; must be a number in \[1e-06, 0.1\]. Is the unit right"),
        (lambda: small(samples=0), r"samples = 0; must be a whole number in \[1, 256\]"),
        (lambda: small(seed=1.5), "seed = 1.5; must be a whole number"),
        (lambda: small(light=(0, 0, -1)), "must be three numbers, the third, towards the camera, > 0"),
        (lambda: small(light=("a", 0, 1)), "must be three numbers"),
        (lambda: small(ambient=1.2), r"ambient = 1.2; must be a number in \[0, 1\]"),
        (lambda: small(read_noise=float("nan")), "read_noise = nan grey levels; must be a number in"),
        (lambda: small().frame(5), r"frame = 5; must be in \[0, 5\)"),
        (lambda: small().flow(4), r"frame = 4; must be in \[0, 4\)"),
        (
            lambda: plica.film(moved(voiced(), TIMES), SMALL, plica.Film(), seed=2),
            "options and seed are both given; must be one or the other",
        ),
        (lambda: plica.Camera(mm_per_px=0), r"mm_per_px = 0 mm; must be a number in \[0.0001, 10\]"),
        (lambda: plica.Camera(width=8), r"width = 8 px; must be a whole number in \[16, 4096\]"),
        (lambda: plica.Camera(tilt=90), "tilt = 90 degrees; must be a number in"),
        (lambda: plica.Camera(centre=(0, 0)), "must be three lengths, x, y and z"),  # type: ignore[arg-type]
        (lambda: plica.Camera(centre=(0, "3 kPa", 0)), 'centre = "3 kPa"; must be .* has another dimension'),
        (
            lambda: plica.film(moved(voiced(), TIMES), plica.Camera(centre=("5 cm", 0, 0))),
            "Camera: no tissue is visible in 256 x 256 px of 0.06 mm; must be. Check centre",
        ),
        (
            lambda: plica.write_film(small(), "clip.mp4"),
            "clip.mp4; must end in one of .avi, .npy, .h5, .hdf5",
        ),
        (lambda: plica.write_film(small(), "nowhere/clip.avi"), "nowhere is not a directory"),
    ],
)
def test_what_cannot_be_filmed_is_refused_in_one_sentence(make: Any, message: str) -> None:
    with pytest.raises(plica.InvalidInput, match=message) as error:
        make()
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(("Film: ", "Camera: "))


def test_a_clip_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    run = moved(voiced(), TIMES)
    run.fields["displacement"][4] = np.nan
    clip = plica.film(run, SMALL)
    with pytest.raises(plica.InvalidInput, match="not finite"):
        plica.write_film(clip, tmp_path / "clip.avi")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of 24 steps of the coarse larynx, pushed open, fields every other step."""
    soft = plica.Tissue(E="10 kPa", nu=0.4, viscosity="1 Pa s")
    scene = plica.Scene(
        plica.Larynx(larynx="coarse"),
        {"body": soft, "ligament": soft, "cover": soft},
        airflow=plica.Airflow(subglottal_pressure="0.8 kPa"),
        initial=plica.Initial(opening_velocity="1 m/s"),
        time=plica.Stepping(step="50 us", duration="1.2 ms"),
        output=plica.Output(every="100 us"),
    )
    directory = tmp_path_factory.mktemp("film") / "run"
    plica.run(scene, directory, progress=False)
    return directory


def test_the_command_films_a_run_and_says_how_to_analyse_it(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = tmp_path / "clip.avi"
    arguments = [
        "film",
        str(stored),
        "-o",
        str(clip),
        "--size",
        "64,128",
        "--mm-per-px",
        "0.12",
        "--tilt",
        "-5",
    ]
    assert (
        main([*arguments, "--from", "200us", "--centre", "-0.5,0,0", "--samples", "1", "--ambient", "0.8"])
        == 0
    )
    result = capsys.readouterr()
    assert result.err.splitlines()[-1].startswith(
        "plica: Caution: plica video will find no cycles in this film: "
    )
    assert re.match(r"plica: \d+ frames, about \S+ (s|min|h); ", result.err)  # before the first is rendered
    message = result.out.splitlines()
    assert (
        message[0]
        == f"written: {clip}, {tmp_path / 'clip.truth.h5'}: 11 frames of 64 x 128 px, 10000 per second"
    )
    assert message[1] == f"plica video {clip} --fps 10000 --mm-per-px 0.12 -o analysis"
    with h5py.File(tmp_path / "clip.truth.h5") as file:
        assert file["camera"].attrs["tilt"] == -5
        assert file["film"].attrs["ambient"] == 0.8
        np.testing.assert_allclose(file["camera"].attrs["centre"], [-0.5e-3, 0, 0])
        assert file["time"][0] == pytest.approx(2e-4)
    again = [*arguments, "--quiet", "--to", "0.0005"]
    kept = clip.read_bytes()
    result = refused(again, capsys)
    assert result.startswith(
        f"plica: {clip}, {tmp_path / 'clip.truth.h5'} would be overwritten; must not exist."
    )
    assert "--overwrite" in result
    assert clip.read_bytes() == kept
    assert main([*again, "--overwrite"]) == 0
    assert capsys.readouterr().out == ""
    assert Recording.open(clip).count == 6


@pytest.mark.parametrize(("periods", "size"), [(2, "48,64"), (5, "48,96")])
def test_a_film_of_too_few_cycles_or_a_part_of_the_glottis_is_cautioned(
    periods: int,
    size: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Periods of eight frames; the film has what `plica video` will find in it."""
    run = moved(voiced(frequency=200), np.arange(8 * periods + 1) * 0.625e-3)
    monkeypatch.setattr(plica.Run, "load", lambda _: run)
    clip = str(tmp_path / "clip.npy")
    options = ["--size", size, "--mm-per-px", "0.2", "--samples", "1", "--quiet"]
    assert main(["film", "run", "-o", clip, *options]) == 0
    message = capsys.readouterr().err
    if periods == 2:
        assert "complete cycles of the glottal area; at least 3 are needed" in message
        assert "Five periods" in message
        assert "the border of the image cuts the glottis in " in message
    else:
        assert message == ""


def test_a_film_of_folds_at_rest_is_cautioned_without_advice_to_film_more(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run = moved(voiced(amplitude=0.0), np.arange(17) * 0.625e-3)
    monkeypatch.setattr(plica.Run, "load", lambda _: run)
    size = ["--size", "48,64", "--mm-per-px", "0.2", "--samples", "1"]
    assert main(["film", "run", "-o", str(tmp_path / "clip.npy"), *size, "--quiet"]) == 0
    message = capsys.readouterr().err
    assert "no oscillation" in message
    assert "Five periods" not in message


@pytest.mark.slow
def test_the_lines_of_the_documentation_run(
    stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (ROOT / "docs" / "film.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert code.count("\n") <= 10
    for one, other in {"runs/first": str(stored), "20 ms": "100 us", "(10)": "(3)"}.items():
        assert one in code
        code = code.replace(one, other)
    monkeypatch.chdir(tmp_path)
    found: dict[str, Any] = {}
    exec(code, found)
    assert found["picture"].shape == found["glottis"].shape == (256, 256)
    assert found["flow"].shape == (256, 256, 2)
    assert (tmp_path / "clip.avi").is_file()
    assert (tmp_path / "clip.truth.h5").is_file()


def test_the_command_refuses_in_one_line(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clip = str(tmp_path / "clip.avi")
    assert "there is no run in it" in refused(["film", str(tmp_path), "-o", clip], capsys)
    assert "must be <= 10000 /s" in refused(["film", str(stored), "-o", clip, "--fps", "20000"], capsys)
    assert "no tissue is visible" in refused(["film", str(stored), "-o", clip, "--centre", "90,0,0"], capsys)
    assert "must end in one of" in refused(["film", str(stored), "-o", f"{clip}.gif"], capsys)
    for option, value, message in (
        ("--from", "1", "plica: --from = 1 s; must be in"),
        ("--to", "-1s", "plica: --to = "),
        ("--noise", "-3", "plica: --noise = -3 grey levels; must be"),
        ("--size", "8,64", "plica: --size = 8 px; must be"),
        ("--mm-per-px", "0", "plica: --mm-per-px = 0 mm; must be"),
    ):
        assert refused(["film", str(stored), "-o", clip, f"{option}={value}"], capsys).startswith(message)
    assert list(tmp_path.iterdir()) == []


def test_the_area_filmed_is_that_of_the_run(stored: Path) -> None:
    run = plica.Run.load(stored)
    clip = plica.film(run, plica.Camera(width=64), start="100 us", samples=1)
    counted = np.array([clip.area(k) for k in range(clip.count)])
    least = np.interp(clip.time, run.time, run["minimum_area"])
    # The narrowest place of every line of sight is at most the narrowest section: less by what the folds hang
    # over one another, more by pixels that go either way along two edges of 14 mm.
    outline = 0.5 * 28e-3 * clip.camera.pixel
    assert (counted < least + outline).all()
    assert (counted > 0.85 * least - outline).all()
    assert np.corrcoef(counted, least)[0, 1] > 0.99
    assert np.ptp(least) > 2 * outline
    part = plica.film(run.between("0.5 ms", None), plica.Camera(width=64), samples=1)
    assert part.area(0) == clip.area(int(np.flatnonzero(np.isclose(clip.time, part.time[0]))[0]))


def test_a_mesh_without_airway_is_seen_as_its_skin() -> None:
    mesh = plica.build_mesh(plica.Block(size=("10 mm", "4 mm", "2 mm"), divisions=(2, 2, 1)))
    camera = plica.Camera(mm_per_px=0.1, width=160, height=100, centre=("5 mm", "2 mm", "2 mm"))
    clip = plica.film(moved(shifted(x=2e-4), [0, 1e-3], mesh), camera)
    flow, visible = clip.flow(0)
    assert np.isfinite(flow[..., 0]).sum() == visible.sum() == pytest.approx(100 * 40, abs=150)
    np.testing.assert_allclose(flow[visible], np.broadcast_to([2.0, 0.0], (visible.sum(), 2)), atol=1e-5)
    assert folds().surfaces.keys() >= {"airway"}
    assert not clip.glottis(0).any()
