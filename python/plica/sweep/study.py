"""A study file: scene, design and what is varied, as TOML.

::

    scene = "voice.toml"
    design = "sobol"
    samples = 256

    [vary]
    airflow.subglottal_pressure = "0.6:1.0 kPa"
    tissue.cover.E = "1:4 kPa"
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from plica.errors import InvalidInput, nearest
from plica.scene.problems import path_text, value_text
from plica.storage.files import require_file
from plica.sweep.plan import Plan

__all__ = ["is_study", "read_study"]

_KINDS: dict[str, type] = {"design": str, "samples": int, "seed": int, "keep": str, "waveforms": list}
_NAMES = ("scene", *_KINDS, "vary")


def is_study(path: Path) -> bool:
    """Whether a file is a study: it has a table `vary`, as no scene has."""
    try:
        return "vary" in tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError):
        return False


def read_study(path: str | Path) -> Plan:
    """The plan of a study file; raises InvalidInput, beginning with the file's name."""
    path = Path(path)
    require_file(path, str(path))
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}.") from None
    except ValueError as error:
        raise InvalidInput(f"{path.name}: not TOML: {error}.") from None
    for name in data:
        if name not in _NAMES:
            raise InvalidInput(
                f"{path.name}: {name} is not known.{nearest(name, _NAMES)} Known here: {', '.join(_NAMES)}."
            )
    for name in ("scene", "vary"):
        if name not in data:
            raise InvalidInput(f"{path.name}: {name} is missing.")
    given: dict[str, Any] = {name: data[name] for name in _KINDS if name in data}
    for name, value in {"scene": data["scene"], **given}.items():
        kind = _KINDS.get(name, str)
        if not isinstance(value, kind) or isinstance(value, bool):
            must = {str: "text", int: "a whole number", list: "a list of texts"}[kind]
            raise InvalidInput(f"{path.name}: {name} = {value_text(value)}; must be {must}.")
    if any(not isinstance(name, str) for name in given.get("waveforms", ())):
        raise InvalidInput(
            f"{path.name}: waveforms = {value_text(given['waveforms'])}; must be a list of texts."
        )
    if not isinstance(data["vary"], dict):
        raise InvalidInput(f"{path.name}: vary = {value_text(data['vary'])}; must be a table.")
    vary = dict(_flat(data["vary"], ()))
    return Plan.make(path.parent / data["scene"], vary, where=path.name, **given)


def _flat(table: Mapping[str, Any], path: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    """Key and value; a key may be a dotted path, also where it is written as one text."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, (*path, name))
        else:
            yield (path_text((*path, name)) if path else name), value
