"""The unit of a field, by its path in a scene."""

from __future__ import annotations

import pytest

import plica
from plica.scene.field_types import unit_at


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        (("airflow", "subglottal_pressure"), "Pa"),
        (("tissue", "cover", "left", "density"), "kg/m^3"),
        (("tissue", "E", "density"), "kg/m^3"),  # a layer of that name
        (("tissue", "cover", "nu"), ""),
        (("mesh", "Larynx", "folds", "lesions", 0, "size", 1), "m"),
        (("mesh", "Larynx", "folds", "medial_angle"), "rad"),
        (("time", "scheme", "hht", "alpha"), ""),
        (("mesh",), ""),
    ],
)
def test_the_unit_of_a_field(path: tuple[str | int, ...], unit: str) -> None:
    assert unit_at(plica.Scene, path) == unit
