"""Small oscillations of folds whose air has inertia in the glottis."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import splu

import plica
from flow_folds import folds, grown, stepped
from plica.stability.small_motion import SmallMotion
from section_pressures import SectionPressures

INERTIA = {"airflow.model": {"viscous_slit": {"inertance": True}}}
TRACHEA = {"uniform": {"length": "20 cm", "area": "2.5 cm^2"}, "supply": {"pressure": {"reflection": 0.2}}}
TRACT = {"uniform": {"length": "17 cm", "area": "3 cm^2"}, "wall": "yielding"}


class WithInertance(SectionPressures):
    """The section pressures' equation of all displacements, with the drop without inertance beside them."""

    def determinant(self, s: complex, impedances: Any = None) -> complex:
        moved = splu((s * s * self.M + s * self.C + self.K).tocsc()).solve(self.B)
        areas = self.A @ moved
        rates = s * np.asarray(self.tangent.pressure_by_expansion) @ (self.B.T @ moved)[:-2]
        count, tangent = len(self.slope), self.tangent
        by_area, by_drop = np.asarray(tangent.momentum_by_area), np.asarray(tangent.momentum_by_drop)
        matrix = np.zeros((count + 1, count + 1), dtype=complex)
        beyond = by_area[-1] - by_area
        matrix[:-1, :-1] = np.eye(count) - (self.slope + s * beyond) @ areas[:, :count] - rates[:, :count]
        matrix[:-1, -1] = -np.asarray(tangent.pressure_by_drop) - s * (by_drop[-1] - by_drop)
        matrix[-1, :-1] = s * by_area[-1] @ areas[:, :count]
        matrix[-1, -1] = 1 + s * by_drop[-1]
        return complex(np.linalg.det(matrix))


def test_pairs_are_roots_of_the_equation_of_section_pressures() -> None:
    motion = SmallMotion(folds(gap=2e-4, symmetry="quarter", **INERTIA), 60)
    own = WithInertance(folds(gap=2e-4, **INERTIA), 500.0)
    found = motion.spectrum(500.0).pairs  # those of motions that move areas
    without = plica.growth(folds(gap=2e-4, symmetry="quarter"), 500.0, modes=60)
    assert np.abs(without - found[0]).min() > 1e-3 * abs(found[0])  # it matters
    for s in found[:1]:
        assert abs(own.root(s) - s) < 2e-4 * abs(s)


@pytest.mark.parametrize(
    ("tubes", "pressure", "steps"),
    [
        ({}, 900.0, 1500),
        ({"trachea": TRACHEA}, 1200.0, 1500),
        ({"tract": TRACT}, 900.0, 700),
        ({"trachea": TRACHEA, "tract": TRACT}, 1000.0, 1000),
    ],
)
def test_oscillations_with_inertance_grow_in_time_steps_as_their_pair_says(
    tubes: dict[str, Any], pressure: float, steps: int
) -> None:
    motion = SmallMotion(folds(gap=2e-4, symmetry="quarter", **tubes, **INERTIA), 40)
    found = motion.spectrum(pressure, vectors=True)
    s = found.pairs[0]
    without = plica.growth(folds(gap=2e-4, symmetry="quarter", **tubes), pressure, modes=40)
    assert np.abs(without - s).min() > 2e-3 * abs(s)
    assert found.vectors is not None
    shape = (motion.shapes @ found.vectors[:, 0]).reshape(-1, 3)
    shape *= 1e-8 / np.abs(shape).max()
    start = (found.equilibrium.displacement + shape.real, (s * shape).real)
    areas = stepped(motion.scene, pressure, start, steps, motion.shapes, motion.mesh)
    growth = grown(areas - found.equilibrium.area, motion.scene.time.step, skip=0.6 if tubes else 0.3)
    assert growth.real == pytest.approx(s.real, abs=0.01 * abs(s.real) + 1e-4 * abs(s))
    assert growth.imag == pytest.approx(s.imag, rel=1e-3)


def test_the_equilibrium_is_that_without_inertance() -> None:
    one = plica.flow_equilibrium(folds(gap=2e-4, **INERTIA), 600.0)
    other = plica.flow_equilibrium(folds(gap=2e-4), 600.0)
    np.testing.assert_array_equal(one.area, other.area)
    areas = stepped(folds(gap=2e-4, **INERTIA), 600.0, (one.displacement, None), 30)
    np.testing.assert_allclose(areas[-1], one.area, rtol=1e-6)
