"""Films of a larynx, drawn by another renderer, that showed where a glottis was not found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.video.larynx_films import drawn_films
from benchmarks.video.larynx_renderer import coverage, render
from plica.video.files.recording import Recording
from plica.video.glottis.segmenter import learn


@pytest.mark.slow
@pytest.mark.parametrize("number", [14, 20])
def test_digits_that_are_sharper_than_the_glottis_in_most_frames_do_not_hide_it(
    number: int, tmp_path: Path
) -> None:
    """Of the twenty frames that are looked at, one finds the glottis."""
    film = drawn_films(30, 50)[number]
    assert film.picture.counter
    stack = render(film)
    np.save(tmp_path / "film.npy", stack)
    reach = learn(Recording.open(tmp_path / "film.npy")).reach
    widest = max(film.time[::12], key=lambda t: float(coverage(film, float(t)).sum()))
    truth = coverage(film, float(widest)) > 0.5
    assert (reach & truth).sum() > 0.9 * truth.sum()
    assert not reach[:16, :40].any()
