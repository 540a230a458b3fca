"""Every example runs, at small size."""

from __future__ import annotations

import re
import runpy
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.commands.main import main
from plica.identify import load
from repository import EXAMPLES, SCENES, copied_example

TINY: dict[str, Any] = {"around": 8, "levels": [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], "body_rings": 1}
STEPS = 10


def small(path: Path) -> plica.Scene:
    """The scene on a very coarse larynx for a few steps; its parts are those of the file."""
    scene = plica.Scene.load(path)
    mesh: Any = scene.mesh
    differ = isinstance(mesh, plica.Larynx) and mesh.folds is not None and mesh.folds.moved
    if isinstance(mesh, plica.Larynx) and not differ:  # folds that differ are no larynx in levels
        mesh = plica.Larynx(larynx="thesis_coarse", order=mesh.order, options=plica.LarynxOptions(**TINY))
    duration = STEPS * scene.time.step
    output = plica.Output(every=5 * scene.time.step, probes=scene.output.probes)
    time = plica.Stepping(**{**dict(scene.time), "duration": duration})
    return plica.Scene(**{**dict(scene), "mesh": mesh, "time": time, "output": output})


@pytest.mark.parametrize("name", SCENES)
def test_an_example_runs_at_small_size(name: str, tmp_path: Path) -> None:
    scene = small(copied_example(name, tmp_path))
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert run.status == "finished"
    assert run.steps == STEPS
    for waveform, values in run.items():
        finite = scene.airflow is not None or waveform != "coupling_residual"
        assert np.isfinite(values).all() == finite, waveform
    assert np.abs(np.asarray(run.displacement)).max() > 0
    assert ("flow" in run) == (scene.airflow is not None)
    assert ("contact_rows" in run) == (scene.contact is not None)


def test_the_thesis_is_as_printed_and_the_demo_is_corrected() -> None:
    thesis, half, normal = (
        plica.Scene.load(EXAMPLES / name)
        for name in ("thesis.toml", "thesis_b.toml", "normal_phonation.toml")
    )
    for layer, tissue in thesis.tissue.items():
        assert tissue.mu_transverse == pytest.approx(tissue.E / (1 + tissue.nu), rel=1e-12)
        assert half.tissue[layer].viscosity == pytest.approx(0.5 * tissue.viscosity, rel=1e-12)
        assert normal.tissue[layer].viscosity == pytest.approx(0.35 * tissue.viscosity, rel=1e-12)
        assert normal.tissue[layer].mu_transverse is None
        for field in ("E", "nu", "E_fibre", "nu_fibre", "mu_fibre", "density"):
            assert getattr(normal.tissue[layer], field) == getattr(tissue, field)
    assert normal.mesh.order == 2


def test_the_tension_mismatch_is_forty_percent() -> None:
    cover = plica.Scene.load(EXAMPLES / "tension_asymmetry.toml").tissue["cover"]
    left, right = cover.on("left").E_fibre, cover.on("right").E_fibre
    assert left is not None
    assert right is not None
    assert 100 * (right - left) / right == pytest.approx(40.0)


def test_the_tension_mismatch_is_all_that_differs_from_the_demo() -> None:
    normal, tense = (
        plica.Scene.load(EXAMPLES / name).resolved()
        for name in ("normal_phonation.toml", "tension_asymmetry.toml")
    )
    del tense["tissue"]["cover"]["right"]
    assert normal.pop("symmetry") == "quarter"  # which the mismatch has not
    assert "symmetry" not in tense
    for scene in (normal, tense):  # a beat of the two folds takes longer to show
        del scene["time"]["duration"], scene["output"]["start"]
    assert tense == normal


@pytest.mark.slow
def test_the_identification_goes_as_its_comment_says_and_comes_near_the_truth(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a film of half the resolution, with one start."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    monkeypatch.chdir(tmp_path / "examples")
    typed = re.findall(r"^# (plica|sed) (.*)$", Path("identify.toml").read_text(), re.MULTILINE)
    assert [program for program, _ in typed] == ["plica", "plica", "sed", "plica"]
    smaller = {"film": ["--mm-per-px", "0.12", "--size", "96,136"], "identify": ["--starts", "1"]}
    for program, rest in typed:
        if program == "sed":
            subprocess.run(f"sed {rest}", shell=True, check=True)
            continue
        command, *arguments = shlex.split(rest)
        assert main([command, *arguments, *smaller.get(command, []), "--quiet"]) == 0
    found = load("runs/tissue").posterior
    assert found.answered
    tissue = plica.Scene.load("free_vibration.toml").tissue
    truth = (tissue["body"].mu_fibre, tissue["cover"].mu_fibre, tissue["body"].viscosity)
    assert found.names == ("body.mu_fibre", "cover.mu_fibre", "viscosity")
    # of the cover 15 % here, its motion being a few pixels'; 1 % from the film as it is typed
    assert np.abs(found.median / truth - 1).max() < 0.2
    assert (np.abs(np.exp(found.prior_mean) / truth - 1) > 0.3).all()  # where it began


@pytest.mark.slow
def test_the_synthetic_recording_is_found_as_it_was_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["recording.py", str(tmp_path), "90"])
    runpy.run_path(str(EXAMPLES / "recording.py"), run_name="__main__")
    message = capsys.readouterr().out
    numbers = re.findall(r"^(\w+) +found +(\S+) \S+ +true +(\S+)$", message, flags=re.MULTILINE)
    found = {name: (float(one), float(other)) for name, one, other in numbers}
    assert found["fundamental_frequency"][0] == pytest.approx(found["fundamental_frequency"][1], abs=2)
    assert found["left_right_phase"][0] == pytest.approx(found["left_right_phase"][1], abs=0.1)
    # Slits under two pixels wide are partly lost: more of a small glottis than of a large one.
    assert found["glottal_area_mean"][0] == pytest.approx(found["glottal_area_mean"][1], rel=0.03)
    assert "mode 1" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_recording_too_short_to_measure_has_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    example = runpy.run_path(str(EXAMPLES / "recording.py"))
    analyse = example["video"].analyse

    def glottis_alone(*given: Any) -> Any:  # of the steps, what the measures need
        return analyse(*given, until="glottis", progress=False)

    monkeypatch.setattr(example["video"], "analyse", glottis_alone)
    example["main"](tmp_path, 12)
    message = capsys.readouterr().out
    assert re.search(r"^fundamental_frequency +not found: too short", message, flags=re.MULTILINE)
    assert re.search(r"^glottal_area_mean +(found|not found)", message, flags=re.MULTILINE)
    assert "report: " in message


@pytest.mark.slow
def test_notes_rise_with_the_activation_of_the_cricothyroid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of short notes; the highest by the posture's own rule 36 % longer."""
    example = runpy.run_path(str(EXAMPLES / "octave.py"))
    voice = example["voice"]
    monkeypatch.setitem(
        example["main"].__globals__, "voice", lambda a: voice(a).replace({"time.duration": "0.08 s"})
    )
    with pytest.warns(plica.CautionWarning):
        example["main"](tmp_path, 2)
    low, high = re.findall(r"longer: (\d+) Hz", capsys.readouterr().out)
    assert int(high) > 1.8 * int(low)
    assert (tmp_path / "octave.wav").stat().st_size == pytest.approx(2 * 2 * 0.08 * 44100, rel=0.01)
