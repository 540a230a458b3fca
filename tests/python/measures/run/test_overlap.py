"""Folds that pass through each other without contact: for how long, how deep, and where they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analytic_run import AnalyticRun, Phonation
from plica.measures.run.overlap import overlapping_folds
from plica.units import two_digits

CLOSER = 0.75e-3  # m, by which each fold comes to the middle: half a gap of 0.25 mm is left
CANAL = 4  # a section of the straight part


def moved(
    run: AnalyticRun, right: tuple[float, float], left: tuple[float, float], sections: slice
) -> AnalyticRun:
    """With the folds' points at these sections moved by (x, z) m in all steps."""
    changed = {}
    for side, (x, z) in (("right", right), ("left", left)):
        points = np.array(run.waveforms[f"coronal_{side}"])
        points[:, sections, 0] += x
        points[:, sections, 2] += z
        changed[f"coronal_{side}"] = points
    return replace(run, waveforms=run.waveforms | changed)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("sections", [slice(None), slice(CANAL, CANAL + 1)], ids=["all", "one"])
def test_folds_that_pass_through_each_other_are_told_of(sections: slice, mirrored: bool) -> None:
    voice = Phonation(gap=1e-3, impulse=0.0, steps=4000, step=25e-6)
    run = voice.run()
    assert overlapping_folds(run) is None
    run = moved(run, (-CLOSER, 0.0), (CLOSER, 0.0), sections)
    if mirrored:
        turned = {
            name: run.waveforms[name] * np.array([-1.0, 1.0, 1.0])
            for name in ("coronal_right", "coronal_left")
        }
        run = replace(run, waveforms=run.waveforms | turned)
    assert run.waveforms["minimum_area"].min() > 0
    width = 2 * (voice.gap - CLOSER + 0.5e-3 * np.cos(2 * np.pi * voice.frequency * run.time))
    overlaps = width < -1e-3 * 2 * voice.major
    assert 0.3 < overlaps.mean() < 1 / 3
    caution = overlapping_folds(run)
    assert caution is not None
    assert caution.name == "overlapping_folds"
    assert f"in {two_digits(100 * overlaps.mean())} % of the steps, first at 1.7 ms" in caution.seen
    assert "in their middle plane by up to 0.5 mm" in caution.seen
    assert "[contact]" in caution.advice
    assert overlapping_folds(replace(run, waveforms={**run.waveforms, "contact_rows": run.time})) is None


def test_folds_that_touch_do_not_overlap() -> None:
    run = Phonation(impulse=0.0).run()
    assert np.any(run.waveforms["minimum_area"] == 0)
    assert overlapping_folds(run) is None
    deep = 1e-3 * 14e-3 / 2  # of each fold
    for share, found in ((0.9, False), (1.1, True)):
        closer = moved(run, (-share * deep, 0.0), (share * deep, 0.0), slice(None))
        assert (overlapping_folds(closer) is not None) == found


def test_a_fold_that_slides_past_the_other_does_not_overlap_it() -> None:
    """Two slanted walls: one moves along itself, so that points that faced each other are past each other."""
    run = Phonation(gap=1e-3, amplitude_left=0.0, amplitude_right=0.0, impulse=0.0).run()
    z = run.section_height
    lines = {side: np.zeros((run.time.size, z.size, 3)) for side in ("coronal_right", "coronal_left")}
    for side, apart in (("coronal_right", 0.2e-3), ("coronal_left", -0.2e-3)):
        lines[side][:, :, 0], lines[side][:, :, 2] = z + apart, z
    lines["coronal_left"][100:, :, 0] += 0.5e-3
    lines["coronal_left"][100:, :, 2] += 0.5e-3
    widths = lines["coronal_right"][:, :, 0] - lines["coronal_left"][:, :, 0]
    assert widths.min() == pytest.approx(-0.1e-3)
    assert overlapping_folds(replace(run, waveforms=run.waveforms | lines)) is None
    lines["coronal_left"][100:, :, 0] += 0.5e-3  # now it is 0.1 mm deep
    caution = overlapping_folds(replace(run, waveforms=run.waveforms | lines))
    assert caution is not None
    assert "by up to 0.1 mm" in caution.seen
