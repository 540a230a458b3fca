"""Sound and electroglottogram beside a filmed voice: on its time, in all files, and what is refused."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import openpyxl
import pytest
from scipy.io import loadmat, wavfile

from plica.commands.main import main
from plica.measures.catalogue import names
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import Settings, VideoError, analyse, chain, compare, load
from plica.video.analysis import Analysis
from plica.video.light import light_of
from plica.video.matlab import write_matlab
from plica.video.praat import write_praat
from plica.video.report.page import write_report
from plica.video.tables import write_tables
from plica.video.workbook import write_workbook
from recorded_signals import Contact, times, vowel

_FPS, _F, _RATE, _START = 4000.0, 200.0, 44100, 0.05
_STACK = SyntheticGlottis(
    Synthetic(height=112, width=96, frames=110, frequency=_F / _FPS, amplitude=(8, 8), opening=(3, 3))
).stack()
_CLOSES = (np.pi + np.arcsin(3 / 8)) / (2 * np.pi)  # of the cycle: where the folds of the film touch
_CONTACT = Contact()


def _recorded(
    start: float = _START, rate: int = _RATE, frequency: float = _F, lag: float = 0.0
) -> np.ndarray:
    """(n, 3) sound, electroglottogram and pulse of a file; its time `start` (s) is the first frame's."""
    time = times(rate, 0.15) - start
    pulse = (time >= 0) & (time < 1e-3)
    egg = _CONTACT.at(frequency * (time - lag) - _CLOSES + _CONTACT.closing)
    return np.stack([0.8 * vowel(frequency * time, frequency), 0.9 * egg - 0.4, 0.7 * pulse], axis=1)


def _written(path: Path, values: np.ndarray, rate: int = _RATE) -> Path:
    wavfile.write(path, rate, values.astype(np.float32))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("signals")
    np.save(where / "film.npy", _STACK)
    _written(where / "voice.wav", _recorded())
    return where


def _settings(folder: Path, **changed: Any) -> Settings:
    voice = folder / "voice.wav"
    given = {"audio": f"{voice}:1", "egg": f"{voice}:2", "sound_start": (_START,), "fps": _FPS}
    return Settings(correct_drift=False, **(given | changed))


@pytest.fixture(scope="module")
def found(folder: Path) -> Analysis:
    done = analyse(folder / "film.npy", folder / "found", _settings(folder), until="glottis", progress=False)
    for write in (write_tables, write_workbook, write_matlab, write_praat, write_report):
        write(done)
    return done


@pytest.fixture(scope="module")
def bare(folder: Path) -> Analysis:
    settings = Settings(fps=_FPS, correct_drift=False)
    done = analyse(folder / "film.npy", folder / "bare", settings, until="glottis", progress=False)
    write_tables(done)
    return done


@pytest.fixture
def copied(
    bare: Analysis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, few_draws: None
) -> Callable[..., Analysis]:
    """The film analysed before, and signals given, where nothing is looked for in pictures again."""
    shutil.copytree(bare.directory, tmp_path / "copy")
    monkeypatch.delattr(chain, "learn")

    def again(settings: Settings) -> Analysis:
        return analyse(bare.source, tmp_path / "copy", settings, until="glottis", progress=False)

    return again


def test_measures_are_those_of_the_closed_forms(found: Analysis) -> None:
    item = found.measures
    assert item["sound_frequency"].value == pytest.approx(_F, rel=1e-3)
    assert item["egg_frequency"].value == pytest.approx(_F, rel=1e-4)
    assert item["egg_contact_quotient_level"].value == pytest.approx(_CONTACT.by_level, abs=1e-4)
    assert item["egg_contact_quotient_peaks"].value == pytest.approx(_CONTACT.by_peaks, abs=5e-4)
    assert item["sound_frequency_difference"].value == pytest.approx(0.0, abs=1e-3)
    # The folds touch at the peak, and the area has 5 % of its largest up to a frame before.
    assert 0 <= item["egg_closing_lag"].value < 1 / _FPS
    assert item["egg_closing_lag"].spread < 0.1 / _FPS
    assert found.signals.doubts == []
    assert light_of(found).shown == "green"
    assert set(names(recorded_from="signal")) <= set(item)


def test_without_signals_nothing_is_otherwise(found: Analysis, bare: Analysis) -> None:
    of_signals = names(recorded_from="signal")
    assert not of_signals & set(bare.measures)
    for name, item in bare.measures.items():
        assert found.measures[name] == item
    assert not (bare.directory / "signals.csv").exists()
    assert "signals" not in bare
    assert bare.signals.parts == {}
    assert "audio" not in json.loads((bare.directory / "light.json").read_text())["recording"]


