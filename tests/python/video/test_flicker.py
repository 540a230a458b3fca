"""A recording whose light flickers, through the whole chain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.report.page import write_report
from plica.video.settings import Settings

_FRAMES, _CHANGE = 16, 0.05


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_light_that_flickers_is_stored_flagged_and_reported(tmp_path: Path) -> None:
    glottis = SyntheticGlottis(
        Synthetic(height=96, width=96, frames=_FRAMES, frequency=0.1, amplitude=(5, 5), opening=(2, 2))
    )
    factor = 1 + _CHANGE * (np.arange(_FRAMES) % 2)
    lit = np.clip(factor[:, None, None] * glottis.stack(), 0, 255)
    np.save(tmp_path / "lit.npy", np.round(lit).astype(np.uint8))
    settings = Settings(preset="fast", correct_drift=False, modes=2)
    found = analyse(tmp_path / "lit.npy", tmp_path / "found", settings, progress=False)
    expected = factor[1:] / factor[:-1] - 1
    # The recording's level 0 is somewhat above black: what is added is a larger share of what is left.
    assert found.brightness == pytest.approx(expected, rel=0.25)
    assert (found.brightness * expected > 0).all()
    assert all("light" in flag for flag in found.flags[:-1])
    page = write_report(found).read_text(encoding="utf-8")
    assert f"{_FRAMES - 1} times by over 3 %" in page
    errors = []
    for k in range(_FRAMES - 1):
        truth, known = glottis.flow(k, k + 1)
        errors.append(np.hypot(*np.moveaxis(found.flow(k) - truth, -1, 0))[known].mean())
    assert np.mean(errors) < 0.2  # several times that where light is taken for motion
