"""Equilibria of tissue at finite strain: closed forms, a second algorithm, linear tissue under small loads,
and where there is none."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import fsolve, root

import plica
from flow_folds import folds
from plica import _engine
from plica.scene.mesh.changed import changed_mesh
from stretched_bodies import DENSITY, FIBRED, Law, block, consistent_mass, tissue_force

STIFFENING, MATRIX = 2.0, 3.0


def fibred(**fields: float) -> Any:
    given = {"density": DENSITY, "stiffening": STIFFENING, "matrix_stiffening": MATRIX}
    return _engine.Material(_engine.TransverselyIsotropic(**FIBRED), **given | fields)


def rest(mesh: Any, material: Any, fixed: Any, **loads: Any) -> np.ndarray:
    layers = np.zeros(len(mesh.cells), dtype=np.int32)
    return np.asarray(
        _engine.equilibrium(mesh, [material], ["bar"], layers, fixed, finite_strain=True, **loads)
    )


def pulled(surface: str, *traction: float) -> Any:
    return [_engine.Load(surface=surface, traction=traction)]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("pull", [20e3, -2e3])
def test_a_bar_under_a_dead_load_has_the_stretch_of_its_law(order: int, pull: float) -> None:
    """Nominal stress along the fibre, none across it."""
    mesh, law = block((1, 4, 1), (1e-3, 8e-3, 1e-3), order), Law(STIFFENING, MATRIX)
    x = np.asarray(mesh.points)
    found = rest(mesh, fibred(), x == 0, loads=pulled("y_max", 0.0, pull, 0.0))

    def left(stretch: np.ndarray) -> np.ndarray:
        P = law.stress(np.diag([stretch[0], stretch[1], stretch[0]]))
        return np.array([P[0, 0], P[1, 1] - pull])

    across, along = fsolve(left, [1.0, 1.0 + pull / 50e3], xtol=1e-14)
    assert abs(along - 1) > 0.03
    np.testing.assert_allclose(found, (np.array([across, along, across]) - 1) * x, rtol=0, atol=1e-13)


def test_a_bar_bent_far_is_that_of_a_second_algorithm() -> None:
    """Held at one end, bent by its weight and a traction: Powell's method on the forces of tetrahedra."""
    mesh = block((1, 4, 1), (2e-3, 8e-3, 3e-3))
    x = np.asarray(mesh.points)
    fixed = np.repeat((x[:, 1] == 0)[:, None], 3, axis=1)
    gravity = (30.0, 0.0, -20.0)
    found = rest(mesh, fibred(), fixed, gravity=gravity, loads=pulled("x_max", 100.0, 0.0, 20.0))
    end = np.zeros_like(x)
    for face in np.asarray(mesh.surfaces["x_max"]):
        a, b, c = x[face]
        end[face] += np.linalg.norm(np.cross(b - a, c - a)) / 6 * np.array([100.0, 0.0, 20.0])
    force, volume = tissue_force(mesh, Law(STIFFENING, MATRIX))
    load, free = end + consistent_mass(mesh, volume).sum(axis=1)[:, None] * np.array(gravity), ~fixed

    def left(values: np.ndarray) -> np.ndarray:
        u = np.zeros_like(x)
        u[free] = values
        return 1e3 * (force(u) - load)[free]

    start, exact = np.zeros(free.sum()), np.zeros_like(x)
    solved = root(left, start, tol=1e-14)
    exact[free] = solved.x
    assert np.abs(left(solved.x)).max() < 1e-9 * np.abs(1e3 * load).max()
    assert np.abs(exact).max() > 1e-3  # an eighth of the length
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8 * np.abs(exact).max())


def voice(**changes: Any) -> plica.Scene:
    """A larynx at finite strain, under gravity and a traction on its folds."""
    heavy = {
        "gravity": (1.0, 0.0, -9.81),
        "loads": [{"surface": "airway", "traction": (0.0, 0.0, 40.0)}],
        "strain": "finite",
        "tissue.cover.stiffening": 2.0,
    }
    return folds(gap=2e-4).replace(heavy | changes)


def test_under_small_loads_it_is_that_of_linear_tissue_to_second_order() -> None:
    for posture in (None, {"elongation": 0.1}):
        scene, off = voice(posture=posture), []
        for share in (1.0, 0.5, 0.25, 0.125):
            less = scene.replace(
                {
                    "gravity": tuple(share * g for g in scene.gravity or ()),
                    "loads": [{"surface": "airway", "traction": (0.0, 0.0, 40.0 * share)}],
                }
            )
            own, linear = plica.equilibrium(less), plica.equilibrium(less.replace({"strain": None}))
            off.append(np.abs(own - linear).max())
            assert off[-1] > 1e-5 * np.abs(linear).max()
        for more, few in pairwise(off):
            assert more / few == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"mesh.order": 2},
        {"posture": {"elongation": 0.05}, "symmetry": "quarter", "gravity": (0.0, 0.0, -9.81)},
        {"posture": {"active_stress": {"body": "5 kPa"}}},
    ],
    ids=["rest", "quadratic", "posture and symmetry", "active"],
)
def test_a_run_that_begins_there_stays_there(changes: dict[str, Any]) -> None:
    scene = voice(airflow=None, initial={"equilibrium": True}, **changes)
    run = plica.build_simulation(scene)
    begun = np.array(run.displacement)
    assert np.abs(begun).max() > 1e-5
    waves = run.advance(50)
    assert np.abs(np.asarray(run.displacement) - begun).max() < 1e-9 * np.abs(begun).max()
    assert waves["kinetic_energy"].max() < 1e-20 * np.abs(waves["elastic_energy"]).max()