def test_the_stored_part_is_that_of_the_frames(found: Analysis) -> None:
    for k, name in enumerate(("audio", "egg")):
        part = found.signals.parts[name]
        inside = np.flatnonzero(np.abs(times(_RATE, 0.15) - _START - 109 / 2 / _FPS) < 55 / _FPS)
        assert part.values == pytest.approx(_recorded()[inside, k], abs=1e-6)
        assert part.time == pytest.approx(times(_RATE, 0.15)[inside] - _START)


@pytest.mark.slow
@pytest.mark.parametrize("first", [7])
@pytest.mark.usefixtures("few_draws")
def test_a_part_of_the_film_has_its_part_of_the_signal(first: int, folder: Path, tmp_path: Path) -> None:
    settings = _settings(folder, first=first)
    done = analyse(folder / "film.npy", tmp_path / "a", settings, until="glottis", progress=False)
    part = done.signals.parts["egg"]
    truth = _CONTACT.at(_F * (part.time + first / _FPS) - _CLOSES + _CONTACT.closing)
    assert part.values == pytest.approx(0.9 * truth - 0.4, abs=1e-6)
    assert 0 <= done.measures["egg_closing_lag"].value < 1 / _FPS


@pytest.mark.slow
@pytest.mark.parametrize(
    ("start", "told"),
    [
        (0.0, "first frame at 0 s of it"),
        (0.02, "first frame at 0.02 s of it"),
        (-0.004, "first frame at -0.004 s of it; it covers 0.004 to 0.0275 s of the 0.0275 s analysed"),
        (0.135, "first frame at 0.135 s of it; it covers 0 to 0.015 s of the 0.0275 s analysed"),
    ],
)
def test_a_signal_may_begin_before_the_film_or_after_it(
    start: float, told: str, copied: Callable[..., Analysis], tmp_path: Path
) -> None:
    egg = _written(tmp_path / "egg.wav", _recorded(start)[:, 1])
    done = copied(Settings(egg=str(egg), sound_start=(start,), fps=_FPS, correct_drift=False))
    assert done.signals.said == [f"electroglottogram: egg.wav, channel 1, 44100 samples/s, {told}"]
    lag = done.measures["egg_closing_lag"]
    assert lag.value is None if start == 0.135 else 0 <= lag.value < 1 / _FPS


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_start_that_is_not_told_is_assumed_and_said(
    copied: Callable[..., Analysis], tmp_path: Path
) -> None:
    voice = _written(tmp_path / "voice.wav", _recorded(0.0)[:, 0])
    done = copied(Settings(audio=str(voice), correct_drift=False))
    assert "first frame at 0 s of it (assumed: --sound-start)" in done.signals.said[0]
    assert "(assumed: --sound-start)" in write_report(done).read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("after", [None, 0.004])
def test_a_pulse_tells_the_first_frame(
    after: float | None, copied: Callable[..., Analysis], tmp_path: Path
) -> None:
    values = _recorded()
    values[:, 2] = np.roll(values[:, 2], -round((after or 0.0) * _RATE))
    voice = _written(tmp_path / "voice.wav", values)
    start = None if after is None else (after,)
    done = copied(Settings(egg=f"{voice}:2", sync=3, sound_start=start, correct_drift=False))
    assert 0 <= done.measures["egg_closing_lag"].value < 1 / _FPS
    assert "the pulse of channel 3" in done.signals.said[0]
    assert done.signals.parts["egg"].begin == pytest.approx(-0.5 / _FPS, abs=2 / _RATE)


