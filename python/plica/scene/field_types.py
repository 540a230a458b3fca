"""What the types of fields say: the types that they are made of, and the units of quantities."""

from __future__ import annotations

import typing
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import BaseModel

from plica.units import Unit

__all__ = ["leaves", "unit_at", "unit_of"]


def leaves(kinds: Iterable[Any]) -> Iterator[Any]:
    """What annotations are made of: types, and what stands beside them."""
    for kind in kinds:
        yield kind
        yield from leaves((*typing.get_args(kind), *getattr(kind, "__metadata__", ())))


def unit_of(kinds: Iterable[Any]) -> str | None:
    """The SI unit of a quantity, empty for a pure number; None for what is no quantity."""
    return next((kind.si for kind in leaves(kinds) if isinstance(kind, Unit)), None)


def unit_at(part: type[BaseModel], path: Iterable[str | int]) -> str:
    """The SI unit of the field at a path below a part; empty for what is no quantity."""
    kinds: tuple[Any, ...] = (part,)
    for name in path:
        tables = [kind for kind in leaves(kinds) if typing.get_origin(kind) is dict]
        if tables and "[" not in str(name):
            kinds = tuple(typing.get_args(table)[1] for table in tables)
            continue
        parts = [kind for kind in leaves(kinds) if isinstance(kind, type) and issubclass(kind, BaseModel)]
        fields = [kind.model_fields[name] for kind in parts if name in kind.model_fields]
        if fields:
            kinds = tuple(kind for field in fields for kind in (field.annotation, *field.metadata))
    return unit_of(kinds) or ""
