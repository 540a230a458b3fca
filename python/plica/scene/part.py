"""Base classes of the parts of a scene: frozen, validated on creation, without unknown names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, cast

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from plica import _engine
from plica.errors import InvalidInput, SceneError, nearest, one_of
from plica.scene.changes import Changeable
from plica.scene.problems import describe

__all__ = ["MAX_COUNT", "Count", "OneOf", "Part", "engine_default", "problem"]

MAX_COUNT = 10**9
"""Limit of integers that are passed to the engine, which uses 32 bits."""

Count = Annotated[int, Field(ge=1, le=MAX_COUNT)]


def problem(relation: str, *path: str | int, **shown: object) -> PydanticCustomError:
    """An error at `path` below the part that raises it; the message reads ``path = value; relation``.

    Give ``value=`` to show a value, ``unit=" s"`` to show its unit behind it; without a value the message
    reads ``path: relation``.
    """
    return PydanticCustomError("scene", "{relation}", {"relation": relation, "path": path, **shown})


def engine_default(option: str, field: str) -> Callable[[], Any]:
    """The default of a field, from the engine's option struct so that it is defined once."""

    return lambda: getattr(_engine, option)._defaults[field]


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _ModelType
else:
    _ModelType = type(BaseModel)


class _PartType(_ModelType):
    """Creates a part and converts validation errors to SceneError."""

    def __call__(cls, *args: Any, **fields: Any) -> Any:  # noqa: N805 (of a class)
        names = getattr(cls, "positional", ())
        if len(args) > len(names):
            raise TypeError(
                f"{cls.__name__} takes {len(names)} positional arguments; {len(args)} were given. "
                f"Its keywords: {', '.join(getattr(cls, 'model_fields', ()))}."
            )
        try:
            return super().__call__(**dict(zip(names, args, strict=False)), **fields)
        except ValidationError as error:
            raise SceneError(describe(error, cls.__name__, cast("type[BaseModel]", cls))) from None


class Part(Changeable, metaclass=_PartType):
    """A part of a scene."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)
    positional: ClassVar[tuple[str, ...]] = ()
    """Fields that may be given as positional arguments."""

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_names(cls, data: Any) -> Any:
        if isinstance(data, dict):
            unknown = [str(name) for name in data if name not in cls.model_fields]
            if unknown:
                raise PydanticCustomError(
                    "unknown_names", "unknown names", {"unknown": unknown, "known": list(cls.model_fields)}
                )
        return data

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy without changes: pydantic does not validate `update`, `replace` does."""
        if update:
            names = ", ".join(map(str, update))
            raise InvalidInput(
                f"{type(self).__name__}.model_copy: update = {names}; must be left out: it would not be "
                'validated. Change fields with replace({"name": value}).'
            )
        return super().model_copy(deep=deep)


class OneOf(Part):
    """Exactly one of several parts; written as the part itself, as its name, or as a table of that name."""

    @model_validator(mode="before")
    @classmethod
    def _unwrap(cls, data: Any) -> Any:
        if isinstance(data, str):
            if data not in cls.kinds:
                raise problem(f"must be {one_of(cls.kinds)}.{nearest(data, cls.kinds)}", value=data)
            return {data: {}}
        for name, kind in cls.kinds.items():
            if isinstance(data, kind):
                return {name: data}
        return data

    @model_validator(mode="after")
    def _exactly_one(self) -> Self:
        given = [name for name in self.kinds if getattr(self, name) is not None]
        if len(given) != 1:
            found = f"it has {' and '.join(given)}" if given else "it has none of them"
            raise problem(f"must have exactly one of {', '.join(self.kinds)}; {found}.")
        return self

    @property
    def choice(self) -> Part:
        """The chosen part."""
        parts: list[Part] = [part for name in self.kinds if (part := getattr(self, name)) is not None]
        return parts[0]

    @property
    def chosen(self) -> str:
        """Its name."""
        return next(name for name in self.kinds if getattr(self, name) is not None)
