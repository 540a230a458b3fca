"""A part of a run is measured as a run of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from analytic_run import AnalyticRun, Phonation
from plica.commands.main import main
from plica.measures.record import time_step
from plica.measures.run.cautions import cautions
from plica.measures.run.measure import measure
from plica.measures.waveforms import SINCE_THE_START
from plica.runs.part import part_of


def one_after_the_other(first: AnalyticRun, second: AnalyticRun) -> AnalyticRun:
    """The one run, then the other; works and losses add up."""
    waveforms = {
        name: np.concatenate([values, second.waveforms[name] + values[-1] * (name in SINCE_THE_START)])
        for name, values in first.waveforms.items()
    }
    time = np.concatenate([first.time, first.time[-1] + second.time])
    return replace(second, time=time, waveforms=waveforms, fields={})


def test_each_half_of_a_run_has_its_own_pitch() -> None:
    run = one_after_the_other(Phonation(steps=1200).run(), Phonation(frequency=100.0, steps=2400).run())
    for start, end, pitch in ((None, "60 ms", 200.0), (0.06, None, 100.0), ("80 ms", 0.14, 100.0)):
        found = measure(part_of(run, start, end))
        assert found["fundamental_frequency"].value == pytest.approx(pitch, rel=1e-6)
        assert found["fundamental_frequency_autocorrelation"].value == pytest.approx(pitch, rel=1e-3)


def test_a_part_measures_as_the_run_that_has_only_it() -> None:
    alone = Phonation(steps=1200).run()
    run = one_after_the_other(Phonation(frequency=130.0, amplitude_left=0.3e-3).run(), alone)
    expected, found = measure(alone), measure(part_of(run, "60 ms", "120 ms"))
    assert expected.keys() == found.keys()
    for name, item in expected.items():
        got = found[name]
        assert (got.cycles, got.note) == (item.cycles, item.note), name
        assert (got.value is None) == (item.value is None), name
        if item.value is not None:  # to the round-off of the later times
            small = 1e-12 if item.unit == "1" else 1e-18
            assert got.value == pytest.approx(item.value, rel=1e-9, abs=small), name


def test_a_run_and_its_part_name_the_surface_of_the_airflow(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    assert run.airway == run.between().airway == "airway"  # it has no airflow
    named = plica.Run.load(run.directory)
    named.scene_text = '[airflow]\nsurface = "lumen"\n'
    assert named.airway == named.between().airway == "lumen"


def test_the_step_of_a_record_does_not_depend_on_when_it_begins() -> None:
    time = 1e-4 * np.arange(1, 101)
    for begin in (0.0, 0.5, -0.2):
        assert time_step(begin + time) == pytest.approx(1e-4, rel=1e-10)
    assert time_step(time[:1]) == 1e-4


@pytest.mark.parametrize(("given_back", "printed"), [(0.3, []), (3.0, ["energy_from_scheme"])])
def test_what_the_scheme_gives_back_in_a_part_is_seen_against_the_whole_run(
    given_back: float, printed: list[str]
) -> None:
    time = np.arange(1.0, 101.0)
    waveforms = {
        "kinetic_energy": np.ones(100),
        "elastic_energy": np.ones(100),
        "load_work": 0.4 * np.minimum(time, 50.0),  # 20 J, none in the part
        "numerical_loss": np.where(time <= 50, 0.0, -given_back * (time - 50) / 50) + 4.0,
    }
    run = AnalyticRun(time, waveforms, Phonation().run().mesh)
    for part in (run, part_of(run, 50.0, None)):
        assert [caution.name for caution in cautions(part)] == printed


def test_works_and_losses_of_a_part_begin_with_it(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    halves = [run.between(None, "2 ms"), run.between("2 ms", None)]
    for name in ("viscous_loss", "numerical_loss", "load_work"):
        ends = [half.waveforms[name][-1] for half in halves]
        assert sum(ends) == pytest.approx(run[name][-1], rel=1e-12, abs=1e-30)
    assert run["viscous_loss"][-1] > 0
    np.testing.assert_array_equal(np.concatenate([half.time for half in halves]), run.time)
    np.testing.assert_array_equal(
        np.concatenate([half.waveforms["kinetic_energy"] for half in halves]), run["kinetic_energy"]
    )
    np.testing.assert_allclose(halves[1].fields["time"], [2.5e-3, 3e-3, 3.5e-3, 4e-3], rtol=1e-12)
    np.testing.assert_array_equal(halves[1].fields["displacement"], run.displacement[5:])


def test_what_contact_made_before_a_part_is_not_attributed_to_it() -> None:
    run = Phonation(steps=2400).run()
    made = np.where(run.time < 0.05, 40e-6 * run.time / 0.05, 40e-6)
    run = replace(run, waveforms={**run.waveforms, "contact_work": made})
    assert [caution.name for caution in cautions(run)] == ["energy_from_contact"]
    assert cautions(part_of(run, 0.06, 0.12)) == ()


@pytest.mark.parametrize(
    ("start", "end", "message"),
    [
        ("0.3 s", None, r"start = 0\.3 s; must be in \[0, 0\.004\] s, the computed time\."),
        (None, 0.1, r"end = 0\.1 s; must be in \[0, 0\.004\] s"),
        (-1, None, r"start = -1 s; must be in "),
        ("2 mm", None, r'start = "2 mm"; must be a number in s or a text with a unit of that kind'),
        (
            "3 ms",
            "2 ms",
            r"end = 0\.002 s; must be two steps or more, of 0\.0001 s, after start = 0\.003 s\.",
        ),
        ("3 ms", "3.1 ms", r"end = 0\.0031 s; must be two steps or more"),
    ],
)
def test_what_is_no_part_is_refused(
    bar: plica.Scene, tmp_path: Path, start: Any, end: Any, message: str
) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    with pytest.raises(plica.InvalidInput, match=r"^Run\.between: " + message):
        run.between(start, end)


def test_the_command_measures_a_part_and_leaves_what_is_stored(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    assert main(["measures", str(run.directory)]) == 0
    capsys.readouterr()
    before = {path.name: path.read_bytes() for path in run.directory.iterdir()}
    assert main(["measures", str(run.directory), "--from", "1ms", "--to", "0.003"]) == 0
    printed = dict(line.split()[:2] for line in capsys.readouterr().out.splitlines())
    assert (printed["steps"], printed["duration"]) == ("20", "2")
    assert before == {path.name: path.read_bytes() for path in run.directory.iterdir()}
    assert main(["measures", str(run.directory), "--from", "1 s"]) == 2
    assert "--from = 1 s; must be in [0, 0.004] s" in capsys.readouterr().err


def test_a_part_says_its_measures_cautions_and_waveforms_itself(
    tmp_path: Path, phonating: plica.Scene
) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    part = run.between(float(run.time[3]), None)
    assert part.measures == measure(part)
    assert part.measures["steps"].value == run.steps - 4
    assert part.cautions == cautions(part)
    assert np.array_equal(part["flow"], run["flow"][4:])
    with pytest.raises(plica.InvalidInput, match=r'"flwo".*Did you mean "flow"'):
        part["flwo"]