def test_motion_that_dies_away_ends_there() -> None:
    scene = voice(airflow=None, **{"time.step": "2 ms", "time.duration": "2 s"})
    for layer in scene.tissue:
        scene = scene.replace({f"tissue.{layer}.viscosity": 40.0})
    scene = scene.replace({"strain": {"finite": {"tolerance": 1e-9}}})
    run = plica.build_simulation(scene)
    run.advance(600)
    found = plica.equilibrium(scene)
    linear = plica.equilibrium(scene.replace({"strain": None}))
    size = np.abs(found).max()
    assert np.abs(found - linear).max() > 1e-2 * size
    np.testing.assert_allclose(np.asarray(run.displacement), found, rtol=0, atol=1e-7 * size)


def column(compressed: float) -> np.ndarray:
    """A column of nu = 0 held at one end, pushed along its axis by this pressure (Pa)."""
    mesh = block((1, 8, 1), (1e-3, 20e-3, 1e-3), order=2)
    x = np.asarray(mesh.points)
    fixed = np.repeat((x[:, 1] == 0)[:, None], 3, axis=1)
    material = _engine.Material(_engine.Isotropic(E=10e3, nu=0.0), density=DENSITY)
    return rest(mesh, material, fixed, loads=pulled("y_max", 0.0, -compressed, 0.0))


def test_a_column_bears_no_more_than_eulers_load() -> None:
    euler = np.pi**2 * 10e3 * (1e-3 / 20e-3) ** 2 / 48  # Pa: pi^2 E I / (4 L^2 A)
    assert np.abs(column(0.95 * euler)[:, [0, 2]]).max() < 1e-9
    with pytest.raises(plica.SolveFailed) as error:
        column(2 * euler)
    said = str(error.value)
    share = float(said.removeprefix("Scene: no equilibrium beyond ").split(" % of gravity and loads: ")[0])
    assert share == pytest.approx(50, abs=1.5)
    assert said.endswith("the tissue buckles. Take less of them, stiffer tissue, or hold more of its nodes.")


def test_what_has_none_is_told_by_its_scene() -> None:
    crushed = voice(loads=[{"surface": "airway", "traction": (0.0, 0.0, 1e6)}])
    with pytest.raises(plica.SolveFailed, match=r"^Scene: no equilibrium beyond .* % of gravity and loads: "):
        plica.equilibrium(crushed)
    free = voice(supports={"fixed": []})
    for call in (plica.equilibrium, plica.flow_equilibrium):
        with pytest.raises(plica.SceneError, match=r"can (shift|turn).*must be held for an equilibrium"):
            call(free)
    printed = folds().replace({"strain": "finite", "tissue": "thesis"})
    with pytest.raises(plica.SceneError, match=r"mu_transverse = .* with strain: stretched tissue is"):
        plica.equilibrium(printed)


@pytest.mark.parametrize("gravity", [2.0, 3.0, 6.0, 12.0])
def test_an_arch_beyond_its_limit_load_is_refused_and_does_not_snap_through(gravity: float) -> None:
    """At 1.46 m/s^2 it gives way; Newton's method finds the shapes beyond from some loads."""
    bar = block((16, 1, 1), (20e-3, 1e-3, 0.6e-3), order=2)
    x = np.array(bar.points)
    fixed = np.repeat(((x[:, 0] == 0) | (x[:, 0] == 20e-3))[:, None], 3, axis=1)
    fixed[:, 1] = True
    x[:, 2] += 1.5e-3 * np.sin(np.pi * x[:, 0] / 20e-3)
    arch = changed_mesh(bar, points=x)
    soft = _engine.Material(_engine.Isotropic(E=10e3, nu=0.0), density=1000.0)
    below = rest(arch, soft, fixed, gravity=(0, 0, -1.4))
    assert -0.7e-3 < below[:, 2].min() < -0.3e-3
    with pytest.raises(plica.SolveFailed, match="no equilibrium beyond") as failure:
        rest(arch, soft, fixed, gravity=(0, 0, -gravity))
    reached = float(re.findall(r"beyond ([0-9.]+) %", str(failure.value))[0]) / 100 * gravity
    assert reached == pytest.approx(1.46, abs=0.06)