@pytest.mark.slow
def test_two_files_have_two_starts_and_rates(copied: Callable[..., Analysis], tmp_path: Path) -> None:
    audio = _written(tmp_path / "audio.wav", _recorded(0.03, 16000)[:, 0], 16000)
    egg = _written(tmp_path / "egg.wav", _recorded(0.08, 96000)[:, 1], 96000)
    done = copied(Settings(audio=str(audio), egg=str(egg), sound_start=(0.03, 0.08), correct_drift=False))
    assert 0 <= done.measures["egg_closing_lag"].value < 1 / _FPS
    write_tables(done)
    with (done.directory / "signals.csv").open(newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert list(rows[0]) == ["audio_time (s)", "audio", "egg_time (s)", "egg", "light"]
    for name in ("audio", "egg"):
        part = done.signals.parts[name]
        read = [(float(row[f"{name}_time (s)"]), float(row[name])) for row in rows if row[name] != ""]
        assert np.array_equal(np.array(read).T, [part.time, part.values])


def test_all_files_have_the_signals(found: Analysis) -> None:
    parts, where = found.signals.parts, found.directory
    with (where / "signals.csv").open(newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert {row["light"] for row in rows} == {"green"}
    sheet = list(openpyxl.load_workbook(where / "recording.xlsx")["Signals"].values)
    assert sheet[0] == ("time (s)", "audio", "egg")
    matlab = loadmat(where / "recording.mat", simplify_cells=True)
    assert matlab["signals"]["units"]["time"] == "s"
    assert np.isnan(matlab["measures"]["egg_closing_lag"]["interval"]).all()
    assert matlab["settings"]["sound_start"] == _START
    for name, values in (
        ("time (s)", parts["audio"].time),
        *((name, part.values) for name, part in parts.items()),
    ):
        assert np.array_equal([float(row[name]) for row in rows], values)
        assert np.array_equal(matlab["signals"][name.removesuffix(" (s)")], values)
        column = [row[sheet[0].index(name)] for row in sheet[1:]]
        assert column == pytest.approx(values, rel=1e-14)
    told = json.loads((where / "light.json").read_text())["recording"]
    assert (told["audio"], told["egg"]) == ("voice.wav:1", "voice.wav:2")


def test_praat_shows_signals_and_area_on_one_time(found: Analysis) -> None:
    """A sample stands in the middle of its time: frame k at (k + 1/2) / fps."""
    _, area = wavfile.read(found.directory / "area.wav")
    for k, name in enumerate(("audio", "egg")):
        rate, values = wavfile.read(found.directory / f"{name}.wav")
        assert rate == _RATE
        assert values.size / rate == pytest.approx(area.size / _FPS, abs=0.5 / rate)
        shown = (np.arange(values.size) + 0.5) / rate - 0.5 / _FPS
        truth = np.interp(shown, times(_RATE, 0.15) - _START, _recorded()[:, k])
        steepest = np.abs(np.gradient(truth)).max()
        assert np.abs(values - truth).max() <= 0.6 * steepest  # half a sample


def test_the_page_shows_both_figures_and_says_what_was_given(found: Analysis) -> None:
    page = (found.directory / "report.html").read_text(encoding="utf-8")
    assert "<h2>Sound and electroglottogram</h2>" in page
    assert page.count('aria-label="Glottal area beside sound and electroglottogram') == 2
    assert "dEGG (1/s)" in page
    assert "sound: voice.wav, channel 1, 44100 samples/s, first frame at 0.05 s of it" in page
    assert f"--audio={found.directory.parent}/voice.wav:1" in page
    assert "--sound-start=0.05" in page


@pytest.mark.slow
def test_settings_stay_and_change_without_the_pictures(
    copied: Callable[..., Analysis], found: Analysis, folder: Path
) -> None:
    given = copied(_settings(folder))
    assert given.measures["egg_closing_lag"] == found.measures["egg_closing_lag"]
    kept = copied(Settings(correct_drift=False, label="again"))
    assert kept.settings.egg == given.settings.egg
    assert kept.measures["egg_closing_lag"] == given.measures["egg_closing_lag"]
    later = copied(Settings(correct_drift=False, sound_start=(_START + 0.5e-3,)))
    moved = given.measures["egg_closing_lag"].value - 0.5e-3
    assert later.measures["egg_closing_lag"].value == pytest.approx(moved, abs=1e-5)
    write_tables(later)
    write_praat(later)
    none = copied(Settings(correct_drift=False, audio="none", egg="none"))
    write_tables(none)
    write_praat(none)
    assert none.signals.parts == {}
    assert none.settings.sound_start is None  # nothing is left for a signal that is given later
    assert none.settings.sync is None
    assert not any((none.directory / name).exists() for name in ("signals.csv", "audio.wav", "egg.wav"))
    assert "signals" not in none
    write_tables(found)


@pytest.mark.slow
def test_a_file_is_needed_until_it_is_stored_and_read_again_where_it_changed(
    copied: Callable[..., Analysis], tmp_path: Path
) -> None:
    egg = _written(tmp_path / "egg.wav", _recorded()[:, 1])
    settings = Settings(egg=str(egg), sound_start=(_START,), correct_drift=False)
    before = copied(settings).measures["egg_closing_lag"].value
    _written(egg, _recorded(lag=0.3e-3)[:, 1])
    assert copied(settings).measures["egg_closing_lag"].value == pytest.approx(before + 0.3e-3, abs=1e-5)
    egg.unlink()
    assert copied(settings).measures["egg_closing_lag"].value == pytest.approx(before + 0.3e-3, abs=1e-5)
    with pytest.raises(VideoError, match=r"egg\.wav cannot be read: No such file"):
        copied(replace(settings, sound_start=(0.02,)))
    assert load(tmp_path / "copy").settings.sound_start == (_START,)  # nothing was lost by it
    with pytest.raises(VideoError, match=r"egg\.wav cannot be read: No such file"):
        copied(replace(settings, fps=2000.0))  # the part of another time


@pytest.mark.slow
def test_an_analysis_stopped_before_its_signals_goes_on(
    copied: Callable[..., Analysis], folder: Path
) -> None:
    where = copied(_settings(folder)).path
    with h5py.File(where, "a") as file:
        del file["signals"]
    with pytest.raises(VideoError, match=r"its sound is not stored yet\. Start it again: it goes on"):
        _ = load(where.parent).signals
    assert copied(_settings(folder)).measures["egg_closing_lag"].value is not None


@pytest.mark.slow
def test_a_wrong_frame_rate_makes_the_light_amber_and_is_at_each_time(
    copied: Callable[..., Analysis], folder: Path
) -> None:
    done = copied(_settings(folder, fps=1.06 * _FPS))
    light = light_of(done)
    assert light.shown == "amber"
    assert (
        "The electroglottogram has 200 Hz, the glottal area 212 Hz over the same time, 5.7 % more"
        in light.said
    )
    for name, cautioned in (("fundamental_frequency", True), ("period", True), ("open_quotient", False)):
        assert any("frame rate may be wrong" in text for text in done.measures[name].cautions) == cautioned


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_two_recordings_with_signals_are_compared(found: Analysis, bare: Analysis) -> None:
    both = {change.name: change for change in compare(found.directory, found.directory).changes}
    assert both["egg_contact_quotient_level"].difference == 0
    assert "egg_frequency" not in {change.name for change in compare(found.directory, bare.directory).changes}


def _named(**given: Any) -> Callable[[Path], Settings]:
    return lambda folder: _settings(folder, **given)


def _made(values: np.ndarray, rate: int = _RATE, **given: Any) -> Callable[[Path], Settings]:
    def settings(folder: Path) -> Settings:
        path = _written(folder / f"made{abs(hash(values.tobytes()))}.wav", values, rate)
        return Settings(**({"egg": str(path), "fps": _FPS, "correct_drift": False} | given))

    return settings


_SHORT = _recorded()[:, 1]
_REFUSED: dict[str, tuple[Callable[[Path], Settings], str]] = {
    "no file": (
        _named(audio="/nowhere/voice.wav"),
        r"Signals: /nowhere/voice\.wav cannot be read: No such file",
    ),
    "empty name": (_named(audio=""), r'Signals: "" is no file'),
    "no text": (_named(egg=3), r"Video: egg = 3; must be FILE\.wav"),
    "a film": (
        lambda folder: _settings(folder, egg=str(folder / "film.npy")),
        r"film\.npy cannot be read: .*WAV",
    ),
    "channel out of range": (
        lambda f: _settings(f, egg=f"{f / 'voice.wav'}:9"),
        r"channel 9 of .*must be 1 to 3",
    ),
    "channel 0": (lambda f: _settings(f, egg=f"{f / 'voice.wav'}:0"), r"channel 0 of .*must be 1 or more"),
    "no frame rate": (_named(fps=None), r"Signals: fps is unknown; must be given with a signal .*--fps"),
    "start after the end": (
        _named(sound_start=(0.4,)),
        r"voice\.wav, channel 1 has 0 samples in the time of the frames",
    ),
    "end before the first frame": (
        _named(sound_start=(-2.0,)),
        r"has 0 samples .*, -2 to -1\.972 s of its 0\.15 s",
    ),
    "start is no number": (
        _named(sound_start=(float("nan"),)),
        r"sound_start = nan s; must be one finite time, or two",
    ),
    "three starts": (
        _named(sound_start=(0, 1, 2)),
        r"sound_start = 0,1,2 s; must be one finite time, or two",
    ),
    "start in words": (_named(sound_start="soon"), r"sound_start = 'soon'; must be numbers"),
    "no pulse": (
        _made(np.stack([_SHORT, 0 * _SHORT], 1), sync=2),
        r"channel 2: none; must be one, at the first frame",
    ),
    "many pulses": (_named(sync=2), r"pulses of voice\.wav, channel 2: \d+; must be one"),
    "pulse out of range": (_named(sync=4), r"channel 4 of .*voice\.wav; must be 1 to 3"),
    "pulse without a signal": (
        _named(audio=None, egg=None, sound_start=None, sync=1),
        r"Signals: --sync = 1 without a signal; must be given with one \(--audio, --egg\)",
    ),
    "start without a signal": (
        _named(audio=None, egg=None, sound_start=(0.1, 0.2)),
        r"Signals: --sound-start = 0\.1,0\.2 without a signal; must be given with one",
    ),
    "pulse 0": (_named(sync=0), r"sync = 0; must be a channel's number, 1 or more"),
    "not a number": (
        _made(np.where(np.arange(_SHORT.size) == 99, np.nan, _SHORT)),
        r"has 1 samples that are no finite",
    ),
    "infinite": (
        _made(np.where(np.arange(_SHORT.size) > 99, np.inf, _SHORT)),
        r"samples that are no finite numbers",
    ),
    "zero": (_made(0 * _SHORT), r"channel 1 is 0 throughout the time of the frames; must vary"),
    "constant": (
        _made(0 * _SHORT + 0.25),
        r"channel 1 is 0\.25 throughout the time of the frames; must vary",
    ),
    "seven samples": (_made(_SHORT[:7]), r"has 7 samples in the time of the frames, .*must have 8 or more"),
    "slow": (_made(_SHORT, rate=400), r"has 400 samples/s; must have 1000 to 1e\+06"),
}


@pytest.mark.parametrize("kind", _REFUSED)
def test_a_signal_that_cannot_be_used_is_one_sentence_and_costs_nothing(
    kind: str, bare: Analysis, folder: Path, tmp_path: Path
) -> None:
    make, text = _REFUSED[kind]
    where = bare.directory if kind != "no frame rate" else tmp_path / "new"
    before = bare.path.read_bytes()
    with pytest.raises(VideoError, match=text) as error:
        analyse(bare.source, where, make(folder), until="glottis", progress=False)
    assert "\n" not in str(error.value)
    assert bare.path.read_bytes() == before


_WEAK: dict[str, tuple[np.ndarray, int, str]] = {
    "two cycles": (_recorded(0.0)[: int(0.011 * _RATE), 1], _RATE, "at least 3 are needed"),
    "noise": (np.random.default_rng(2).standard_normal(6000), _RATE, ""),
    "upside down": (-_recorded(0.0)[:, 1], _RATE, "seems upside down"),
    "clipped": (np.clip(3 * _recorded(0.0)[:, 1], -1, 1), _RATE, "samples are clipped"),
    "twice as fast": (_recorded(0.0, frequency=2 * _F)[:, 1], _RATE, "has 400 Hz, the glottal area 200 Hz"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", _WEAK)
@pytest.mark.usefixtures("unrendered")
def test_a_signal_that_says_little_is_measured_and_cautioned(
    kind: str, copied: Callable[..., Analysis], tmp_path: Path
) -> None:
    values, rate, text = _WEAK[kind]
    egg = _written(tmp_path / "egg.wav", values, rate)
    done = copied(Settings(egg=str(egg), sound_start=(0.0,), correct_drift=False))
    item = done.measures["egg_contact_quotient_peaks"]
    said = " ".join([item.note, *item.cautions, *done.signals.doubts])
    assert text in said
    assert item.value is None or item.cautions or done.signals.doubts
    write_tables(done)
    write_report(done)


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_the_command_takes_signals_for_one_recording(
    found: Analysis, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(found.directory, tmp_path / "a")
    film, voice = str(folder / "film.npy"), str(folder / "voice.wav")
    command = ["glottis", film, "--no-drift", "-o", str(tmp_path / "a"), "--audio", f"{voice}:1"]
    assert main([*command, "--egg", f"{voice}:2", "--sound-start", "0.05", "--praat"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"egg_contact_quotient_level +0\.464", said)
    assert main([*command, "--sound-start", "-0.01,0.05", "--quiet"]) == 0
    assert load(tmp_path / "a").settings.sound_start == (-0.01, 0.05)
    assert main(["glottis", film, film, "-o", str(tmp_path / "b"), "--egg", voice]) == 2
    error = capsys.readouterr().err
    assert error.endswith("for 2 recordings; must be for one. Give the recording that it belongs to alone.\n")
    assert not (tmp_path / "b").exists()
