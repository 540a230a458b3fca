"""The voices of people that come with the package are in the ranges of speech (docs/voices.md)."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica

SPEECH = {
    "male": {"fundamental_frequency": (95, 140), "peak_flow": (200e-6, 400e-6)},
    "female": {"fundamental_frequency": (180, 220), "peak_flow": (130e-6, 300e-6)},
    "child": {"fundamental_frequency": (230, 350), "peak_flow": (60e-6, 250e-6)},
}
OF_ALL = {"open_quotient": (0.5, 0.8), "flow_h1_h2": (6, 17), "vertical_phase_difference": (0.8, 2.1)}


def spoken(name: str, folder: Path, **changes: object) -> plica.Run:
    """The settled end of a voice on `coarse`."""
    scene = plica.Scene.of_voice(name).replace(
        {"mesh.larynx": "coarse", "time.duration": "0.18 s", "output": None, **changes}
    )
    return plica.run(scene, folder / name, progress=False).between("0.12 s", None)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPEECH)
def test_a_person_speaks(name: str, tmp_path: Path) -> None:
    run = spoken(name, tmp_path)
    for measure, (low, high) in (SPEECH[name] | OF_ALL).items():
        assert low < run.measures[measure].value < high, measure
    period = run.measures["period"]
    assert period.spread < 0.04 * period.value
    assert run["inverted_tissue"].max() == 0


@pytest.mark.slow
def test_longer_folds_sing_higher(tmp_path: Path) -> None:
    """Linear tissue about postures by the cricothyroid, the gap kept: f0 at 18 % longer, and at 31 %."""
    pitch = []
    for activation in (0.0, 0.3, 0.51):
        posture = {"muscles": {"cricothyroid": activation}, "contraction": 0.48 - 0.16 * activation}
        changes = {"strain": None, "time.step": "100 us", "posture": posture}
        run = spoken("female", tmp_path / f"{activation}", **changes)
        pitch.append(run.measures["fundamental_frequency"].value)
    assert 1.25 < pitch[1] / pitch[0] < 1.6
    assert 1.8 < pitch[2] / pitch[0] < 2.3
