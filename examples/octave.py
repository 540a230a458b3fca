"""An octave sung by the cricothyroid muscle alone: python octave.py [DIR] [NOTES]

The folds of `voice = "female"` in linear tissue about their posture, at rising activations of the muscle that
lengthens them: at finite strain the notes between are irregular (docs/voices.md). Writes DIR/octave.wav
(default: runs/octave), one note after the other, and prints the pitch of each; a run that is there already is
kept. Some two minutes for eight notes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.io import wavfile

import plica

HIGHEST = 0.6  # activation of the cricothyroid muscle
FULL_SCALE = 5.0  # Pa


def voice(cricothyroid: float) -> plica.Scene:
    """The contraction of what holds the tissue leaves the gap between the folds nearly as it is at rest."""
    return plica.Scene.of_voice("female").replace(
        {
            "strain": None,
            "mesh.larynx": "coarse",
            "posture": {"muscles": {"cricothyroid": cricothyroid}, "contraction": 0.48 - 0.16 * cricothyroid},
            "time": {"step": "100 us", "duration": "0.2 s"},
        }
    )


def main(directory: Path, notes: int) -> None:
    sung = []
    for cricothyroid in np.linspace(0.0, HIGHEST, notes).tolist():
        name = f"cricothyroid_{cricothyroid:.2f}"
        run = plica.run(voice(cricothyroid), directory / name, resume="if_there", progress=False)
        pitch = run.measures["fundamental_frequency"]
        heard = run.sound(rate=44100)
        sung.append(heard.pressure)
        hertz = "no pitch: " + pitch.note if pitch.value is None else f"{pitch.value:.0f} Hz"
        print(
            f"cricothyroid {cricothyroid:.2f}, {100 * 0.6 * cricothyroid:.0f} % longer: {hertz}", flush=True
        )
    pressure = np.concatenate(sung) / FULL_SCALE
    path = directory / "octave.wav"
    wavfile.write(path, 44100, np.round(32767 * np.clip(pressure, -1, 1)).astype(np.int16))
    print(f"written: {path} (full scale {FULL_SCALE:g} Pa at 0.3 m)")


if __name__ == "__main__":
    main(
        Path(sys.argv[1] if len(sys.argv) > 1 else "runs/octave"),
        int(sys.argv[2] if len(sys.argv) > 2 else 8),
    )
