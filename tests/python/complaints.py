"""What a command says of bad input: one sentence, exit code 2, no traceback, and nothing on the disk."""

from __future__ import annotations

from pathlib import Path

import pytest

from plica.commands.main import main


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str], code: int = 2) -> str:
    """The command's complaint; its exit code is `code` and it has no traceback."""
    assert main(arguments) == code
    message = capsys.readouterr()
    assert message.out == ""
    assert "Traceback" not in message.err
    assert all(line.startswith("plica: ") for line in message.err.splitlines())
    return message.err


def refused_scene(text: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The complaint about a scene that is not run; it names the file, and nothing is left."""
    (folder / "s.toml").write_text(text)
    message = refused(["run", str(folder / "s.toml"), "-o", str(folder / "run")], capsys)
    assert message.startswith("plica: s.toml: ")
    assert not (folder / "run").exists()
    return message
