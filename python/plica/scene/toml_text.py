"""Plain data as TOML text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

__all__ = ["toml_line", "toml_text"]


def toml_text(data: Mapping[str, Any]) -> str:
    """Tables, lists, strings, numbers and booleans as TOML; numbers are read back to the same bits."""
    return "\n".join(_table(data, ())).lstrip("\n") + "\n"


def toml_line(name: str, value: Mapping[str, Any]) -> str:
    """A table on one line, so that following keys belong to the enclosing table."""
    return f"{_key(name)} = {_value(value)}\n"


def _table(data: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    inner = {name: value for name, value in data.items() if isinstance(value, Mapping)}
    own = {name: value for name, value in data.items() if name not in inner}
    lines = ["", f"[{'.'.join(_key(name) for name in path)}]"] if path and (own or not inner) else []
    lines += [f"{_key(name)} = {_value(value)}" for name, value in own.items()]
    for name, value in inner.items():
        lines += _table(value, (*path, name))
    return lines


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if bare else json.dumps(name)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(name)} = {_value(entry)}" for name, entry in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(entry) for entry in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
