"""The surface that the airflow is in."""

from __future__ import annotations

import tomllib

__all__ = ["airway_name"]


def airway_name(scene_text: str) -> str:
    """Name of the surface of the airflow of a scene (TOML); ``airway`` if it has none, or says nothing."""
    try:
        airflow = tomllib.loads(scene_text).get("airflow", {})
    except tomllib.TOMLDecodeError:
        airflow = {}
    return str(airflow.get("surface", "airway")) if isinstance(airflow, dict) else "airway"
