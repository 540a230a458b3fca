"""Glottal waveforms against the synthetic glottis, whose truth is known."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from plica.measures.cycles import find_cycles
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.errors import VideoError
from plica.video.files.recording import Recording
from plica.video.glottis.frame_segmentation import segment
from plica.video.glottis.glottal_area import GlottalArea, areas
from plica.video.glottis.kymogram import kymogram
from plica.video.glottis.midline import Midline, find_midline
from plica.video.glottis.segmenter import masks
from plica.video.measures.frame_flags import flags
from plica.video.measures.waveforms import measures, phases
from plica.video.motion.drift import Drift
from plica.video.motion.edge_agreement import edge_agreement

pytestmark = pytest.mark.usefixtures("few_draws")

_FPS = 4000.0


@pytest.fixture(scope="module")
def asymmetric() -> SyntheticGlottis:
    """Noise, blur, highlights; the right fold swings less and leads by 0.6 rad."""
    return SyntheticGlottis(Synthetic(frames=90, phase=(0.0, 0.6), amplitude=(9, 7), frequency=0.0473))


@pytest.fixture(scope="module")
def recorded(asymmetric: SyntheticGlottis, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("video") / "glottis.npy"
    np.save(path, asymmetric.stack())
    return Recording.open(path)


def test_flow_of_the_synthetic_glottis_carries_one_frame_to_the_next() -> None:
    from scipy import ndimage

    glottis = SyntheticGlottis(Synthetic(height=120, width=120, noise=0, blur=0, highlights=0, light=0))
    flow, known = glottis.flow(2, 3)
    y, x = np.mgrid[0:120, 0:120].astype(float)
    seen = ndimage.map_coordinates(glottis.frame(3), [y, x + flow[..., 0]], order=3)
    away = known & ~ndimage.binary_dilation(glottis.mask(2) | glottis.mask(3), iterations=2)
    away[:, :4] = away[:, -4:] = False
    assert np.abs(seen - glottis.frame(2))[away].max() < 2
    assert np.abs(glottis.frame(3) - glottis.frame(2))[away].max() > 20


def test_area_of_the_synthetic_glottis_is_that_of_its_mask() -> None:
    glottis = SyntheticGlottis()
    for t in (3, 5, 8):
        assert sum(glottis.area(t)) == pytest.approx(glottis.mask(t).sum(), rel=0.01)


@pytest.mark.parametrize(
    ("late", "said"), [(0.8, "the right fold lags"), (-0.8, "the left fold lags"), (0, "")]
)
def test_the_note_of_a_phase_says_which_fold_lags(late: float, said: str) -> None:
    turn = 2 * np.pi * np.arange(120) / 20.7
    left, right = 5 + 4 * np.sin(turn), 5 + 4 * np.sin(turn - late)
    found, _ = measures(GlottalArea(60 * left, 60 * right, left, right))
    note = found["left_right_phase"].note
    assert note.startswith(said) if said else "lags" not in note


@pytest.mark.slow
def test_masks_area_and_midline_are_the_true_ones(asymmetric: SyntheticGlottis, recorded: Recording) -> None:
    found = list(masks(recorded))
    midline = find_midline(found)
    assert abs(midline.upper[0] - asymmetric.midline) < 0.5
    assert abs(midline.lower[0] - asymmetric.midline) < 0.5
    area, truth = areas(found, midline), np.array([asymmetric.area(t) for t in range(90)])
    lost = 0.025  # in slits narrower than a pixel
    assert area.total.mean() == pytest.approx(truth.sum(axis=1).mean(), rel=lost)
    wide = truth.sum(axis=1) > 0.5 * truth.sum(axis=1).max()
    overlap = np.array(
        [
            (found[t] & asymmetric.mask(t)).sum() / max(1, (found[t] | asymmetric.mask(t)).sum())
            for t in range(90)
        ]
    )
    assert overlap[wide].min() > 0.95
    assert (area.total[truth.sum(axis=1) == 0] < 0.01 * truth.max()).all()

    told, cycles = measures(area, _FPS)
    rows = np.linspace(0.45, 0.55, 21) * (0.85 - 0.15) * 256 + 0.15 * 256
    edges = np.array([[asymmetric.edge(side, rows, t).mean() for t in range(90)] for side in (0, 1)])
    true_measures, _ = measures(GlottalArea(truth[:, 0], truth[:, 1], *edges), _FPS)
    assert cycles.count == 3
    assert told["fundamental_frequency"].value == pytest.approx(0.0473 * _FPS, abs=2)
    assert told["left_right_phase"].value == pytest.approx(-0.6, abs=0.1)
    limits = {
        "open_quotient": 0.05,
        "area_asymmetry": 0.02,
        "amplitude_asymmetry": 0.04,  # of edges that stop where they touch, between two frames
        "amplitude_left": 0.35,
        "amplitude_right": 0.35,
    }
    for name, close in limits.items():
        assert told[name].value == pytest.approx(true_measures[name].value, abs=close)


def test_the_midline_is_where_the_folds_meet_and_not_halfway_between_them() -> None:
    glottis = SyntheticGlottis(Synthetic(height=128, width=128, amplitude=(9, 3), opening=(4, 2)))
    midline = find_midline(glottis.mask(t) for t in range(20))
    assert abs(midline.upper[0] - glottis.midline) < 0.6
    assert abs(midline.lower[0] - glottis.midline) < 0.6


def test_a_closed_glottis_and_plain_tissue_have_none() -> None:
    glottis = SyntheticGlottis(Synthetic(highlights=0))
    assert not glottis.mask(15).any()
    assert segment(np.full((64, 64), 90.0)).score == 0
    open_one = segment(glottis.frame(5))
    truth = glottis.mask(5)
    assert (open_one.mask & truth).sum() / (open_one.mask | truth).sum() > 0.9


def test_measures_without_a_frame_rate_are_in_frames() -> None:
    time = np.arange(120.0)
    area = np.maximum(0, np.sin(2 * np.pi * time / 15)) * 100
    found, cycles = measures(GlottalArea(0.5 * area, 0.5 * area, area, area))
    assert found["fundamental_frequency"].unit == "1/frame"
    assert found["fundamental_frequency"].value == pytest.approx(1 / 15, rel=1e-3)
    assert found["open_quotient"].value == pytest.approx(
        1 - 2 * np.arcsin(0.05) / (2 * np.pi) - 0.5, abs=0.04
    )
    labels = phases(GlottalArea(0.5 * area, 0.5 * area, area, area), cycles, time)
    assert {"closed", "opening", "open", "closing"} <= set(labels)
    for k in range(1, 119):  # falls and rises as it is called
        if labels[k] == "closing":
            assert area[k] < area[k - 1]
        if labels[k] == "opening":
            assert area[k] > area[k - 1]
    breathy = GlottalArea(*np.tile(60 + 50 * np.sin(2 * np.pi * time / 15), (4, 1)))  # never closed
    labels = phases(breathy, measures(breathy)[1], time)
    assert 0.3 < labels.count("opening") / (labels.count("closing") + labels.count("opening")) < 0.7
    quiet, _ = measures(GlottalArea(*np.zeros((4, 40))))
    assert quiet["fundamental_frequency"].value is None
    assert "no oscillation" in quiet["fundamental_frequency"].note
    assert find_cycles(np.arange(40.0), np.zeros(40)).count == 0


def test_sides_are_those_of_the_image_whichever_way_the_midline_leans() -> None:
    mask = np.zeros((40, 40), dtype=bool)
    mask[10:30, 20:26] = True
    for lean in (-4.0, 0.0, 4.0):
        area = areas([mask], Midline((18.0 - lean, 0.0), (18.0 + lean, 39.0)))
        assert area.right[0] > area.left[0]
    with pytest.raises(VideoError, match=r"runs 180 degrees from the vertical; must be within 45"):
        Midline((18.0, 39.0), (18.0, 0.0))
    with pytest.raises(VideoError, match=r"runs 60 degrees .*by -60 degrees more"):
        Midline((0.0, 0.0), (np.sqrt(3), 1.0))


def test_a_kymogram_shows_the_edges_where_they_are(asymmetric: SyntheticGlottis) -> None:
    line = asymmetric.midline
    top, bottom = 0.15 * 256, 0.85 * 256
    frames = [np.asarray(asymmetric.frame(t), dtype=np.float32) for t in (4, 26, 47)]
    both = kymogram(frames, Midline((line, top), (line, bottom)), (0.5, 0.2), 30)
    assert both.shape == (2, 3, 61)
    picture = both[0]
    row = np.array([0.5 * (top + bottom)])
    for seen, t in zip(picture, (4, 26, 47), strict=True):
        width = asymmetric.edge(0, row, t)[0] + asymmetric.edge(1, row, t)[0]
        dark = seen < 60
        assert dark.sum() == pytest.approx(width, abs=2)


def test_without_a_glottis_or_a_direction_it_is_said(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    square = np.zeros((64, 64), dtype=bool)
    square[20:40, 28:36] = True
    np.save(tmp_path / "noise.npy", random.normal(120, 1, (5, 64, 64)) - 0.5 * square)
    noise = Recording.open(tmp_path / "noise.npy")
    with pytest.raises(VideoError, match="none of the 5 frames looked at has a dark region within an edge"):
        list(masks(noise))
    with pytest.raises(VideoError, match=r"Glottis: the darkest region is .* grey levels darker"):
        list(masks(noise, {0: square}))
    with pytest.raises(VideoError, match="no frame has a glottis"):
        find_midline([np.zeros((20, 20), dtype=bool)])
    square = np.zeros((20, 20), dtype=bool)
    square[5:15, 5:15] = True
    with pytest.raises(VideoError, match="times as long as wide"):
        find_midline([square])


def test_a_midline_tells_places_and_mirror_images() -> None:
    midline = Midline((10.0, 5.0), (14.0, 8.0 + 5.0))
    assert midline.place(np.array([14.0, 13.0])) == pytest.approx([np.sqrt(80), 0])
    assert midline.place(np.array([12.0, 9.0]) + 3 * midline.across) == pytest.approx([np.sqrt(20), 3])
    assert midline.across[0] > 0  # to the right
    points = np.random.default_rng(1).normal(0, 20, (7, 2))
    assert midline.points(midline.place(points)) == pytest.approx(points)


def test_calibrated_measures_are_in_si_and_others_over_the_glottal_length() -> None:
    time = np.arange(120.0)
    edge = 8 * np.maximum(0, np.sin(2 * np.pi * time / 15))
    area = GlottalArea(100 * edge, 100 * edge, edge, edge)
    bare, told = measures(area)[0], measures(area, 3000, 0.05, 200.0)[0]
    assert bare["amplitude_left"].unit == "px"
    assert told["amplitude_left"].unit == "m"
    assert told["amplitude_left"].value == pytest.approx(0.05e-3 * bare["amplitude_left"].value)
    assert told["glottal_area_max"].value == pytest.approx(0.05e-3**2 * bare["glottal_area_max"].value)
    assert told["glottal_length"].value == pytest.approx(10.0e-3)
    assert told["amplitude_left_relative"].value == pytest.approx(bare["amplitude_left"].value / 200)
    assert told["glottal_area_max_relative"].value == pytest.approx(area.total.max() / 200**2)
    assert "glottal_length" not in bare


@pytest.mark.slow
def test_the_exact_flow_agrees_with_the_edges_and_no_flow_does_not(asymmetric: SyntheticGlottis) -> None:
    times = range(45)
    glottis = [asymmetric.mask(t) for t in times]
    midline = Midline((asymmetric.midline, 38.0), (asymmetric.midline, 218.0))
    area = areas(glottis, midline)
    flows = [np.nan_to_num(asymmetric.flow(t, t + 1)[0]) for t in times[:-1]]
    found = edge_agreement(flows, glottis, area, midline)
    assert found.count > 20
    assert found.correlation > 0.98
    assert (
        0.6 < found.slope < 1
    )  # tissue within 8 px moves less than the edge: 1 / e over 25 px, and on the rows
    against = edge_agreement([-flow for flow in flows], glottis, area, midline)
    assert against.slope == pytest.approx(-found.slope)
    still = edge_agreement([0 * flow for flow in flows], glottis, area, midline)
    assert np.isnan(still.correlation)
    assert edge_agreement(flows[:2], glottis[:3], GlottalArea(*np.zeros((4, 3))), midline).count == 0


def test_a_symmetric_glottis_is_symmetric_wherever_its_midline_lies_between_pixels() -> None:
    mask = np.zeros((40, 41), dtype=bool)
    mask[5:35, 16:25] = True  # nine columns about column 20
    for column in (20.0, 19.7):
        area = areas([mask], Midline((column, 0.0), (column, 39.0)))
        off = 20.0 - column
        assert area.right[0] - area.left[0] == pytest.approx(30 * 2 * off)
        assert area.right_edge[0] == pytest.approx(4.5 + off)
        assert area.total[0] == pytest.approx(mask.sum())


def test_folds_in_opposite_phase_are_half_a_cycle_apart() -> None:
    time = np.arange(200.0)
    random = np.random.default_rng(5)
    left = 50 + 40 * np.sin(2 * np.pi * time / 20) + random.normal(0, 1, 200)
    right = 50 - 30 * np.sin(2 * np.pi * time / 20) + random.normal(0, 1, 200)
    found, cycles = measures(GlottalArea(left, right, left, right))
    assert cycles.count >= 3
    assert abs(abs(found["left_right_phase"].value) - np.pi) < 0.1
    assert found["left_right_phase"].spread < 0.2


def test_a_kymogram_has_the_images_left_first_and_its_places_from_above() -> None:
    y, x = np.mgrid[0:60, 0:40]
    frames = [np.asarray(x + 100 * y, dtype=np.float32)] * 2
    line = Midline((20.0, 10.0), (20.0, 50.0))
    upper, lower = kymogram(frames, line, (0.25, 0.75), 5)
    assert upper[0].tolist() == [2000.0 + x for x in range(15, 26)]
    assert lower[1].tolist() == [4000.0 + x for x in range(15, 26)]
    with pytest.raises(VideoError, match=r"kymogram = 1\.2; must be places in"):
        kymogram(frames, line, (1.2,))


@pytest.mark.parametrize(
    "name", ["blur", "saturation", "drift", "lost", "border", "residual", "blind", "collision"]
)
def test_each_flag_is_raised_by_its_fault_alone(name: str) -> None:
    total = np.tile([0.0, 0.0, 50, 100, 60, 20], 5)
    motion, likeness = np.zeros((30, 3)), np.ones(30)
    sharpness, saturated, border, residual = np.full(30, 9.0), np.zeros(30), np.zeros(30, bool), np.ones(29)
    expected = [8]
    if name == "blur":
        sharpness[8] = 4
    elif name == "saturation":
        saturated[8] = 0.06
    elif name == "drift":
        motion[8:, 0] = 1.2
    elif name == "lost":
        likeness[8] = 0.4
    elif name == "border":
        border[8] = True
    elif name == "residual":
        residual[8] = 3.1
    elif name == "blind":
        residual[8] = np.nan
    else:
        expected = [6, 12, 18, 24]
    found = flags(total, Drift(motion, likeness), sharpness, saturated, border, residual)
    assert [k for k, said in enumerate(found) if name in said.split(", ")] == expected
    others = {reason for said in found for reason in said.split(", ")} - {"", "collision", name}
    assert not others


def test_the_midline_leans_as_the_folds_do_beside_a_shadow_that_stays() -> None:
    line = Midline((60.0, 20.0), (30.0, 110.0))
    y, x = np.mgrid[0:130, 0:100].astype(float)
    along, off = np.moveaxis(line.place(np.stack([x, y], axis=-1)), -1, 0)
    shadow = (np.abs(y - 20) < 2) & (x > 42) & (x < 62)  # a thin one across the upper end
    shapes = [np.clip(4 * along / line.length * (1 - along / line.length), 0, 1) * w for w in (2, 4, 6, 4)]
    found = find_midline([(np.abs(off) < shape) | shadow for shape in shapes])
    ends = np.abs(line.place(np.array([found.upper, found.lower]))[:, 1])
    assert ends.max() < 3


def _pulses(count: int = 400) -> GlottalArea:
    area = 300 * np.maximum(np.sin(2 * np.pi * np.arange(count) / 25.0), 0)
    return GlottalArea(area / 2, area / 2, area / 50, area / 50)


def test_measures_over_frames_that_are_not_known_say_so() -> None:
    whole = measures(_pulses(), _FPS)[0]
    assert whole["open_quotient"].cautions == ()
    lost = np.random.default_rng(0).random(400) < 0.4
    parts = (np.where(lost, np.nan, part) for part in _pulses().parts.values())
    found = measures(GlottalArea(*parts), _FPS)[0]["open_quotient"]
    assert found.value != pytest.approx(whole["open_quotient"].value, abs=0.03)
    (said,) = found.cautions
    assert re.fullmatch(r"the area of 1\d\d of 3\d\d frames is not known and taken .*", said)


def test_cycles_with_a_lost_frame_are_found_and_not_used() -> None:
    parts = [part.copy() for part in _pulses().parts.values()]
    for part in parts:
        part[[60, 61, 210]] = np.nan  # in two cycles, at their height
    found, cycles = measures(GlottalArea(*parts), _FPS)
    assert (found["cycles_found"].value, found["cycles_used"].value) == (cycles.count, cycles.count - 2)
    whole = measures(_pulses(), _FPS)[0]
    for name in ("glottal_area_max", "open_quotient", "speed_quotient", "amplitude_left"):
        assert found[name].cycles == cycles.count - 2
        assert found[name].value == pytest.approx(whole[name].value, rel=1e-3)
    assert found["shimmer"].value == pytest.approx(whole["shimmer"].value, abs=1e-3)


def test_folds_of_two_frequencies_are_diplophonic() -> None:
    time = np.arange(600)
    left, right = (100 * np.maximum(np.sin(2 * np.pi * time / period), 0) for period in (25.0, 19.0))
    cycles = measures(GlottalArea(left, right, left / 9, right / 9), _FPS)[1]
    assert cycles.verdict == "diplophonic"
    assert "left of the midline repeats itself at 160 Hz, right of it at 210" in cycles.note
    assert measures(GlottalArea(left, left, left / 9, left / 9), _FPS)[1].verdict == "regular"


def test_a_record_that_is_lost_at_its_end_has_the_cycles_before() -> None:
    late = np.arange(400) > 250
    parts = (np.where(late, np.nan, part) for part in _pulses().parts.values())
    found = measures(GlottalArea(*parts), _FPS)[0]["open_quotient"]
    assert found.cycles == 8  # of 25 frames each in 250; the record begins within the first rise
    assert found.value == pytest.approx(measures(_pulses(), _FPS)[0]["open_quotient"].value, abs=0.01)


def test_what_compares_the_folds_of_a_recording_says_which_is_the_left_one() -> None:
    patients = ("left in the image (the patient's right)", "right in the image (the patient's left)")
    found = measures(_pulses(), _FPS, sides=patients)[0]
    for name in ("left_right_phase", "amplitude_ratio", "amplitude_asymmetry", "area_asymmetry"):
        assert found[name].note == "the left fold being the one left in the image (the patient's right)"


@pytest.mark.parametrize(("amplitude", "said"), [(4.0, True), (15.0, False)])
def test_small_amplitudes_in_pixels_are_said_to_be_uncertain(amplitude: float, said: bool) -> None:
    angle = 2 * np.pi * np.arange(200) / 20
    edge = amplitude * (1 + np.sin(angle))
    found, _ = measures(GlottalArea(50 * edge, 50 * edge, edge, edge), _FPS, 0.05)
    for name in ("amplitude_left", "amplitude_right", "amplitude_ratio", "amplitude_asymmetry"):
        assert any("edges are placed to 0.5 px" in text for text in found[name].cautions) == said
