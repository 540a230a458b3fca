"""Description of this installation: version, commit, compiler, processor, threads, date."""

from __future__ import annotations

import platform
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from plica import _engine

__all__ = ["Installation", "this_installation"]

_SOURCES = ("cpp", "python", "cmake", "CMakeLists.txt", "pyproject.toml")


@dataclass(frozen=True)
class Installation:
    """The software and machine that computed the results."""

    version: str
    commit: str
    """Empty if the package is not in a source tree."""
    compiler: str
    backend: str
    python: str
    processor: str
    system: str
    threads: int
    date: str

    def __str__(self) -> str:
        engine = f"plica {self.version}" + (f" (engine {self.commit})" if self.commit else "")
        threads = f"{self.threads} thread{'s' * (self.threads > 1)}"
        return f"{engine}, {self.compiler}, {self.backend}, {self.processor}, {threads}, {self.date}"


def this_installation() -> Installation:
    """The present installation and time."""
    built = _engine.build_info()
    return Installation(
        version=str(built["version"]),
        commit=_commit(),
        compiler=str(built["compiler"]),
        backend=str(built["backend"]),
        python=platform.python_version(),
        processor=_processor(),
        system=" ".join([platform.system(), platform.machine(), *platform.libc_ver()]).strip(),
        threads=_engine.threads(),
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )


def _commit() -> str:
    """The last commit of the source tree of the package, with a plus if it has uncommitted changes."""
    package = Path(__file__).resolve().parents[1]
    root = package.parents[1]
    if not (root / "pyproject.toml").is_file() or not (root / ".git").exists():
        return ""
    try:
        commit = _git(root, "log", "-1", "--format=%h", "--abbrev=7")
        changed = _git(root, "status", "--porcelain")
    except (OSError, subprocess.SubprocessError):
        return ""
    return f"{commit}{'+' * bool(changed)}"


def _git(root: Path, *command: str) -> str:
    """Output of a git command restricted to the sources of engine and package."""
    arguments = ["git", "-C", str(root), *command, "--", *_SOURCES]
    return subprocess.run(arguments, capture_output=True, text=True, check=True, timeout=10).stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()
