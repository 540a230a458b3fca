"""``plica sweep``: what it prints, writes and refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica
from complaints import refused
from plica.commands.main import main
from plica.sweep import Plan
from plica.sweep.case import CaseResult
from plica.sweep.store import Store
from sweeps import NU, E

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture
def scene(bar: plica.Scene, tmp_path: Path) -> str:
    path = tmp_path / "bar.toml"
    bar.save(path)
    return str(path)


def test_a_grid_is_computed_and_shown(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "out")
    typed = ["sweep", scene, "--vary", f"{E}=10:30:3kPa", "--vary", f"{NU}=0.2,0.3", "-o", out]
    assert main(typed) == 0
    said = capsys.readouterr()
    assert said.out.splitlines() == [
        "6 cases: 6 done",
        f"table: {out}/cases.csv",
        f"report: {out}/report.html",
    ]
    assert "6/6" in said.err
    page = Path(out, "report.html").read_text()
    assert page.count("<svg") == 1
    assert "tissue.body.E" in page
    assert main(["sweep", out, "--table", "--measures", "kinetic_energy"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split("  ")[-1] == "cautions"
    assert "kinetic_energy (uJ)" in head
    assert [row.split()[:4] for row in rows] == [
        [str(2 * k + j), str(10 * (k + 1)), nu, "done"]
        for k in range(3)
        for j, nu in enumerate(("0.2", "0.3"))
    ]
    assert main(["sweep", out, "--measures", "load_work,kinetic_energy", "--quiet"]) == 0
    assert Path(out, "report.html").read_text() != page


def test_a_corner_that_is_no_scene_is_isolated_and_said(
    scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "out")
    typed = ["sweep", scene, "--vary", f"{NU}=0.2,0.3,0.6", "-o", out, "--quiet"]
    for _ in range(2):  # again: nothing is left to compute, and the outcome is the same
        assert main(typed) == 1
        said = capsys.readouterr()
        assert said.out == ""
        first, last = said.err.splitlines()
        assert first.startswith("plica: 1 of 3 cases have no result (1 refused, 0 failed); case 2, refused: ")
        assert "tissue.body.nu = 0.6; must be < 0.5" in first
        assert last == f"plica: All are in {out}/cases.csv."
    assert "must be &lt; 0.5" in Path(out, "report.html").read_text()


def test_a_study_is_computed_in_parts(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study, out = tmp_path / "study.toml", str(tmp_path / "out")
    study.write_text(
        'scene = "bar.toml"\ndesign = "latin_hypercube"\nsamples = 5\n[vary]\ntissue.body.E = "10:30 kPa"\n'
    )
    assert main(["sweep", str(study), "-o", out, "--first", "2"]) == 0
    assert capsys.readouterr().out.startswith("5 cases: 3 waiting, 2 done\n")
    assert main(["sweep", str(study), "-o", out, "--quiet"]) == 0
    assert main(["sweep", out]) == 0
    assert capsys.readouterr().out.startswith("5 cases: 5 done\n")
    assert "Latin hypercube, 5 samples, seed 1" in Path(out, "report.html").read_text()


@pytest.mark.parametrize(
    ("typed", "why"),
    [
        (["--vary", f"{E}=10,20kPa"], "-o DIR is left out"),
        (["-o", "OUT"], "--vary: no key is varied"),
        (["--vary", f"{E}=1kPa", "--vary", f"{E}=2kPa", "-o", "OUT"], f"--vary {E}: is given twice"),
        (
            ["--vary", "tissue.body.e=1kPa", "-o", "OUT"],
            '--vary: tissue.body.e is not known. Did you mean "E"?',
        ),
        (["--vary", "mesh.size=1", "-o", "OUT"], "must be a number to vary it"),
        (["--vary", f"{E}=1kPa", "--table", "-o", "OUT"], "--table with"),
        (["--vary", f"{E}=1:2kPa", "--design", "sobol", "-o", "OUT"], "--vary: samples is left out"),
        (["--vary", f"{E}=1kPa", "--first", "2", "-o", "OUT"], "first = 2; must be from 1 to the 1 cases"),
    ],
)
def test_what_is_typed_wrongly_is_refused(
    typed: list[str], why: str, scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    error = refused(["sweep", scene, *(str(out) if one == "OUT" else one for one in typed)], capsys)
    assert why in error
    assert not out.exists()


@pytest.mark.parametrize(
    ("typed", "why"),
    [
        (["--vary", E], f"--vary: {E}; must be KEY=VALUES"),
        (["--workers", "0"], "--workers: 0; must be a whole number from 1"),
        (["--design", "sobol", "--design", "morris"], "--design: is given twice; must be given once"),
    ],
)
def test_what_cannot_be_parsed_is_refused(
    typed: list[str], why: str, scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["sweep", scene, *typed])
    assert why in capsys.readouterr().err


def test_a_directory_and_a_study_take_no_plan(
    scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "out")
    assert main(["sweep", scene, "--vary", f"{E}=10kPa", "-o", out, "--quiet"]) == 0
    assert "--vary is given; must be left out" in refused(["sweep", out, "--vary", f"{E}=1kPa"], capsys)
    assert "-o is given; must be left out" in refused(["sweep", out, "-o", out], capsys)
    assert "--retry is given; must be left out" in refused(["sweep", out, "--retry"], capsys)
    assert 'measure "flow"; must be one that the cases have' in refused(
        ["sweep", out, "--table", "--measures", "flow"], capsys
    )
    study = tmp_path / "study.toml"
    study.write_text(f'scene = "bar.toml"\n[vary]\n{E} = "10 kPa"\n')
    assert "has the plan" in refused(["sweep", str(study), "--design", "grid", "-o", out], capsys)


def test_what_is_no_sweep_is_said_to_be_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    run.mkdir()
    assert "there is no sweep in it" in refused(["sweep", str(run), "--retry"], capsys)
    (run / "results.h5").touch()
    assert "holds a run or an analysis (results.h5), and no sweep" in refused(
        ["sweep", str(run), "--retry"], capsys
    )


def test_cautions_of_cases_are_counted_and_explained(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = Plan.make(bar, {E: "10:30:3kPa"})
    store = Store(tmp_path, plan)
    for case, cautions in enumerate(((), ("large_strain", "stiffness"), ("large_strain",))):
        store.keep(CaseResult(case, plan.case_digest(case), "done", cautions=cautions))
    assert main(["sweep", str(tmp_path)]) == 0
    said = capsys.readouterr().out.splitlines()
    told = "cautions: 2 of 3 cases have some (large_strain 2, stiffness 1), which the report explains"
    assert said[1] == told
    page = " ".join((tmp_path / "report.html").read_text().split())
    for name, count, meaning in (
        ("large_strain", 2, "The strain is too large for the linear tissue model"),
        ("stiffness", 1, "Tissue of the larynx has 100 Pa to 2 MPa."),
    ):
        assert f'<th scope="row">{name}</th><td class="num">{count}</td><td class="note">{meaning}' in page


def test_without_its_libraries_a_sweep_says_what_to_install(
    scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "zarr", None)
    error = refused(["sweep", scene, "--vary", f"{E}=10kPa", "-o", str(tmp_path / "out")], capsys)
    assert "plica sweep needs zarr, which is not installed; must be: pip install 'plica[sweep]'." in error
