"""What number of a scene a key names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plica.errors import InvalidInput
from plica.scene.changes import Changeable, key_names
from plica.scene.field_types import leaves, unit_of
from plica.scene.problems import path_text, unknown_text, value_text

__all__ = ["NumberKey", "number_key"]


@dataclass(frozen=True)
class NumberKey:
    """A number of a scene.

    Attributes
    ----------
    key : str
        Dotted path, ``tissue.cover.E``, as `Scene.replace` takes it.
    unit : str
        SI; empty for a pure number.
    whole : bool
        Whether it is a whole number.
    """

    key: str
    unit: str
    whole: bool


def number_key(scene: Changeable, key: str, where: str) -> NumberKey:
    """The number that a key names in this scene, or in other settings.

    Raises
    ------
    InvalidInput
        If there is no such key, or it is no number, or of a part that the scene does not have; the message
        begins with `where`.
    """
    names = key_names(key)
    if not names:
        raise InvalidInput(f'{where}: "{key}" is no key; must be like "tissue.cover.E" or "loads[0].phase".')
    value: Any = scene
    kinds: tuple[Any, ...] = ()
    path: list[str | int] = []
    for name in names:
        if value is None:
            raise InvalidInput(
                f"{where}: {key} is in {path_text(path)}, which the scene leaves out; must be there. Give it "
                "in the scene."
            )
        value, kinds = _inside(value, kinds, name, path, where)
        path.append(int(name) if name.isdecimal() else name)
    unit = unit_of(kinds)
    plain = [kind for kind in leaves(kinds) if kind in (int, float)]
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if (unit is None and not plain and not number) or not (number or value is None):
        raise InvalidInput(f"{where}: {key} = {value_text(_plain(value))}; must be a number to vary it.")
    return NumberKey(key, "" if unit is None else unit, unit is None and float not in plain)


def _inside(
    value: Any, kinds: tuple[Any, ...], name: str, path: list[str | int], where: str
) -> tuple[Any, tuple[Any, ...]]:
    """The value of a name in a value, and what its type says."""
    if isinstance(value, Changeable):
        fields = type(value).model_fields
        if name in fields:
            return getattr(value, name), (fields[name].annotation, *fields[name].metadata)
        raise InvalidInput(f"{where}: {unknown_text(tuple(path), name, list(fields))}")
    if isinstance(value, Mapping):
        if name in value:
            return value[name], kinds
        raise InvalidInput(f"{where}: {unknown_text(tuple(path), name, list(value))}")
    if isinstance(value, (tuple, list)):
        if name.isdecimal() and int(name) < len(value):
            return value[int(name)], kinds
        has = f"has {len(value)} entries, from [0]" if value else "is empty"
        raise InvalidInput(f"{where}: {path_text([*path, name])} is not known: {path_text(path)} {has}.")
    raise InvalidInput(f"{where}: {path_text([*path, name])} is not known: {path_text(path)} has no parts.")


def _plain(value: Any) -> Any:
    return value.model_dump(mode="json", exclude_none=True) if isinstance(value, Changeable) else value
