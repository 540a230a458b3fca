"""The Python of docs/sound.md runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from scipy.io import wavfile

import plica
from typed_commands import python_blocks


def test_the_python_of_sound_md_writes_a_sound(
    phonating: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    plica.run(phonating, "runs/first", progress=False)
    names: dict[str, object] = {}
    exec(compile(*python_blocks("docs/sound.md"), "sound.md", "exec"), names)
    assert names["scale"] == 5.0
    assert wavfile.read("voice.wav")[0] == 48000
