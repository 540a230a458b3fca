"""The engine's options of a scene's parts."""

from __future__ import annotations

from typing import Any

from plica import _engine
from plica.scene.part import OneOf, Part

__all__ = ["engine_options"]


def engine_options(part: Part, **given: Any) -> Any:
    """The engine's options struct with the part's name, from the fields of the part and the given ones."""
    options = getattr(_engine, type(part).__name__)
    names = {*options._defaults, *(name for name in type(part).model_fields if hasattr(options, name))}
    fields = {name: getattr(part, name) for name in names - given.keys()}
    chosen = {
        name: engine_options(field.choice if isinstance(field, OneOf) else field)
        for name, field in fields.items()
        if isinstance(field, Part)
    }
    return options(**fields | chosen, **given)
