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
    for name, least in (("minimum_area", 0.2e-6), ("flow", 1e-6)):  # m^2 and m^3/s
        assert np.min(leaks[name]) > least
        assert np.min(closes[name]) < 0.2 * least
    assert leaks.measures["open_quotient"].value > closes.measures["open_quotient"].value + 0.1


@pytest.mark.slow
def test_the_fold_with_less_tension_lags(tmp_path: Path) -> None:
    scene = plica.Scene.load(EXAMPLES / "paralysis.toml").replace(
        {"mesh.options.around": 12, "time.duration": "0.14 s", "output": None}
    )
    run = plica.run(scene, tmp_path / "run", progress=False).between("80 ms", None)
    assert -1.2 < run.measures["left_right_phase"].value < -0.1  # positive where the right lags
