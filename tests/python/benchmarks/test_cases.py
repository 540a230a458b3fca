"""`python -m benchmarks`: every case runs small, shows what it claims, and can fail."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.__main__ import main
from benchmarks.dynamics.newmark import trapezoidal
from benchmarks.harness.case import Case
from benchmarks.harness.case_record import CaseRecord
from benchmarks.harness.families import FAMILIES, chosen_cases
from benchmarks.harness.run import blank, failed_claims, measure
from benchmarks.tissue.peers import discrete_mode, plica_assembly
from plica.errors import InvalidInput

CASES = {case.name: case for family in FAMILIES.values() for case in family.cases}


def small(case: Case) -> CaseRecord:
    return measure(case, blank(case, "any", "small", 1), [1])


@pytest.fixture(scope="module")
def records() -> dict[str, CaseRecord]:
    """Those that were made, by case."""
    return {}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_case_runs_small_and_shows_what_it_claims(name: str, records: dict[str, CaseRecord]) -> None:
    record = records[name] = small(CASES[name])
    assert failed_claims(CASES[name], record) == []
    assert record.finished
    assert len(record.rows) >= len(CASES[name].levels["small"])
    first = next(iter(record.errors))
    for row in record.rows:
        assert row.errors.keys() <= record.errors.keys()
        value = row.errors[first]
        assert value is not None
        assert 0 <= value < 2
        assert row.median is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_case_whose_results_are_wrong_fails(name: str, records: dict[str, CaseRecord]) -> None:
    record = records.get(name) or small(CASES[name])
    wrong = [row.model_copy(update={"errors": dict.fromkeys(row.errors, 0.9)}) for row in record.rows]
    message = failed_claims(CASES[name], record.model_copy(update={"rows": wrong}))
    assert message
    assert all(sentence.startswith("not so: ") for sentence in message)


def test_names_are_unique_and_every_family_says_what_to_use_when() -> None:
    names = [case.name for family in FAMILIES.values() for case in family.cases]
    assert len({*names, *FAMILIES}) >= len(names)
    assert len(set(names)) == len(names)
    for family in FAMILIES.values():
        assert family.advice.endswith(".")
        for case in family.cases:
            assert case.claims
            assert case.levels["full"]
            assert len({method.name for method in case.methods}) == len(case.methods)


def test_cases_are_chosen_by_their_names_and_their_familys() -> None:
    assert [case.name for case in chosen_cases(["assembly"])] == ["assembly", "frequency"]
    assert [case.name for case in chosen_cases(["smoother", "flow"])] == ["flow", "smoother"]
    assert len(chosen_cases(None)) == len(CASES)
    refusal = r'CASE = "asembly"; must be one of assembly, .* Did you mean "assembly"\?'
    with pytest.raises(InvalidInput, match=refusal) as caught:
        chosen_cases(["asembly"])
    assert str(caught.value).count(" assembly,") == 1  # a family has a case of its name


def test_the_trapezoidal_rule_that_is_written_out_keeps_energy_and_swings_as_it_must() -> None:
    made = plica_assembly({"cells": 2, "elements": "linear"})()
    stiffness, mass = made.on_free()
    mode, omega = discrete_mode(made)
    step, steps = 0.1 / omega, 50
    dense = lambda matrix: lambda right: np.linalg.solve(matrix.toarray(), right)  # noqa: E731
    u, v = trapezoidal(mass, stiffness, dense, mode, step, steps)
    energy = 0.5 * (v @ (mass @ v) + u @ (stiffness @ u))
    assert energy == pytest.approx(0.5 * mode @ (stiffness @ mode), rel=1e-10)
    angle = 2 * steps * np.arctan(0.5 * omega * step)  # of the rule, exactly
    np.testing.assert_allclose(u, np.cos(angle) * mode, atol=1e-9 * np.abs(mode).max())


def test_the_command_measures_a_case_continues_and_writes_one_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["run", "frequency", "--size", "small", "-o", str(tmp_path)]
    assert main(command) == 0
    message = capsys.readouterr().out
    assert "| plica | linear | 4 | 1 |" in message
    written = (tmp_path / "frequency.json").read_bytes()
    assert main(command) == 0  # nothing is missing: no row is measured again
    assert (tmp_path / "frequency.json").read_bytes()[:200] == written[:200]
    page = (tmp_path / "benchmarks.html").read_text(encoding="utf-8")
    for part in (
        "What to use when",
        FAMILIES["assembly"].advice.split(":")[0],
        "<svg",
        "Shown: the error of plica",
    ):
        assert part in page
    assert "http" not in page.replace("http://www.w3.org", "")
    table = (tmp_path / "benchmarks.csv").read_text(encoding="utf-8").splitlines()
    assert table[0].startswith(
        "family,case,size,method,package,version,threads,elements,cells,error: frequency"
    )
    assert len(table) == 1 + message.count("| plica | ") + message.count("| scikit-fem | ") + message.count(
        "| NGSolve | "
    )
    assert main(["compare", str(tmp_path), str(tmp_path)]) == 0
    assert (
        "none of 4 rows are slower or less exact; the time of 4 cannot be compared."
        in capsys.readouterr().out
    )
    assert main(["page", str(tmp_path)]) == 0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run", "assemly", "--size", "small"], 'Did you mean "assembly"?'),
        (["run", "assembly"], "run: -o is left out; must name a directory"),
        (["page", "/nowhere"], "no record of a case in it"),
        (["compare", "/nowhere/a.json", "/nowhere/b.json"], "/nowhere/a.json: cannot be read"),
    ],
)
def test_bad_input_is_reported(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) in (1, 2)
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("command", [[], ["run"], ["compare"], ["impact"], ["free"], ["extremes"]])
def test_the_help_of_a_command_has_examples_of_it(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main([*command, "--help"])
    assert stop.value.code == 0
    examples = capsys.readouterr().out.partition("examples:")[2]
    assert " ".join(["python -m benchmarks", *command]) in examples


def test_an_unknown_option_refers_to_the_help_of_its_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["run", "--nonsense"])
    assert stop.value.code == 2
    assert "--nonsense. See python -m benchmarks run --help." in capsys.readouterr().err


def test_the_list_names_cases_references_and_absent_peers(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    message = capsys.readouterr().out
    for name in CASES:
        assert f"\n  {name} " in message
    for family in FAMILIES.values():
        assert f"{family.name}: {family.title}" in message
