"""What speaks against a frame: light that changes is told, and speaks against nothing."""

from __future__ import annotations

import numpy as np

from plica.video.measures.frame_flags import flags, in_doubt, lit
from plica.video.motion.drift import Drift


def test_light_that_changes_by_over_three_percent_is_told_and_is_no_doubt() -> None:
    frames = 5
    found = flags(
        np.full(frames, 10.0),
        Drift(np.zeros((frames, 3)), np.ones(frames)),
        np.ones(frames),
        np.zeros(frames),
        np.zeros(frames, bool),
        np.array([1.0, 1.0, np.nan, 1.0]),
        np.array([0.02, -0.05, np.nan, 0.04]),
    )
    assert found == ["", "light", "blind", "light", ""]
    assert [lit(flag) for flag in found] == [False, True, False, True, False]
    assert [in_doubt(flag) for flag in found] == [False, False, True, False, False]
