"""``plica info``: versions, contents and licences of this build."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Mapping
from importlib import metadata
from typing import Any, NamedTuple

from plica.commands.arguments import add_command

__all__ = ["add_commands"]

_HELP = """\
Versions, contents and licence of this build. With --licences also the licence of all that it contains and
of every package that it imports, by what they are for; what is not installed is left out.

examples:
  plica info
  plica info --licences
"""

_ENGINE = {
    "Eigen": "MPL-2.0",
    "pybind11": "BSD-3-Clause",
    "CGAL (kernel)": "LGPL-3.0-or-later",
    "Boost": "BSL-1.0",
}
"""What is compiled into the engine; headers alone (docs/dependencies.md)."""

_ENGINE_GPL = {"CGAL (triangulations)": "GPL-3.0-or-later", "SuiteSparse CHOLMOD": "GPL-2.0-or-later"}
"""Likewise, with PLICA_GPL=ON."""

_ENGINE_LIBCXX = {
    "LLVM libc++, libc++abi, libunwind": "Apache-2.0 WITH LLVM-exception",
    "Zig compiler_rt": "MIT",
}
"""Likewise, in the wheels of `make wheel`, which take no C++ run time from the system."""

_IN_PAGES = {"three.js": "MIT", "uPlot": "MIT"}
"""What the pages of `plica view` contain (viewer/vendor/licences.txt)."""

_BROUGHT = {"av": "its wheel holds FFmpeg with libx264 and libx265: GPL-2.0-or-later"}
"""What a package's own metadata does not say of its wheel."""


class _Need(NamedTuple):
    name: str
    extra: str
    """Of Plica, that asks for it; empty: every installation does."""


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    info = add_command(commands, "info", _info, "show versions, contents and licences of this build", _HELP)
    info.add_argument("--licences", action="store_true", help="also of all that is contained or imported")


def _info(options: argparse.Namespace) -> int:
    import plica

    info = plica.build_info()
    licence = "GPL-3.0-or-later (it contains parts under the GPL)" if info["gpl"] else "BSD-3-Clause"
    rows = {"plica": info["version"], "licence of this build": licence}
    rows |= {
        name.replace("_", " "): _plain(value)
        for name, value in info.items()
        if name not in {"version", "gpl"}
    }
    if "meshing" in info["absent"]:
        rows["meshing is for"] = "contact between any two meshes; built by PLICA_GPL=ON pip install ."
    rows["python"] = sys.version.split()[0]
    for need in _needs("plica"):
        absent = f"not installed: pip install 'plica[{need.extra}]'" if need.extra else "not installed"
        rows[need.name] = _version(need.name) or absent
    _show(rows)
    if options.licences:
        print("\nCompiled into the engine")
        own_run_time = info["standard_library"].startswith("libc++")
        _show(_ENGINE | (_ENGINE_GPL if info["gpl"] else {}) | (_ENGINE_LIBCXX if own_run_time else {}))
        print("\nIn the pages of plica view")
        _show(_IN_PAGES)
        for extra, names in _installed().items():
            print(f"\nFor plica[{extra}]" if extra else "\nImported by every installation")
            _show({name: _licence(name) for name in names})
    return 0


def _needs(package: str) -> Iterator[_Need]:
    """What a package asks for, but not to develop it, nor all of its extras by one name."""
    for text in metadata.requires(package) or []:
        name = re.match(r"[\w.-]+", text)
        extra = re.search(r"extra *== *['\"]([\w-]+)['\"]", text)
        if name is not None and (extra is None or extra[1] not in ("dev", "all")):
            yield _Need(name[0], extra[1] if extra else "")


def _installed() -> dict[str, list[str]]:
    """What is installed of all that Plica asks for, directly or not, by the extra that does."""
    found: dict[str, str] = {}
    waiting = [*_needs("plica")]
    waiting.sort(key=lambda need: need.extra)
    while waiting:
        need = waiting.pop(0)
        name = need.name.lower().replace("_", "-")
        if name not in found and _version(name) is not None:
            found[name] = need.extra
            waiting[:0] = [_Need(other.name, need.extra) for other in _needs(name) if not other.extra]
    extras = sorted(set(found.values()))
    return {extra: sorted(name for name, of in found.items() if of == extra) for extra in extras}


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _licence(package: str) -> str:
    """As its metadata states it: an SPDX expression, or its classifier, or the first line of a text."""
    stated = metadata.metadata(package)
    kinds = [text.rpartition(" :: ")[2] for text in stated.get_all("Classifier", []) if "License ::" in text]
    expression, text = (next(iter(stated.get_all(key, [])), "") for key in ("License-Expression", "License"))
    text = expression or "; ".join(kinds) or text or "not stated"
    also = _BROUGHT.get(package)
    return text.splitlines()[0] + (f"; {also}" if also else "")


def _show(rows: Mapping[str, object]) -> None:
    width = max(map(len, rows))
    print("\n".join(f"{name:<{width}}  {value}" for name, value in rows.items()))


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
