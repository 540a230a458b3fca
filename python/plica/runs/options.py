"""The engine's options of a scene's parts."""

from __future__ import annotations

from typing import Any

from plica import _engine
from plica.scene.part import OneOf, Part

__all__ = ["engine_options"]


def engine_options(part: Part, **given: Any) -> Any:
    """The engine's options struct with the part's name, from the fields of the part and the given ones."""
    options = getattr(_engine, type(part).__name__)
    fields = {name: getattr(part, name) for name in options._defaults if name not in given}
    chosen = {
        name: engine_options(field.choice if isinstance(field, OneOf) else field)
        for name, field in fields.items()
        if isinstance(field, Part)
    }
    return options(**fields | chosen, **given)
