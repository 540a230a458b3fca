"""What measures must know of the scene of a run, from its text."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from typing import Any

__all__ = ["airway_name", "scene_table", "scene_tables"]


@lru_cache(maxsize=8)  # of a run it is asked for often
def scene_tables(scene_text: str) -> dict[str, Any]:
    """The keys and tables of a scene (TOML); none of a run that was not made from a scene file. To be read
    only."""
    try:
        return tomllib.loads(scene_text)
    except tomllib.TOMLDecodeError:
        return {}


def scene_table(scene_text: str, name: str) -> dict[str, Any] | None:
    """A table of the scene; None if it has none of this name."""
    table = scene_tables(scene_text).get(name)
    return table if isinstance(table, dict) else None


def airway_name(scene_text: str) -> str:
    """Name of the surface of the airflow; ``airway`` if the scene has no airflow, or says nothing."""
    return str((scene_table(scene_text, "airflow") or {}).get("surface", "airway"))
