"""Physical quantities with units: ``"0.8 kPa"``, ``"1e4 dyn/cm^2"``, or a number in SI."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from numbers import Integral, Real
from typing import TYPE_CHECKING, Annotated, Any

from pydantic_core import PydanticCustomError, core_schema

from plica.errors import InvalidInput

if TYPE_CHECKING:
    import pint
    from pydantic import GetCoreSchemaHandler

__all__ = [
    "Acceleration",
    "Angle",
    "Area",
    "Density",
    "Frequency",
    "Length",
    "MassPerArea",
    "Number",
    "PerLength",
    "Pressure",
    "SpecificImpedance",
    "Stiffness",
    "Time",
    "Unit",
    "Velocity",
    "Viscosity",
    "Volume",
    "VolumeFlow",
    "clock",
    "in_typed_unit",
    "number",
    "quantity_within",
    "read_quantity",
    "two_digits",
    "whole_number",
]


@cache
def registry() -> pint.UnitRegistry[Decimal]:
    """The units library, loaded for the first unit that is not a common one; decimal, like those."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def read_quantity(value: object, unit: str) -> float:
    """Convert a number or a text with a unit to a number in the SI unit `unit`.

    Parameters
    ----------
    value : float, int or str
        A number is in SI; a text has a unit: ``"0.8 kPa"``. A text without a unit is refused if a unit is
        expected.
    unit : str
        The SI unit expected, e.g. ``"Pa"``; ``""`` for a pure number.

    Returns
    -------
    float
        Finite, in `unit`.

    Raises
    ------
    ValueError
        With the relation that the value violates, ``must be ...``.
    """
    expected = f"a number in {unit} or a text with a unit of that kind" if unit else "a number"
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f"must be {expected}.")
    try:
        number = float(value) if not isinstance(value, str) else _from_text(value, unit, expected)
    except ArithmeticError:  # beyond the range of a float or a decimal
        number = math.inf
    if not math.isfinite(number):
        raise ValueError("must be finite.")
    return number


_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def _from_text(text: str, unit: str, expected: str) -> float:
    parts = _QUANTITY.fullmatch(text)
    if parts is None:
        raise ValueError(f"must be {expected}; it does not start with a number.")
    number, name = Decimal(parts[1]), parts[2]
    if not name:
        if unit:
            raise ValueError(f"must be {expected}; the text has no unit.")
        return float(number)

    factor = _USUAL.get(unit, {}).get(name)
    if factor is not None:
        return float(number * factor)

    import pint

    units = registry()
    usual = _usual_unit(name, unit)
    hint = f' Did you mean "{usual}"?' if usual else ""
    try:
        found = units.parse_units(_SPELLINGS.get(name, name))
    except pint.UndefinedUnitError:
        raise ValueError(
            f'must be {expected}; "{name}" is not known. Units are case-sensitive.{hint}'
        ) from None
    except Exception:  # pint's parser raises many kinds (tokenize, assertion, attribute errors)
        raise ValueError(f'must be {expected}; "{name}" cannot be read as a unit.{hint}') from None
    target = units.parse_units(unit or "dimensionless")
    if not found.is_compatible_with(target):
        raise ValueError(f'must be {expected}; "{name}" has another dimension.{hint}')
    if usual and units.Quantity(Decimal(1), found) > _IMPLAUSIBLE * units.Quantity(Decimal(1), usual):
        raise ValueError(f'must be {expected}; "{name}" has the prefix mega.{hint}')
    return float(units.Quantity(number, found).to(target).magnitude)


def in_typed_unit(value: float, typed: str, unit: str) -> str:
    """A number in the SI unit `unit` as text in the unit of a quantity that is given as text: 0.35 rad is
    ``"20.05 deg"`` beside ``"30 deg"``."""
    parts = _QUANTITY.fullmatch(typed)
    if parts is None or not parts[2]:
        return f"{value:g}{f' {unit}' if unit else ''}"
    return f"{value / read_quantity(f'1 {parts[2]}', unit):.4g} {parts[2]}"


