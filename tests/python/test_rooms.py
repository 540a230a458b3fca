"""The rooms of the package and which of them may import which."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

import plica

_PACKAGE = Path(plica.__file__).parent
_BASE = {"plica._engine", "plica.errors", "plica.tetrahedron", "plica.units"}
_VIEW = {"plica.view"}
_SHARED = {"plica.measures", "plica.report", "plica.storage"}
_SCENE = {"plica.phonation.scene"}
_MEASURED = {"plica.phonation.measures"}
_MAY_IMPORT = {
    "plica.storage": _BASE,
    "plica.measures": _BASE | {"plica.storage"},
    "plica.phonation.scene": _BASE | {"plica.measures", "plica.storage"},
    "plica.phonation.measures": _BASE | {"plica.measures"},
    "plica.phonation.run": _BASE | _SHARED | _SCENE | _MEASURED,
    "plica.phonation.report": _BASE | _SHARED | _MEASURED,
    "plica.report": _BASE | _SHARED,
    "plica.video": _BASE | _SHARED,
    "plica.view": _BASE,
    "plica.film": _BASE | _VIEW | {"plica.storage"},
    "plica.larynx_fit": _BASE | _VIEW | _SHARED | _SCENE | {"plica.film", "plica.video"},
    "plica.uncertainty": _BASE | _SHARED | _SCENE | _MEASURED | {"plica.phonation.run"},
    "plica.identify": _BASE | _VIEW | _SHARED | _SCENE | {"plica.phonation.run", "plica.video"},
}


def _modules(room: str) -> list[Path]:
    return sorted((_PACKAGE / room.removeprefix("plica").removeprefix(".").replace(".", "/")).rglob("*.py"))


def _imports(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            yield from (f"{node.module}.{name.name}" for name in node.names)


def _inside(name: str, room: str) -> bool:
    return name == room or name.startswith(room + ".")


@pytest.mark.parametrize("room", _MAY_IMPORT)
def test_a_room_imports_only_what_lies_below_it(room: str) -> None:
    files = _modules(room)
    assert files
    allowed = _MAY_IMPORT[room] | {room}
    wrong = [
        f"{file.relative_to(_PACKAGE)}: {name}"
        for file in files
        for name in _imports(file)
        if _inside(name, "plica") and not any(_inside(name, below) for below in allowed)
    ]
    assert wrong == []


def _name(file: Path) -> str:
    parts = ("plica", *file.relative_to(_PACKAGE).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


def test_no_module_imports_one_that_imports_it() -> None:
    """Also within functions, and through others."""
    names = {_name(file): file for file in _modules("plica")}
    below = {
        name: {
            found
            for given in _imports(file)
            if (found := given if given in names else given.rpartition(".")[0]) in names
        }
        - {name, "plica"}
        for name, file in names.items()
    }
    assert len(below) > 300
    while leaves := {name for name, imported in below.items() if not imported & below.keys()}:
        below = {name: imported for name, imported in below.items() if name not in leaves}
    assert sorted(below) == []


def test_every_module_of_phonation_is_in_a_room() -> None:
    assert [file.name for file in (_PACKAGE / "phonation").glob("*.py")] == ["__init__.py"]


def _is_there(name: str) -> bool:
    module, _, last = name.rpartition(".")
    if hasattr(importlib.import_module(module), last):
        return True
    try:
        return importlib.import_module(name) is not None
    except ModuleNotFoundError:
        return False


def test_what_benchmarks_and_examples_import_is_there() -> None:
    root = Path(__file__).parents[2]
    files = [file for folder in ("benchmarks", "examples") for file in (root / folder).rglob("*.py")]
    assert len(files) > 20
    missing = [
        f"{file.relative_to(root)}: {name}"
        for file in files
        for name in _imports(file)
        if name.startswith(("benchmarks.", "plica.")) and not _is_there(name)
    ]
    assert missing == []
