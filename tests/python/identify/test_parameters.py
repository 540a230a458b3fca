"""What may be estimated has the names of scenes, and the derivatives of what it changes."""

from __future__ import annotations

import numpy as np
import pytest

import plica
from plica import _engine
from plica.identify import TissueParameters
from plica.identify.parameters import FIELDS

LAW = _engine.TransverselyIsotropic(E=12e3, nu=0.4, E_fibre=60e3, nu_fibre=0.3, mu_fibre=20e3, mu=5e3)


def test_parameters_are_called_as_fields_of_a_scenes_tissue() -> None:
    assert FIELDS.keys() <= plica.Tissue.model_fields.keys()


def test_all_that_the_stiffness_depends_on_may_be_estimated() -> None:
    names = {"mu": "mu_transverse"}
    found = _engine.stiffness_parameters(_engine.Material(LAW, density=1040.0))
    assert {names.get(name, name) for name in found} == FIELDS.keys() - {"viscosity"}


@pytest.mark.parametrize("field", FIELDS)
def test_derivatives_are_those_of_differences(field: str) -> None:
    material = _engine.Material(LAW, density=1040.0, viscosity=0.5)
    parameters = TissueParameters([material], ["cover"], [f"cover.{field}"])
    (at,), step = parameters.prior_mean, 1e-5
    _, _, *derivatives = parameters.coefficients(np.array([at]))
    more, less = (parameters.coefficients(np.array([at + way * step]))[:2] for way in (1, -1))
    assert any(np.any(part) for part in derivatives)
    for part, one, other in zip(derivatives, more, less, strict=True):
        assert part[0] == pytest.approx((one - other) / (2 * step), rel=1e-6, abs=1e-5)
