"""Sensitivity indices against closed forms, and where there are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.measures.record import Floats
from plica.sweep import Plan, Sweep, indices, write_report
from plica.sweep.case import CaseResult
from plica.sweep.sensitivity import indices_of
from plica.sweep.store import Store
from sweeps import NU, E

VISCOSITY = "tissue.body.viscosity"
RANGES = {E: "10:30 kPa", NU: "0.1:0.4", VISCOSITY: "0.1:0.3 Pa s"}
LOW, HIGH = np.array([1e4, 0.1, 0.1]), np.array([3e4, 0.4, 0.3])


def _stored(plan: Plan, values: Floats, directory: Path) -> Sweep:
    """A sweep whose cases have these values of the kinetic energy; none of those that are NaN."""
    directory.mkdir()
    store = Store(directory, plan)
    for case, value in enumerate(values):
        found = None if np.isnan(value) else float(value)
        measures = {"kinetic_energy": (found, None, None), "duration": (0.004, None, None)}
        store.keep(CaseResult(case, plan.case_digest(case), "done", measures=measures))
    return Sweep.load(directory)


def _ishigami(x: Floats) -> Floats:
    """sin a + 7 sin^2 b + 0.1 c^4 sin a, over (-pi, pi)^3."""
    a, b, c = x.T
    return np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)


def _closed_form() -> dict[str, list[float]]:
    """First-order and total indices (Ishigami and Homma 1990)."""
    a, b = 7.0, 0.1
    of_first = 0.5 * (1 + b * np.pi**4 / 5) ** 2
    of_second = a**2 / 8
    with_third = b**2 * np.pi**8 * (1 / 18 - 1 / 50)
    whole = of_first + of_second + with_third
    return {
        "first order": [of_first / whole, of_second / whole, 0.0],
        "total": [(of_first + with_third) / whole, of_second / whole, with_third / whole],
    }


@pytest.mark.usefixtures("unsynced")
def test_sobol_indices_of_a_stored_sweep_are_those_of_a_closed_form(bar: plica.Scene, tmp_path: Path) -> None:
    plan = Plan.make(bar, RANGES, design="sobol", samples=64)
    unit = (plan.values - LOW) / (HIGH - LOW)
    values = _ishigami(np.pi * (2 * unit - 1))
    sweep = _stored(plan, values, tmp_path / "sweep")
    found = indices(sweep, "kinetic_energy")
    problem = {"num_vars": 3, "names": [E, NU, VISCOSITY], "bounds": np.column_stack([LOW, HIGH]).tolist()}
    assert found.unit == "1"
    assert found.found == indices_of("sobol", problem, plan.values, values)
    for one in found.found:
        truth = _closed_form()[one.kind][[E, NU, VISCOSITY].index(one.key)]
        half = 0.5 * (one.interval[1] - one.interval[0])
        assert 0.01 < half < 0.5
        assert abs(one.value - truth) < 2 * half, one
    page = write_report(sweep, ("kinetic_energy",)).read_text()
    assert "Sensitivity" in page
    assert plan.values[:, 0].min() > LOW[0]  # the page has what was asked for, not what was drawn
    for key, low, high in ((E, "10", "30"), (NU, "0.1", "0.4"), (VISCOSITY, "0.1", "0.3")):
        assert f'{key}</th><td class="num">{low}</td><td class="num">{high}</td>' in page
    rows = (tmp_path / "sweep" / "sensitivity.csv").read_text().splitlines()
    assert rows[0] == "measure,key,kind,unit,value,from,to"
    assert len(rows) == 1 + 2 * 3


def test_sobol_indices_converge_to_the_closed_form() -> None:
    from SALib.sample import sobol

    problem = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[-np.pi, np.pi]] * 3}
    errors = []
    for samples in (128, 4096):
        x = sobol.sample(problem, samples, calc_second_order=False, seed=1)
        found = indices_of("sobol", problem, x, _ishigami(x), resamples=10)
        truth = [value for values in _closed_form().values() for value in values]
        errors.append(max(abs(one.value - t) for one, t in zip(found, truth, strict=True)))
    assert errors[1] < 0.02 < errors[0]


@pytest.mark.usefixtures("unsynced")
def test_elementary_effects_of_a_linear_measure_are_its_slopes(bar: plica.Scene, tmp_path: Path) -> None:
    """Over the whole range of a key each, which is how they are scaled."""
    plan = Plan.make(bar, RANGES, design="morris", samples=6)
    slopes = np.array([2.0, -3.0, 0.5])
    values = (plan.values - LOW) / (HIGH - LOW) @ slopes
    found = indices(_stored(plan, values, tmp_path / "sweep"), "kinetic_energy")
    assert found.unit == "J"
    assert [one.key for one in found.found] == [E, NU, VISCOSITY]
    assert [one.value for one in found.found] == pytest.approx(np.abs(slopes))


@pytest.mark.usefixtures("unsynced")
@pytest.mark.parametrize(
    ("design", "samples", "spoilt", "why"),
    [
        ("sobol", 8, 7, "1 of 40 cases have no kinetic_energy, e.g. case 7 (done, without a value)"),
        ("morris", 3, 2, "1 of 12 cases have no kinetic_energy, e.g. case 2 (done, without a value)"),
        ("latin_hypercube", 5, None, 'design = "latin_hypercube" has no sensitivity indices'),
    ],
)
def test_a_design_that_is_not_whole_has_no_indices(
    design: Any, samples: int, spoilt: int | None, why: str, bar: plica.Scene, tmp_path: Path
) -> None:
    plan = Plan.make(bar, RANGES, design=design, samples=samples)
    values = np.arange(float(len(plan)))
    if spoilt is not None:
        values[spoilt] = np.nan
    sweep = _stored(plan, values, tmp_path / "sweep")
    with pytest.raises(plica.InvalidInput) as error:
        indices(sweep, "kinetic_energy")
    assert why in str(error.value)
    page = write_report(sweep, ("kinetic_energy",)).read_text()
    assert ("No sensitivity indices: 1 of" in page) == (spoilt is not None)
    assert not (tmp_path / "sweep" / "sensitivity.csv").exists()
    if design != "latin_hypercube":
        with pytest.raises(plica.InvalidInput, match=r"duration = 0\.004 in all cases; must differ"):
            indices(sweep, "duration")


@pytest.mark.usefixtures("unsynced")
def test_a_waiting_case_spoils_a_design(bar: plica.Scene, tmp_path: Path) -> None:
    plan = Plan.make(bar, RANGES, design="sobol", samples=2)
    sweep = _stored(plan, np.arange(9.0), tmp_path / "sweep")
    with pytest.raises(
        plica.InvalidInput, match=r"1 of 10 cases have no kinetic_energy, e\.g\. case 9 \(waiting\)"
    ):
        indices(sweep, "kinetic_energy")
