"""``plica sound``: the file that it writes, what it prints, and what it refuses."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

import plica
from complaints import refused
from interrupted_runs import killed
from plica.commands.main import main


@pytest.fixture
def directory(tmp_path: Path, phonating: plica.Scene) -> Path:
    plica.run(phonating, tmp_path / "run", progress=False)
    return tmp_path / "run"


def test_the_sound_of_a_run_is_written_and_described(
    directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "voice.wav"
    assert main(["sound", str(directory), "-o", str(path)]) == 0
    said = capsys.readouterr()
    scale = float(re.findall(r"full scale (\S+) Pa", said.out)[0])
    rate, values = wavfile.read(path)
    wanted = plica.Run.load(directory).sound()
    assert rate == 48000
    assert scale * values / 2.0**31 == pytest.approx(wanted.pressure, abs=scale / 2**23)
    assert "0.3 m from the lips, radiated by the glottal flow, as there is no tract" in said.out
    assert re.search(r"level \d+\.?\d* dB \(re 20 uPa\) over all of it, up to 9000 Hz", said.out)
    assert said.err == ""
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run", "voice.wav"]


@pytest.mark.parametrize(("kind", "dtype"), [("16", np.int16), ("24", np.int32), ("float", np.float32)])
def test_format_rate_distance_and_scale_are_those_asked_for(
    kind: str, dtype: type, directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "voice.wav"
    options = ["--rate", "16 kHz", "--distance", "1m", "--full-scale", "7.5", "--format", kind]
    assert main(["sound", str(directory), "-o", str(path), *options]) == 0
    said = capsys.readouterr().out
    rate, values = wavfile.read(path)
    assert (rate, values.dtype) == (16000, dtype)
    assert "16000 Hz, full scale 7.5 Pa; sound pressure 1 m from the lips" in said
    assert "up to 7200 Hz" in said


def test_noise_is_added_with_its_level_and_again_with_its_seed(
    directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [tmp_path / f"{name}.wav" for name in ("one", "two", "three")]
    for path, seed in zip(files, ("7", "7", "8"), strict=True):
        assert main(["sound", str(directory), "-o", str(path), "--aspiration", "--seed", seed]) == 0
        said = capsys.readouterr().out
        assert f"with aspiration noise (seed {seed})" in said
        assert re.search(r"aspiration noise (\d+\.?\d* dB \(re 20 uPa\)|silent) over all of it", said)
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.slow
def test_a_killed_run_has_the_sound_of_its_part(
    tmp_path: Path, phonating: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    steps = killed(phonating, tmp_path, 40)
    assert main(["sound", str(tmp_path / "run"), "-o", str(tmp_path / "v.wav")]) == 0
    said = capsys.readouterr()
    assert f"killed; the sound of {steps} of 1200 steps" in said.err
    rate, values = wavfile.read(tmp_path / "v.wav")
    assert values.size == pytest.approx(rate * 5e-5 * steps, abs=4)


def test_an_existing_file_is_kept_unless_asked(
    directory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "voice.wav"
    path.write_text("mine")
    message = refused(["sound", str(directory), "-o", str(path)], capsys)
    assert "would be overwritten; must not exist" in message
    assert path.read_text() == "mine"
    assert main(["sound", str(directory), "-o", str(path), "--overwrite"]) == 0
    assert path.read_bytes()[:4] == b"RIFF"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["-o", "voice.mp3"], "voice.mp3: must have the suffix .wav."),
        (["-o", "voice"], "voice: must have the suffix .wav."),
        (["-o", "none/voice.wav"], "there is no directory none; must be one."),
        (["-o", "dir.wav"], "dir.wav: is a directory; must be a file."),
        (["-o", "v.wav", "--distance", "0"], "--distance = 0 m; must be in [0.01, 100] m."),
        (["-o", "v.wav", "--distance", "-1"], "--distance = -1 m; must be in [0.01, 100] m."),
        (["-o", "v.wav", "--distance", "2 kg"], "--distance = 2 kg; must be a number in m"),
        (["-o", "v.wav", "--distance", "nan"], "--distance = nan; must be"),
        (["-o", "v.wav", "--rate", "100"], "--rate = 100 Hz; must be a whole number from 8000 to 192000 Hz."),
        (["-o", "v.wav", "--rate", "0"], "--rate = 0 Hz; must be"),
        (["-o", "v.wav", "--full-scale", "0"], "--full-scale = 0 Pa; must be > 0 and finite."),
        (["-o", "v.wav", "--full-scale", "-2"], "--full-scale = -2 Pa; must be > 0 and finite."),
        (["-o", "v.wav", "--full-scale", "nan"], "--full-scale = nan; must be finite."),
        (["-o", "v.wav", "--full-scale", "1e-6"], "--full-scale = 1e-06 Pa; must be "),
        (["-o", "v.wav", "--aspiration", "--seed", "-3"], "--seed = -3; must be a whole number >= 0."),
        (["-o", "v.wav", "--seed", "3"], "--seed = 3; must come with --aspiration."),
        (["-o", "v.wav", "--rate", "48 kPa"], "--rate = 48 kPa; must be a number in Hz"),
        (["-o", "v.wav", "--rate", "x"], "--rate = x; must be a number in Hz"),
        (["-o", "v.wav", "--rate", "44.1"], "--rate = 44.1 Hz; must be a whole number"),
        (["-o", "v.wav", "--full-scale", "loud"], "--full-scale = loud; must be a number in Pa"),
    ],
)
def test_a_bad_option_is_one_sentence_and_leaves_no_file(
    options: list[str],
    sentence: str,
    directory: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(directory.parent)
    Path("dir.wav").mkdir()
    assert sentence in refused(["sound", "run", *options], capsys)
    assert sorted(file.name for file in Path.cwd().iterdir()) == ["dir.wav", "run"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--format", "8"], "8; must be one of 16, 24, float"),
        (["--seed", "x"], "x; must be a whole number"),
        (["--volume", "3"], "unrecognized arguments: --volume"),
    ],
)
def test_an_option_that_cannot_be_read_is_refused(
    options: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(["sound", "run", "-o", "v.wav", *options])
    assert end.value.code == 2
    assert sentence in capsys.readouterr().err


def test_what_has_no_sound_is_refused(
    tmp_path: Path, bar: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    plica.run(bar, tmp_path / "bar", progress=False)
    path = str(tmp_path / "v.wav")
    assert "the run has no airflow; must have one" in refused(
        ["sound", str(tmp_path / "bar"), "-o", path], capsys
    )
    assert "there is no such directory" in refused(["sound", str(tmp_path / "no"), "-o", path], capsys)
    assert "there is no run in it" in refused(["sound", str(tmp_path), "-o", path], capsys)
    assert not Path(path).exists()


def test_a_run_of_few_steps_is_refused(
    tmp_path: Path, phonating: plica.Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    text = phonating.text().replace("duration = 0.002", "duration = 0.0005")
    plica.run(plica.Scene.from_text(text), tmp_path / "run", progress=False)
    message = refused(["sound", str(tmp_path / "run"), "-o", str(tmp_path / "v.wav")], capsys)
    assert "the run has 10 steps; must have 16 or more for a sound" in message
