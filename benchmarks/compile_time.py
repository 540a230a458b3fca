"""What compiling costs, in processor time: the engine, the extension and the C++ tests, module by module.

    python -m benchmarks.compile_time

Builds twice in a temporary folder without a compiler cache: each source by itself (PLICA_UNITY=OFF) and ten
of a module together. User time of the compiler in seconds; the heaviest source is that of the first build.
Record: `compile_time`. About 20 min of a processor.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from collections import defaultdict
from pathlib import Path

import pybind11

from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record

COLUMNS = ("module", "sources", "heaviest (s)", "each by itself (s)", "together (s)", "ratio")
LAUNCHER = """#!/bin/sh
exec time -a -o {log} -f "%U $*" "$@"
"""


def compiled(folder: Path, together: bool) -> list[tuple[str, str, float]]:
    """(module, source, seconds) of every compilation of a build from nothing."""
    log, launcher = folder / "log", folder / "launcher"
    launcher.write_text(LAUNCHER.format(log=shlex.quote(str(log))), encoding="utf-8")
    launcher.chmod(0o755)
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_CXX_COMPILER_LAUNCHER": launcher,
        "PLICA_PYTHON": "ON",
        "PLICA_TESTS": "ON",
        "PLICA_UNITY": "ON" if together else "OFF",
        "Python_EXECUTABLE": sys.executable,
        "Python_INCLUDE_DIR": sysconfig.get_path("include"),
        "pybind11_DIR": pybind11.get_cmake_dir(),
    }
    build = [f"-D{name}={value}" for name, value in options.items()]
    subprocess.run(["cmake", "-G", "Ninja", "-S", ROOT, "-B", folder / "build", *build], check=True)
    subprocess.run(["cmake", "--build", folder / "build", "--target", "all", "plica_tests"], check=True)
    found = []
    for line in log.read_text(encoding="utf-8").splitlines():
        if made := re.search(r"^([\d.]+) .* -o \S*?/?(\w+)\.dir/(\S+)\.o -c ", line):
            found.append((made[2].removeprefix("plica_"), Path(made[3]).name, float(made[1])))
    return found


def main() -> None:
    with tempfile.TemporaryDirectory() as made:
        both = []
        for together in (False, True):
            folder = Path(made) / str(together)
            folder.mkdir()
            both.append(compiled(folder, together))
    apart, together_ = both
    seconds: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0])
    for which, units in enumerate(both):
        for module, _, time in units:
            seconds[module][which] += time
    rows = []
    for module, (alone, joined) in sorted(seconds.items(), key=lambda of: -of[1][0]):
        sources = sorted(((time, source) for name, source, time in apart if name == module), reverse=True)
        heaviest = f"{sources[0][1]} {sources[0][0]:.1f}"
        rows.append(
            [module, len(sources), heaviest, f"{alone:.1f}", f"{joined:.1f}", f"{joined / alone:.2f}"]
        )
    alone, joined = (sum(time for *_, time in units) for units in (apart, together_))
    rows.append(["all", len(apart), "", f"{alone:.0f}", f"{joined:.0f}", f"{joined / alone:.2f}"])
    record("compile_time", COLUMNS, rows)


if __name__ == "__main__":
    os.environ["CCACHE_DISABLE"] = "1"
    main()
