"""The command: what it prints, writes and returns."""

from __future__ import annotations

import html
import json
import os
import re
from pathlib import Path

import meshio
import numpy as np
import pytest

import plica
from analytic_run import AnalyticMesh, AnalyticRun
from plica.commands.main import main
from plica.measures.run.cautions import cautions


@pytest.fixture
def scene_file(bar: plica.Scene, tmp_path: Path) -> Path:
    bar.save(tmp_path / "scene.toml")
    return tmp_path / "scene.toml"


def test_a_part_of_the_scene_can_be_left_out(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bar.replace({"gravity": (0, 0, -9.81), "output": {"every": bar.time.step}}).save(tmp_path / "s.toml")
    command = ["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"]
    assert main([*command, "--without", "gravity", "--without", "output.every"]) == 0
    scene = plica.Run.load(tmp_path / "run").scene
    assert scene.gravity is None
    assert scene.output.every is None
    assert main([*command, "--without", "gravty"]) == 2
    assert 'gravty is not known. Did you mean "gravity"?' in capsys.readouterr().err


@pytest.mark.slow
def test_run_ends_with_measures_and_a_report(
    scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(scene_file), "-o", str(tmp_path / "run")]) == 0
    message = capsys.readouterr()
    assert "report.html" in message.out
    assert "100%" in message.err
    names = {path.name for path in (tmp_path / "run").iterdir()}
    made = {"scene.toml", "results.h5", "fields.xdmf", "waveforms.csv", "measures.json", "report.html"}
    assert made <= names
    measures = json.loads((tmp_path / "run" / "measures.json").read_text())
    assert measures["steps"]["value"] == 40
    for entry in measures.values():
        assert {"value", "unit", "spread", "cycles"} <= set(entry)
    assert plica.Run.load(tmp_path / "run").measures.as_json() == measures


@pytest.mark.slow
def test_quiet_is_quiet(scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scene_file), "-o", str(tmp_path / "run"), "--quiet", "--threads", "1"]) == 0
    message = capsys.readouterr()
    assert message.out == message.err == ""


@pytest.mark.parametrize(
    ("available", "options", "taken"), [(3, [], 3), (64, [], 8), (3, ["--threads", "5"], 5)]
)
def test_a_run_takes_the_processors_there_are(
    scene_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    available: int,
    options: list[str],
    taken: int,
) -> None:
    found: list[int] = []
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(available)))
    monkeypatch.setattr(plica, "set_threads", found.append)
    (tmp_path / "file").write_text("")
    # refused after the threads are set
    assert main(["run", str(scene_file), "-o", str(tmp_path / "file"), *options]) == 2
    assert found == [taken]


