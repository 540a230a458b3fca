"""The rooms of the package and which of them may import which."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

import plica
from repository import ROOT

_PACKAGE = Path(plica.__file__).parent
_BASE = {"plica._engine", "plica.errors", "plica.tetrahedron", "plica.units"}
_SHARED = {"plica.measures", "plica.report", "plica.storage"}
_ABOVE_A_RUN = {"plica.scene", "plica.runs", "plica.measures.run"}
_MAY_IMPORT = {
    "plica.storage": _BASE,
    "plica.measures": _BASE | {"plica.storage"},
    "plica.scene": _BASE | {"plica.measures", "plica.storage"},
    "plica.sound": _BASE | {"plica.measures", "plica.storage"},
    "plica.measures.run": _BASE | {"plica.measures", "plica.sound"},
    "plica.runs": _BASE | _SHARED | {"plica.scene", "plica.measures.run", "plica.sound"},
    "plica.report": _BASE | _SHARED,
    "plica.report.run": _BASE | _SHARED | {"plica.measures.run", "plica.sound"},
    "plica.video": _BASE | _SHARED,
    "plica.synthetic": _BASE | {"plica.video"},
    "plica.camera": _BASE,
    "plica.films": _BASE | {"plica.camera", "plica.storage"},
    "plica.viewer": _BASE | _SHARED | {"plica.films", "plica.measures.run"},
    "plica.larynx_fit": _BASE | _SHARED | {"plica.camera", "plica.films", "plica.scene", "plica.video"},
    "plica.stability": _BASE | _SHARED | {"plica.runs", "plica.scene"},
    "plica.uncertainty": _BASE | _SHARED | _ABOVE_A_RUN,
    "plica.sweep": _BASE | _SHARED | _ABOVE_A_RUN | {"plica.identify", "plica.video"},
    "plica.identify": _BASE | _SHARED | {"plica.camera", "plica.runs", "plica.scene", "plica.video"},
}
_FLOORS = {
    "plica.video": (
        {"errors", "files"},
        {"glottis"},
        {"motion"},
        {"settings"},
        {"measures"},
        {
            "analysis",
            "chain",
            "checks",
            "dataset",
            "dicom_report",
            "light",
            "matlab",
            "opening",
            "praat",
            "results",
            "signals",
            "tables",
            "workbook",
        },
        {"report"},
    ),
    "plica.identify": (
        {"parameters", "settings"},
        {"observation"},
        {"model"},
        {"state_space"},
        {"likelihood"},
        {"estimator"},
        {"results"},
        {"report"},
        {"identification"},
    ),
}
"""What lies on each floor of a room, the lowest first: nothing imports from a floor above its own."""


def _modules(room: str) -> list[Path]:
    """The files of a room without those of the rooms inside it."""
    folder = _PACKAGE / room.removeprefix("plica").removeprefix(".").replace(".", "/")
    inner = [other for other in _MAY_IMPORT if other.startswith(room + ".")]
    return [file for file in sorted(folder.rglob("*.py")) if not any(_inside(_name(file), o) for o in inner)]


def _name(file: Path) -> str:
    parts = ("plica", *file.relative_to(_PACKAGE).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


def _imports(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            yield from (f"{node.module}.{name.name}" for name in node.names)


def _inside(name: str, room: str) -> bool:
    return name == room or name.startswith(room + ".")


def _room(name: str) -> str:
    """The innermost room that a name of the package is in."""
    return max((room for room in _MAY_IMPORT if _inside(name, room)), key=len, default=name)


@pytest.mark.parametrize("room", _MAY_IMPORT)
def test_a_room_imports_only_what_lies_below_it(room: str) -> None:
    files = _modules(room)
    assert files
    allowed = _MAY_IMPORT[room] | {room}
    wrong = [
        f"{file.relative_to(_PACKAGE)}: {name}"
        for file in files
        for name in _imports(file)
        if _inside(name, "plica") and not any(_inside(_room(name), below) for below in allowed)
    ]
    assert wrong == []


@pytest.mark.parametrize("room", _FLOORS)
def test_nothing_in_a_room_imports_from_a_floor_above(room: str) -> None:
    floor = {name: level for level, names in enumerate(_FLOORS[room]) for name in names}
    wrong, seen = [], set()
    for file in _modules(room):
        own = _name(file).removeprefix(room).removeprefix(".").partition(".")[0]
        if not own:  # the room's own names
            continue
        seen.add(own)
        for name in _imports(file):
            other = name.removeprefix(room + ".").partition(".")[0]
            if _inside(name, room) and not (other in floor and floor[other] <= floor[own]):
                wrong.append(f"{file.relative_to(_PACKAGE)}: {name}")
    assert wrong == []
    assert seen == floor.keys()


def test_no_module_imports_one_that_imports_it() -> None:
    """Also within functions, and through others."""
    names = {_name(file): file for file in sorted(_PACKAGE.rglob("*.py"))}
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


def test_the_package_imports_no_benchmark() -> None:
    files = list(_PACKAGE.rglob("*.py"))
    assert [file for file in files for name in _imports(file) if _inside(name, "benchmarks")] == []


def _is_there(name: str) -> bool:
    module, _, last = name.rpartition(".")
    if hasattr(importlib.import_module(module), last):
        return True
    try:
        return importlib.import_module(name) is not None
    except ModuleNotFoundError:
        return False


def test_what_benchmarks_and_examples_import_is_there() -> None:
    files = [file for folder in ("benchmarks", "examples") for file in (ROOT / folder).rglob("*.py")]
    assert len(files) > 20
    missing = [
        f"{file.relative_to(ROOT)}: {name}"
        for file in files
        for name in _imports(file)
        if name.startswith(("benchmarks.", "plica.")) and not _is_there(name)
    ]
    assert missing == []
