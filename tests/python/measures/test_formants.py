"""Formants of transfer functions whose poles are known, and of tubes in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import plica
from plica.measures.formants import formants
from plica.runs.tubes import tract_formants, tract_response

AIR = plica.Airflow(sound_speed=350.0)
LENGTH = 0.17
PLAIN = {"wall": "rigid", "friction_frequency": 0}


def test_oscillations_are_found_where_they_are() -> None:
    """Also one close to its neighbour, and none that does not ring or that grows."""
    poles = [(500.0, 40.0), (1480.0, 90.0), (1700.0, 60.0), (3000.0, 400.0), (20.0, 45.0)]
    rates = np.zeros((2 * len(poles), 2 * len(poles)))
    for k, (f, b) in enumerate(poles):
        rates[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = np.pi * np.array([[-b, 2 * f], [-2 * f, -b]])
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal(rates.shape))[0]
    found = formants(turn @ rates @ turn.T)
    assert [one.frequency for one in found] == pytest.approx([500, 1480, 1700, 3000], rel=1e-9)
    assert [one.bandwidth for one in found] == pytest.approx([40, 90, 60, 400], rel=1e-7)
    assert len(formants(rates, 1600.0)) == 2
    assert [one.frequency for one in formants(rates, lowest=600.0)] == pytest.approx([1480, 1700, 3000])


def _of_elements(frequency: float) -> float:
    """Hz, of a tube in elements of l: c / (pi l) sin(pi f l / c) (docs/theory/tubes.md)."""
    element = LENGTH / np.ceil(LENGTH / 4e-3)
    return float(350.0 / (np.pi * element) * np.sin(np.pi * frequency * element / 350.0))


@pytest.mark.parametrize("reflection", [1.0, 0.8, 0.5])
def test_a_tube_whose_end_gives_back_a_share(reflection: float) -> None:
    """A wave decays by r in 2 L / c: s = c / 2 L (ln r + i pi (2 k - 1))."""
    tract = plica.Tract(
        uniform={"length": LENGTH, "area": 3e-4}, end={"reflecting": {"reflection": reflection}}, **PLAIN
    )
    found = tract_formants(tract, AIR)
    exact = [(2 * k - 1) * 350.0 / (4 * LENGTH) for k in range(1, 6)]
    assert len(found) == 5
    assert [one.frequency for one in found] == pytest.approx([_of_elements(f) for f in exact], rel=2e-4)
    width = -350.0 / (2 * np.pi * LENGTH) * np.log(reflection)
    assert [one.bandwidth for one in found] == pytest.approx([width] * 5, rel=0.03, abs=1e-6)


def test_two_tubes() -> None:
    """tan(k L1) tan(k L2) = A2 / A1."""
    lengths, areas = (0.09, 0.08), (1e-4, 7e-4)
    tract = plica.Tract(
        sections={"length": lengths, "area": areas}, end={"reflecting": {"reflection": 1.0}}, **PLAIN
    )
    found = tract_formants(tract, AIR, 2000.0)
    assert len(found) == 2
    for formant in found:
        k1, k2 = (2 * np.pi * formant.frequency / 350.0 * length for length in lengths)
        off = np.sin(k1) * np.sin(k2) * areas[0] - np.cos(k1) * np.cos(k2) * areas[1]
        assert abs(off) < 4e-3 * areas[1]


def test_walls_that_yield_raise_the_first_formant_as_their_mass_says() -> None:
    """F1^2 = F^2 + F_w^2, F_w = sqrt(rho c^2 perimeter / (m area)) / (2 pi), the wall's own ring in it."""
    shape: dict[str, Any] = {"vowel": {"name": "i"}}
    hard, soft = (
        tract_formants(plica.Tract(**shape, **PLAIN | {"wall": wall}), AIR)[0].frequency
        for wall in ("rigid", {"yielding": {"resistance": 0}})
    )
    length, area = (np.array(one) for one in plica.Tract(**shape).profile)
    surface, volume = (2 * np.sqrt(np.pi * area) * length).sum(), (area * length).sum()
    own = 8.45e5 / 21.0  # (rad/s)^2 of the wall itself
    ring = np.sqrt(AIR.air_density * 350.0**2 * surface / (21.0 * volume) + own) / (2 * np.pi)
    assert hard < soft
    assert soft == pytest.approx(np.hypot(hard, ring), rel=0.1)


def test_a_closed_tract_rings_at_halves() -> None:
    tract = plica.Tract(uniform={"length": LENGTH, "area": 3e-4}, end="closed", **PLAIN)
    found = [one.frequency for one in tract_formants(tract, AIR, 3500.0)]
    assert found == pytest.approx([_of_elements(k * 350.0 / (2 * LENGTH)) for k in (1, 2, 3)], rel=1e-9)


@pytest.mark.parametrize(
    "end", ["open", {"reflecting": {"reflection": 1.0}}, {"reflecting": {"reflection": 0.4}}]
)
def test_the_flow_at_the_lips_is_that_of_a_tube_in_closed_form(end: Any) -> None:
    """U_lips / U = 1 / (cos kL + i Z / Z_c sin kL), Z of a piston in a wall (Flanagan), or of the end."""
    area = 3e-4
    response = tract_response(plica.Tract(uniform={"length": LENGTH, "area": area}, end=end, **PLAIN), AIR)
    frequency = np.array([20.0, 258.0, 700.0, 1100.0, 1900.0])
    k, radius = 2 * np.pi * frequency / 350.0, np.sqrt(area / np.pi)
    resistance, inertance = 128 / (9 * np.pi**2), 8j * k * radius / (3 * np.pi)
    load = resistance * inertance / (resistance + inertance)
    if end != "open":
        share = end["reflecting"]["reflection"]
        load = (1 - share) / (1 + share) * np.ones(frequency.size)
    exact = -20 * np.log10(np.abs(np.cos(k * LENGTH) + 1j * load * np.sin(k * LENGTH)))
    assert np.ptp(exact) > 3.0
    assert response.gain(frequency) == pytest.approx(exact, abs=0.05)  # elements of 4 mm


def test_a_closed_tract_lets_no_flow_out() -> None:
    response = tract_response(plica.Tract(uniform={"length": LENGTH, "area": 3e-4}, end="closed"), AIR)
    assert response.gain(np.array([200.0])) == -np.inf