def test_mesh_prints_what_there_is(scene_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mesh", str(scene_file)]) == 0
    message = capsys.readouterr().out
    assert (
        "24 linear tetrahedra, 20 nodes, 60 displacement components before supports, 10 x 2 x 2 mm" in message
    )
    assert "40.00 mm^3" in message
    assert "x_min" in message


@pytest.mark.parametrize("suffix", ["vtu", "msh", "vtk"])
@pytest.mark.parametrize("order", [1, 2])
def test_mesh_writes_what_meshio_reads(
    scene_file: Path, tmp_path: Path, suffix: str, order: int, capsys: pytest.CaptureFixture[str]
) -> None:
    scene_file.write_text(scene_file.read_text().replace("order = 1", f"order = {order}"))
    path = tmp_path / f"mesh.{suffix}"
    assert main(["mesh", str(scene_file), "-o", str(path)]) == 0
    built = plica.build_mesh(plica.Scene.load(scene_file).mesh)
    read = meshio.read(path)
    np.testing.assert_allclose(read.points, built.points, atol=1e-15)
    assert np.array_equal(read.cells[0].data, built.cells)
    assert "without surfaces, node sets and names of layers" in capsys.readouterr().out


def test_the_version_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"plica {plica.__version__}\n"


def test_info_names_the_licence_and_the_versions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info"]) == 0
    message = capsys.readouterr().out
    gpl = plica.build_info()["gpl"]
    assert ("GPL-3.0-or-later" if gpl else "BSD-3-Clause") in message
    assert plica.__version__ in message
    assert "numpy" in message


def test_info_names_the_licences_of_what_is_contained_and_imported(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["info", "--licences"]) == 0
    parts = capsys.readouterr().out.split("\n\n")[1:]
    titles = [part.partition("\n")[0] for part in parts]
    assert titles[:3] == [
        "Compiled into the engine",
        "In the pages of plica view",
        "Imported by every installation",
    ]
    rows = {
        title: dict(row.split(maxsplit=1) for row in part.splitlines()[1:])
        for title, part in zip(titles, parts, strict=True)
    }
    always = rows["Imported by every installation"]
    assert "MPL-2.0" in parts[0]
    assert rows["In the pages of plica view"] == {"three.js": "MIT", "uPlot": "MIT"}
    assert always["numpy"].startswith("BSD-3-Clause")
    assert {"contourpy", "pydantic-core"} <= {*always}  # of matplotlib, pydantic
    assert not {"av", "meshio", "tifffile", "xarray", "pytest"} & {*always}
    assert [name for name, licence in always.items() if re.search(r"\bA?GPL|not stated", licence)] == []
    assert "libx264" in rows["For plica[video]"]["av"]
    assert {"pandas", "dask", "xarray"} <= {*rows["For plica[sweep]"]}  # the first that asks for them


@pytest.mark.parametrize("command", [[], ["run"], ["mesh"], ["info"], ["report"], ["measures"]])
def test_help_teaches(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([*command, "--help"])
    assert stop.value.code == 0
    message = capsys.readouterr().out
    if command in ([], ["run"], ["mesh"]):
        examples = message.partition("A first session:" if not command else "examples:")[2]
        assert "plica " + " ".join(command) in examples


@pytest.mark.slow
def test_a_finished_run_counts_its_steps_in_doubt(
    phonating: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = phonating.text().replace("max_sweeps = 40", "max_sweeps = 2")
    (tmp_path / "s.toml").write_text(text.replace("freeze_after = 8", "freeze_after = 1"))
    assert main(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"]) == 0
    count = int((plica.Run.load(tmp_path / "run")["coupling_converged"] == 0).sum())
    assert count > 0
    message = capsys.readouterr().err
    assert re.search(rf"^plica: Caution: In {count} of 40 steps, .* did not converge", message, re.MULTILINE)
    stored = json.loads((tmp_path / "run" / "cautions.json").read_text(encoding="utf-8"))
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "unconverged_coupling" in {caution["name"] for caution in stored}
    for caution in stored:
        sentence = f"{caution['seen']} {caution['advice']}"
        assert f"plica: Caution: {sentence}\n" in message
        assert re.search(rf"Caution \d+: {re.escape(sentence)}", html.unescape(page))
    assert main(["measures", str(tmp_path / "run")]) == 0
    assert capsys.readouterr().err == message
    assert main(["measures", str(tmp_path / "run"), "--to", "1 ms"]) == 0
    first = int((plica.Run.load(tmp_path / "run")["coupling_converged"][:20] == 0).sum())
    assert f"In {first} of 20 steps, first at" in capsys.readouterr().err


@pytest.mark.slow
def test_a_run_says_where_augmentations_ran_out(phonating: plica.Scene, tmp_path: Path) -> None:
    few = plica.Contact(augmented=plica.Augmented(stiffness=0.1, max_augmentations=2))
    thrown = {"contact": few, "airflow": None, "initial": plica.Initial(opening_velocity=-3.0)}
    run = plica.run(phonating.replace(thrown), tmp_path / "run", progress=False)
    short = run["contact_converged"] == 0
    assert 0 < short.sum() < short.size
    tolerance = run["contact_gap_error"][~short].max()
    assert (run["contact_gap_error"][short] > tolerance).all()
    touching = short | (run["contact_rows"] > 0)
    sentence = f"In {short.sum()} of {touching.sum()} steps with contact it did not converge to its tolerance"
    assert any(sentence in str(caution) for caution in run.cautions)


def doubts(waveforms: dict[str, np.ndarray], scene_text: str = "") -> str:
    """Cautions of a run with these waveforms only."""
    steps = len(next(iter(waveforms.values())))
    mesh = AnalyticMesh(np.zeros((1, 3)), {})
    run = AnalyticRun(np.arange(1.0, steps + 1), waveforms, mesh, scene_text=scene_text)
    return " ".join(map(str, cautions(run)))


def unsettled(first: int) -> dict[str, np.ndarray]:
    """400 steps, the first 200 of them with contact, of these so many left at 40 nm."""
    step = np.arange(400)
    left = step < first
    return {
        "contact_rows": np.where(step < 200, 5, 0),
        "contact_converged": np.where(left, 0, 1),
        "contact_gap_error": np.where(left, 40e-9, 1e-9),
    }


@pytest.mark.parametrize("method", ["multipliers", "penalty", "nitsche", "volume_penalty"])
def test_passes_left_unsettled_are_reported_above_a_hundredth_of_the_steps_with_contact(method: str) -> None:
    text = f"[contact.{method}]\n"
    assert doubts(unsettled(0), text) == doubts(unsettled(2), text) == ""
    message = doubts(unsettled(3), text)
    assert "In 3 of 200 steps with contact" in message
    assert "up to 4e-05 mm" in message
    assert "augment" not in message


def test_augmentations_that_ran_out_are_reported_for_a_single_step() -> None:
    text = "[contact.augmented]\n"
    assert doubts(unsettled(0), text) == ""
    assert "In 1 of 200 steps with contact" in doubts(unsettled(1), text)
    assert "max_augmentations" in doubts(unsettled(1), text)


def test_contact_that_was_left_by_pairs_without_force_counts_as_contact() -> None:
    step = np.arange(100)
    run = {"contact_rows": np.zeros(100), "contact_gap_error": np.full(100, 40e-9)}
    assert "In 1 of 1 steps with contact" in doubts(run | {"contact_converged": np.where(step == 5, 0, 1)})


def test_surfaces_that_slide_in_a_matched_airway_are_reported() -> None:
    assert doubts({"contact_slide": np.array([0.0, 0.2])}) == ""
    assert "slid along each other by 0.4 mean edges" in doubts({"contact_slide": np.array([0.1, 0.4, 0.0])})


@pytest.mark.parametrize("absent", [(), ("meshing",)])
def test_advice_to_triangulate_says_which_build_can(
    monkeypatch: pytest.MonkeyPatch, absent: tuple[str, ...]
) -> None:
    monkeypatch.setattr(plica._engine, "build_info", lambda: {"absent": absent})
    message = doubts({"contact_slide": np.array([0.1, 0.4, 0.0])})
    assert 'contact.airway = "triangulated"' in message
    assert ("PLICA_GPL=ON" in message) == bool(absent)


def test_a_scheme_that_makes_energy_is_reported() -> None:
    ones, zeros = np.ones(5), np.zeros(5)
    run = {"kinetic_energy": ones, "elastic_energy": ones, "load_work": zeros}
    assert doubts(run | {"numerical_loss": np.array([0.0, 0.1, 0.2, 0.3, 0.4])}) == ""
    assert doubts(run | {"numerical_loss": np.array([0.0, 0.1, 0.05, 0.1, 0.1])}) == ""
    message = doubts(run | {"numerical_loss": np.array([0.0, -0.2, -0.5, -0.5, -0.4])})
    assert "The time scheme created energy, 25 % of the largest energy" in message
    # What it took before does not hide what it makes.
    assert "25 %" in doubts(run | {"numerical_loss": np.array([0.0, 0.8, 0.3, 0.3, 0.4])})
    assert doubts(run | {"numerical_loss": np.array([0.0, -0.5, -0.5, 0, 0]), "load_work": 20 * ones}) == ""


def test_a_scheme_that_gives_back_to_contact_what_it_takes_makes_no_energy() -> None:
    ones, zeros = np.ones(4), np.zeros(4)
    run = {"kinetic_energy": ones, "elastic_energy": ones, "load_work": zeros}
    run |= {"contact_rows": np.array([0, 1, 1, 0]), "numerical_loss": np.array([0.0, -0.2, -0.5, -0.5])}
    assert doubts(run | {"contact_work": np.array([0.0, -0.2, -0.5, -0.5])}) == ""
    assert "The time scheme created energy, 25 %" in doubts(run | {"contact_work": zeros})


def test_contact_that_makes_energy_is_reported() -> None:
    ones, zeros = np.ones(8), np.zeros(8)
    run = {"kinetic_energy": ones, "elastic_energy": ones, "load_work": zeros, "numerical_loss": zeros}
    run["contact_rows"] = np.array([0, 3, 3, 0, 0, 2, 0, 0])
    made = {"contact_work": np.array([0.0, 0.3, 0.4, 0.4, 0.4, 0.5, 0.5, 0.5])}
    assert "Contact created energy, 25 % of the largest energy or work of the loads" in doubts(run | made)
    assert doubts(run | made | {"load_work": 20 * ones}) == ""
    assert doubts(run | {"contact_work": np.array([0.0, -0.5, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05])}) == ""
    # What the scheme takes in the same steps counts against it, what it takes elsewhere does not.
    assert doubts(run | made | {"numerical_loss": made["contact_work"]}) == ""
    elsewhere = {"numerical_loss": np.array([0.0, 0.0, 0.0, 0.0, 0.6, 0.6, 0.6, 1.0])}
    assert "25 %" in doubts(run | made | elsewhere)
    # Friction that takes as much as contact makes does not hide it.
    rubbed = {"contact_work": zeros, "friction_loss": np.array([0.0, 0.3, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0])}
    assert "25 %" in doubts(run | rubbed)


def test_contact_of_a_single_step_that_makes_energy_is_reported() -> None:
    ones, zeros = np.ones(5), np.zeros(5)
    run = {"kinetic_energy": ones, "elastic_energy": ones, "load_work": zeros, "numerical_loss": zeros}
    run["contact_rows"] = np.array([0, 1, 0, 0, 0])  # half of the force's work is done when it is over
    assert "Contact created energy, 20 %" in doubts(
        run | {"contact_work": np.array([0.0, 0.0, 0.4, 0.4, 0.4])}
    )


def stop(*args: object, **fields: object) -> None:
    """What Ctrl-C does to whoever is computing."""
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("command", "busy"),
    [("mesh", "scene_mesh"), ("info", "build_info"), ("report", "Run"), ("measures", "Run")],
)
def test_ctrl_c_is_one_sentence_in_every_command(
    scene_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
    busy: str,
) -> None:
    if busy == "Run":
        monkeypatch.setattr(plica.Run, "load", stop)
    else:
        monkeypatch.setattr(plica, busy, stop)
    assert main([command] if command == "info" else [command, str(scene_file)]) == 130
    assert capsys.readouterr().err == "plica: stopped.\n"


@pytest.mark.parametrize("busy", ["scene_mesh", "build_simulation"])
def test_ctrl_c_before_the_first_step_leaves_nothing_and_promises_nothing(
    scene_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    busy: str,
) -> None:
    monkeypatch.setattr(f"plica.runs.run.{busy}", stop)
    assert main(["run", str(scene_file), "-o", str(tmp_path / "run")]) == 130
    assert capsys.readouterr().err == "plica: stopped.\n"
    assert not (tmp_path / "run").exists()


def test_ctrl_c_in_a_run_says_how_to_continue_it(
    scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["run", str(scene_file), "-o", str(tmp_path / "run"), "--quiet"]
    with monkeypatch.context() as patch:
        patch.setattr("plica.runs.run._Runner._advance", stop)
        assert main(command) == 130
    message = capsys.readouterr().err
    assert (
        message
        == f"plica: stopped. Continue with --resume: plica {command[0]} --resume {' '.join(command[1:])}\n"
    )
    assert main([*command, "--resume"]) == 0
    assert plica.Run.load(tmp_path / "run").steps == 40
