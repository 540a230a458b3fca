"""Impacts and free bodies: the exact motions, what is found on coarse bars, what their commands print."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.__main__ import main
from benchmarks.contact import free
from benchmarks.contact.impact import recommendation
from benchmarks.harness import study
from plica.verify.bodies.bars import PROBLEMS, Collision, Swing
from plica.verify.bodies.blocks import blocks
from plica.verify.bodies.combinations import Combination
from plica.verify.bodies.impact import displacement_error, measure
from repository import ROOT

MULTIPLIERS = Combination("multipliers", "HHT(-0.3)", "kept")


@pytest.mark.parametrize("name", PROBLEMS)
def test_exact_motions_obey_the_wave_equation_and_start_and_rest_as_they_should(name: str) -> None:
    problem = PROBLEMS[name](10)
    bar, exact = problem.bar, problem.exact
    length, c = bar.length, bar.wave
    gravity = exact.gravity if isinstance(exact, Collision) else 0.0
    slow = exact.speed if isinstance(exact, Collision) else 0.5
    # Away from the fronts, which are where x, x + c t and x - c t are multiples of the length.
    rng = np.random.default_rng(1)
    x = length * rng.uniform(0.01, 0.99, 400)
    t = exact.begin + rng.uniform(-0.5, 2.5, 400) * length / c
    s = c * (t - exact.begin) / length
    near = [np.abs(value - np.round(value)) < 0.01 for value in (s - x / length, s + x / length, s)]
    smooth = ~np.any(near, axis=0)
    assert smooth.sum() > 300
    x, t, e = x[smooth], t[smooth], 1e-3

    def u(dx: float, dt: float) -> np.ndarray:
        values = exact.displacement(x + dx * e * length, t + dt * e * length / c)
        return np.diag(values) / length

    in_time = (u(0, 1) - 2 * u(0, 0) + u(0, -1)) / e**2
    in_space = (u(1, 0) - 2 * u(0, 0) + u(-1, 0)) / e**2
    # second differences of polynomials of second degree are exact: round-off over e^2
    np.testing.assert_allclose(in_time - in_space, -gravity * length / c**2, atol=1e-7)

    ends = np.array([0.0, length])
    inside = np.linspace(exact.begin, exact.end, 41)[1:-1]
    assert np.abs(exact.displacement(ends, inside)[:, 0]).max() < 1e-12 * length  # on the wall
    small = 1e-6 * length
    slope = np.diff(exact.displacement(np.array([0.0, small]), inside), axis=1)[:, 0] / small
    pushed = exact.pressure(inside)
    np.testing.assert_allclose(-bar.modulus * slope, pushed, rtol=1e-3)
    at = np.array([exact.begin, exact.begin + 1e-6 * length / c])
    middle = exact.displacement(np.array([0.3 * length]), at)[:, 0]
    assert abs(middle[0]) < 1e-12 * length
    assert np.diff(middle)[0] / np.diff(at)[0] == pytest.approx(-slow, rel=1e-4)

    e = 1e-6 * length / c
    depths = length * np.linspace(0.05, 0.95, 19)
    around = exact.displacement(depths, exact.end + e * np.array([-1.0, 1.0, 3.0]))
    velocity = np.diff(around, axis=0) / (2 * e)
    np.testing.assert_allclose(velocity, slow, rtol=1e-4)  # everywhere, as it comes off


def test_the_fast_bars_are_those_of_the_specification() -> None:
    for name, pressure, duration, impulse in (
        ("bars", 49.4975e6, 3.81838e-3, 189e3),
        ("bars-0.3", 57.4289e6, 3.29103e-3, 189e3),
    ):
        exact = PROBLEMS[name](10).exact
        assert exact.begin == pytest.approx(1e-4)
        assert exact.end - exact.begin == pytest.approx(duration, rel=1e-5)
        assert exact.pressure(np.array([2e-3]))[0] == pytest.approx(pressure, rel=1e-5)
        assert pressure * duration == pytest.approx(impulse, rel=1e-5)
    assert isinstance(PROBLEMS["R1"](10).exact, Swing)


def test_displacement_counts_from_first_touch_on_and_end_nodes_half() -> None:
    problem = PROBLEMS["bars"](4)
    begin, length = problem.exact.begin, problem.bar.length
    depth, time = np.linspace(0, length, 5), begin * np.array([0.5, 1.0, 1.5, 2.0, 3.0])
    exact = problem.exact.displacement(depth, time)
    weights = begin * np.array([0.5, 0.5, 0.5, 1.0])[:, None] * np.array([0.5, 1, 1, 1, 0.5])
    scale = (weights * exact[1:] ** 2).sum()

    def error(at: tuple[int, int], by: float) -> float:
        moved = exact + problem.offset
        moved[at] += by
        return displacement_error(problem, depth, time, moved)

    assert error((0, 2), 1.0) == pytest.approx(0, abs=1e-12)  # before
    for at in ((1, 2), (1, 0), (3, 4), (4, 1)):
        assert error(at, 2e-3) == pytest.approx(2e-3 * np.sqrt(weights[at[0] - 1, at[1]] / scale))


@pytest.mark.parametrize("name", PROBLEMS)
def test_errors_fall_with_the_edge(name: str) -> None:
    coarse, fine = (measure(PROBLEMS[name](n), MULTIPLIERS, 1e-8) for n in (10, 40))
    assert fine["displacement"] < 0.5 * coarse["displacement"]
    assert fine["force"] < coarse["force"]  # it jumps: with the root of the edge at best
    assert abs(fine["impulse"] - 1) < max(0.5 * abs(coarse["impulse"] - 1), 0.02)
    for found in (coarse, fine):
        assert found["force sum"] < 1e-14
        assert found["energy balance"] < 1e-7


def test_what_chatters_or_gains_energy_is_not_recommended() -> None:
    good = {"duty": 1.0, "energy max": 1.0, "energy end": 1.0, "impulse": 1.0, "duration": 1.0}
    good |= {"displacement": 0.0, "force": 0.1, "penetration": 0.0, "ms/step": 1.0}

    def row(contact: str, **changes: object) -> dict[str, object]:
        return {"contact": contact, "scheme": "s", "mass": "kept", **good, **changes}

    made = [
        row("quick", force=0.2),
        row("best"),
        row("close", force=0.105),
        row("slow", force=0.098, **{"ms/step": 9.0}),
        row("chatters", force=0.01, duty=0.9),
        row("gains", force=0.01, **{"energy max": 1.1}),
        {"contact": "failed", "scheme": "s", "mass": "kept", "failure": "Step 3"},
        row("mixed", force=0.01),
        row("mixed", force=0.01, duty=0.5),
    ]
    message = recommendation(made)
    assert message.startswith("Recommended: best, s, mass kept (its errors sum to 0.100; 4 of 8 combinations")
    assert message.endswith("As good: close, s, mass kept (0.105).")
    assert recommendation(made[4:5]) == "None of 1 combinations is sound."


def test_the_command_prints_the_table_and_writes_the_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "impact.csv"
    command = ["impact", "--problems", "R3", "--elements", "12", "--schemes", "trapezoidal", "HHT(-0.3)"]
    assert main([*command, "-o", str(path), "--contacts", "multipliers", "penalty"]) == 0
    message = capsys.readouterr()
    lines = message.out.splitlines()
    assert lines[0].startswith("| problem | elements | contact | scheme | mass | displacement |")
    assert sum(line.startswith("| R3 | 12 |") for line in lines) == 8
    assert "Recommended: multipliers, trapezoidal, mass redistributed" in message.out
    assert "8/8" in message.err
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8
    exact = measure(PROBLEMS["R3"](12), Combination("penalty", "HHT(-0.3)", "kept"), 1e-8)
    row = next(r for r in rows if (r["contact"], r["scheme"], r["mass"]) == ("penalty", "HHT(-0.3)", "kept"))
    assert float(row["impulse"]) == exact["impulse"]
    assert float(row["displacement"]) == exact["displacement"]


def test_a_recorded_table_has_the_numbers_of_its_rows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "RECORDS", tmp_path)
    monkeypatch.setattr(sys, "argv", [str(ROOT / "benchmarks" / "__main__.py"), "impact"])
    command = ["impact", "--problems", "R3", "--elements", "12", "--contacts", "penalty", "--masses", "kept"]
    assert main([*command, "--schemes", "trapezoidal", "--quiet", "--record", "one"]) == 0
    made = study.Study.read(tmp_path / "one.json")
    row = dict(zip(made.columns, *made.rows, strict=True))
    exact = measure(PROBLEMS["R3"](12), Combination("penalty", "trapezoidal", "kept"), 1e-8)
    assert row["impulse"] == exact["impulse"]
    assert row["elements"] == 12
    assert made.said.startswith("None of 1 combinations") or made.said.startswith("Recommended: penalty")
    assert f"| R3 | 12 | penalty | trapezoidal | kept | {exact['displacement']:.3f} |" in made.markdown()
    assert made.said in capsys.readouterr().out


def test_a_run_that_fails_is_a_row_with_its_message(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["impact", "--problems", "R1", "--elements", "100", "--contacts", "multipliers"]
    options = ["--schemes", "trapezoidal", "--masses", "kept", "--quiet"]
    assert main([*command, *options, "--tolerance", "1e-17"]) == 0  # below what round-off leaves
    message = capsys.readouterr()
    assert (
        "| R1 | 100 | multipliers | trapezoidal | kept | Simulation: the initial acceleration" in message.out
    )
    assert "None of 1 combinations is sound." in message.out
    assert message.err == ""


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ["impact", "--problems", "R9"],
            'benchmarks: --problems = "R9"; must be one of R1, R2, R3, bars, bars-0.3.',
        ),
        (["impact", "--contacts", "penalti"], 'Did you mean "penalty"?'),
        (["free", "--masses", "none"], 'benchmarks: --masses = "none"; must be one of kept, redistributed.'),
        (["impact", "--elements", "100", "-o", "/nowhere/x.csv"], "/nowhere/x.csv: cannot be saved"),
    ],
)
def test_a_wrong_name_is_reported_with_those_there_are(
    options: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(options) in (1, 2)
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("mass", ["kept", "redistributed"])
@pytest.mark.parametrize("contact", ["multipliers", "Nitsche", "penalty"])
def test_free_blocks_keep_their_momenta_and_explain_what_contact_turns(contact: str, mass: str) -> None:
    found = blocks(Combination(contact, "HHT(-0.3)", mass), 1e-10, 60)
    assert found["collisions"] == 1
    # some hundred times the tolerance, over as many steps
    for name in ("momentum", "angular, free", "angular, balance"):
        assert found[name] < 1e-8
    assert found["angular, change"] > 1e-3  # or the balance would say nothing
    assert found["force sum"] < 1e-14
    assert found["gain"] < 1e-9


@pytest.mark.parametrize("scheme", ["HHT(-0.3)", "trapezoidal"])
def test_a_body_that_rattles_in_a_frame_gains_neither_momentum_nor_energy(scheme: str) -> None:
    found = free.box(Combination("multipliers", scheme, "redistributed"), 1500, 1e-10)
    assert found["collisions"] > 20
    assert found["momentum"] < 1e-7
    assert found["force sum"] < 1e-14
    assert found["gain"] < 1e-9
    kept = free.box(Combination("multipliers", "trapezoidal", "kept"), 1500, 1e-10)
    assert kept["gain"] > 0.1  # exact contact on nodes with mass makes energy
