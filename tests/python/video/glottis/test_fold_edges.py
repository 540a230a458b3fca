"""Where each fold's tissue ends: folds that meet beside the midline, on a curve, late, or not at all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy import ndimage

from plica.measures.sides import side_measures
from plica.video.analysis import analyse, load
from plica.video.errors import VideoError
from plica.video.glottis.fold_edges import _between_sides, fold_edges
from plica.video.glottis.glottal_area import GlottalArea, areas
from plica.video.glottis.midline import Midline, Slits, closing_in, find_midline
from plica.video.measures.waveforms import area_cycles, measures
from plica.video.settings import Settings
from plica.video.tables import cycles_table

_FRAMES, _PERIOD = 120, 20.7
_HEIGHT, _WIDTH, _MIDDLE = 160, 120, 60.3
_TOP, _LENGTH = 20.0, 120.0

Fold = Callable[[float, np.ndarray], np.ndarray]  # px right of the middle, of a turn (rad) and of 4 s (1 - s)


def _coverage(left: Fold, right: Fold, frame: int, times: int = 5) -> np.ndarray:
    """(h, w) share of each pixel that is glottis; rows that cross are drawn together at the stiffer fold."""
    y = (np.arange(_HEIGHT * times) + 0.5) / times - 0.5
    share = np.clip((y - _TOP) / _LENGTH, 0, 1)
    shape, turn = 4 * share * (1 - share), 2 * np.pi * frame / _PERIOD
    one, other = (_MIDDLE + fold(turn, shape) for fold in (left, right))
    x = np.arange(_WIDTH)[None, :] + 0.5
    filled = np.clip(x - one[:, None], 0, 1) - np.clip(x - other[:, None], 0, 1)
    return np.clip(filled, 0, 1).reshape(_HEIGHT, times, _WIDTH).mean(axis=1)


def _masks(left: Fold, right: Fold) -> list[np.ndarray]:
    return [_coverage(left, right, k) > 0.5 for k in range(_FRAMES)]


def _sides(area: GlottalArea) -> dict[str, float | None]:
    cycles = area_cycles(area)
    time = np.arange(float(_FRAMES))
    return {item.name: item.value for item in side_measures(time, area.left_edge, area.right_edge, cycles)}


def _found(left: Fold, right: Fold) -> tuple[dict[str, float | None], Midline]:
    masks = _masks(left, right)
    line = closing_in(masks, find_midline(masks))
    return _sides(areas(masks, line)), line


@pytest.mark.parametrize("beside", [3.0, 6.0])
def test_a_fold_that_stands_still_beside_the_midline_has_no_amplitude(beside: float) -> None:
    found, line = _found(
        lambda _, shape: -beside * shape,
        lambda turn, shape: shape * np.maximum(3 + 7 * np.sin(turn), -beside),
    )
    assert found["amplitude_left"] == pytest.approx(0.0, abs=0.2)
    assert found["amplitude_right"] == pytest.approx((10 + min(beside, 4.0)) / 2, abs=0.4)
    assert min(line.bow) == pytest.approx(-beside, abs=0.8)


@pytest.mark.parametrize("curve", [3.0, 8.0, -5.0])
def test_folds_that_meet_on_a_curve_move_as_they_do_beside_a_straight_line(curve: float) -> None:
    found, line = _found(
        lambda turn, shape: curve * shape - 5 * shape * np.maximum(np.sin(turn), 0),
        lambda turn, shape: curve * shape + 4 * shape * np.maximum(np.sin(turn), 0),
    )
    assert found["amplitude_left"] == pytest.approx(2.5, abs=0.5)
    assert found["amplitude_right"] == pytest.approx(2.0, abs=0.5)
    assert abs(found["left_right_phase"]) < 0.06
    bow = np.array(line.bow)
    assert bow[np.abs(bow).argmax()] == pytest.approx(curve, abs=0.8)
    assert np.abs(line.ends[[0, 2]] + 0.5 - _MIDDLE).max() < 1.5  # its ends are where the folds begin


@pytest.mark.parametrize("lag", [0.5, 0.7, np.pi / 2])
def test_phases_are_those_of_the_folds_whatever_contact_does(lag: float) -> None:
    found, _ = _found(
        lambda turn, shape: -9 * shape * np.sin(turn), lambda turn, shape: 6 * shape * np.sin(turn - lag)
    )
    assert found["left_right_phase"] == pytest.approx(lag, abs=0.06)


def test_folds_that_meet_on_a_straight_line_have_a_midline_without_a_bow() -> None:
    masks = _masks(
        lambda turn, shape: -6 * shape * np.sin(turn), lambda turn, shape: 6 * shape * np.sin(turn)
    )
    line = find_midline(masks)
    assert closing_in(masks, line) is line
    edges = fold_edges(masks, line)
    closed = ~edges.open.any(axis=1)
    assert closed.any()
    inner = np.abs(edges.along / line.length - 0.5) < 0.3
    assert np.abs(edges.left[closed][:, inner]).max() < 1.2
    assert (edges.left + edges.right)[~edges.open] == pytest.approx(0.0)


def _moved(line: Midline, by: float) -> Midline:
    return Midline.between(line.ends + np.array([by, 0, by, 0]))


@pytest.mark.parametrize("by", [-4.0, 1.0, 4.0])
def test_a_midline_that_is_set_beside_the_folds_stays_there(by: float) -> None:
    """It divides the area; how far the edges swing does not depend on it."""
    masks = _masks(
        lambda turn, shape: -shape * np.maximum(0, 3 + 7 * np.sin(turn)),
        lambda turn, shape: shape * np.maximum(0, 2 + 5 * np.sin(turn + 0.5)),
    )
    found = find_midline(masks)
    line = closing_in(masks, _moved(found, by), keep_ends=True).as_set
    assert not line.bow
    before, after = areas(masks, found), areas(masks, line)
    assert after.total == pytest.approx(before.total)
    assert (
        (after.left - before.left).max() > 0.7 * by * _LENGTH
        if by > 0
        else after.left.sum() < before.left.sum()
    )
    for name in ("amplitude_left", "amplitude_right", "left_right_phase"):
        assert _sides(after)[name] == pytest.approx(_sides(before)[name], abs=0.1), name


@pytest.mark.parametrize("by", [0.0, 3.0])
def test_between_ends_that_are_set_the_line_has_the_bow_in_which_folds_meet(by: float) -> None:
    masks = _masks(
        lambda _, shape: -8 * shape, lambda turn, shape: shape * np.maximum(3 + 7 * np.sin(turn), -8)
    )
    commissures = Midline((_MIDDLE, _TOP), (_MIDDLE, _TOP + _LENGTH))
    line = closing_in(masks, _moved(commissures, by), keep_ends=True).as_set
    assert line.ends == pytest.approx(_moved(commissures, by).ends)
    bow = line.bow_at(np.array([0.0, 0.5, 1.0]) * line.length)
    assert bow == pytest.approx([0.0, -8.0, 0.0], abs=1.0)


def test_a_strand_over_the_glottis_takes_nothing_from_edges_and_area() -> None:
    masks = _masks(
        lambda turn, shape: -shape * (3 + 8 * np.sin(turn)),
        lambda turn, shape: shape * (3 + 8 * np.sin(turn)),
    )
    y, x = np.mgrid[0:_HEIGHT, 0:_WIDTH]
    line = find_midline(masks)
    bare, crossed = (
        areas([mask & (np.abs(y - place - 0.25 * x) > 2) for mask in masks], line) for place in (-99, 62)
    )
    wide = bare.total > 0.5 * bare.total.max()
    lost = [np.count_nonzero(mask & (np.abs(y - 62 - 0.25 * x) <= 2)) for mask in masks]
    assert np.max(np.array(lost)[wide] / bare.total[wide]) > 0.04
    assert crossed.total[wide] == pytest.approx(bare.total[wide], rel=0.012)
    assert crossed.left[wide] == pytest.approx(bare.left[wide], rel=0.025)
    for edge in ("left_edge", "right_edge"):
        assert getattr(crossed, edge)[wide] == pytest.approx(getattr(bare, edge)[wide], abs=0.5)


def test_a_strand_that_slants_over_a_wide_glottis_leaves_its_curve() -> None:
    """It crosses 18 lines, over which the folds bulge by 5 % of their distance."""
    masks = _masks(
        lambda turn, shape: -shape * (13 + 8 * np.sin(turn)),
        lambda turn, shape: shape * (13 + 8 * np.sin(turn)),
    )
    y, x = np.mgrid[0:_HEIGHT, 0:_WIDTH]
    over = np.abs(y - _HEIGHT / 2 - 0.3 * (x - _WIDTH / 2)) <= 2
    line = find_midline(masks)
    bare, crossed = (fold_edges(shown, line) for shown in (masks, [mask & ~over for mask in masks]))
    middle = np.abs(bare.along - line.length / 2) <= 8
    wide = bare.left[:, middle].mean(axis=1) > 15
    for side in ("left", "right"):
        off = (getattr(crossed, side) - getattr(bare, side))[np.ix_(wide, middle)]
        assert abs(off.mean()) < 0.15


def test_of_lines_on_one_side_alone_no_curve_is_drawn_across_a_strand() -> None:
    """Those on the other side are another strand's; a parabola would run on from one side."""
    lines = np.arange(30.0)
    width, centre = (10 - 0.05 * (lines - 15) ** 2)[None], np.zeros((1, 30))
    free = np.ones(30, dtype=bool)
    curved, _ = _between_sides(width, centre, 12, 18, free)
    assert curved[0] == pytest.approx(width[0, 12:18])
    free[18:] = False
    straight, _ = _between_sides(width, centre, 12, 18, free)
    assert straight[0] == pytest.approx(np.interp(lines[12:18], [11, 18], width[0, [11, 18]]))


