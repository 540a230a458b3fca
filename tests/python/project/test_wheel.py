"""Wheels for any Linux of the last years: made by .ci/wheel, which runs a scene where Python alone is."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import re
import shutil
import subprocess
import zipfile
from email.parser import Parser
from types import ModuleType

import pytest
from elftools.elf.elffile import ELFFile

from repository import ROOT

_TOOLS = ROOT / "build" / "wheel" / "tools"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    loader = importlib.machinery.SourceFileLoader("wheel_script", str(ROOT / ".ci" / "wheel"))
    spec = importlib.util.spec_from_loader("wheel_script", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("name", "holds"),
    [
        ("plica-0.1.0-cp311-cp311-manylinux_2_17_x86_64.whl", True),
        ("plica-0.1.0-cp311-cp311-manylinux2014_x86_64.manylinux_2_17_x86_64.whl", True),
        ("plica-0.1.0-cp311-cp311-manylinux_2_12_x86_64.manylinux_2_17_x86_64.whl", True),
        ("plica-0.1.0-cp311-cp311-manylinux_2_35_x86_64.whl", False),
        ("plica-0.1.0-cp311-cp311-linux_x86_64.whl", False),
    ],
)
def test_a_wheel_for_newer_systems_alone_is_refused(script: ModuleType, name: str, holds: bool) -> None:
    if holds:
        script.check_tag(name)
    else:
        with pytest.raises(SystemExit, match=re.escape(f"tag of {name}; must be manylinux_2_17")):
            script.check_tag(name)


@pytest.mark.slow
def test_a_wheel_runs_where_there_is_python_alone_and_asks_for_nothing_but_an_old_glibc() -> None:
    if shutil.which("apt-get") is None:
        pytest.skip("needs apt-get, for Debian's Python and headers")
    if not (_TOOLS.exists() or os.environ.get("PLICA_WHEEL")):
        pytest.skip(
            "needs Zig, which 'make wheel' fetches, or PLICA_WHEEL=1, as .ci/run sets it, to fetch it here"
        )
    made = subprocess.run([ROOT / ".ci" / "wheel", "bookworm"], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    passed = re.search(r"^(\d+) of (\d+) pass", made.stdout, re.MULTILINE)
    assert passed is not None
    assert passed[1] == passed[2]
    (wheel,) = (ROOT / "build" / "wheel" / "bookworm" / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as opened:
        names = opened.namelist()
        (engine,) = (name for name in names if name.endswith(".so"))
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        text = Parser().parsestr(opened.read(metadata).decode())
        with opened.open(engine) as file:
            elf = ELFFile(file)
            needed = {tag.needed for tag in elf.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")}
            versions = {
                version.name
                for _, found in elf.get_section_by_name(".gnu.version_r").iter_versions()
                for version in found
            }
    assert text["License-Expression"] == "BSD-3-Clause"
    assert {name.split("/")[0] for name in names} == {"plica", metadata.split("/")[0]}
    assert {name.split(".so")[0] for name in needed} <= {
        "libc",
        "libm",
        "libpthread",
        "libdl",
        "ld-linux-x86-64",
    }
    assert versions
    assert all(re.fullmatch(r"GLIBC_2\.(\d|1[0-7])(\.\d+)?", version) for version in versions), versions
