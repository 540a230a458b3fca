"""Where a camera stands: to a picture and back, and what its angles change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plica

LOOKING = plica.Camera(
    mm_per_px=0.05, width=40, height=48, centre=("1 mm", -2e-3, 3e-3), tilt=12, lean=-7, roll=33
)


@pytest.mark.parametrize("roll", [-170.0, 0.0, 33.0, 180.0])
def test_a_camera_is_found_again_from_its_projection(roll: float) -> None:
    camera = replace(LOOKING, roll=roll)
    again = plica.Camera.of_projection(camera.projection, camera.shape)
    assert again.projection[:2] == pytest.approx(camera.projection[:2], rel=1e-12, abs=1e-9)
    assert (again.mm_per_px, again.tilt, again.lean) == pytest.approx((0.05, 12, -7), rel=1e-12)
    assert np.cos(np.radians(again.roll - roll)) == pytest.approx(1, rel=1e-12)
    off = np.subtract(again.centre, camera.centre)  # along the line of sight
    assert np.allclose(np.cross(off, camera.axes[2]), 0, atol=1e-15)


def test_a_tilted_camera_stands_where_its_angles_say() -> None:
    towards = LOOKING.axes[2]
    tilt, lean = np.radians([12, -7])
    expected = [np.sin(lean), np.cos(lean) * np.sin(tilt), np.cos(lean) * np.cos(tilt)]
    assert towards == pytest.approx(expected, rel=1e-12)


def test_derivatives_by_tilt_and_lean_are_central_differences() -> None:
    h = 1e-3
    for name, derivative in zip(("tilt", "lean"), LOOKING.tilt_derivatives(), strict=True):
        ahead, behind = (replace(LOOKING, **{name: getattr(LOOKING, name) + k * h}) for k in (1, -1))
        difference = (ahead.projection - behind.projection) / (2 * h)
        assert np.abs(difference[:2, :3]).max() > 1.0  # px/m a degree
        assert derivative == pytest.approx(difference, rel=1e-6, abs=1e-6)


def test_a_projection_that_is_no_camera_s_is_refused() -> None:
    rows = LOOKING.projection
    for wrong, expected in (
        (rows * [[1], [2], [1]], "must be orthographic"),
        (rows * [[1], [-1], [1]], "looks along z = .*; must look down. Rows count downwards"),
        (0 * rows, "must be orthographic"),
        (rows * np.nan, "must be orthographic"),
    ):
        with pytest.raises(plica.InvalidInput, match=f"Camera: projection {expected}"):
            plica.Camera.of_projection(wrong, (48, 40))
