"""A subglottal pressure that changes over time: key, waveform, and what of a run is measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from analytic_run import AnalyticRun, Phonation
from flow_folds import folds
from interrupted_runs import assert_resumes_to_the_bit
from plica.measures.run.measure import measure, steady_cycles
from plica.scene.mesh.build import build_mesh
from plica.scene.plausibility import scene_cautions
from plica.uncertainty.plan import plan_levels
from plica.uncertainty.start import Start

POINTS: dict[str, Any] = {
    "time": ["0.4 ms", "1.2 ms", "1.6 ms"],
    "pressure": ["0.8 kPa", "0.2 kPa", "0.3 kPa"],
}
TUBES = {
    "trachea": {
        "uniform": {"length": "12 cm", "area": "2.5 cm^2"},
        "supply": {"pressure": {"reflection": 0.7}},
    },
    "tract": {"vowel": {"name": "a"}},
}
EXPLICIT = {"time.scheme": "central_differences", "time.step": 5e-7, "contact": None}


def expected(time: Any) -> np.ndarray:
    return np.interp(time, [0.4e-3, 1.2e-3, 1.6e-3], [800.0, 200.0, 300.0])


def of_course(scene: plica.Scene, **changes: Any) -> plica.Scene:
    course = {"airflow.course": POINTS, "airflow.subglottal_pressure": None}
    return scene.replace({**course, "time.duration": "2 ms", **changes})


def test_the_scene_has_the_greatest_pressure_of_its_course(phonating: plica.Scene) -> None:
    airflow = of_course(phonating).airflow
    assert airflow is not None
    assert airflow.subglottal_pressure == 800.0
    assert plica.Scene.from_text(of_course(phonating).text()) == of_course(phonating)
    given = plica.Airflow(course=POINTS, subglottal_pressure="800 Pa")
    assert given == plica.Airflow(course=plica.Course(**POINTS))


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"time": ["1 ms"]}, "airflow.course.time"),
        (
            {"time": ["1 ms", "1 ms", "2 ms"]},
            "time[1] = 0.001 s; must be > the one before, 0.001 s.",
        ),
        ({"time": ["-1 ms", "1 ms", "2 ms"]}, "must be >= 0. Is the sign right?"),
        ({"pressure": ["1 kPa", "2 kPa"]}, "must have as many entries as time, 3."),
        ({"pressure": [0, 0, 0]}, "airflow.course.pressure = [0.0, 0.0, 0.0] Pa; must have one > 0 Pa."),
        ({"pressure": [800, -1, 0]}, "must be >= 0. Is the sign right?"),
        ({"pressure": ["1 s", 1, 0]}, "airflow.course.pressure"),
        ({"points": 3}, "airflow.course.points is not known"),
    ],
)
def test_what_is_no_course_is_told(phonating: plica.Scene, changes: dict[str, Any], text: str) -> None:
    with pytest.raises(plica.SceneError) as error:
        phonating.replace({"airflow.course": POINTS | changes, "airflow.subglottal_pressure": None})
    assert text in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("pressure", "text"),
    [(700.0, "= 700.0 Pa; must be the greatest of airflow.course, 800 Pa"), (0, "= 0 Pa; must be > 0")],
)
def test_another_subglottal_pressure_is_refused(phonating: plica.Scene, pressure: float, text: str) -> None:
    with pytest.raises(plica.SceneError) as error:
        phonating.replace({"airflow.course": POINTS, "airflow.subglottal_pressure": pressure})
    assert f"airflow.subglottal_pressure {text}" in str(error.value)


@pytest.mark.parametrize("kind", ["full", "quarter", "reduced", "lagged", "explicit"])
def test_every_step_has_the_pressure_of_its_load(phonating: plica.Scene, tmp_path: Path, kind: str) -> None:
    changes: dict[str, Any] = {"symmetry": "quarter"} if kind == "quarter" else {}
    changes |= EXPLICIT if kind == "explicit" else {}
    changes |= {"airflow.coupling": "lagged"} if kind == "lagged" else {}
    if kind == "reduced":
        plica.reduce(phonating, tmp_path / "basis.h5", modes=20, contact_vectors=20)
        changes = {"reduction": {"basis": str(tmp_path / "basis.h5")}}
    scene = of_course(phonating, **changes)
    found = plica.build_simulation(scene).advance(scene.time.steps, ["time", "subglottal_pressure"])
    step = scene.time.step
    ahead = -1.0 if kind == "lagged" else 0.0 if kind == "explicit" else -0.3  # of the end of the step
    wanted = expected(np.asarray(found["time"]) + ahead * step)
    assert np.ptp(wanted) == pytest.approx(600.0, rel=0.1)
    np.testing.assert_allclose(found["subglottal_pressure"], wanted, rtol=1e-12)


def test_behind_a_trachea_it_is_the_supply_that_changes(phonating: plica.Scene) -> None:
    scene = of_course(phonating, **TUBES)
    found = plica.build_simulation(scene).advance(scene.time.steps, ["time", "supply_rise"])
    wanted = expected(np.asarray(found["time"]) - 0.3 * scene.time.step) / 800.0
    np.testing.assert_allclose(found["supply_rise"], wanted, rtol=1e-12)


@pytest.mark.parametrize("closed", [False, True])
def test_a_course_rises_from_0(phonating: plica.Scene, closed: bool) -> None:
    tubes = {"tract": {"vowel": {"name": "a"}, "end": "closed"}} if closed else {}
    scene = of_course(phonating, **{"airflow.rise": "1 ms"}, **tubes)
    found = plica.build_simulation(scene).advance(scene.time.steps, ["time", "subglottal_pressure"])
    time = np.asarray(found["time"]) - 0.3 * scene.time.step
    share = 0.5 - 0.5 * np.cos(np.pi * np.minimum(time / 1e-3, 1.0))
    assert share[0] < 0.01
    np.testing.assert_allclose(found["subglottal_pressure"], share * expected(time), rtol=1e-12)


def test_a_course_that_stays_is_a_constant_pressure(phonating: plica.Scene) -> None:
    flat = of_course(phonating, **{"airflow.course": {"time": [0, 1e-3], "pressure": [800.0, 800.0]}})
    one, other = (plica.build_simulation(scene).advance(40) for scene in (phonating, flat))
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


def test_a_slow_fall_follows_the_equilibria() -> None:
    """Quasi-static: areas are those of the equilibrium under the pressure of the moment."""
    course = {"time": ["1 ms", "0.2 s"], "pressure": ["150 Pa", "50 Pa"]}
    scene = folds(gap=2e-4).replace(
        {
            "initial": {"equilibrium": "flow"},
            "airflow.course": course,
            "airflow.subglottal_pressure": None,
            "symmetry": "quarter",
            "time.duration": "0.1 s",
        }
    )
    found = plica.build_simulation(scene).advance(scene.time.steps, ["section_area", "subglottal_pressure"])
    areas = np.asarray(found["section_area"])
    np.testing.assert_allclose(areas[0], plica.flow_equilibrium(scene, 150.0).area, rtol=1e-9)
    last = plica.flow_equilibrium(scene, float(found["subglottal_pressure"][-1])).area
    moved = np.abs(last - areas[0]).max()
    assert moved > 0.01 * areas[0].min()
    assert np.abs(areas[-1] - last).max() < 0.01 * moved


@pytest.mark.slow
@pytest.mark.parametrize("tubes", [False, True])
def test_a_killed_run_is_continued_in_its_course_to_the_bit(
    phonating: plica.Scene, tmp_path: Path, tubes: bool
) -> None:
    scene = of_course(phonating, **(TUBES if tubes else {}))
    assert_resumes_to_the_bit(scene, tmp_path, 10)


def _under(run: AnalyticRun, pressure: np.ndarray) -> AnalyticRun:
    course = "course = { time = [0.0, 1.0], pressure = [800.0, 400.0] }"
    text = f"[airflow]\nsubglottal_pressure = 800.0\n{course}\n"
    return replace(run, waveforms=dict(run.waveforms, subglottal_pressure=pressure), scene_text=text)


def test_measures_under_a_pressure_that_moves_have_a_caution_and_its_mean() -> None:
    run = Phonation().run()
    falling = _under(run, np.interp(run.time, [0.0, run.time[-1]], [800.0, 400.0]))
    cycles = steady_cycles(falling)
    assert cycles.count >= 3
    (told,) = (one for one in falling.cautions if one.name == "moving_pressure")
    assert "moves by" in told.seen
    mean = falling.waveforms["subglottal_pressure"][cycles.extent(run.time)].mean()
    assert measure(falling)["subglottal_pressure"].value == pytest.approx(mean)
    assert 450 < mean < 750


def test_where_the_pressure_stays_long_enough_only_that_is_measured() -> None:
    run = Phonation().run()
    half = 0.5 * run.time[-1]
    rests = _under(run, np.interp(run.time, [0.0, half], [800.0, 400.0]))
    assert steady_cycles(rests).starts[0] >= half
    assert not [one for one in rests.cautions if one.name == "moving_pressure"]
    assert measure(rests)["subglottal_pressure"].value == 400.0


def test_a_course_that_the_run_does_not_reach_the_end_of_is_cautioned_of(phonating: plica.Scene) -> None:
    mesh = build_mesh(phonating.mesh)
    for duration, cautioned in (("1.5 ms", True), ("1.6 ms", False)):
        scene = of_course(phonating, **{"time.duration": duration})
        assert cautioned == any("airflow.course" in str(one) for one in scene_cautions(scene, mesh))


def test_levels_that_begin_in_the_voice_are_refused(phonating: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(of_course(phonating), tmp_path / "run", progress=False)
    begun = Start(1e-3, np.zeros((1, 3)), np.zeros((1, 3)))
    with pytest.raises(plica.InvalidInput, match=r"airflow\.course is given; must be left out"):
        plan_levels(run, steady_cycles(Phonation().run()), begun, tmp_path, budget=1.0, other="none")
