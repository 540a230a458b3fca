"""The voices of people that come with the package are in the ranges of speech (docs/voices.md)."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica

SPEECH = {
    "male": {"fundamental_frequency": (100, 130), "peak_flow": (200e-6, 400e-6)},
    "female": {"fundamental_frequency": (180, 220), "peak_flow": (130e-6, 300e-6)},
    "child": {"fundamental_frequency": (230, 350), "peak_flow": (60e-6, 250e-6)},
}
OF_ALL = {"open_quotient": (0.5, 0.8), "flow_h1_h2": (6, 15), "vertical_phase_difference": (0.8, 2.1)}


@pytest.mark.slow
@pytest.mark.parametrize("name", SPEECH)
def test_a_person_speaks(name: str, tmp_path: Path) -> None:
    scene = plica.Scene.of_voice(name).replace(
        {"mesh.larynx": "coarse", "time": {"step": "100 us", "duration": "0.22 s"}, "output": None}
    )
    run = plica.run(scene, tmp_path / "run", progress=False).between("0.12 s", None)
    for measure, (low, high) in (SPEECH[name] | OF_ALL).items():
        assert low < run.measures[measure].value < high, measure
    period = run.measures["period"]
    assert period.spread < 0.02 * period.value
