"""Quantiles of t and F."""

from __future__ import annotations

import math

import pytest
from scipy import special

from plica.measures.quantiles import fisher, student

FREEDOMS = (1, 2, 3, 6, 17, 38, 150, 500)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95, 0.975, 0.999, 0.9995])
def test_quantiles_of_f_are_those_of_a_statistics_library(share: float) -> None:
    for above in FREEDOMS:
        for below in FREEDOMS:
            assert fisher(above, below, share) == pytest.approx(special.fdtri(above, below, share), rel=1e-11)


@pytest.mark.parametrize("share", [0.6, 0.975, 0.9975, 1 - 1e-4 / 2])
def test_quantiles_of_t_are_those_of_a_statistics_library(share: float) -> None:
    for freedom in FREEDOMS:
        assert student(freedom, share) == pytest.approx(special.stdtrit(freedom, share), rel=1e-11)


def test_quantiles_known_in_closed_form() -> None:
    assert student(1, 0.975) == pytest.approx(math.tan(0.475 * math.pi), rel=1e-12)  # Cauchy's distribution
    assert fisher(2, 2, 0.75) == pytest.approx(3.0, rel=1e-12)  # x / (1 + x) below share
    assert fisher(7, 7, 0.5) == pytest.approx(1.0, rel=1e-12)
