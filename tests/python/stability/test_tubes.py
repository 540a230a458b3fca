"""Small oscillations of folds between a trachea and a vocal tract."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import plica
from flow_folds import folds, grown, stepped
from plica.runs.build import equilibrium_branch
from plica.stability.small_motion import SmallMotion

TRACHEA = {"uniform": {"length": "20 cm", "area": "2.5 cm^2"}, "supply": {"pressure": {"reflection": 0.2}}}
TRACT = {"uniform": {"length": "17 cm", "area": "3 cm^2"}, "wall": "yielding"}
TUBES = {"trachea": TRACHEA, "tract": TRACT}


def between(**tubes: Any) -> plica.Scene:
    return folds(gap=2e-4).replace(tubes)


def test_tubes_do_not_change_the_modes_without_air() -> None:
    scenes = between(**TUBES), folds(gap=2e-4)
    with_tubes, without = (plica.eigenmodes(scene, 2).frequency for scene in scenes)
    np.testing.assert_array_equal(with_tubes, without)


def test_a_steady_flow_pays_for_the_resistance_of_its_tubes() -> None:
    scene = between(**TUBES)
    branch = equilibrium_branch(scene)
    rest = branch.at(800.0)
    below, above = rest.pressure[-2:]
    assert below == pytest.approx(800.0 - branch.flow.trachea.steady_resistance * rest.flow, rel=1e-10)
    assert above == pytest.approx(branch.flow.tract.steady_resistance * rest.flow, rel=1e-8)
    assert above > 0
    areas = stepped(scene, 800.0, (rest.displacement, None), 30)
    np.testing.assert_allclose(areas[-1], rest.area, rtol=1e-6)


def test_tubes_as_wide_as_a_hall_are_none() -> None:
    hall = {"uniform": {"length": "10 cm", "area": "0.9 m^2"}}
    wide = between(trachea=hall, tract=hall)
    one = plica.growth(wide, 500.0, modes=40)
    other = plica.growth(folds(gap=2e-4), 500.0, modes=40)
    for s in other[:4]:
        assert np.abs(one - s).min() < 1e-4 * abs(s)


@pytest.mark.parametrize(
    ("tubes", "pressure", "steps"),
    [
        ({"trachea": TRACHEA}, 1000.0, 5000),  # others decay by 19 and 27 1/s
        ({"tract": TRACT}, 300.0, 2000),
        (TUBES, 400.0, 2000),
        (TUBES, 800.0, 2000),
    ],
)
def test_oscillations_between_tubes_grow_in_time_steps_as_their_pair_says(
    tubes: dict[str, Any], pressure: float, steps: int
) -> None:
    motion = SmallMotion(between(symmetry="quarter", **tubes), 40)
    found = motion.spectrum(pressure, vectors=True)
    s = found.pairs[0]
    without = plica.growth(folds(gap=2e-4, symmetry="quarter"), pressure, modes=40)
    assert np.abs(without - s).min() > 0.01 * abs(s)
    shape = (motion.shapes @ found.vectors[:, 0]).reshape(-1, 3)
    shape *= 1e-7 / np.abs(shape).max()
    start = (found.equilibrium.displacement + shape.real, (s * shape).real)
    areas = stepped(motion.scene, pressure, start, steps, motion.shapes, motion.mesh)
    growth = grown(areas - found.equilibrium.area, motion.scene.time.step, skip=0.6)  # sound has died away
    assert growth.real == pytest.approx(s.real, abs=0.01 * abs(s.real) + 1e-4 * abs(s))
    assert growth.imag == pytest.approx(s.imag, rel=1e-3)


def test_tubes_that_are_closed_or_fed_by_a_flow_are_refused() -> None:
    fed = {"uniform": {"length": "20 cm", "area": "2.5 cm^2"}, "supply": {"flow": {"flow": 1e-4}}}
    scene = between(trachea=fed, **{"airflow.rise": 5e-3})
    with pytest.raises(
        plica.InvalidInput, match="Trachea: the far end is closed, or supplied by a flow; must"
    ):
        plica.growth(scene, 500.0)