def test_below_a_strand_edges_are_those_beside_it_in_every_frame() -> None:
    """Noise shows a pixel in five of what it hides, and over a narrow slit it is not known by itself."""
    masks = _masks(
        lambda turn, shape: -shape * (0.5 + 4 * np.sin(turn)),
        lambda turn, shape: shape * (0.5 + 2 * np.sin(turn)),
    )
    y, x = np.mgrid[0:_HEIGHT, 0:_WIDTH]
    over = np.abs(y - 50 - 0.5 * x) <= 4
    line, noise = find_midline(masks), np.random.default_rng(3)
    strand = [mask & ~(over & (noise.random(over.shape) > 0.2)) for mask in masks]
    bare, crossed = (fold_edges(shown, line) for shown in (masks, strand))
    middle = np.abs(bare.along - line.length / 2) <= 0.1 * line.length
    assert np.mean(crossed.open[:, middle] == bare.open[:, middle]) > 0.99
    for side in ("left", "right"):
        edges = [getattr(one, side)[:, middle] for one in (bare, crossed)]
        assert np.ptp(edges[0], axis=0).min() > 2
        assert np.sqrt(np.mean((edges[1] - edges[0]) ** 2)) < 0.25


def test_folds_that_touch_in_their_middle_are_not_taken_for_a_strand() -> None:
    def polyp(way: int) -> Fold:
        return lambda turn, shape: (
            way
            * (np.maximum(shape * (7 + 6 * np.sin(turn)) - 14 * np.exp(-(((shape - 1) / 0.04) ** 2)), 0.0))
        )

    masks = _masks(polyp(-1), polyp(1))
    line = find_midline(masks)
    found = areas(masks, line)
    assert found.total == pytest.approx([mask.sum() for mask in masks], rel=0.005)
    assert found.opened.sum() < 0.6 * _FRAMES
    assert found.total.min() >= 100


