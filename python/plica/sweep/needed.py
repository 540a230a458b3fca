"""The libraries that sweeps stand on, loaded where they are used."""

from __future__ import annotations

from typing import Any

from plica.errors import library

__all__ = ["needed"]


def needed(name: str) -> Any:
    """A library of the extra ``sweep``; without it an error says how to install it."""
    return library(name, "sweep", "plica sweep")
