"""What figures were made with: version, commit, compiler, processor, threads, date."""

from __future__ import annotations

import platform
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from plica import _engine

__all__ = ["Installation", "this_installation"]


@dataclass(frozen=True)
class Installation:
    """What is named beside the rows."""

    version: str
    commit: str
    """Empty where the package does not lie in its sources."""
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
    """Now and here."""
    built = _engine.build_info()
    return Installation(
        version=str(built["version"]),
        commit=_commit(),
        compiler=str(built["compiler"]),
        backend=str(built["backend"]),
        python=platform.python_version(),
        processor=_processor(),
        system=platform.platform(),
        threads=_engine.threads(),
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )


def _commit() -> str:
    """Of the sources that the package lies in, with a plus where a file of theirs was changed."""
    package = Path(__file__).resolve().parents[1]
    root = package.parents[1]
    if not (root / "pyproject.toml").is_file() or not (root / ".git").exists():
        return ""
    command = ["git", "-C", str(root), "describe", "--always", "--dirty=+", "--abbrev=7", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()
