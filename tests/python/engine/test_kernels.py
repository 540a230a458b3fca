"""The engine takes the version of its kernels that the processor at hand can run."""

from __future__ import annotations

import platform
import re
from pathlib import Path

import pytest

import plica

_CPUINFO = Path("/proc/cpuinfo")


@pytest.mark.skipif(platform.machine() != "x86_64" or not _CPUINFO.exists(), reason="x86-64 has versions")
def test_kernels_are_those_for_what_the_system_says_of_the_processor() -> None:
    line = re.search(r"^flags\s*:(.*)$", _CPUINFO.read_text(encoding="ascii"), re.MULTILINE)
    assert line is not None
    flags = set(line[1].split())
    expected = "any processor"
    for name, needed in [
        ("AVX2", {"avx2"}),
        ("AVX2 with FMA", {"avx2", "fma"}),
        ("AVX-512 with FMA", {"avx2", "fma", "avx512f", "avx512vl", "avx512dq"}),
    ]:
        expected = name if needed <= flags else expected
    assert plica.build_info()["kernels"] == expected
