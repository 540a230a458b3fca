"""The static equilibrium under the flow: its equation, steps that stay there, and where there is none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

import plica
from benchmarks.voice.onset_steps import scene_of
from flow_folds import folds, stepped
from plica import _engine
from plica.runs.build import build_simulation, equilibrium_branch, fixed_components
from plica.runs.flow_equilibrium import EquilibriumBranch
from plica.scene.mesh.build import build_mesh


@pytest.fixture(scope="module")
def branch() -> EquilibriumBranch:
    return equilibrium_branch(folds(gap=2e-4))


def test_elastic_forces_are_those_of_the_flow_through_the_areas() -> None:
    scene = folds(gap=2e-4, gravity=(0.0, 0.0, -9.81))
    mesh = build_mesh(scene.mesh)
    found = plica.flow_equilibrium(scene, mesh=mesh)
    simulation = build_simulation(scene, mesh)
    flow = _engine.GlottalFlow(simulation)
    free = ~fixed_components(scene, mesh).ravel()
    x = np.asarray(mesh.points) + found.displacement
    widths = csr_array(flow.width_map(), shape=(len(flow.width_spacing()), len(x))) @ x[:, 0]
    areas = flow.areas(widths)
    pressure, volume = flow.evaluate(areas, 800.0, 0.0)
    patterns = csr_array(flow.load_patterns(), shape=(x.size, len(areas) + 2))
    K, M = (csr_array(m, shape=(x.size, x.size)) for m in (simulation.stiffness, simulation.mass))
    load = patterns @ np.concatenate((pressure, (800.0, 0.0))) + M @ np.tile((0.0, 0.0, -9.81), len(x))
    left = (K @ found.displacement.ravel() - load)[free]
    assert np.abs(left).max() < 1e-8 * np.abs(load[free]).max()
    assert np.abs(found.displacement).max() > 1e-5
    np.testing.assert_allclose(found.area, areas, rtol=1e-12)
    assert found.flow == pytest.approx(volume, rel=1e-10)
    assert found.residual < 1e-10


def test_time_steps_that_begin_there_stay_there() -> None:
    scene = folds(gap=2e-4)
    mesh = build_mesh(scene.mesh)
    found = plica.flow_equilibrium(scene, 150.0, mesh)
    areas = stepped(scene, 150.0, (found.displacement, None), 60, mesh=mesh)
    rest = plica.flow_equilibrium(scene, 1.0, mesh)
    assert np.abs(found.area - rest.area).max() > 1e-3 * rest.area.max()
    np.testing.assert_allclose(areas[-1], found.area, rtol=1e-6)


def test_small_pressures_move_in_proportion(branch: EquilibriumBranch) -> None:
    one, two = branch.at(1e-5).displacement, branch.at(2e-5).displacement
    assert np.abs(one).max() > 0
    np.testing.assert_allclose(two, 2 * one, atol=1e-4 * np.abs(two).max())  # friction alone


def test_a_branch_does_not_depend_on_the_order_in_which_it_is_asked(branch: EquilibriumBranch) -> None:
    for pressure in (700.0, 300.0, 500.0):
        own = equilibrium_branch(branch.scene).at(pressure)
        np.testing.assert_allclose(branch.at(pressure).area, own.area, rtol=1e-8)


@pytest.mark.slow
def test_of_two_equilibria_at_one_pressure_the_branch_leads_to_its_own() -> None:
    """At 500 Pa these folds have another one, 0.7 % narrower at another section, to which long steps lead."""
    scene = scene_of("normal_phonation", {"gap": 3e-4}, "coarse")
    branch = equilibrium_branch(scene)
    at_once = branch.at(500.0)
    again = equilibrium_branch(scene)
    for pressure in np.arange(20.0, 501.0, 20.0):
        slowly = again.at(float(pressure))
    np.testing.assert_allclose(at_once.area, slowly.area, rtol=1e-6)
    assert at_once.area.argmin() == slowly.area.argmin()


def test_folds_of_unequal_tissue_move_unequally() -> None:
    scene = folds(gap=2e-4).replace({"tissue.cover.left": {"E": 500.0}})
    mesh = build_mesh(scene.mesh)
    moved = plica.flow_equilibrium(scene, 300.0, mesh).displacement
    sides = [np.unique(np.asarray(mesh.surfaces[name])) for name in ("airway_left", "airway_right")]
    left, right = (np.abs(moved[side]).max() for side in sides)
    assert left > 1.1 * right


def test_symmetry_reduction_and_start_play_no_part() -> None:
    scene = folds(gap=2e-4)
    quarter = scene.replace(
        {"symmetry": "quarter", "initial": {"opening_velocity": 0.1}, "airflow.rise": 1e-3}
    )
    one, other = plica.flow_equilibrium(scene, 300.0), plica.flow_equilibrium(quarter, 300.0)
    np.testing.assert_array_equal(one.displacement, other.displacement)


@pytest.mark.parametrize(
    ("changes", "pressure", "kind", "text"),
    [
        ({"airflow": None}, None, plica.InvalidInput, "airflow is missing"),
        ({"airflow.load_shape": "current"}, None, plica.InvalidInput, 'load_shape = "current"; must be'),
        (
            {"loads": [{"surface": "airway", "traction": (0.0, 0.0, 1.0), "frequency": 50.0}]},
            None,
            plica.InvalidInput,
            "loads[0].frequency = 50 Hz; must be 0",
        ),
        ({"supports": None}, None, plica.InvalidInput, "rigid motion"),
        ({}, -1.0, plica.InvalidInput, "pressure = -1 Pa; must be"),
        ({}, "1 mm", plica.InvalidInput, "pressure"),
        ({}, 1e7, plica.InvalidInput, "pressure = 1e+07 Pa; must be"),
        ({}, 1e5, plica.SolveFailed, "Take a"),
    ],
)
def test_what_has_no_equilibrium_is_told(
    changes: dict[str, Any], pressure: Any, kind: type[Exception], text: str
) -> None:
    scene = folds(gap=2e-4)
    if "supports" in changes:
        scene = scene.replace(
            {"mesh": plica.Larynx(larynx="thesis_coarse"), "supports": plica.Supports(fixed=[])}
        )
    else:
        scene = scene.replace(changes)
    with pytest.raises(kind) as error:
        plica.flow_equilibrium(scene, pressure)
    assert text in str(error.value)


def test_folds_that_overlap_at_rest_are_refused_with_the_place() -> None:
    scene = folds(gap=2e-4)
    loads = [{"surface": "airway", "traction": (0.0, 0.0, 0.0)}]
    pressed = scene.replace({"loads": loads})
    assert plica.flow_equilibrium(pressed, 10.0).flow > 0
    closing = [
        plica.Load(surface=name, traction=(sign * 3000.0, 0.0, 0.0))
        for name, sign in (("airway_left", 1.0), ("airway_right", -1.0))
    ]
    with pytest.raises(
        plica.InvalidInput, match=r"width of the glottis at rest = -.* mm at z = .* mm; must be > 0"
    ):
        plica.flow_equilibrium(scene.replace({"loads": closing}), 10.0)