def test_contact_between_folds_that_press_unlike_may_go_with_them() -> None:
    """Folds alike would carry the line of contact on with the mean of their velocities; whether they do is
    not seen, so it counts as doubt."""
    masks = _masks(
        lambda turn, shape: shape * np.minimum(-(3 + 12 * np.sin(turn)), 0.0),
        lambda turn, shape: shape * np.maximum(3 + 6 * np.sin(turn), 0.0),
    )
    found = areas(masks, find_midline(masks))
    closed = ~found.opened
    assert found.contact is not None
    assert found.contact[closed].max() > 0.6  # to the right, the slower one's side
    assert found.contact[~closed] == pytest.approx(0.0, abs=1e-9)


def test_places_on_a_bowed_midline_are_found_again() -> None:
    line = Midline((40.0, 10.0), (50.0, 90.0), tuple(5 * np.sin(np.linspace(0, np.pi, 65))))
    points = np.random.default_rng(1).uniform(0, 100, (50, 2))
    assert line.points(line.place(points)) == pytest.approx(points)
    on_it = line.points(np.array([[line.length / 2, 0.0]]))
    assert line.place(on_it) == pytest.approx(np.array([[line.length / 2, 0.0]]))
    assert np.linalg.norm(on_it[0] - (45.0, 50.0)) == pytest.approx(5.0, rel=1e-3)
    again = Midline.of(line.numbers.tolist())
    assert again.place(points) == pytest.approx(line.place(points))


