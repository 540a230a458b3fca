"""Small oscillations: the section pressures' own equation, time steps, damping, fewer modes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plica
from flow_folds import folds, grown, stepped
from plica.stability.small_motion import Damping, SmallMotion
from section_pressures import SectionPressures

PRESSURE = 500.0


@pytest.fixture(scope="module")
def motion() -> SmallMotion:
    return SmallMotion(folds(gap=2e-4), 100)


def test_pairs_are_roots_of_the_equation_of_section_pressures(motion: SmallMotion) -> None:
    own = SectionPressures(motion.scene, PRESSURE)
    errors = []
    for modes in (25, 50, 100):
        found = motion.with_modes(modes).spectrum(PRESSURE).pairs[0]
        errors.append(abs(found - own.root(found)) / abs(found))
    assert 0 < errors[2] < 1e-4
    assert errors[2] < errors[0]


def ladder(length: float, area: float, elements: int) -> SimpleNamespace:
    """A tube whose far end is held, without friction, as the engine gives one."""
    density, speed = 1.23, 350.0
    part = length / elements
    storage = np.concatenate(
        (np.full(elements, part * area / (density * speed**2)), np.full(elements, density * part / area))
    )
    storage[0] *= 0.5
    between = np.eye(elements) - np.eye(elements, k=-1)
    zero = np.zeros((elements, elements))
    rates = np.block([[zero, -between], [between.T, zero]])
    return SimpleNamespace(storage=storage, rates=rates, steady_resistance=0.0)


def test_pairs_between_tubes_are_roots_of_the_equation_with_their_impedances(motion: SmallMotion) -> None:
    both = SmallMotion(motion.scene.replace({"symmetry": "quarter"}), 60, mesh=motion.mesh)
    without = both.spectrum(PRESSURE).pairs
    both.trachea, both.tract = ladder(0.25, 2.5e-4, 30), ladder(0.17, 1e-4, 20)
    own = SectionPressures(motion.scene, PRESSURE)

    def impedance(length: float, area: float, elements: int) -> Any:
        """Of the ladder in closed form: x = s part / 2 c, the sound's phase from node to node 2 asinh x."""

        def of(s: complex) -> complex:
            x = s * length / elements / (2 * 350.0)
            angle = 2 * elements * np.arcsinh(x)
            return complex(1.23 * 350.0 / area * np.tanh(angle) / np.sqrt(1 + x * x))

        return of

    impedances = (impedance(0.25, 2.5e-4, 30), impedance(0.17, 1e-4, 20))
    pairs = both.spectrum(PRESSURE).pairs
    assert np.abs(pairs[0] - without).min() > 1e-2 * abs(pairs[0])  # they matter
    for s in pairs[pairs.imag < 2 * np.pi * 1500][:6]:
        assert abs(own.root(s, impedances) - s) < 1e-3 * abs(s)


@pytest.mark.parametrize("pressure", [200.0, 500.0, 900.0])
def test_oscillations_grow_and_swing_in_time_steps_as_their_pair_says(
    motion: SmallMotion, pressure: float
) -> None:
    found = motion.spectrum(pressure, vectors=True)
    s = found.pairs[0]
    shape = (motion.shapes @ found.vectors[:, 0]).reshape(-1, 3)
    shape *= 1e-7 / np.abs(shape).max()
    start = (found.equilibrium.displacement + shape.real, (s * shape).real)
    areas = stepped(motion.scene, pressure, start, 1000, motion.shapes, motion.mesh)
    growth = grown(areas - found.equilibrium.area, motion.scene.time.step)
    assert growth.real == pytest.approx(s.real, abs=0.01 * abs(s.real) + 1e-4 * abs(s))
    assert growth.imag == pytest.approx(s.imag, rel=1e-3)


def test_with_hardly_any_flow_modes_have_their_damping(motion: SmallMotion) -> None:
    omega = np.sqrt(motion.squares)
    for damping, expected in (
        (Damping(ratio=0.06), omega * (-0.06 + 1j * np.sqrt(1 - 0.06**2))),
        (Damping(loss_factor=0.1), 1j * omega * np.sqrt(1 + 0.1j)),
    ):
        other = motion.with_modes(motion.modes)
        other.damping = damping
        other.loads = 1e-9 * motion.loads
        pairs = other.spectrum(1.0).pairs
        pairs = pairs[np.argsort(pairs.imag)]
        slow = expected[expected.imag < 2 * np.pi * 5e3]
        assert 30 < len(pairs) == len(slow)
        np.testing.assert_allclose(pairs, slow, rtol=1e-6)


