"""The line in which the folds meet, from masks of whole pixels: slits drawn about lines between them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from plica.video.glottis.midline import Midline, find_midline, pixels

_SIZE, _FINE = 72, 4
_PERIOD = 13.3  # frames


def _masks(line: Midline, amplitude: tuple[float, float], lean: float = 0.0) -> Iterator[np.ndarray]:
    """Pixels more than half of which are glottis; the right fold leads by 0.5 rad, `lean` times that at the
    lower end."""
    at = (pixels((_SIZE * _FINE,) * 2) + 0.5) / _FINE - 0.5
    along, off = np.moveaxis(line.place(at), -1, 0)
    along = along / line.length
    shape = np.where((along > 0) & (along < 1), 4 * along * (1 - along), 0.0)
    for t in range(14):
        turn = 2 * np.pi * t / _PERIOD
        phases = (turn, turn + 0.5 + 0.5 * lean * along)
        left, right = (
            shape * np.maximum(0.0, a * (0.3 + np.sin(phase)))
            for a, phase in zip(amplitude, phases, strict=True)
        )
        inside = (off > -left) & (off < right)
        yield inside.reshape(_SIZE, _FINE, _SIZE, _FINE).mean(axis=(1, 3)) > 0.5


def _error(found: Midline, line: Midline) -> float:
    """px, root mean square of the distance of the found line from the true one."""
    ends = line.points(np.stack([np.linspace(0.05, 0.95, 19) * line.length, np.zeros(19)], axis=-1))
    return float(np.sqrt(np.mean(found.place(ends)[:, 1] ** 2)))


@pytest.mark.parametrize("amplitude", [(7.0, 7.0), (6.0, 8.0), (9.0, 4.0)])
@pytest.mark.parametrize("column", [35.5, 35.75, 36.0, 36.25])
def test_the_midline_is_found_to_a_third_of_a_pixel_wherever_it_lies(
    column: float, amplitude: tuple[float, float]
) -> None:
    for lower in (column, column - 7):
        line = Midline((column, 12.0), (lower, 60.0))
        assert _error(find_midline(_masks(line, amplitude)), line) < 0.33


def test_slits_of_one_pixel_beside_the_line_do_not_decide_alone() -> None:
    """Of a line between two columns only one shows the narrowest slits: that of the fold that goes ahead."""
    one, two, four = np.zeros((3, 40, 40), dtype=bool)
    one[5:35, 20] = True
    two[5:35, 19:21] = True
    four[5:35, 18:22] = True
    found = find_midline([one, two, two, four, four])
    assert found.upper[0] == pytest.approx(found.lower[0], abs=1e-6)
    assert 19.5 < found.upper[0] < 19.77  # by their width alone: 19.81


def test_a_phase_that_changes_along_the_folds_leaves_the_line_within_half_a_pixel() -> None:
    line = Midline((35.6, 12.0), (31.2, 60.0))
    assert _error(find_midline(_masks(line, (8.0, 6.0), lean=1.0)), line) < 0.5
