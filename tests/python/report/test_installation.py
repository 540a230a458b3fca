"""What figures say they were made with: the commit of the sources, and whether they were changed since."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from plica.report import installation


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A committed tree in whose python/plica this module seems to lie."""
    module = tmp_path / "python" / "plica" / "report" / "installation.py"
    module.parent.mkdir(parents=True)
    module.write_text("first\n", encoding="utf-8")
    for name in ("pyproject.toml", "README.md"):
        (tmp_path / name).write_text("first\n", encoding="utf-8")
    git(tmp_path, "init", "-q")
    commit(tmp_path)
    monkeypatch.setattr(installation, "__file__", str(module))
    return tmp_path


def git(root: Path, *words: str) -> str:
    name = ["-c", "user.name=A", "-c", "user.email=a@b.c"]
    command = ["git", "-C", str(root), *name, *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def commit(root: Path) -> str:
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", "all")
    return git(root, "log", "-1", "--format=%h", "--abbrev=7")


def version() -> str:
    return installation.this_installation().commit


def test_the_commit_is_the_last_that_changed_the_sources(sources: Path) -> None:
    first = version()
    (sources / "README.md").write_text("second\n", encoding="utf-8")
    assert version() == first
    assert commit(sources) != first
    assert version() == first
    (sources / "pyproject.toml").write_text("second\n", encoding="utf-8")
    assert version() == first + "+"
    assert commit(sources) == version() != first


def test_a_new_file_among_the_sources_is_a_change(sources: Path) -> None:
    (sources / "notes.txt").write_text("beside the sources\n", encoding="utf-8")
    assert not version().endswith("+")
    (sources / "python" / "plica" / "new.py").write_text("new\n", encoding="utf-8")
    assert version().endswith("+")


def test_an_installed_package_has_no_commit(sources: Path) -> None:
    (sources / "pyproject.toml").unlink()
    assert version() == ""
