"""What a lesion does to a voice (docs/lesions.md)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import plica
from repository import EXAMPLES


@pytest.mark.slow
def test_air_leaks_through_a_chink_and_folds_before_it_close(tmp_path: Path) -> None:
    scene = plica.Scene.load(EXAMPLES / "chink.toml").replace(
        {"mesh.options.around": 12, "time.duration": "0.1 s", "output": None}
    )
    healthy = scene.replace({"mesh.folds.posterior_chink": None})
    leaks, closes = (
        plica.run(own, tmp_path / name, progress=False).between("60 ms", None)
        for name, own in (("chink", scene), ("healthy", healthy))
    )
    area = 9 / 16 * 0.8e-3 * 4e-3
    assert np.min(leaks["minimum_area"]) > 0.5 * area
    assert np.min(closes["minimum_area"]) < 0.05 * area
    assert np.min(leaks["flow"]) > 5 * np.min(closes["flow"])
    assert leaks.measures["open_quotient"].value == 1.0
    assert closes.measures["open_quotient"].value < 0.8


@pytest.mark.slow
def test_the_fold_with_less_tension_lags_and_moves_less(tmp_path: Path) -> None:
    scene = plica.Scene.load(EXAMPLES / "paralysis.toml").replace(
        {"mesh.options.around": 12, "time.duration": "0.14 s", "output": None}
    )
    run = plica.run(scene, tmp_path / "run", progress=False).between("80 ms", None)
    assert -1.2 < run.measures["left_right_phase"].value < -0.1  # positive where the right lags
    assert run.measures["amplitude_left"].value < run.measures["amplitude_right"].value