def test_fewer_modes_are_those_that_a_basis_of_fewer_has(motion: SmallMotion) -> None:
    fewer, made = motion.with_modes(30), SmallMotion(motion.scene, 30, mesh=motion.mesh)
    np.testing.assert_allclose(
        fewer.spectrum(PRESSURE).pairs[:5], made.spectrum(PRESSURE).pairs[:5], rtol=1e-6
    )
    again = motion.with_modes(60).with_modes(30)
    np.testing.assert_allclose(
        again.spectrum(PRESSURE).pairs[:5], fewer.spectrum(PRESSURE).pairs[:5], rtol=1e-6
    )


def test_symmetric_oscillations_are_among_those_of_the_whole(motion: SmallMotion) -> None:
    quarter = SmallMotion(motion.scene.replace({"symmetry": "quarter"}), 60, mesh=motion.mesh)
    found, whole = quarter.spectrum(PRESSURE).pairs[:3], motion.spectrum(PRESSURE).pairs
    for s in found:
        assert np.abs(whole - s).min() < 2e-3 * abs(s)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"modes": 0}, "onset: modes = 0; must be a whole number in"),
        ({"modes": 1000}, "onset: modes = 1000"),
        ({"zeta": -0.1}, "onset: zeta = -0.1; must be"),
        ({"zeta": 1.5}, "onset: zeta = 1.5; must be"),
        ({"loss_factor": -1.0}, "onset: loss_factor = -1; must be"),
        ({"zeta": 0.1, "loss_factor": 0.1}, "must be one of them"),
        ({"pressure": -800.0}, "onset: at = -800 Pa; must be"),
        ({"pressure": "8 mm"}, "onset: at"),
        ({"pressure": "much"}, "onset: at"),
        ({"zeta": 0.0}, "zeta = 0"),
        ({"loss_factor": 0.0}, "loss_factor = 0"),
    ],
)
def test_arguments_out_of_range_are_refused(given: dict[str, object], text: str) -> None:
    pressure = given.pop("pressure", 500.0)
    with pytest.raises(plica.InvalidInput) as error:
        plica.growth(folds(gap=2e-4), pressure, **given)  # type: ignore[arg-type]
    assert text in str(error.value)


def test_tissue_without_any_damping_is_refused() -> None:
    with pytest.raises(plica.InvalidInput, match="no tissue has a viscosity; must be damped"):
        plica.growth(folds(gap=2e-4, viscosity=0.0), 500.0)
    assert len(plica.growth(folds(gap=2e-4, viscosity=0.0), 500.0, zeta=0.05))


class Pair(SmallMotion):
    """Two coordinates that the air couples: a force that does not derive from one takes them apart."""

    def matrix(self, rest: Any) -> Any:
        loss = self.damping.loss_factor
        stiff = 1e6 * np.eye(2) * (1 if loss is None else 1 + 1j * loss)
        damped = 1.0 * np.eye(2) if loss is None else np.zeros((2, 2))
        return np.block([[np.zeros((2, 2)), np.eye(2)], [self.air - stiff, -damped]])


@pytest.mark.parametrize("loss", [None, 0.12])
def test_what_is_left_without_oscillation_is_seen_whatever_the_damping(loss: float | None) -> None:
    """1e6 of stiffness under 1.01e6 and under 0.9e6 of air: the first turns the tissue over."""
    motion = Pair(folds(gap=2e-4), 4, Damping(loss_factor=loss))
    motion.air = np.diag([1.01e6, 0.0])  # type: ignore[attr-defined]
    assert motion.spectrum(100.0).fastest == pytest.approx(np.sqrt(0.25 + 1e4) - 0.5, rel=1e-6)
    motion.air = np.diag([0.9e6, 0.0])  # type: ignore[attr-defined]
    assert motion.spectrum(100.0).fastest < 0


def test_the_growth_about_a_state_that_is_left_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SmallMotion, "_still", staticmethod(lambda values: 12.5))
    with pytest.raises(
        plica.SolveFailed, match=r"at 100 Pa it is left without oscillation, growing by 12\.5 1/s"
    ):
        plica.growth(folds(gap=2e-4), 100.0, modes=10)