def test_what_lies_over_a_slit_is_no_edge_of_it() -> None:
    mask = np.zeros((40, 40), dtype=bool)
    mask[5:35, 10:30] = True
    slits = Slits(Midline((20.0, 5.0), (20.0, 34.0)), mask.shape)
    whole = slits.of(mask)
    mask[:, 18:21] = False  # a strand
    crossed = slits.of(mask)
    for one, other in zip(whole[:2], crossed[:2], strict=True):
        assert np.array_equal(one, other)
    there = whole[0] > 0
    assert crossed[2][there] == pytest.approx(3 / 20)
    assert not crossed[2][~there].any()
    assert not whole[2].any()


@pytest.mark.parametrize("lean", [0.0, 7.0, 20.0])
def test_slits_are_as_wide_as_they_are_on_lines_that_lean(lean: float) -> None:
    """A band of 9 px about a line that leans."""
    line = Midline((50.0 - lean, 0.0), (50.0 + lean, 99.0))
    y, x = np.mgrid[0:100, 0:100].astype(float)
    off = line.place(np.stack([x, y], axis=-1))[..., 1]
    width, centre, _ = Slits(line, off.shape).of(np.abs(off - 2.0) < 4.5)
    assert width[20:80].mean() == pytest.approx(9.0, abs=0.1)
    assert centre[20:80].mean() == pytest.approx(2.0, abs=0.1)


@pytest.mark.usefixtures("few_draws")
def test_no_phase_and_no_ratio_is_made_of_a_fold_that_stands_still() -> None:
    time = np.arange(float(_FRAMES))
    moves, still = 5 + 4 * np.sin(2 * np.pi * time / _PERIOD), np.full(_FRAMES, 2.0)
    edges = {"left": (still, moves), "right": (moves, still)}
    for side, (left, right) in edges.items():
        found, _ = measures(GlottalArea(60 * left, 60 * right, left, right))
        assert found["left_right_phase"].value is None
        assert f"the {side} fold by 0 px moves less than" in found["left_right_phase"].note
        assert (found["amplitude_ratio"].value is None) == (side == "left")
        assert any("moves less than" in said for said in found["amplitude_asymmetry"].cautions)
        assert "fold lags" not in found["left_right_phase"].note
        moving = "right" if side == "left" else "left"
        assert not any("moves less than" in said for said in found[f"amplitude_{moving}"].cautions)


def _film(left: Fold, right: Fold) -> np.ndarray:
    random = np.random.default_rng(3)
    texture = 25 * ndimage.gaussian_filter(random.standard_normal((_HEIGHT, _WIDTH)), 2)
    frames = []
    for k in range(_FRAMES):
        open_part = _coverage(left, right, k)
        grey = ndimage.gaussian_filter((150 + texture) * (1 - open_part) + 20 * open_part, 0.8)
        frames.append(grey + 2 * random.standard_normal(grey.shape))
    return np.clip(np.round(frames), 0, 255).astype(np.uint8)


def test_the_measures_of_a_film_of_a_paralysed_fold_hold_what_is_true(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    np.save(
        tmp_path / "film.npy",
        _film(lambda _, shape: -4 * shape, lambda turn, shape: shape * np.maximum(3 + 7 * np.sin(turn), -4)),
    )
    settings = Settings(fps=4000, correct_drift=False)
    where = tmp_path / "film.npy", tmp_path / "found"
    found = analyse(*where, settings, until="glottis", progress=False)
    left, right = (found.measures[f"amplitude_{side}"] for side in ("left", "right"))
    assert left.value < 0.5
    assert right.value == pytest.approx(6.98, abs=0.5)
    assert right.interval[0] < 6.98 < right.interval[1]
    assert found.measures["left_right_phase"].value is None
    assert np.isnan(cycles_table(found)["left_right_phase (rad)"]).all()
    middle = found.vibrogram[:, found.vibrogram.shape[1] // 2]
    assert np.ptp(middle[0]) < 1.5
    assert np.ptp(middle[1]) > 12

    # Results of a version without outlines of either fold are not read, and are made again where asked for.
    with h5py.File(found.path, "r+") as file:
        del file["glottis/coverage"]
    with pytest.raises(VideoError, match="from an earlier version of plica"):
        load(tmp_path / "found")
    request.getfixturevalue("few_draws")
    again = analyse(*where, settings, until="glottis", progress=False)
    assert again.measures["amplitude_right"].value == right.value
