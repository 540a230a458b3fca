"""What is told to the data term: edges and overexposed tissue, but no highlight and no hollow."""

from __future__ import annotations

import numpy as np

from plica.video.motion.frame_content import Seen, informing

_Y, _X = np.mgrid[0:60, 0:80]


def disc(x: float, y: float, radius: float) -> np.ndarray:
    return (_X - x) ** 2 + (_Y - y) ** 2 <= radius**2


def test_a_highlight_is_small_and_what_is_larger_is_overexposed_tissue() -> None:
    frame = np.full((60, 80), 100.0, dtype=np.float32)
    frame[disc(20, 30, 2)] = 255
    frame[disc(60, 30, 9)] = 255
    seen = Seen(frame, np.zeros((60, 80), dtype=bool))
    assert seen.highlights[30, 20]
    assert seen.highlights[30, 24]  # two pixels about it
    assert not seen.highlights[30, 26]
    assert not seen.highlights[:, 45:].any()
    assert np.array_equal(seen.tissue, ~seen.highlights)


def test_the_edge_of_the_glottis_is_told_and_its_hollow_is_not() -> None:
    frame = np.full((60, 80), 100.0, dtype=np.float32)
    narrow, wide = Seen(frame, disc(40, 30, 8)), Seen(frame, disc(40, 30, 14))
    told = informing(narrow, wide)
    assert not told[30, 40]
    assert not told[30, 45]  # hollow of both
    assert told[30, 47]  # the edge of the narrower one
    assert told[30, 50]  # tissue in one, glottis in the other: it moves there
    assert np.array_equal(told, informing(wide, narrow))
    assert not narrow.tissue[30, 50]  # within two pixels of the glottis nothing is counted
    assert narrow.tissue[30, 51]