_SPELLINGS = {
    "cm H2O": "cm_H2O",
    "mm H2O": "mm_H2O",
    "in H2O": "in_H2O",
    "cm_water": "cm_H2O",
    "cm water": "cm_H2O",
    "mm Hg": "mm_Hg",
    "dyn/cm2": "dyn/cm^2",
    "dyne/cm2": "dyn/cm^2",
    "N/m2": "N/m^2",
}
"""Common spellings of units of pressure that the library does not know."""
_USUAL = {
    "s": {"s": Decimal(1), "ms": Decimal("1e-3"), "us": Decimal("1e-6"), "ns": Decimal("1e-9")},
    "m": {"m": Decimal(1), "cm": Decimal("1e-2"), "mm": Decimal("1e-3"), "um": Decimal("1e-6")},
    "Pa": {
        "Pa": Decimal(1),
        "kPa": Decimal(1000),
        "MPa": Decimal(1000000),
        "cmH2O": Decimal("98.0665"),
        "mmHg": Decimal("133.322387415"),
        "dyn/cm^2": Decimal("0.1"),
    },
    "Pa s": {
        "Pa s": Decimal(1),
        "mPa s": Decimal("1e-3"),
        "uPa s": Decimal("1e-6"),
        "poise": Decimal("0.1"),
    },
    "Hz": {"Hz": Decimal(1), "kHz": Decimal(1000)},
    "m/s": {"m/s": Decimal(1), "cm/s": Decimal("1e-2"), "mm/s": Decimal("1e-3")},
    "kg/m^3": {"kg/m^3": Decimal(1), "g/cm^3": Decimal(1000)},
    "m^2": {"m^2": Decimal(1), "cm^2": Decimal("1e-4"), "mm^2": Decimal("1e-6")},
    "m^3": {"m^3": Decimal(1), "l": Decimal("1e-3"), "ml": Decimal("1e-6"), "cm^3": Decimal("1e-6")},
    "m^3/s": {
        "m^3/s": Decimal(1),
        "l/s": Decimal("1e-3"),
        "ml/s": Decimal("1e-6"),
        "cm^3/s": Decimal("1e-6"),
    },
}
"""Common units in the SI unit, by that: they are read without the units library, which takes long to load."""
_IMPLAUSIBLE = 10**6
"""A unit this many times as large as a common one that differs only in case is refused: "Ms" is a million
seconds."""


def _usual_unit(name: str, unit: str) -> str:
    """The common unit that differs from a name only in case, or an empty string."""
    return next((one for one in _USUAL.get(unit, ()) if one != name and one.lower() == name.lower()), "")


def number(where: str, name: str, value: Any, least: float, most: float, unit: str) -> None:
    """Raises InvalidInput unless `value` is a number in [least, most]."""
    kind = isinstance(value, Real) and not isinstance(value, bool)
    if not kind or not least <= value <= most:
        shown = f"{value:g} {unit}".rstrip() if kind else _typed(value)
        hint = " Is the unit right?" if kind and unit else ""
        raise InvalidInput(f"{where}: {name} = {shown}; must be a number in [{least:g}, {most:g}].{hint}")


def whole_number(where: str, name: str, value: Any, least: int, most: int) -> None:
    """Raises InvalidInput unless `value` is a whole number in [least, most]."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        raise InvalidInput(f"{where}: {name} = {_typed(value)}; must be a whole number in [{least}, {most}].")


def _typed(value: object) -> str:
    """A string in double quotes, anything else as its repr."""
    return f'"{value}"' if isinstance(value, str) else repr(value)


def two_digits(value: float) -> str:
    """Two significant digits as a plain number: 150, where ``.2g`` alone writes 1.5e+02."""
    return f"{float(f'{value:.2g}'):g}"


def clock(seconds: float) -> str:
    """A duration as text, in s, min or h."""
    if seconds < 90:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.2g} min" if seconds < 5400 else f"{seconds / 3600:.2g} h"


def quantity_within(where: str, name: str, value: Any, unit: str, least: float, most: float) -> float:
    """A number in SI, or a text with a unit, as a number; raises InvalidInput outside [least, most]."""
    try:
        found = read_quantity(
            float(value) if isinstance(value, Real) and not isinstance(value, bool) else value, unit
        )
    except ValueError as error:
        raise InvalidInput(f"{where}: {name} = {_typed(value)}; {error}") from None
    number(where, name, found, least, most, unit)
    return found


@dataclass(frozen=True)
class Unit:
    """Marks a field as a quantity in this SI unit; text with a unit is accepted and converted."""

    si: str

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(self._read, handler(source))

    def _read(self, value: object) -> float:
        try:
            return read_quantity(value, self.si)
        except ValueError as error:
            raise PydanticCustomError("quantity", "{relation}", {"relation": str(error)}) from None


Number = Annotated[float, Unit("")]
Angle = Annotated[float, Unit("rad")]
Length = Annotated[float, Unit("m")]
Time = Annotated[float, Unit("s")]
Velocity = Annotated[float, Unit("m/s")]
Acceleration = Annotated[float, Unit("m/s^2")]
Frequency = Annotated[float, Unit("Hz")]
Pressure = Annotated[float, Unit("Pa")]
Viscosity = Annotated[float, Unit("Pa s")]
Density = Annotated[float, Unit("kg/m^3")]
Stiffness = Annotated[float, Unit("N/m")]
PerLength = Annotated[float, Unit("Pa/m")]
Area = Annotated[float, Unit("m^2")]
Volume = Annotated[float, Unit("m^3")]
VolumeFlow = Annotated[float, Unit("m^3/s")]
MassPerArea = Annotated[float, Unit("kg/m^2")]
SpecificImpedance = Annotated[float, Unit("Pa s/m")]
