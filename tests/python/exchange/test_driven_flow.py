"""Areas through a scene's air: a run's own areas give its own flow; steady flows in closed form; files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import wavfile

import plica
from complaints import refused
from interrupted_runs import longer
from plica.commands.main import main
from plica.exchange.driven_flow import driven_flow
from plica.exchange.files import Areas, read_areas, write_run
from repository import ROOT

STEP = 5e-5
TUBES: dict[str, Any] = {
    "tract": {"vowel": {"name": "u"}},
    "trachea": {
        "uniform": {"length": 0.15, "area": 2.5e-4},
        "supply": {"pressure": {"reflection": 0.7, "volume": 1e-4}},
    },
}


def driven(run: plica.Run, path: Path) -> dict[str, np.ndarray]:
    write_run(run, path)
    return dict(driven_flow(run.scene, read_areas(path)).waveforms)


def test_without_tubes_a_runs_areas_give_its_flow(phonating: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    assert run["flow"].max() > 1e-5
    found = driven(run, tmp_path / "a.h5")
    assert found["flow"] == pytest.approx(run["flow"], rel=1e-12, abs=1e-18)
    assert set(found) == {"flow", "subglottal_pressure", "supraglottal_pressure", "flow_below", "flow_above"}


def test_between_tubes_a_runs_areas_give_its_flow_but_for_the_beginning(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    """The first step of a run is shorter, and moves: what is left of that decays."""
    run = plica.run(longer(phonating, 10).replace(TUBES), tmp_path / "run", progress=False)
    found = driven(run, tmp_path / "a.h5")
    for name in (
        "flow",
        "flow_above",
        "flow_below",
        "supraglottal_pressure",
        "subglottal_pressure",
        "lip_flow",
    ):
        own, late = np.asarray(run[name]), slice(3 * run.steps // 4, None)
        assert np.ptp(own) > 0
        error = np.abs(found[name] - own) / np.ptp(own)
        assert error[late].max() < 0.01
        assert error[late].max() < 0.3 * error[: run.steps // 10].max()
    bare = driven_flow(phonating, read_areas(tmp_path / "a.h5")).waveforms["flow"]
    assert np.abs(bare - run["flow"]).max() > 0.05 * np.ptp(run["flow"])  # tubes matter


def test_a_constant_area_keeps_the_steady_flow_of_both_resistances(phonating: plica.Scene) -> None:
    time = STEP * np.arange(1, 200)
    areas = Areas(time, np.full(time.size, 5e-6))
    found = driven_flow(phonating.replace(TUBES), areas).waveforms
    for name in ("flow", "lip_flow", "subglottal_pressure", "supraglottal_pressure"):
        assert np.ptp(found[name]) < 1e-8 * abs(found[name][0])
    assert found["lip_flow"][0] == pytest.approx(found["flow"][0], rel=1e-9)
    drop = found["subglottal_pressure"][0] - found["supraglottal_pressure"][0]
    held = phonating.replace({"airflow.subglottal_pressure": float(drop)})
    assert driven_flow(held, areas).waveforms["flow"][0] == pytest.approx(found["flow"][0], rel=1e-9)


def test_a_small_flow_through_a_wide_tract_is_that_without(phonating: plica.Scene) -> None:
    time = STEP * np.arange(1, 300)
    areas = Areas(time, 2e-6 * (1.1 + np.sin(2 * np.pi * 130 * time)))
    wide = {"tract": {"uniform": {"length": 0.05, "area": 0.5}, "wall": "rigid"}}
    bare, tube = (driven_flow(scene, areas).waveforms for scene in (phonating, phonating.replace(wide)))
    assert tube["flow"] == pytest.approx(bare["flow"], rel=1e-3)


def test_the_narrowest_area_is_the_one_that_is_asked_for(phonating: plica.Scene) -> None:
    """Bernoulli: U = A sqrt(2 p / rho) at the narrowest section, where the flow leaves the folds."""
    scene = phonating.replace({"airflow.model": {"bernoulli": {}}})
    time = STEP * np.arange(1, 60)
    area = 4e-6 + 1e-6 * np.sin(2 * np.pi * 200 * time)
    flow = driven_flow(scene, Areas(time, area)).waveforms["flow"]
    assert scene.airflow is not None
    jet = area * np.sqrt(2 * scene.airflow.subglottal_pressure / scene.airflow.air_density)
    assert flow == pytest.approx(jet, rel=0.02)


@pytest.mark.parametrize("tubes", [{}, TUBES], ids=["alone", "between tubes"])
@pytest.mark.parametrize(
    "changes",
    [
        {"airflow.rise": 15e-3},
        {
            "airflow.course": {"time": [2e-3, 18e-3], "pressure": [300.0, 900.0]},
            "airflow.subglottal_pressure": 900.0,
            "airflow.rise": 10e-3,
        },
    ],
    ids=["a rise", "a rise and a course"],
)
def test_a_pressure_that_changes_is_that_of_the_run(
    phonating: plica.Scene, changes: dict[str, Any], tubes: dict[str, Any], tmp_path: Path
) -> None:
    """By the trapezoidal rule, with which a run's flow belongs to the end of its step."""
    scene = longer(phonating, 10).replace({**changes, **tubes, "time.scheme": "newmark"})
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert np.ptp(run["subglottal_pressure"]) > 700
    found = driven(run, tmp_path / "a.h5")
    late = slice(run.steps // 2, None) if tubes else slice(None)
    for name in ("flow", "subglottal_pressure"):
        own = np.asarray(run[name])
        assert found[name][late] == pytest.approx(own[late], abs=(0.003 if tubes else 1e-12) * np.ptp(own))


def test_a_file_is_read_in_any_units(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("# mine\ntime (ms),area (mm^2)\n0,1\n0.1,2\n0.2,3\n")
    found = read_areas(file)
    assert found.time == pytest.approx([0, 1e-4, 2e-4])
    assert found.narrowest == pytest.approx([1e-6, 2e-6, 3e-6])
    assert found.sections is None is found.displaced


def test_the_command_goes_out_and_in(
    phonating: plica.Scene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = phonating.replace(TUBES)
    scene.save("voice.toml")
    run = plica.run(scene, "run", progress=False)
    for name in ("a.csv", "a.h5"):
        assert main(["exchange", "run", "-o", name]) == 0
    with h5py.File("a.h5") as file:
        assert file.attrs["air_density"] == scene.airflow.air_density  # type: ignore[union-attr]
        assert file["section_area"].shape == run["section_area"].shape
        assert file["coronal_left"].attrs["units"] == "m"
        assert all(data.attrs["description"] for data in file.values())
    out = ["exchange", "a.csv", "voice.toml", "-o", "f.csv", "--sound", "v.wav"]
    assert main(out) == 0
    assert "peak flow" in capsys.readouterr().out
    assert Path("f.csv").read_text().splitlines()[3].startswith("time (s),area (m^2),flow (m^3/s)")
    assert wavfile.read("v.wav")[0] == 48000
    assert "f.csv, v.wav would be overwritten" in refused(out, capsys)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["a.csv", "-o", "f.csv"], "a.csv: is given without a scene"),
        (["a.csv", "voice.toml", "-o", "f.txt"], "f.txt: must have the suffix .csv or .h5."),
        (["none.csv", "voice.toml", "-o", "f.csv"], "none.csv"),
        (["uneven.csv", "voice.toml", "-o", "f.csv"], "must be equidistant"),
        (["negative.csv", "voice.toml", "-o", "f.csv"], "areas >= 0"),
        (["short.csv", "voice.toml", "-o", "f.csv"], "3 or more"),
        (["unit.csv", "voice.toml", "-o", "f.csv"], 'the header must have "area (UNIT)"'),
        (["other.h5", "voice.toml", "-o", "f.csv"], "must be of the 40 of the scene"),
        (["a.csv", "bar.toml", "-o", "f.csv"], "has no airflow"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: list[str],
    sentence: str,
    phonating: plica.Scene,
    bar: plica.Scene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    phonating.save("voice.toml")
    bar.save("bar.toml")
    head = "time (s),area (m^2)\n"
    Path("a.csv").write_text(head + "0,1e-6\n1e-4,1e-6\n2e-4,1e-6\n")
    Path("uneven.csv").write_text(head + "0,1e-6\n1e-4,1e-6\n3e-4,1e-6\n")
    Path("negative.csv").write_text(head + "0,1e-6\n1e-4,-1e-6\n2e-4,1e-6\n")
    Path("short.csv").write_text(head + "0,1e-6\n")
    Path("unit.csv").write_text("time (s),area\n0,1\n1,1\n2,1\n")
    with h5py.File("other.h5", "w") as file:
        file["time"], file["section_area"] = STEP * np.arange(4), np.full((4, 7), 1e-6)
    assert sentence in refused(["exchange", *arguments], capsys)
    assert not Path("f.csv").exists()


@pytest.mark.parametrize(
    ("widest", "step", "doubts"),
    [
        (20e-6, 5e-5, []),
        (20e-6, 5e-2, ["50 ms apart"]),
        (20.0, 5e-5, ["2e+07 mm^2"]),
        (20e-12, 5e-5, ["2e-05 mm^2"]),
        (20e-4, 2e-3, ["2000 mm^2", "2 ms apart"]),
    ],
)
def test_areas_and_times_of_no_voice_are_doubted(widest: float, step: float, doubts: list[str]) -> None:
    time = step * np.arange(100)
    found = Areas(time, widest * np.linspace(0, 1, 100)).doubts
    assert len(found) == len(doubts)
    for text, expected in zip(found, doubts, strict=True):
        assert expected in text


def test_the_command_says_what_it_doubts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    areas, scene, out = tmp_path / "areas.csv", tmp_path / "scene.toml", tmp_path / "flow.csv"
    rows = "".join(f"{0.1 * k},{100 + 50 * k}\n" for k in range(10))
    areas.write_text("time (ms),area (cm^2)\n" + rows, encoding="utf-8")
    scene.write_text((ROOT / "examples" / "vowel.toml").read_text(encoding="utf-8"), encoding="utf-8")
    assert main(["exchange", str(areas), str(scene), "-o", str(out)]) == 0
    assert "Caution: The widest of the areas is 5.5e+04 mm^2" in capsys.readouterr().err
