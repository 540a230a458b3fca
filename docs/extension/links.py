"""Links out of docs: to a folder or a page of the sources they become its name; files are downloads."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
_LINK = re.compile(r"\[([^\]\[]+)\]\(([^)\s:#]+)(?:#[^)\s]*)?\)")
_FENCE = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)


def setup(app: Any) -> None:
    app.connect("source-read", _read)


def _read(app: Any, docname: str, source: list[str]) -> None:
    folder = Path(app.srcdir, docname).parent
    parts = _FENCE.split(source[0])
    parts[::2] = [_LINK.sub(lambda link: _shown(link, folder), part) for part in parts[::2]]
    source[0] = "".join(parts)


def _shown(link: re.Match[str], folder: Path) -> str:
    target = Path(os.path.normpath(folder / link[2]))
    if target == ROOT / "README.md":
        return f"[{link[1]}]({os.path.relpath(ROOT / 'docs' / 'index.md', folder)})"
    if not target.is_dir() and not (target.suffix == ".md" and not target.is_relative_to(ROOT / "docs")):
        return link[0]
    name = link[1].strip("`")
    path = target.relative_to(ROOT).as_posix()
    return f"`{path}`" if name in (path, path.rpartition("/")[2]) else f"{name} (`{path}`)"
