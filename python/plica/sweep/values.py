"""What is varied: ``0.4:1.2:9 kPa`` (nine values), ``1, 2, 4 kPa`` (these), ``0.4:1.2 kPa`` (a range)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from plica.errors import InvalidInput, nearest, one_of
from plica.scene.number_key import NumberKey
from plica.scene.problems import value_text
from plica.sweep.subject import ChoiceKey, Key
from plica.units import read_quantity

__all__ = ["Range", "Values", "read_values"]

_MOST = 1_000_000
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_FORMS = '"0.4:1.2:9 kPa" (nine values), "1, 2, 4 kPa" (these) or "0.4:1.2 kPa" (a range)'


@dataclass(frozen=True)
class Values:
    """A key and the values that it takes, in SI; of a choice the words, and their positions among these."""

    key: Key
    values: tuple[float, ...]
    words: tuple[str, ...] = ()

    @classmethod
    def of_words(cls, key: ChoiceKey, given: Sequence[str]) -> Values:
        """Words in the order in which they are given."""
        words = tuple(dict.fromkeys(given))
        return cls(key, tuple(float(words.index(word)) for word in given), words)


@dataclass(frozen=True)
class Range:
    """A key and the ends between which a design chooses its values, in SI."""

    key: NumberKey
    low: float
    high: float


def read_values(key: Key, given: object, where: str) -> Values | Range:
    """What is given for a key: a text (see the module docstring), or a list of numbers and quantities; of a
    choice its words.

    A unit at the end holds for all numbers before it that have none. Raises InvalidInput, beginning with
    `where` and the key.
    """
    what = f"{where}: {key.key} = {value_text(given)}"
    if isinstance(key, ChoiceKey):
        return Values.of_words(key, _words(key, given, what))
    if isinstance(given, (list, tuple)):
        return Values(key, _listed(key, given, what))
    if isinstance(given, (int, float)) and not isinstance(given, bool):
        return Values(key, _listed(key, [given], what))
    if not isinstance(given, str):
        raise InvalidInput(f"{what}; must be a list, or a text like {_FORMS}.")
    if ":" not in given:
        return Values(key, _listed(key, _with_unit(given.split(","), what), what))
    parts = given.split(":")
    if len(parts) not in (2, 3) or "," in given:
        raise InvalidInput(f"{what}; must be like {_FORMS}.")
    if len(parts) == 2:
        low, high = _listed(key, _with_unit(parts, what), what, whole=False)
        if not low < high:
            raise InvalidInput(f"{what}; the range must go from its smaller to its larger end.")
        return Range(key, low, high)
    *ends, number = parts
    count, unit = _count(number, what)
    begin, end = _listed(key, _with_unit([ends[0], f"{ends[1]} {unit}"], what), what, whole=False)
    steps = [Fraction(begin) + (Fraction(end) - Fraction(begin)) * k / (count - 1) for k in range(count)]
    return Values(key, _listed(key, [float(step) for step in steps], what))


def _words(key: ChoiceKey, given: object, what: str) -> list[str]:
    """Words of a choice: a list, or a text with commas; true and false stand for themselves."""
    told = (
        given.split(",") if isinstance(given, str) else given if isinstance(given, list | tuple) else [given]
    )
    words = [str(one).lower() if isinstance(one, bool) else str(one).strip() for one in told]
    for word in words:
        if word not in key.choices:
            raise InvalidInput(f"{what}; each must be {one_of(key.choices)}.{nearest(word, key.choices)}")
    if not words:
        raise InvalidInput(f"{what}; must have a value.")
    return words


def _count(text: str, what: str) -> tuple[int, str]:
    """How many values, and the unit behind it."""
    found = _NUMBER.fullmatch(text)
    if found is None or not found[1].isdecimal() or not 2 <= int(found[1]) <= _MOST:
        raise InvalidInput(
            f"{what}; the number of values must be a whole number from 2 to {_MOST}, behind the second colon."
        )
    return int(found[1]), found[2]


def _with_unit(parts: Sequence[str], what: str) -> list[str]:
    """Numbers as quantities; the last unit holds for those before that have none."""
    found = [_NUMBER.fullmatch(part) for part in parts]
    last = found[-1]
    texts = []
    for one in found:
        if one is None or last is None:
            raise InvalidInput(f"{what}; must be like {_FORMS}.")
        texts.append(f"{one[1]} {one[2] or last[2]}".strip())
    return texts


def _listed(key: NumberKey, given: Sequence[Any], what: str, *, whole: bool = True) -> tuple[float, ...]:
    """Different values in SI."""
    try:
        found = tuple(read_quantity(one, key.unit) for one in given)
    except ValueError as error:
        raise InvalidInput(f"{what}; {error}") from None
    if not found:
        raise InvalidInput(f"{what}; must have a value.")
    if whole and key.whole and any(value != round(value) for value in found):
        raise InvalidInput(f"{what}; must be whole numbers.")
    return found
