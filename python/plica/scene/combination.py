"""What of a scene is there, what it does not go with, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

__all__ = ["PARTS", "Choice", "Combination", "Fault", "Group", "Pairs", "at", "each", "key"]

Fault = tuple[tuple[str | int, ...], object] | None
"""The path of a key in a scene, and the value that is shown if not None; None where the scene has it not."""

PARTS = {"Airflow": "airflow", "Contact": "contact", "Stepping": "time", "MeshFile": "mesh"}
"""Parts that are seen as a scene with nothing else, so that they are refused as soon as they are made."""


@dataclass(frozen=True)
class Choice:
    """What a scene may have.

    Attributes
    ----------
    name : str
        As keys of the scene.
    found : callable
        The fault of a scene, or of one of its parts, that has it.
    must : str
        What must hold of its key where it is refused.
    hint : str
        What more there is to say or to do then.
    """

    name: str
    found: Callable[[Any], Fault]
    must: str = ""
    hint: str = ""

    def saying(self, hint: str) -> Choice:
        return replace(self, hint=hint)


Pairs = tuple[tuple[Choice, Choice], ...]
"""An option, whose key and value are shown, and what it does not go with."""


@dataclass(frozen=True)
class Combination:
    """What is refused for one reason.

    Attributes
    ----------
    reason : str
        Why.
    kind : {"physics", "construction"}
        construction: it could be built.
    pairs : tuple of (Choice, Choice)
    """

    reason: str
    kind: Literal["physics", "construction"]
    pairs: Pairs

    def relation(self, option: Choice, other: Choice) -> str:
        """What must hold of the option, and why, as in messages."""
        return f"{option.must} with {other.name}: {self.reason}{_hint(option, other)}"

    @property
    def groups(self) -> list[Group]:
        """The pairs, those together of which the same is said."""
        others: dict[tuple[str, str, str], list[str]] = {}
        for option, other in self.pairs:
            others.setdefault((option.name, option.must, _hint(option, other)), []).append(other.name)
        options: dict[tuple[str, tuple[str, ...], str], list[str]] = {}
        for (name, must, hint), names in others.items():
            options.setdefault((must, tuple(names), hint), []).append(name)
        return [Group(tuple(names), *said) for said, names in options.items()]


@dataclass(frozen=True)
class Group:
    """Options, what must hold of them with any of others, and what more there is to say."""

    options: tuple[str, ...]
    must: str
    others: tuple[str, ...]
    hint: str


def _hint(option: Choice, other: Choice) -> str:
    hint = option.hint or other.hint
    return f" {hint}" if hint else ""


def each(options: Iterable[Choice], others: Iterable[Choice]) -> Pairs:
    """Every option with every other."""
    others = tuple(others)
    return tuple((option, other) for option in options for other in others)


def at(part: Any, path: str) -> Any:
    """The value of a dotted key of the scene; None where neither the scene nor the part has it."""
    names = path.split(".")
    if (root := PARTS.get(type(part).__name__)) is not None and names.pop(0) != root:
        return None
    for name in names:
        part = getattr(part, name, None)
    return part


def key(path: str, *values: object, must: str = "must be left out", hint: str = "") -> Choice:
    """A dotted key that is given or, with `values`, that has one of them; of a choice, its kinds."""

    def found(part: Any) -> Fault:
        value = at(part, path)
        if values:
            value = getattr(value, "chosen", value)
        if value not in values if values else value is None or value == ():
            return None
        return tuple(path.split(".")), value if isinstance(value, str | float | bool) else None

    texts = [f'"{value}"' if isinstance(value, str) else f"{value}" for value in values]
    return Choice(path + (f" = {' or '.join(texts)}" if texts else ""), found, must, hint)
