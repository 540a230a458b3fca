"""The C++ reference: a page a module, of its public headers, which Doxygen reads and Breathe shows."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sphinx.errors import ExtensionError

__all__ = ["XML", "made", "public_headers", "setup"]

ROOT = Path(__file__).parents[2]
XML = ROOT / "build" / "docs" / "doxygen" / "xml"
_FILTER = r"sed -E 's@([;,{}(] *|^ {8,})// @\1///< @'"
"""Of each line: a comment behind a declaration ("// Pa, > 0"), or far in, where it goes on, documents it."""
_SETTINGS = {
    "PROJECT_NAME": "Plica",
    "OUTPUT_DIRECTORY": XML.parent,
    "STRIP_FROM_PATH": ROOT / "cpp",
    "INPUT_FILTER": f'"{_FILTER}"',
    "EXTRACT_ALL": "YES",
    "JAVADOC_AUTOBRIEF": "YES",
    "MARKDOWN_SUPPORT": "YES",
    "AUTOLINK_SUPPORT": "NO",
    "GENERATE_HTML": "NO",
    "GENERATE_LATEX": "NO",
    "GENERATE_XML": "YES",
    "XML_PROGRAMLISTING": "NO",
    "QUIET": "YES",
    "WARN_IF_UNDOCUMENTED": "NO",
    "WARN_AS_ERROR": "YES",
}


def setup(app: Any) -> None:
    app.connect("builder-inited", lambda _: _read_headers())


def public_headers() -> Iterator[tuple[str, Path]]:
    """Module and path of each header for embedders."""
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    for module, headers in re.findall(r"plica_module\((\w+)[^)]*?PUBLIC_HEADERS ([^)]*)\)", text):
        for name in headers.split():
            yield module, ROOT / "cpp/plica" / module / name


def _read_headers() -> None:
    if shutil.which("doxygen") is None:
        raise ExtensionError(
            "docs: doxygen is not installed; must be, as it reads the C++ headers. Run apt install doxygen."
        )
    XML.parent.mkdir(parents=True, exist_ok=True)
    inputs = " ".join(f'"{path}"' for _, path in public_headers())
    text = "".join(f"{name} = {value}\n" for name, value in {**_SETTINGS, "INPUT": inputs}.items())
    done = subprocess.run(["doxygen", "-"], input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ExtensionError(f"docs: doxygen cannot read the headers: {done.stderr.strip()}")


def made() -> dict[str, str]:
    """The pages, by their path in docs."""
    headers: dict[str, list[str]] = {}
    for module, path in public_headers():
        headers.setdefault(module, []).append(path.name)
    contents = _contents()
    found = {
        f"reference/cpp/{module}.md": _page(module, names, contents[module])
        for module, names in headers.items()
    }
    rows = [f"| [`{module}`](cpp/{module}.md) | {contents[module]} |" for module in headers]
    tree = ["```{toctree}\n:hidden:\n:maxdepth: 1\n", *(f"cpp/{module}" for module in headers), "```\n"]
    return found | {"reference/cpp.md": "\n".join([_INTRODUCTION, *rows, "", *tree])}


_INTRODUCTION = """\
# C++

The headers for embedders, by module. Names do not change without a line in the changelog; sizes, indices and
options are checked. How modules stand on each other is in [the architecture](../architecture.md); a program
that steps a scene is [examples/embedding.cpp](../../examples/embedding.cpp).

| Module | Contents |
|---|---|"""


def _contents() -> dict[str, str]:
    """What is in each module, of the table in docs/architecture.md."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    return dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", text, re.MULTILINE))


def _page(module: str, names: list[str], contents: str) -> str:
    parts = [f"# `{module}`\n", f"{contents[0].upper()}{contents[1:]}.\n"]
    for name in names:
        shown = f"```{{eval-rst}}\n.. doxygenfile:: {name}\n   :sections: {_SECTIONS}\n```\n"
        parts += [f"## `plica/{module}/{name}`\n", shown]
    return "\n".join(parts)


_SECTIONS = " ".join(
    (
        "briefdescription",
        "detaileddescription",
        "innernamespace",
        "innerclass",
        "enum",
        "typedef",
        "func",
        "var",
        "public-type",
        "public-attrib",
        "public-func",
        "public-static-attrib",
        "public-static-func",
    )
)
