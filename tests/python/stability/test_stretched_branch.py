"""Equilibria of tissue at finite strain with the flow: runs that stay there or end there, and where there is
none."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import plica
from flow_folds import folds
from plica.runs.build import equilibrium_branch

TRACT = {"uniform": {"length": "17 cm", "area": "3 cm^2"}, "wall": "yielding"}
TRACHEA = {"uniform": {"length": "20 cm", "area": "2.5 cm^2"}, "supply": {"pressure": {"reflection": 0.2}}}
POSTURE = {"posture": {"elongation": 0.05}, "tissue.cover.stiffening": 2.0}


def voice(pressure: float = 100.0, **changes: Any) -> plica.Scene:
    """Folds at finite strain, soft enough to be moved far."""
    given = {"strain": "finite", "airflow.subglottal_pressure": pressure}
    return folds(gap=2e-4, stiffness=0.5).replace(given).replace(changes)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"gravity": (0.0, 0.0, -9.81), "trachea": TRACHEA, "tract": TRACT},
        {**POSTURE, "symmetry": "quarter"},
    ],
    ids=["rest", "gravity and tubes", "posture and symmetry"],
)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_a_run_that_begins_there_stays_there(changes: dict[str, Any], tolerance: float) -> None:
    scene = voice(initial={"equilibrium": "flow"}, **changes)
    scene = scene.replace({"airflow.coupling": {"iterated": {"tolerance": tolerance}}})
    run = plica.build_simulation(scene)
    begun = np.array(run.displacement)
    from_rest = plica.build_simulation(scene.replace({"initial": None}))
    assert np.abs(run.acceleration).max() < 1e-6 * np.abs(from_rest.acceleration).max()
    names = ["section_area", "section_pressure", "flow"]
    waves = run.advance(round(10e-3 / scene.time.step), names)
    assert np.abs(begun).max() > 1e-5
    assert np.abs(np.asarray(run.displacement) - begun).max() < 1e-8 * np.abs(begun).max()
    for name in names:
        values = np.asarray(waves[name])
        assert np.ptp(values, axis=0).max() < 1e-8 * np.abs(values).max(), name


def test_under_small_pressures_it_is_that_of_linear_tissue_to_second_order() -> None:
    scene, off = voice(), []
    linear = equilibrium_branch(scene.replace({"strain": None}))
    finite = equilibrium_branch(scene)
    for pressure in (0.4, 0.2, 0.1, 0.05):  # friction alone, which is linear
        own, other = finite.at(pressure).displacement, linear.at(pressure).displacement
        off.append(np.abs(own - other).max())
        assert off[-1] > 1e-5 * np.abs(other).max()
    for more, less in pairwise(off):
        assert more / less == pytest.approx(4, rel=0.1)


def test_motion_that_dies_away_ends_there() -> None:
    scene = voice(300.0, **{"time.step": "1 ms", "time.duration": "1 s", "airflow.rise": "10 ms"})
    for layer in scene.tissue:
        scene = scene.replace({f"tissue.{layer}.viscosity": 5.0})
    scene = scene.replace({"strain": {"finite": {"tolerance": 1e-9}}})
    run = plica.build_simulation(scene)
    run.advance(300, [])
    found = plica.flow_equilibrium(scene).displacement
    linear = plica.flow_equilibrium(scene.replace({"strain": None})).displacement
    size = np.abs(found).max()
    assert np.abs(found - linear).max() > 5e-3 * size
    np.testing.assert_allclose(np.asarray(run.displacement), found, rtol=0, atol=1e-8 * size)


def test_a_branch_does_not_depend_on_the_order_in_which_it_is_asked() -> None:
    branch = equilibrium_branch(voice())
    for pressure in (300.0, 100.0, 200.0):
        own = equilibrium_branch(branch.scene).at(pressure)
        np.testing.assert_allclose(branch.at(pressure).area, own.area, rtol=1e-8)
        size = np.abs(own.displacement).max()
        np.testing.assert_allclose(
            branch.at(pressure).displacement, own.displacement, rtol=0, atol=1e-8 * size
        )


def test_where_it_ends_is_told() -> None:
    with pytest.raises(
        plica.SolveFailed, match=r"the one that begins at rest ends at .* Pa, with an area of"
    ):
        plica.flow_equilibrium(voice(), 1e5)
