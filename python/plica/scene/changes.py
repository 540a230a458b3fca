"""A copy of a scene part with some fields changed and validated."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self, TypeVar

from pydantic import BaseModel, ValidationError

from plica.errors import SceneError
from plica.scene.problems import describe, path_text, unknown_text

__all__ = ["Changeable", "changed", "key_names"]

SomePart = TypeVar("SomePart", bound="Changeable")
Path = tuple[str | int, ...]

_TOKEN = re.compile(r'(?:(?<!^)\.|^)(?:"([^"\\]+)"|([^."\[\]]+))|\[(\d+)\]')


@dataclass
class _Leaf:
    """A new value; None removes the old one."""

    value: Any


@dataclass
class _Node:
    """Changes inside a value."""

    inner: dict[str | int, _Node | _Leaf] = field(default_factory=dict)
    table: bool = False
    """Whether it was given as a table instead of dotted keys."""


class Changeable(BaseModel):
    """What `replace` can change."""

    kinds: ClassVar[Mapping[str, type[Changeable]]] = {}
    """The parts of a choice, of which exactly one is there; empty for any other part."""

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """A validated copy with some fields changed.

        Parameters
        ----------
        changes : mapping
            Key to new value. Keys are dotted paths, ``"tissue.cover.E"``, ``"contact.multipliers.solver"``,
            with positions in lists, ``"loads[0].traction"``; a name that contains a dot is quoted,
            ``'supports.components."a.x_min"'``. A value is anything the field accepts: a number, a text with
            a unit, a part. A dict changes the fields it names and keeps the others; a part replaces the old
            one. In a choice (contact, coupling, scheme) another kind replaces the present one, and the other
            fields are kept. None removes an optional part, or an entry of a list or table; it resets any
            other field to its default.

        Raises
        ------
        SceneError
            With one line per error; for an unknown name, with the nearest known one.

        Examples
        --------
        >>> import plica
        >>> air = plica.Airflow(subglottal_pressure="0.8 kPa")
        >>> air.replace({"subglottal_pressure": "1 kPa", "coupling": "lagged"}).subglottal_pressure
        1000.0
        """
        return changed(self, changes, f"{type(self).__name__}.replace")

    def before_change(self, names: Collection[str]) -> Self:
        """The part before `replace` changes these fields."""
        return self


def key_names(key: str) -> list[str]:
    """The names and positions of a dotted key, as of `Changeable.replace`; empty if it is invalid."""
    found, end = [], 0
    while (match := _TOKEN.match(key, end)) is not None:
        found.append(next(filter(None, match.groups())))
        end = match.end()
    return found if end == len(key) else []


def changed(part: SomePart, changes: Mapping[str, Any], where: str) -> SomePart:
    """What `Changeable.replace` returns; lines of its SceneError begin with `where`."""
    return _Changer(where).apply(part, changes)


class _Changer:
    """Applies changes from the inside out; every message starts with `where`."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.problems: list[str] = []

    def apply(self, part: SomePart, changes: Mapping[str, Any]) -> SomePart:
        root = _Node()
        for key, value in changes.items():
            self._insert(root, key, value)
        new: SomePart = part if self.problems else self._part(part, root, ())
        if self.problems:
            raise SceneError(self.problems)
        return new

    def _fail(self, text: str) -> None:
        self.problems.append(f"{self.where}: {text}")

    def _insert(self, root: _Node, key: object, value: Any) -> None:
        """Insert one change into the tree of changes."""
        *path, last = self._tokens(key) or [""]
        if not last:
            return
        node: _Node | _Leaf = root
        for token in path:
            if isinstance(node, _Node) and not node.table:
                node = node.inner.setdefault(token, _Node())
        if not isinstance(node, _Node) or node.table or last in node.inner:
            self._fail(f"{key} is given twice.")
        else:
            node.inner[last] = _given(value)

    def _tokens(self, key: object) -> list[str]:
        """The names and positions of a dotted key; empty, with an error recorded, if it is invalid."""
        found = key_names(key) if isinstance(key, str) else []
        if not found:
            self._fail(
                f'the key {json.dumps(key, default=str)} is invalid; must be like "time.step", '
                '"loads[0].traction" or \'supports.components."a.x_min"\'.'
            )
        return found

    def _change(self, old: Any, change: _Node | _Leaf, path: Path) -> Any:
        """The value that replaces `old`."""
        if isinstance(change, _Leaf):
            kind = _kind_of(old, change.value)
            return self._part(old, kind, path) if kind is not None else change.value
        if isinstance(old, Changeable):
            foreign = change.table and not change.inner.keys() <= type(old).model_fields.keys()
            return _plain(change) if foreign else self._part(old, change, path)
        if isinstance(old, Mapping):
            return self._table(old, change, path)
        if isinstance(old, (tuple, list)):
            return self._list(old, change, path)
        if old is not None and not change.table:
            self._fail(f"{path_text((*path, *change.inner))} is not known: {path_text(path)} has no parts.")
        return _plain(change)

    def _part(self, old: SomePart, change: _Node, path: Path) -> SomePart:
        before = len(self.problems)
        old = old.before_change([str(name) for name in change.inner])
        data = {name: getattr(old, name) for name in old.model_fields_set}
        if old.kinds:
            named = {name for name, new in change.inner.items() if name in old.kinds and not _removes(new)}
            for kind in old.kinds.keys() - named if named else ():
                data.pop(kind, None)
        for key, new in change.inner.items():
            name = str(key)
            if _removes(new) and name in type(old).model_fields:
                data.pop(name, None)
            else:
                data[name] = self._change(old.__dict__.get(name), new, (*path, name))
        if len(self.problems) > before:
            return old
        try:
            return type(old).model_validate(data)
        except ValidationError as error:
            self.problems += describe(error, self.where, type(old), path)
            return old

    def _table(self, old: Mapping[str, Any], change: _Node, path: Path) -> dict[str, Any]:
        data = dict(old)
        for key, new in change.inner.items():
            name = str(key)
            inside = isinstance(new, _Node) and not new.table  # inside a value that must exist
            if name not in data and (_removes(new) or inside):
                self._fail(unknown_text(path, name, list(data)))
            elif _removes(new):
                del data[name]
            else:
                data[name] = self._change(data.get(name), new, (*path, name))
        return data

    def _list(self, old: tuple[Any, ...] | list[Any], change: _Node, path: Path) -> list[Any]:
        if change.table and not all(str(key).isdecimal() for key in change.inner):
            self._fail(f"{path_text(path)} is a table; must be a list: [[{path_text(path)}]] in a file.")
            return []
        data = list(old)
        removed = set()
        for key, new in change.inner.items():
            position = int(key) if str(key).isdecimal() else -1
            if position not in range(len(data)):
                has = f"has {len(data)} entries, from [0]" if data else "is empty"
                inner = path_text((*path, position if position >= 0 else str(key)))
                self._fail(f"{inner} is not known: {path_text(path)} {has}.")
            elif _removes(new):
                removed.add(position)
            else:
                data[position] = self._change(data[position], new, (*path, position))
        return [value for position, value in enumerate(data) if position not in removed]


def _given(value: Any) -> _Node | _Leaf:
    if not isinstance(value, Mapping):
        return _Leaf(value)
    return _Node({name: _given(inner) for name, inner in value.items()}, table=True)


def _plain(change: _Node | _Leaf) -> Any:
    """The changes as data of a new value."""
    if isinstance(change, _Leaf):
        return change.value
    return {str(name): _plain(inner) for name, inner in change.inner.items() if not _removes(inner)}


def _removes(change: _Node | _Leaf) -> bool:
    return isinstance(change, _Leaf) and change.value is None


def _kind_of(old: Any, value: Any) -> _Node | None:
    """For a choice given by its kind alone, the change of that kind; other fields are kept."""
    if not isinstance(old, Changeable):
        return None
    for name, kind in old.kinds.items():
        if isinstance(value, kind):
            return _Node({name: _Leaf(value)})
        if value == name:
            return _Node({name: _Node(table=True)})
    return None
