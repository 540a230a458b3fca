"""A film analysed by plica's own video tools, against its truth."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy import ndimage

import plica
from filmed_folds import moved, voiced
from plica import video

FREQUENCY = 200.0


def test_the_flow_of_two_frames_is_found() -> None:
    clip = plica.film(moved(voiced(FREQUENCY), np.arange(5) * 0.25e-3), plica.Camera(width=160, height=256))
    true, visible = clip.flow(3)
    found = plica.flow(clip.frame(3), clip.frame(4), preset="video").flow
    length = np.hypot(true[..., 0], true[..., 1])
    moving = ndimage.binary_erosion(visible, iterations=2) & (length > 0.5)
    assert moving.sum() > 4000
    error = np.hypot(*np.moveaxis(found - true, -1, 0))
    assert np.median(length[moving]) > 0.6
    assert np.median(error[moving]) < 0.1  # 0.055 px
    assert np.sqrt(np.mean(error[visible] ** 2)) < 0.2 * np.sqrt(np.mean(length[visible] ** 2))


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_the_glottis_of_a_film_is_found_and_its_frequency(tmp_path: Path) -> None:
    # Without lag: where the medial surface shows below the edge it is dark, and taken for glottis.
    run = moved(voiced(FREQUENCY, lag=0.0), np.arange(90) * 0.25e-3)
    clip = plica.film(run, plica.Camera(mm_per_px=0.1, width=96, height=152), samples=2)
    path, _ = plica.write_film(clip, tmp_path / "clip.avi")
    settings = video.Settings(fps=clip.fps, mm_per_px=clip.camera.mm_per_px)
    found = video.analyse(path, tmp_path / "analysis", settings, until="glottis", progress=False)
    frequency = found.measures["fundamental_frequency"].value
    assert frequency == pytest.approx(FREQUENCY, rel=0.005)
    with h5py.File(tmp_path / "clip.truth.h5") as file:
        area, glottis = file["glottal_area"][()], file["glottis"][()]
    measured = found.to_xarray()["area_total"].to_numpy()
    assert np.corrcoef(measured, area)[0, 1] > 0.98
    both = [
        2 * (found.mask(k) & glottis[k]).sum() / (found.mask(k).sum() + glottis[k].sum()) for k in range(90)
    ]
    assert np.median(both) > 0.8
