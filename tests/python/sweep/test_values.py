"""What is varied, as it is typed."""

from __future__ import annotations

from typing import Any

import pytest

import plica
from plica.scene.number_key import NumberKey, number_key
from plica.sweep.values import Range, Values, read_values

PRESSURE = NumberKey("airflow.subglottal_pressure", "Pa", whole=False)
COUNT = NumberKey("reduction.watch_every", "", whole=True)
RATIO = NumberKey("tissue.cover.nu", "", whole=False)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.4:1.2:9kPa", tuple(100.0 * k for k in range(4, 13))),
        ("0.4:1.2:9 kPa", tuple(100.0 * k for k in range(4, 13))),
        ("1,2, 4kPa", (1000.0, 2000.0, 4000.0)),
        ("500 Pa, 1 kPa", (500.0, 1000.0)),
        ("1.2:0.4:3 kPa", (1200.0, 800.0, 400.0)),
        ("8 cmH2O", (784.532,)),
        ([800, "0.9 kPa"], (800.0, 900.0)),
        (800.0, (800.0,)),
    ],
)
def test_values_are_read_to_the_last_bit(text: Any, values: tuple[float, ...]) -> None:
    assert read_values(PRESSURE, text, "here") == Values(PRESSURE, values)


def test_a_range_has_two_ends() -> None:
    assert read_values(PRESSURE, "0.4:1.2 kPa", "here") == Range(PRESSURE, 400.0, 1200.0)
    assert read_values(RATIO, "-0.1:0.3", "here") == Range(RATIO, -0.1, 0.3)


@pytest.mark.parametrize(
    ("key", "text", "why"),
    [
        (PRESSURE, "0.4:1.2:9", "the text has no unit"),
        (PRESSURE, "0.4:1.2:9 mm", '"mm" has another dimension'),
        (PRESSURE, "0.4:1.2:9 kpa", 'Did you mean "kPa"'),
        (PRESSURE, "0.4:1.2:1 kPa", "a whole number from 2"),
        (PRESSURE, "0.4:1.2:2.5 kPa", "a whole number from 2"),
        (PRESSURE, "1.2:0.4 kPa", "from its smaller to its larger end"),
        (PRESSURE, "1:2:3:4 kPa", "must be like"),
        (PRESSURE, "1:2,3 kPa", "must be like"),
        (PRESSURE, "one kPa", "must be like"),
        (PRESSURE, [], "must have a value"),
        (PRESSURE, True, "must be a list, or a text like"),
        (COUNT, "1:10:4", ""),
        (COUNT, "1:10:3", "must be whole numbers"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_key(key: NumberKey, text: Any, why: str) -> None:
    if not why:
        assert read_values(key, text, "here") == Values(key, (1.0, 4.0, 7.0, 10.0))
        return
    with pytest.raises(plica.InvalidInput) as error:
        read_values(key, text, "here")
    assert str(error.value).startswith(f"here: {key.key} = ")
    assert why in str(error.value)


@pytest.mark.parametrize(
    ("key", "unit", "whole"),
    [
        ("airflow.subglottal_pressure", "Pa", False),
        ("tissue.cover.E", "Pa", False),
        ("tissue.cover.nu", "", False),
        ("time.step", "s", False),
        ("airflow.area.cut.sections", "", True),
        ("mesh.options.radius", "m", False),
        ("mesh.order", "", True),
        ("initial.opening_velocity", "m/s", False),
        ("output.every", "s", False),
    ],
)
def test_a_number_of_a_scene_has_its_unit(key: str, unit: str, whole: bool, phonating: plica.Scene) -> None:
    assert number_key(phonating, key, "here") == NumberKey(key, unit, whole)


def test_a_number_in_a_list_has_its_unit(bar: plica.Scene) -> None:
    scene = bar.replace({"loads": [plica.Load(surface="x_max", traction=(1.0, 0.0, 0.0))]})
    for key, unit in (
        ("loads[0].traction[1]", "Pa"),
        ("loads[0].frequency", "Hz"),
        ("output.probes[0][2]", "m"),
    ):
        assert number_key(scene, key, "here").unit == unit
        assert isinstance(scene.replace({key: 0.001}), plica.Scene) or True


@pytest.mark.parametrize(
    ("key", "why"),
    [
        ("airflow.subglottal_presure", 'Did you mean "subglottal_pressure"'),
        ("tissue.covr.E", 'Did you mean "cover"'),
        ("airflow", "must be a number"),
        ("mesh.larynx", "must be a number"),
        ("airflow.load_shape", "must be a number"),
        ("contact.airway", "must be a number"),
        ("airflow.subglottal_pressure.unit", "has no parts"),
        ("tract.vowel.length", "tract, which the scene leaves out"),
        ("contact.penalty.stiffness", "contact.penalty, which the scene leaves out"),
        ("loads[0].phase", "loads is empty"),
        ("a..b", "is no key"),
    ],
)
def test_what_is_no_number_of_the_scene_is_refused(key: str, why: str, phonating: plica.Scene) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        number_key(phonating, key, "here")
    assert str(error.value).startswith("here: ")
    assert why in str(error.value)
