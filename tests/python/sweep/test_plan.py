"""Designs, what is refused, and what makes two plans different."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.sweep import Plan, read_study

E, NU = "tissue.body.E", "tissue.body.nu"


def test_a_grid_has_all_combinations_the_last_key_first(bar: plica.Scene) -> None:
    plan = Plan.make(bar, {E: "10:30:3 kPa", NU: "0.2, 0.3"})
    assert plan.values.tolist() == [[e, nu] for e in (1e4, 2e4, 3e4) for nu in (0.2, 0.3)]
    assert plan.shape == (3, 2)
    assert plan.changes(1) == {E: 1e4, NU: 0.3}


def test_a_list_takes_values_in_step(bar: plica.Scene) -> None:
    plan = Plan.make(bar, {E: "10, 20 kPa", NU: [0.2, 0.3]}, design="list")
    assert plan.values.tolist() == [[1e4, 0.2], [2e4, 0.3]]


def test_a_latin_hypercube_has_one_case_in_each_slice_of_each_range(bar: plica.Scene) -> None:
    plan = Plan.make(bar, {E: "10:30 kPa", NU: "0.1:0.4"}, design="latin_hypercube", samples=50)
    for column, low, high in zip(plan.values.T, (1e4, 0.1), (3e4, 0.4), strict=True):
        slices = np.floor(50 * (column - low) / (high - low))
        assert sorted(slices.tolist()) == list(range(50))
    again = Plan.make(bar, {E: "10:30 kPa", NU: "0.1:0.4"}, design="latin_hypercube", samples=50)
    other = Plan.make(bar, {E: "10:30 kPa", NU: "0.1:0.4"}, design="latin_hypercube", samples=50, seed=2)
    assert np.array_equal(plan.values, again.values)
    assert not np.array_equal(plan.values, other.values)


def test_rows_of_a_sobol_design_differ_from_two_points_by_one_key_each(bar: plica.Scene) -> None:
    """Saltelli: A, then A with column k of B for each k, then B."""
    plan = Plan.make(bar, {E: "10:30 kPa", NU: "0.1:0.4"}, design="sobol", samples=8)
    assert len(plan) == 8 * (2 + 2)
    for first, one, other, last in plan.values.reshape(8, 4, 2):
        assert one.tolist() == [last[0], first[1]]
        assert other.tolist() == [first[0], last[1]]


def test_steps_of_a_morris_path_change_one_key_each(bar: plica.Scene) -> None:
    plan = Plan.make(bar, {E: "10:30 kPa", NU: "0.1:0.4"}, design="morris", samples=5)
    assert len(plan) == 5 * 3
    for path in plan.values.reshape(5, 3, 2):
        changed = [np.flatnonzero(step).tolist() for step in np.diff(path, axis=0)]
        assert sorted(changed) == [[0], [1]]


def test_a_whole_number_stays_one(bar: plica.Scene) -> None:
    plan = Plan.make(bar, {"mesh.divisions[0]": "2:6:3"})
    assert [plan.changes(k) for k in range(3)] == [{"mesh.divisions[0]": n} for n in (2, 4, 6)]
    assert bar.replace(plan.changes(2)).mesh.divisions[0] == 6


@pytest.mark.parametrize(
    ("vary", "given", "why"),
    [
        ({}, {}, "no key is varied"),
        ({"tissue.body.Y": "1 kPa"}, {}, "tissue.body.Y is not known"),
        ({E: "10:30 kPa"}, {}, 'must have values, e.g. "0.4:1.2:9 kPa", in a design "grid"'),
        ({E: "10, 30 kPa"}, {"design": "sobol", "samples": 8}, 'must have a range, e.g. "0.4:1.2 kPa"'),
        ({E: "10, 10 kPa"}, {}, "has a value twice"),
        (
            {E: "10, 20 kPa", NU: "0.2"},
            {"design": "list"},
            "E 2, tissue.body.nu 1; must be equal",
        ),
        ({E: "10, 20 kPa"}, {"design": "cross"}, 'design = "cross"; must be one of'),
        ({E: "10, 20 kPa"}, {"samples": 3}, "samples = 3; must be left out"),
        ({E: "10, 20 kPa"}, {"seed": 3}, "seed = 3; must be left out"),
        ({E: "10:20 kPa"}, {"design": "sobol"}, "samples is left out; must be the number of points"),
        ({E: "10:20 kPa"}, {"design": "sobol", "samples": 12}, "must be a power of 2"),
        ({E: "10:20 kPa"}, {"design": "morris", "samples": 0}, "samples is 0; must be the number of paths"),
        ({"mesh.divisions[0]": "2:6"}, {"design": "morris", "samples": 2}, "is a whole number"),
        ({E: "1:2:1000 kPa", NU: "0:0.4:1001"}, {}, "the plan has 1001000 cases; must be at most 1000000"),
        ({E: "10, 20 kPa"}, {"waveforms": ["kinetic"]}, 'Did you mean "kinetic_energy"'),
        ({E: "10, 20 kPa"}, {"waveforms": ["probes"]}, "must be one with a number a step"),
        (
            {"time.step": "1, 2 us"},
            {"waveforms": ["kinetic_energy"]},
            "waveforms with time.step",
        ),
        ({E: "10, 20 kPa"}, {"keep": "all"}, 'keep = "all"; must be one of measures, runs'),
    ],
)
def test_what_is_no_plan_is_refused(vary: Any, given: Any, why: str, bar: plica.Scene) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        Plan.make(bar, vary, **given)
    assert str(error.value).startswith("sweep: ")
    assert why in str(error.value)


def test_a_case_has_the_digest_of_what_it_is_of(bar: plica.Scene) -> None:
    plan = Plan.make(bar, {E: "10, 20 kPa"})
    wider = Plan.make(bar, {E: "20, 30 kPa"})
    longer = Plan.make(bar.replace({"time.duration": "8 ms"}), {E: "10, 20 kPa"})
    digests = [one.case_digest(k) for one in (plan, longer) for k in (0, 1)]
    assert len(set(digests)) == 4
    assert wider.case_digest(0) == plan.case_digest(1)


def test_a_basis_counts_by_what_is_in_it(bar: plica.Scene, tmp_path: Path) -> None:
    digests = []
    for name, text in (("a.h5", "one"), ("b.h5", "one"), ("c.h5", "two")):
        (tmp_path / name).write_text(text)
        scene = bar.replace({"reduction": {"basis": tmp_path / name}})
        digests.append(Plan.make(scene, {E: "10 kPa"}).case_digest(0))
    assert digests[0] == digests[1] != digests[2]
    with pytest.raises(plica.InvalidInput, match="there is no such file"):
        _ = Plan.make(bar.replace({"reduction": {"basis": tmp_path / "d.h5"}}), {E: "10 kPa"}).record


def test_a_study_is_the_plan_that_it_says(bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "bar.toml")
    study = tmp_path / "study.toml"
    study.write_text(
        'scene = "bar.toml"\ndesign = "list"\nwaveforms = ["kinetic_energy"]\n'
        '[vary]\ntissue.body.E = "10, 20 kPa"\n"tissue.body.nu" = [0.2, 0.3]\n'
    )
    plan = Plan.make(bar, {E: "10, 20 kPa", NU: "0.2, 0.3"}, design="list", waveforms=["kinetic_energy"])
    assert read_study(study).record == plan.record


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('[vary]\ntissue.body.E = "1 kPa"', "scene is missing"),
        ('scene = "bar.toml"', "vary is missing"),
        ('scene = "bar.toml"\nsample = 3\n[vary]', 'Did you mean "samples"'),
        ('scene = "bar.toml"\nsamples = "3"\n[vary]', 'samples = "3"; must be a whole number'),
        ('scene = "bar.toml"\nwaveforms = [1]\n[vary]', "must be a list of texts"),
        ('scene = "bar.toml"\nvary = 3', "vary = 3; must be a table"),
        ('scene = "bar.toml"\n[vary]\ntissue.body.E = "1"', "the text has no unit"),
        ('scene = "none.toml"\n[vary]\ntissue.body.E = "1 kPa"', "there is no such file"),
        ("scene =", "not TOML"),
    ],
)
def test_a_study_that_is_none_is_refused(text: str, why: str, bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "bar.toml")
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(plica.InvalidInput) as error:
        read_study(tmp_path / "study.toml")
    assert why in str(error.value)
