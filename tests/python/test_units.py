"""Quantities with units."""

from __future__ import annotations

from decimal import Decimal

import pytest

from plica.units import _USUAL, read_quantity, registry


@pytest.mark.parametrize("unit", _USUAL)
@pytest.mark.parametrize("number", ["0.7", "1e-3", "-20e4", "3", "0.123456789012345678901234567890", "5.4"])
def test_a_common_unit_is_converted_to_the_bit_as_the_units_library_does(unit: str, number: str) -> None:
    units = registry()
    for name in _USUAL[unit]:
        theirs = units.Quantity(Decimal(number), units.parse_units(name))
        assert read_quantity(f"{number} {name}", unit) == float(theirs.to(units.parse_units(unit)).magnitude)


def test_common_units_are_read_without_the_units_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plica.units.registry", lambda: pytest.fail("loaded"))
    assert read_quantity("50 us", "s") == 5e-5
    assert read_quantity("20e4 dyn/cm^2", "Pa") == 2e4
    with pytest.raises(pytest.fail.Exception, match="loaded"):
        read_quantity("1 inHg", "Pa")
