"""Error messages of a scene, one line per error: ``scene.toml: tissue.cover.nu = 0.9; must be ...``."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from plica.errors import nearest, one_of
from plica.scene.field_types import unit_at
from plica.units import in_typed_unit

__all__ = ["describe", "differences", "path_text", "unknown_text", "value_text"]

_MISSING = object()


def path_text(path: Iterable[str | int]) -> str:
    """``("loads", 0, "surface")`` as ``loads[0].surface``; tags of unions, ``<...>``, are omitted."""
    text = ""
    for name in path:
        if isinstance(name, int):
            text += f"[{name}]"
        elif not name.startswith("<"):
            name = name if name.replace("_", "").isalnum() else json.dumps(name)
            text += f".{name}" if text else name
    return text


def value_text(value: object) -> str:
    """A value as in TOML, shortened."""
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "..."


def differences(
    before: Any, now: Any, path: tuple[str | int, ...] = ()
) -> Iterator[tuple[str, str | None, str | None]]:
    """Key, old value and new value of all differences between two tables; None if there is no value."""
    if isinstance(before, dict) and isinstance(now, dict):
        names: Iterable[Any] = [*before, *(name for name in now if name not in before)]
        pairs = ((name, before.get(name, _MISSING), now.get(name, _MISSING)) for name in names)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        pairs = ((k, *pair) for k, pair in enumerate(zip(before, now, strict=True)))
    else:
        if before != now:
            yield path_text(path), _shown(before), _shown(now)
        return
    for name, old, new in pairs:
        yield from differences(old, new, (*path, name))


def _shown(value: object) -> str | None:
    if value is _MISSING:
        return None
    if isinstance(value, dict):
        return f"a table with {', '.join(map(str, value))}" if value else "an empty table"
    return "none" if value is None else value_text(value)


def describe(
    error: ValidationError, where: str, part: type[BaseModel], inside: tuple[str | int, ...] = ()
) -> list[str]:
    """One line per error, each starting with `where`; `inside` is the path of the validated part."""
    return [f"{where}: {line}" for details in error.errors() for line in _lines(details, part, inside)]


def _lines(details: ErrorDetails, part: type[BaseModel], inside: tuple[str | int, ...]) -> list[str]:
    context: dict[str, Any] = details.get("ctx", {})
    path = (*inside, *details["loc"], *context.get("path", ()))
    if details["type"] == "unknown_names":
        return [unknown_text(path, name, context["known"]) for name in context["unknown"]]
    if details["type"] == "missing":
        return [f"{path_text(path)} is missing."]
    if details["type"] == "scene":
        value = context.get("value", _MISSING)
    else:
        path = _without_branches(path)
        value = details["input"]
    name = unit_at(part, details["loc"])
    relation = _relation(details, context, name)
    if not path:
        return [relation]
    unit = f" {name}" if name and details["type"] in _BOUNDS and not isinstance(value, str) else ""
    shown = "" if value is _MISSING else f" = {value_text(value)}{context.get('unit', unit)}"
    return [f"{path_text(path)}{shown}{';' if shown else ':'} {relation}"]


def unknown_text(path: tuple[str | int, ...], name: str, known: list[str]) -> str:
    """The message for an unknown name at `path`, with the nearest and all known names."""
    hint = f"Known here: {', '.join(known)}." if known else f"{path_text(path)} has no keys."
    return f"{path_text((*path, name))} is not known.{nearest(name, known)} {hint}"


def _without_branches(path: tuple[str | int, ...]) -> tuple[str | int, ...]:
    """The path without pydantic's entries for union branches and keys: ``literal['x']``, ``[key]``."""
    return tuple(
        name
        for name in path
        if isinstance(name, int)
        or not (
            name in {"Sides", "int", "str", "[key]"} or name.startswith(("literal[", "function-", "tuple["))
        )
    )


_BOUNDS = {
    "greater_than": (">", "gt"),
    "greater_than_equal": (">=", "ge"),
    "less_than": ("<", "lt"),
    "less_than_equal": ("<=", "le"),
}


def _relation(details: ErrorDetails, context: dict[str, Any], unit: str) -> str:
    """``must be ...`` for each kind of error of the parts."""
    kind = details["type"]
    if kind in {"scene", "quantity"}:
        return str(context["relation"])
    if kind in _BOUNDS:
        sign, name = _BOUNDS[kind]
        bound, given = context[name], details["input"]
        if bound and isinstance(given, str):
            shown = in_typed_unit(bound, given, unit)
        else:
            shown = f"{bound:g}{f' {unit}' if bound and unit else ''}"
        return f"must be {sign} {shown}." + _sign_hint(given, bound)
    if kind == "literal_error":
        return _one_of_texts(str(context.get("expected", "")), details["input"])
    relations = {
        "multiple_of": f"must be a multiple of {context.get('multiple_of', '')}.",
        "too_short": f"must have at least {context.get('min_length', '')} entries.",
        "too_long": f"must have at most {context.get('max_length', '')} entries.",
        "int_type": "must be a whole number.",
        "int_from_float": "must be a whole number.",
        "int_parsing": "must be a whole number.",
        "string_type": "must be text.",
        "string_too_short": "must not be empty.",
        "tuple_type": "must be a list.",
        "dict_type": "must be a table.",
        "model_type": "must be a table.",
        "model_attributes_type": "must be a table.",
        "path_type": "must be the name of a file.",
    }
    return relations.get(kind, f"{details['msg']}.")


def _one_of_texts(expected: str, value: object) -> str:
    """Pydantic's expectation ``'a', 'b' or 'c'`` in the form of all messages, with the nearest choice."""
    names = re.findall(r"'([^']*)'", expected)
    if not names:
        return f"must be {expected}."
    return f"must be {one_of(names)}.{nearest(value, names) if isinstance(value, str) else ''}"


def _sign_hint(value: object, bound: float) -> str:
    number = value if isinstance(value, (int, float)) else None
    if isinstance(value, str):
        return " Is the sign right?" if value.strip().startswith("-") else ""
    return " Is the sign right?" if number is not None and number < 0 <= bound else ""
