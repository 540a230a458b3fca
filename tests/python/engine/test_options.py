"""The engine's options: each is defined once, and Python has all that the definition says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from plica import _engine
from plica.scene import parts
from plica.scene.part import OneOf, Part
from plica.scene.scene import Scene

ALL = sorted(name for name, one in vars(_engine).items() if hasattr(one, "_defaults"))
GIVEN: dict[str, dict[str, Any]] = {
    "Material": {"elasticity": _engine.TransverselyIsotropic(fibre=[0, 0, 2])},
    "Course": {"time": [0.0, 0.1], "pressure": [100.0, 50.0]},
    "Tube": {"length": [0.1, 0.2], "area": [1e-4, 3e-4]},
    "Load": {"surface": "side", "traction": [1, 0.1, -3]},
}
COMPARED = [name for name in ALL if name not in ("Contact", "Mortar", "Reduction")]  # these hold arrays


def made(name: str) -> Any:
    return getattr(_engine, name)(**GIVEN.get(name, {}))


def test_every_kind_of_option_is_here() -> None:
    assert {"Airflow", "Contact", "Iterated", "Newmark", "FlowOptions", "Isotropic", "Load"} <= set(ALL)


@pytest.mark.parametrize("name", COMPARED)
def test_the_repr_of_options_makes_them_again(name: str) -> None:
    one = made(name)
    again = eval(repr(one), dict(vars(_engine)))
    assert again == one
    assert hash(again) == hash(one)


@pytest.mark.parametrize("name", COMPARED)
def test_options_that_differ_in_one_value_are_not_equal(name: str) -> None:
    one = made(name)
    assert one != "another type"
    for option, default in one._defaults.items():
        assert getattr(one, option) == default
        if isinstance(default, float) and default > 0:
            other = type(one)(**GIVEN.get(name, {}), **{option: 0.95 * default})
            assert getattr(other, option) == 0.95 * default
            assert other != one, option


@pytest.mark.parametrize("name", sorted(set(ALL) & set(parts.__all__)))
def test_a_part_of_a_scene_has_every_option_of_the_engines_and_its_default(name: str) -> None:
    part: type[Part] = getattr(parts, name)
    for option, default in getattr(_engine, name)._defaults.items():
        of = Scene if option in ("trachea", "tract") else part  # tables of their own
        assert option in of.model_fields
        own = of.model_fields[option].get_default(call_default_factory=True)
        if isinstance(own, OneOf):
            assert type(own.choice).__name__ == type(default).__name__
        else:
            assert own == default


def test_contact_shows_all_but_its_surfaces() -> None:
    none = np.empty((0, 3), np.int32)
    airway = _engine.Airway(none, none, np.empty((0, 4), np.int32))
    contact = _engine.Contact(airway=airway, enforcement=_engine.Penalty(stiffness=3), friction=0.5)
    shown = (
        "Contact(enforcement=Penalty(stiffness=3.0), tolerance=1e-05, max_passes=200, friction=0.5, "
        "surface_mass='kept', faces='nodes')"
    )
    assert repr(contact) == shown


def test_a_name_that_is_no_choice_is_answered_with_the_choices() -> None:
    with pytest.raises(_engine.InvalidInput) as raised:
        _engine.Multipliers(solver="magic")
    expected = 'Multipliers: solver = "magic"; must be "auto", "condensed", "saddle" or "gmres".'
    assert str(raised.value) == expected
