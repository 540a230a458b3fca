"""Reference of all scene keys, from the docstrings of the parts: for ``plica keys`` and docs/scene.md."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
import types
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

from plica.scene.mesh.parts import Block, Blocks, Larynx, LarynxOptions, MeshFile
from plica.scene.part import OneOf, Part
from plica.scene.scene import Scene
from plica.scene.tissue import TissueSide
from plica.scene.voices import VOICES

__all__ = ["Key", "Table", "part_keys", "scene_tables"]


@dataclass(frozen=True)
class Key:
    """One key of a table.

    Attributes
    ----------
    name : str
    unit : str
        SI; empty if it is not a quantity.
    default : str
        As written in a scene file, or "required", or a description.
    meaning : str
    """

    name: str
    unit: str
    default: str
    meaning: str


@dataclass(frozen=True)
class Table:
    """One table of a scene file.

    Attributes
    ----------
    path : str
        Its path, ``airflow.coupling``; empty: the scene itself.
    kind : str
        The key that distinguishes several tables of one path, ``larynx`` of ``mesh``; else empty.
    description : str
        One sentence or more.
    keys : tuple of Key
    """

    path: str
    kind: str
    description: str
    keys: tuple[Key, ...]

    @property
    def title(self) -> str:
        """``[airflow]``, or "The scene"."""
        where = f"[{self.path}]" if self.path else "The scene"
        return f"{where} with {self.kind}" if self.kind else where


_OF_A_FILE = (
    Key(
        "voice",
        "",
        "none",
        "Of a scene file: the voice of a person that its other keys change, in Python "
        "`plica.Scene.of_voice(NAME).replace({...})`. Nothing else is required then (docs/voices.md). "
        f"One of {', '.join(f'`{chr(34)}{name}{chr(34)}`' for name in VOICES)}.",
    ),
    Key("without", "", "none", 'Keys that are left out of the voice, e.g. `["symmetry", "tract"]`.'),
)

_KINDS = {Larynx: "larynx", MeshFile: "file", Blocks: "blocks"}


@cache
def scene_tables() -> tuple[Table, ...]:
    """All tables of a scene, each once, from the outside in."""
    found: dict[tuple[type[Part], str], Table] = {}
    for part, path in _parts_below(Scene):
        if (part, path) not in found:
            found[part, path] = Table(path, _KINDS.get(part, ""), _description(part), tuple(_keys(part)))
    return tuple(found.values())


def part_keys(part: type[Part]) -> tuple[Key, ...]:
    """The fields of a part as keys of a scene file."""
    return tuple(key for key in _keys(part) if key not in _OF_A_FILE)


def _parts_below(part: type[Part], path: str = "") -> Iterator[tuple[type[Part], str]]:
    """This part and those inside it, each with its path in the file."""
    yield part, f"{path}.block" if part is Block and path == "mesh" else path
    for name, field in part.model_fields.items():
        for inner, place in _parts_in(field.annotation, f"{path}.{name}".lstrip(".")):
            yield from _parts_below(inner, place)


def _parts_in(annotation: object, path: str) -> Iterator[tuple[type[Part], str]]:
    """The parts that a field may hold, each with its path in the file."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        yield annotation, path
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated or origin in (typing.Union, types.UnionType):
        for one in inner[:1] if origin is typing.Annotated else inner:
            yield from _parts_in(one, path)
    elif origin is dict:
        yield from _parts_in(inner[1], f"{path}.NAME")
    elif origin is tuple:
        yield from _parts_in(inner[0], f"[{path}]")


def _keys(part: type[Part]) -> Iterator[Key]:
    if part is TissueSide:  # same keys as the tissue
        return
    if part is Scene:
        yield from _OF_A_FILE
    for name in part.model_fields:
        if part is Block and name == "order":  # it is in [mesh], as for the other meshes
            continue
        unit, meaning = _meaning(part, name)
        yield Key(name, unit, _default(part, name), meaning)


def _default(part: type[Part], name: str) -> str:
    field = part.model_fields[name]
    if field.is_required():
        return "required"
    if issubclass(part, OneOf) and name in part.kinds:
        return "one of these"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, OneOf):
        return _written(next(name for name in value.kinds if getattr(value, name) is not None))
    if value is None:
        return "the preset's" if part is LarynxOptions else "left out"
    if isinstance(value, Part) or value in ((), {}):
        return "see below" if isinstance(value, Part) else "none"
    return _written(value)


def _written(value: object) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"'
        case tuple():
            return f"[{', '.join(map(_written, value))}]"
        case _:
            return f"{value:g}"


def _choices(annotation: object) -> str:
    """The allowed values of a field with a closed list of them."""
    found = [annotation, *typing.get_args(annotation)]
    literal = next((one for one in found if typing.get_origin(one) is typing.Literal), None)
    if literal is None:
        return ""
    values = (*((True, False) if bool in found else ()), *typing.get_args(literal))
    return f" One of {', '.join(f'`{_written(value)}`' for value in values)}."


def _meaning(part: type[Part], name: str) -> tuple[str, str]:
    """Unit and meaning."""
    field = part.model_fields[name]
    text = _plain(_attribute_docstrings(part).get(name, ""))
    if not text and issubclass(part, OneOf) and name in part.kinds:
        text = _plain(_first_paragraph(part.kinds[name]))
    found = re.match(r"\[(.*?)\] ?(.*)", text)
    unit, meaning = (found[1].replace("-", "1") if found else "", found[2] if found else text)
    return unit, (meaning + _choices(field.annotation)).strip()


@cache
def _attribute_docstrings(part: type[Part]) -> dict[str, str]:
    """The texts below the fields of a part, by field; read from the source, which pydantic would do for each
    part when it is imported."""
    found = {}
    for base in reversed(part.__mro__):
        if issubclass(base, Part):
            (made,) = ast.parse(textwrap.dedent(inspect.getsource(base))).body
            assert isinstance(made, ast.ClassDef)
            for statement, below in pairwise(made.body):
                if isinstance(statement, ast.AnnAssign) and isinstance(below, ast.Expr):
                    found[ast.unparse(statement.target)] = str(ast.literal_eval(below.value))
    return found


def _plain(text: str) -> str:
    """The text on one line, with single backquotes."""
    return " ".join(text.split()).replace("``", "`")


def _description(part: type[Part]) -> str:
    """The docstring of a part; for the scene, whose docstring documents the Python class, its first
    paragraph."""
    if part is TissueSide:
        return "Values that differ on that side; keys as in `[tissue.NAME]`."
    text = _first_paragraph(part) if part is Scene else inspect.getdoc(part) or ""
    text = text.replace("``", "`")
    if part is Block:
        text += "\n\n`order` is in `[mesh]`, as for the other meshes: 1, or 2 for quadratic tetrahedra."
    return text


def _first_paragraph(part: type) -> str:
    return (inspect.getdoc(part) or "").split("\n\n")[0]
