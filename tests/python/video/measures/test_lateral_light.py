"""Light from one side: left and right are measured where there is no shade, and what may be left is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from plica.measures.measure import Measure, whole
from plica.video.analysis import Analysis, analyse
from plica.video.light import light_of
from plica.video.measures.lateral_light import by_light, cautioned, is_lateral, is_shaded
from plica.video.settings import Settings

_FRAMES, _PERIOD, _SIZE = 76, 16.37, 72
_DARK, _SHADE, _TISSUE = 12.0, 55.0, 140.0


def _frames(amplitude: tuple[float, float], shade: float) -> np.ndarray:
    """Folds of these amplitudes (px) in phase; beside the right one a surface in shade, of so many px while
    they part and of less while they close."""
    y, x = np.mgrid[0:_SIZE, 0:_SIZE].astype(float)
    middle = (_SIZE - 1) / 2
    along = np.clip((y - 8) / (_SIZE - 16), 0, 1)
    shape = 4 * along * (1 - along)
    frames = []
    for t in range(_FRAMES):
        turn = 2 * np.pi * t / _PERIOD
        left, right = (shape * max(0.0, a * (0.4 + np.sin(turn))) for a in amplitude)
        beside = shape * shade * (1 + np.cos(turn)) / 2 * (right > 0)
        fine = np.full((_SIZE, _SIZE), _TISSUE)
        off = x - middle
        fine = np.where((off > 0) & (off < right + beside), _SHADE, fine)
        fine = np.where((off > -left) & (off < right), _DARK, fine)
        fine *= 1 - 0.1 * (shade > 0) * off / middle  # of the lamp, on the left
        noise = np.random.default_rng(t).standard_normal(fine.shape)
        frames.append(ndimage.gaussian_filter(fine, 0.8) + noise)
    return np.round(np.clip(frames, 0, 255)).astype(np.uint8)


def _recorded(directory: Path, amplitude: tuple[float, float], shade: float) -> Analysis:
    np.save(directory / "folds.npy", _frames(amplitude, shade))
    settings = Settings(fps=4000, correct_drift=False)
    return analyse(directory / "folds.npy", directory / "a", settings, until="glottis", progress=False)


def _told(found: Analysis) -> bool:
    return any("light from one side" in said for said in found.measures["amplitude_ratio"].cautions)


def test_folds_that_move_alike_are_measured_alike_in_light_from_one_side(tmp_path: Path) -> None:
    found = _recorded(tmp_path, (6.0, 6.0), 3.0)
    assert np.ptp(found.area.right_edge) > 1.06 * np.ptp(found.area.left_edge)  # halfway, shade is glottis
    ratio, phase = (found.measures[name] for name in ("amplitude_ratio", "left_right_phase"))
    assert ratio.value == pytest.approx(1.0, abs=0.17)  # a pixel: edges are of whole ones
    assert ratio.interval[0] < 1 < ratio.interval[1]
    assert abs(phase.value) < 0.08
    assert phase.interval[0] < 0 < phase.interval[1]
    assert _told(found)
    assert light_of(found).colour != "good"
    assert "Light from one side" in light_of(found).said


def test_area_and_quotients_in_shade_have_what_it_may_have_made_of_them(tmp_path: Path) -> None:
    """Halfway to the tissue shade is glottis, by more than cycles scatter; in even light there is none."""
    turn = 2 * np.pi * np.arange(_FRAMES) / _PERIOD
    along = np.clip((np.arange(_SIZE) - 8) / (_SIZE - 16), 0, 1)
    opening = 2 * 6.0 * np.maximum(0.0, 0.4 + np.sin(turn)) * (4 * along * (1 - along)).sum()
    for folder, shade in (("lit", 0.0), ("shaded", 3.0)):
        (tmp_path / folder).mkdir()
        found = _recorded(tmp_path / folder, (6.0, 6.0), shade)
        area = found.measures["glottal_area_mean"]
        truth = np.mean([opening[part].mean() for part in found.cycles.samples(found.time)])
        low, high = area.interval
        assert any("the outline is not sharp" in said for said in area.cautions) == bool(shade)
        assert (area.value > 1.08 * truth) == bool(shade)
        if shade:
            assert low < truth < area.value < high
            low, high = found.measures["open_quotient_20_percent"].interval
            assert low < np.mean(opening > 0.2 * opening.max()) < high
        else:
            assert high - low < 0.11 * area.value


def test_where_nothing_has_a_value_nothing_is_said_of_it() -> None:
    some, none = whole("glottal_area_mean", 5.0), whole("open_quotient", float("nan"))
    assert cautioned([some, none], "said") == [replace(some, cautions=("said",)), none]


@pytest.mark.usefixtures("few_draws")
def test_a_true_asymmetry_in_even_light_is_kept_and_not_taken_for_the_lamp(tmp_path: Path) -> None:
    found = _recorded(tmp_path, (5.0, 7.0), 0.0)
    assert found.measures["amplitude_ratio"].value == pytest.approx(1.4, abs=0.1)
    assert not _told(found)


def test_a_recording_without_cycles_has_no_green_light(tmp_path: Path) -> None:
    np.save(tmp_path / "folds.npy", _frames((5.0, 5.0), 0.0)[:20])
    settings = Settings(fps=4000, correct_drift=False)
    found = analyse(tmp_path / "folds.npy", tmp_path / "a", settings, until="glottis", progress=False)
    assert not found.cycles.count
    assert light_of(found).colour == "bad"
    assert "No cycles were found" in light_of(found).said


_NAMES = ("amplitude_left", "amplitude_asymmetry", "left_right_phase")


def _sides(*values: float) -> list[Measure]:
    return [whole(name, value) for name, value in zip(_NAMES, values, strict=True)]


def _by_light(halfway: list[Measure], inner: list[Measure], *, wide: bool) -> tuple[list[Measure], bool]:
    """Where the darkest part tells the same whether the folds touch or not."""
    return by_light(halfway, inner, inner, wide=wide)


def test_where_folds_touch_is_no_shade() -> None:
    halfway, inner = _sides(5.0, 0.1, 0.2), _sides(4.0, 0.3, 0.4)
    assert by_light(halfway, inner, _sides(4.0, 0.11, 0.21), wide=False) == (halfway, False)


def test_where_both_outlines_agree_and_are_sharp_nothing_is_said() -> None:
    halfway = _sides(5.0, 0.1, 0.2)
    assert _by_light(halfway, _sides(4.0, 0.11, 0.21), wide=False) == (halfway, False)


def test_where_the_outline_is_not_sharp_the_darkest_part_is_taken_and_that_is_said() -> None:
    for inner in (_sides(4.0, 0.11, 0.21), _sides(4.0, 0.5, 0.21)):
        found, darkest = _by_light(_sides(5.0, 0.1, 0.2), inner, wide=True)
        assert darkest
        assert [item.value for item in found] == [item.value for item in inner]
        for item in found:
            assert "by the darkest part, as the outline is not sharp" in item.cautions
    assert is_shaded(found)


def test_a_side_that_is_not_known_is_not_compared_and_that_is_said() -> None:
    nan = float("nan")
    for halfway, inner in ((nan, 0.5), (0.5, nan), (nan, nan)):
        found, _ = _by_light(_sides(5.0, 0.1, halfway), _sides(4.0, 0.1, inner), wide=False)
        (said,) = found[1].cautions
        assert said.startswith("the phase by the outline halfway to the tissue cannot be compared")
        assert found[0].cautions == ()
        assert found[0].value == 5.0
    found, _ = _by_light(_sides(5.0, 0.3, nan), _sides(4.0, 0.1, 0.5), wide=False)
    told, unknown = found[1].cautions
    assert "halfway to the tissue the amplitude asymmetry would be +0.2 off; half" in told
    assert "phase" in unknown


def test_a_lamp_is_named_only_where_tissue_is_brighter_on_one_side() -> None:
    halfway, inner = _sides(5.0, 0.1, 0.2), _sides(4.0, 0.3, 0.2)
    for brightness, lamp in (((150.0, 130.0), True), ((150.0, 145.0), False), (None, False)):
        known = None if brightness is None else np.array(brightness)
        assert is_lateral(known) == lamp
        found, darkest = by_light(halfway, inner, inner, wide=False, brightness=known)
        assert darkest
        (said,) = found[1].cautions
        assert said.startswith("light from one side: with the outline" if lamp else "with the outline")
    assert not is_lateral(np.array([np.nan, 140.0]))


def test_where_nothing_is_measured_nothing_is_said() -> None:
    none, some = _sides(*3 * [float("nan")]), _sides(1.0, 1.0, 1.0)
    assert _by_light(none, some, wide=False) == (none, False)
    (said,) = (text for text in _by_light(none, some, wide=True)[0][1].cautions if "cannot" in text)
    assert "amplitude asymmetry and the phase" in said
