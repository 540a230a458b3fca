"""``plica info``: versions, contents and licence of this build."""

from __future__ import annotations

import argparse
import sys
from importlib import metadata
from typing import Any

from plica.commands.arguments import add_command

__all__ = ["add_commands"]


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    add_command(commands, "info", _info, "show versions, contents and licence of this build")


def _info(options: argparse.Namespace) -> int:
    import plica

    info = plica.build_info()
    licence = "GPL-3.0-or-later (it contains parts under the GPL)" if info["gpl"] else "BSD-3-Clause"
    rows = {"plica": info["version"], "licence of this build": licence}
    rows |= {name: _plain(value) for name, value in info.items() if name not in {"version", "gpl"}}
    if "meshing" in info["absent"]:
        rows["meshing is for"] = "contact between any two meshes; built by PLICA_GPL=ON pip install ."
    rows["python"] = sys.version.split()[0]
    for name in (
        "numpy",
        "scipy",
        "h5py",
        "meshio",
        "pydantic",
        "pint",
        "xarray",
        "matplotlib",
        "pillow",
        "av",
        "weasyprint",
    ):
        try:
            rows[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            rows[name] = "not installed"
    width = max(map(len, rows))
    print("\n".join(f"{name:<{width}}  {value}" for name, value in rows.items()))
    return 0


def _plain(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
