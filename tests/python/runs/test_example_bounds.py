"""The numerical uncertainty that runs near the example show without an estimate of their own."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

import plica
from benchmarks.harness.study import RECORDS, Study
from plica.commands.output import measures_table
from plica.measures.catalogue import CATALOGUE
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, Measures
from plica.report.wording import headlines, row
from plica.runs.example_bounds import FILE, example_bounds
from repository import ROOT

KEPT = json.loads(files("plica.runs").joinpath(FILE).read_text(encoding="utf-8"))
STATED = KEPT["uncertainty"]["measures"]
STEADY = Cycles(4e-3 * np.arange(21))


@pytest.fixture(scope="module")
def example() -> plica.Scene:
    return plica.Scene.load(ROOT / "examples/normal_phonation.toml")


def measured(share: float = 1.0) -> Measures:
    """What the example measures, times a share."""
    return Measures(
        Measure(name, share * item["value"], item["spread"], item["cycles"]) for name, item in STATED.items()
    )


def test_the_example_has_the_bounds_that_were_estimated_of_it(example: plica.Scene) -> None:
    found = example_bounds(example, measured(), STEADY)
    assert len(found) > 20
    for name, bound in found.items():
        assert bound.uncertainty == STATED[name]["numerical"]
        assert "normal_phonation" in bound.source
        assert "0.8 kPa" in bound.source


@pytest.mark.parametrize(
    "change",
    [
        {"symmetry": None},
        {"time.duration": 1.0},
        {"output.every": 1e-3},
        {"initial.opening_velocity": 0.2},
        {"airflow.rise": 0.0},
        {"airflow.rise": 20e-3},
        {"airflow.subglottal_pressure": 870.0},
    ],
)
def test_what_has_no_part_in_the_error_of_a_steady_voice_leaves_them(
    example: plica.Scene, change: dict[str, Any]
) -> None:
    assert example_bounds(example.replace(change), measured(), STEADY)


@pytest.mark.parametrize("verdict", ["changing", "irregular", "undecided", "ended"])
def test_a_voice_that_is_not_settled_has_none(example: plica.Scene, verdict: Any) -> None:
    assert not example_bounds(example, measured(), replace(STEADY, verdict=verdict))


def test_the_first_scene_has_them() -> None:
    assert example_bounds(plica.Scene.load(ROOT / "examples/first.toml"), measured(), STEADY)


@pytest.mark.parametrize(
    "change",
    [
        {"airflow.subglottal_pressure": 890.0},
        {"airflow.subglottal_pressure": 710.0},
        {"time.step": 25e-6},
        {"mesh.order": 1},
        {"mesh.larynx": "coarse"},
        {"tissue.cover.E": 1001.0},
        {"contact.surface_mass": "redistributed"},
        {"airflow.coupling": "lagged"},
        {"time.scheme": {"hht": {"alpha": -0.2}}},
    ],
)
def test_another_voice_or_another_way_to_compute_it_has_none(
    example: plica.Scene, change: dict[str, Any]
) -> None:
    assert not example_bounds(example.replace(change), measured(), STEADY)


def test_a_bound_is_carried_over_as_a_number_or_as_a_share_whichever_is_larger(example: plica.Scene) -> None:
    less, more = (example_bounds(example, measured(share), STEADY)["peak_flow"] for share in (0.8, 1.2))
    assert less.uncertainty == STATED["peak_flow"]["numerical"]
    assert more.uncertainty == pytest.approx(1.2 * STATED["peak_flow"]["numerical"], rel=1e-12)


def test_a_measure_of_another_definition_or_without_cycles_has_none(
    example: plica.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = replace(CATALOGUE["peak_flow"], meaning="another")
    monkeypatch.setitem(CATALOGUE, "peak_flow", entry)
    found = measured()
    found["mean_flow"] = replace(found["mean_flow"], cycles=0)
    bounds = example_bounds(example, found, STEADY)
    assert "contact_impulse" in bounds
    assert not {"peak_flow", "mean_flow"} & bounds.keys()


def test_the_bounds_are_those_whose_truth_is_recorded() -> None:
    """docs/records/uncertainty_voice.json has them with two digits, of an engine of the same numbers."""
    table = Study.read(RECORDS / "uncertainty_voice.json")
    stated = {line[0]: float(line[2]) for line in table.rows if line[2] != "-"}
    assert stated["open quotient"] == pytest.approx(STATED["open_quotient"]["numerical"], rel=0.02)
    assert stated["peak flow (cm3/s)"] == pytest.approx(1e6 * STATED["peak_flow"]["numerical"], rel=0.02)
    pressure = 1e-3 * STATED["peak_contact_pressure"]["numerical"]
    assert stated["peak contact pressure (kPa)"] == pytest.approx(pressure, rel=0.02)


def test_scatter_and_numerical_uncertainty_are_called_what_they_are(example: plica.Scene) -> None:
    found = measured().bounded(example_bounds(example, measured(), STEADY))
    text = measures_table(found)
    line = next(one for one in text.splitlines() if one.startswith("open_quotient "))
    assert "scatter of 20 cycles 0.0036" in line
    assert "numerical 0.054" in line
    assert "+-" not in text
    assert "normal_phonation" in text
    assert "not known" in measures_table(measured())
    entry = found.as_json()["open_quotient"]
    assert entry["spread"] == pytest.approx(0.0036, rel=0.02)
    assert entry["uncertainty"] == pytest.approx(0.054, rel=0.02)
    assert "normal_phonation" in entry["uncertainty_source"]
    assert row(found["open_quotient"]).numerical == "0.054"
    assert found["open_quotient"].uncertainty == entry["uncertainty"]


def test_a_measure_without_a_limit_is_no_headline_and_says_why() -> None:
    quantity = CATALOGUE["peak_contact_pressure"]
    doubted = replace(
        measured()["peak_contact_pressure"], no_limit=quantity.no_limit, cautions=(quantity.no_limit,)
    )
    found = Measures([doubted, measured()["contact_impulse"]])
    assert "peak_contact_pressure" not in measures_table(found, short=True)
    assert "contact_impulse" in measures_table(found, short=True)
    assert quantity.no_limit in measures_table(found)
    assert quantity.no_limit in found.as_json()["peak_contact_pressure"]["cautions"]
    assert "peak_contact_pressure" not in {one.name for one in headlines(found)}
    sound = Measures([measured()["peak_contact_pressure"]])
    assert "peak_contact_pressure" in measures_table(sound, short=True)


def test_an_asymmetric_run_shows_left_and_right_in_its_summary() -> None:
    even = Measures([Measure("left_right_phase", 1e-12), Measure("amplitude_asymmetry", 0.0)])
    uneven = Measures([Measure("left_right_phase", 0.3), Measure("amplitude_asymmetry", 0.1)])
    flow = Measure("peak_flow", 4e-4)
    for measures, shown in ((even, False), (uneven, True)):
        text = measures_table(Measures([flow, *measures.values()]), short=True)
        assert ("left_right_phase" in text) == ("amplitude_asymmetry" in text) == shown
