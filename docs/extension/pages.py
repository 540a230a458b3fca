"""Pages that are made of the code: scene keys, cautions, commands, Python and C++. Never in git."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import plica
from extension import cautions, cpp, keys
from plica.commands.main import command_parsers
from plica.scene.part import Part
from plica.scene.reference import part_keys

GROUPS: Mapping[str, tuple[str, ...]] = {
    "Scenes": ("plica.scene",),
    "Runs and what is made of them": (
        "plica.runs",
        "plica.sweep",
        "plica.uncertainty",
        "plica.films",
        "plica.viewer",
        "plica.camera",
    ),
    "Modes and onset": ("plica.stability",),
    "Recordings and tissue from them": ("plica.video", "plica.identify"),
    "Errors and this build": ("plica.errors", "plica._engine"),
}
"""Of the names of `plica`, by the beginning of the module that each is from."""


def setup(app: Any) -> None:
    app.connect("builder-inited", _make)


def _make(app: Any) -> None:
    folder = Path(app.srcdir)
    for name, text in made().items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def made() -> dict[str, str]:
    """All pages by their path in docs."""
    found = {"scene.md": keys.text(), "cautions.md": cautions.text(), "reference/commands.md": _commands()}
    found["reference/python.md"] = _index()
    for name in _names():
        found[f"reference/python/{name}.md"] = _page(name)
    return found | cpp.made()


def _commands() -> str:
    parts = ["# Commands\n", "What `plica --help` and `plica COMMAND --help` print.\n"]
    for name, parser in command_parsers().items():
        parser.prog = f"plica {name}".strip()
        parts += [f"## `{parser.prog}`\n", f"```text\n{parser.format_help().rstrip()}\n```\n"]
    return "\n".join(parts)


def _names() -> list[str]:
    return [name for name in plica.__all__ if name != "__version__"]


def _module(name: str) -> str:
    found = getattr(plica, name)
    return str(found.__name__ if inspect.ismodule(found) else getattr(found, "__module__", "plica.scene"))


def _index() -> str:
    parts = [
        "# Python\n",
        "All of `plica`. Fields of scene parts are the keys of scene files, [by table](../scene.md).\n",
    ]
    left = _names()
    for title, begins in GROUPS.items():
        names = [name for name in left if _module(name).startswith(begins)]
        left = [name for name in left if name not in names]
        parts += [f"## {title}\n", "| | |", "|---|---|"]
        parts += [f"| [`{name}`](python/{name}.md) | {_summary(name)} |" for name in names]
        parts += [
            "",
            "```{toctree}\n:hidden:\n:maxdepth: 1\n",
            *(f"python/{name}" for name in names),
            "```\n",
        ]
    if left:
        raise RuntimeError(f"docs: in no group of the Python reference: {', '.join(left)}")
    return "\n".join(parts)


def _summary(name: str) -> str:
    text = inspect.getdoc(getattr(plica, name)) or ""
    found = getattr(plica, name)
    if not isinstance(found, type) and not callable(found) and not inspect.ismodule(found):
        text = "Tissue of the layers, by name." if name == "TISSUE_PRESETS" else ""
    lines = [line for line in text.partition("\n\n")[0].splitlines() if line]
    return " ".join(lines).replace("``", "`").replace("|", "\\|")


def _page(name: str) -> str:
    found = getattr(plica, name)
    if isinstance(found, type) and issubclass(found, Part):
        return _part(name, found)
    if inspect.ismodule(found):
        parts = [f"# `plica.{name}`\n", _rst("automodule", f"plica.{name}")]
        for inner in found.__all__:
            parts += [f"## `{inner}`\n", _rst(_kind(getattr(found, inner)), f"plica.{name}.{inner}")]
        return "\n".join(parts)
    return f"# `plica.{name}`\n\n" + _rst(_kind(found), f"plica.{name}")


def _kind(found: object) -> str:
    return "autoclass" if isinstance(found, type) else "autofunction" if callable(found) else "autodata"


def _rst(directive: str, target: str) -> str:
    members = "   :members:\n" if directive == "autoclass" else ""
    return f"```{{eval-rst}}\n.. {directive}:: {target}\n{members}```\n"


def _part(name: str, part: type[Part]) -> str:
    text = inspect.getdoc(part) or ""
    rows = list(_rows(part))
    parts = [f"# `plica.{name}`\n", text.replace("``", "`") + "\n"]
    if rows:
        parts += ["| field | unit | default | meaning |", "|---|---|---|---|", *rows, ""]
    for inner, value in vars(part).items():
        if inner.startswith("_") or "validator" in type(value).__name__.lower() or not inspect.getdoc(value):
            continue
        if isinstance(value, property):
            parts += [
                f"## `{inner}`\n",
                _rst("autoproperty", f"{part.__module__}.{part.__qualname__}.{inner}"),
            ]
        elif isinstance(value, classmethod) or inspect.isfunction(value):
            parts += [f"## `{inner}`\n", _rst("automethod", f"{part.__module__}.{part.__qualname__}.{inner}")]
    return "\n".join(parts)


def _rows(part: type[Part]) -> Iterator[str]:
    for key in part_keys(part):
        default = (
            key.default if " " in key.default or key.default in ("required", "none") else f"`{key.default}`"
        )
        meaning = key.meaning.replace("|", "\\|")
        yield f"| `{key.name}` | {key.unit} | {default} | {meaning} |"
