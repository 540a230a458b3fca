"""A study file: what is swept, the design and what is varied, as TOML.

::

    scene = "voice.toml"
    design = "sobol"
    samples = 256

    [vary]
    airflow.subglottal_pressure = "0.6:1.0 kPa"
    tissue.cover.E = "1:4 kPa"

Of recordings: ``recordings``, ``until`` and a table ``settings``, those of `plica.video.Settings`; with a
``scene`` the recordings are asked for its tissue, and ``settings`` are those of `plica.identify.Settings`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from plica.errors import InvalidInput, nearest
from plica.scene.problems import path_text, value_text
from plica.storage.files import require_file
from plica.sweep.identification_cases import Identifications
from plica.sweep.plan import Plan
from plica.sweep.recording_cases import Recordings
from plica.sweep.subject import Subject

__all__ = ["is_study", "read_study"]

_KINDS: dict[str, type] = {"design": str, "samples": int, "seed": int, "keep": str, "waveforms": list}
_OF: dict[str, type] = {"scene": str, "recordings": list, "until": str, "settings": dict}
_NAMES = (*_OF, *_KINDS, "vary")
_MUST: dict[type, str] = {str: "text", int: "a whole number", list: "a list of texts", dict: "a table"}


def is_study(path: Path) -> bool:
    """Whether a file is a study: it has a table `vary` or a list of recordings, as no scene has."""
    try:
        return not {"vary", "recordings"}.isdisjoint(tomllib.loads(path.read_text(encoding="utf-8-sig")))
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
    if "scene" not in data and "recordings" not in data:
        raise InvalidInput(f"{path.name}: scene is missing; must be there, or recordings.")
    if "vary" not in data and "recordings" not in data:
        raise InvalidInput(f"{path.name}: vary is missing.")
    for name, kind in (_OF | _KINDS | {"vary": dict}).items():
        if name in data and (not isinstance(data[name], kind) or isinstance(data[name], bool)):
            raise InvalidInput(f"{path.name}: {name} = {value_text(data[name])}; must be {_MUST[kind]}.")
    for name in ("waveforms", "recordings"):
        if any(not isinstance(one, str) for one in data.get(name, ())):
            raise InvalidInput(f"{path.name}: {name} = {value_text(data[name])}; must be a list of texts.")
    vary = dict(_flat(data.get("vary", {}), ()))
    given: dict[str, Any] = {name: data[name] for name in _KINDS if name in data}
    return Plan.make(_subject(path, data), vary, where=path.name, **given)


def _subject(path: Path, data: Mapping[str, Any]) -> Subject | Path:
    """What a study is of."""
    if "recordings" in data and "scene" not in data:
        until = {"until": data["until"]} if "until" in data else {}
        settings = _video_settings(path, data.get("settings", {}))
        return Recordings(data["recordings"], settings, where=path.name, base=path.parent, **until)
    if "until" in data:
        raise InvalidInput(f"{path.name}: until is given; must be left out: it is of recordings alone.")
    scene = path.parent / str(data["scene"])
    if "recordings" not in data:
        if "settings" in data:
            raise InvalidInput(f"{path.name}: settings are given; must be left out: they are of recordings.")
        return scene
    from plica.identify.settings import Settings

    found = Settings.of_table(data.get("settings", {}), path, ("settings",))
    return Identifications(data["recordings"], scene, found, where=path.name, base=path.parent)


def _video_settings(path: Path, table: Mapping[str, Any]) -> Any:
    from plica.video.settings import Settings

    known = [one.name for one in fields(Settings)]
    for name in table:
        if name not in known:
            raise InvalidInput(f"{path.name}: settings.{name} is not known.{nearest(name, known)}")
    given: dict[str, Any] = {
        name: tuple(one) if isinstance(one, list) else one for name, one in table.items()
    }
    if isinstance(given.get("segmenter"), str):
        given["segmenter"] = str((path.parent / given["segmenter"]).resolve())
    return Settings(**given)


def _flat(table: Mapping[str, Any], path: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    """Key and value; a key may be a dotted path, also where it is written as one text."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, (*path, name))
        else:
            yield (path_text((*path, name)) if path else name), value
