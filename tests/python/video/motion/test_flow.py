"""Motion between two frames: the API, the files and the command."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import plica
from plica import _engine as engine
from plica.commands.main import main
from plica.video.files.grey import to_grey
from plica.video.files.image_file import read_image
from plica.video.motion.flow import PRESETS, endpoint_error, flow, warp_error
from plica.video.motion.flow_file import read_flow, write_flow
from shared_data import shared_data

Frame = NDArray[np.float32]
MOTION = (1.4, -0.7)


def texture(rows: int, columns: int, motion: tuple[float, float] = (0.0, 0.0), seed: int = 1) -> Frame:
    """Waves of 7 to 50 px, moved by (u, v), in [0, 255]."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[:rows, :columns].astype(float)
    total = np.zeros((rows, columns))
    for k in range(10):
        frequency, direction, phase = 0.9 * 0.8**k, *random.uniform(-np.pi, np.pi, 2)
        along = np.cos(direction) * (x - motion[0]) + np.sin(direction) * (y - motion[1])
        total += np.sin(frequency * along + phase)
    return (128 + 12 * total).astype(np.float32)


@pytest.fixture
def pair() -> tuple[Frame, Frame]:
    return texture(60, 80), texture(60, 80, MOTION)


def test_what_moved_to_the_right_and_up_has_positive_u_and_negative_v(pair: tuple[Frame, Frame]) -> None:
    found = plica.flow(*pair)
    assert found.flow.shape == (60, 80, 2)
    assert found.flow.dtype == np.float32
    assert np.median(found.flow, axis=(0, 1)) == pytest.approx(MOTION, abs=0.005)
    assert found.mismatch is None


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_finds_a_translation(preset: str, pair: tuple[Frame, Frame]) -> None:
    found = flow(*pair, preset=preset).flow[8:-8, 8:-8]
    assert np.abs(found - MOTION).mean() < 0.02


def test_residual_and_mismatch_are_those_of_their_formulas(pair: tuple[Frame, Frame]) -> None:
    first, second = pair
    found = flow(first, second, round_trip=True)
    outside = np.isnan(found.residual)
    assert outside[:, -1].all()  # u > 0: the last column leaves the frame
    assert outside[0].all()
    assert not outside[2:, :-3].any()
    still = np.abs(second - first).mean()
    assert still > 5
    assert np.nanmean(np.abs(found.residual)) < 0.02 * still
    assert found.mismatch is not None
    assert (np.isnan(found.mismatch) == outside).all()
    assert np.nanmedian(found.mismatch) < 0.01
    back = flow(second, first).flow
    y, x = 30, 40
    to = np.array([x, y]) + found.flow[y, x]
    corner = np.floor(to).astype(int)
    s, t = to - corner
    cell = back[corner[1] : corner[1] + 2, corner[0] : corner[0] + 2]
    there = (1 - t) * ((1 - s) * cell[0, 0] + s * cell[0, 1]) + t * ((1 - s) * cell[1, 0] + s * cell[1, 1])
    assert found.mismatch[y, x] == pytest.approx(np.hypot(*(found.flow[y, x] + there)), abs=1e-5)


def test_grey_levels_of_any_range_give_the_same_flow(pair: tuple[Frame, Frame]) -> None:
    first, second = pair
    as_is, wide = flow(first, second), flow(256 * first - 1000, 256 * second - 1000)
    assert np.abs(as_is.flow - wide.flow).mean() < 1e-3  # round-off of the stretch
    assert wide.residual[30, 40] == pytest.approx(256 * as_is.residual[30, 40], abs=0.5)
    low, high = as_is.intensity
    assert (low, high) == (min(first.min(), second.min()), max(first.max(), second.max()))
    assert (flow(first, second, intensity=(low, high)).flow == as_is.flow).all()
    # Half the contrast on the scale of lambda: smoother.
    assert (flow(first, second, intensity=(low, 2 * high)).flow != as_is.flow).any()


def test_an_option_replaces_the_preset_s(pair: tuple[Frame, Frame]) -> None:
    options = {name: getattr(PRESETS["robust"], name) for name in dir(PRESETS["robust"]) if name[0] != "_"}
    assert engine.FlowOptions().smoothness == 0.045
    assert set(options) >= {"smoothness", "data_scale", "levels", "warps", "data_penalty"}
    thesis = flow(*pair, smoothness=0.5, sweeps=PRESETS["thesis"].sweeps, light="none").flow
    assert (thesis == flow(*pair, preset="thesis").flow).all()
    assert (thesis != flow(*pair).flow).any()
    assert flow(*pair, data_penalty="quadratic", smooth_penalty="quadratic", levels=1).flow.shape == (
        60,
        80,
        2,
    )


def test_light_that_changes_by_a_slope_does_not_move_a_constant_gradient(pair: tuple[Frame, Frame]) -> None:
    first, second = pair
    y, x = np.mgrid[:60, :80]
    lit = second + 20 + 0.2 * x - 0.1 * y
    inside = np.s_[8:-8, 8:-8]
    assert np.abs(flow(first, lit, light="none").flow[inside] - MOTION).mean() > 0.1
    assert np.abs(flow(first, lit, preset="gradient", light="none").flow[inside] - MOTION).mean() < 0.02


@pytest.mark.parametrize("preset", [name for name in PRESETS if PRESETS[name].light == "smooth"])
def test_light_that_changes_is_reported_and_moves_nothing(preset: str) -> None:
    first, second = texture(150, 190), texture(150, 190, MOTION)
    x = np.linspace(-1, 1, 190)
    gain = 1.06 + 0.03 * x
    lit = 5 + gain * second
    found = flow(first, lit, preset=preset, round_trip=True)
    inside = np.s_[12:-12, 12:-12]
    assert np.abs(found.flow[inside] - MOTION).mean() < 0.02
    low, _ = found.intensity
    modelled = low + found.light.gain * (first - low) + found.light.offset
    assert np.abs(modelled - (5 + gain * first)).max() < 1
    assert found.light.change == pytest.approx(((modelled - first) / (first - low).mean()).mean(), abs=1e-3)
    assert np.nanmedian(np.abs(found.residual)) < 0.5
    assert found.mismatch is not None
    assert np.nanmedian(found.mismatch) < 0.02


def test_the_published_methods_know_no_light_that_changes() -> None:
    assert [name for name in PRESETS if PRESETS[name].light == "none"] == ["reference", "thesis"]
    first = texture(60, 80)
    found = flow(first, 1.06 * first, preset="reference")
    assert (found.light.gain == 1).all()
    assert (found.light.offset, found.light.change) == (0, 0)


def test_a_masked_highlight_does_not_hold_the_flow(pair: tuple[Frame, Frame]) -> None:
    first, second = (frame.copy() for frame in pair)
    first[20:40, 30:50] = second[20:40, 30:50] = 255  # does not move
    mask = np.ones(first.shape, bool)
    mask[17:43, 27:53] = False
    over = np.s_[22:38, 32:48]
    assert np.abs(flow(first, second).flow[over] - MOTION).mean() > 0.3
    assert np.abs(flow(first, second, mask=mask).flow[over] - MOTION).mean() < 0.1


def test_colour_becomes_grey_by_the_weights_of_the_thesis() -> None:
    colour = np.random.default_rng(2).uniform(0, 255, (4, 5, 4))
    expected = colour[..., :3] @ [0.2989, 0.5870, 0.1140]
    assert to_grey(colour) == pytest.approx(expected, rel=1e-6)
    assert (to_grey(colour[..., :1]) == colour[..., 0].astype(np.float32)).all()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"second": np.zeros((60, 81))}, "flow: second is 81 x 60 px; must be 80 x 60 px like first."),
        ({"first": np.zeros((60, 80, 2))}, "to_grey: first has shape (60, 80, 2); must be (rows, columns)"),
        ({"first": np.array([["a"]])}, "to_grey: first has type <U1; must be numbers."),
        (
            {"preset": "robus"},
            'preset = "robus"; must be one of robust, reference, video, thesis, fast, gradient. Did you mean',
        ),
        ({"lamda": 0.1}, "flow: option lamda is unknown; must be one of"),
        ({"smoothness": -1}, "FlowOptions: smoothness = -1; must be in [1e-06, 1e+06]."),
        ({"warps": "many"}, "flow: warps = 'many'; must be numbers"),
        (
            {"data_penalty": "huber"},
            'data_penalty = "huber"; must be "lorentzian", "charbonnier" or "quadratic".',
        ),
        ({"gradient_noise": 0}, "gradient_noise = 0 grey levels per px^2; must be in [0.001, 1000]."),
        ({"mask": np.ones((3, 3), bool)}, "flow: mask has shape (3, 3); must be (60, 80)"),
        ({"mask": np.ones((60, 80))}, "flow: mask has type float64; must be bool"),
        ({"mask": np.zeros((60, 80), bool)}, "flow: mask leaves 0 pixels; must leave at least 1."),
        ({"intensity": (5, 5)}, "flow: intensity = (5, 5); must be (low, high) with low < high."),
    ],
)
def test_bad_input_is_refused(change: dict[str, Any], text: str, pair: tuple[Frame, Frame]) -> None:
    arguments: dict[str, Any] = {"first": pair[0], "second": pair[1]} | change
    with pytest.raises(plica.InvalidInput) as raised:
        flow(arguments.pop("first"), arguments.pop("second"), **arguments)
    assert text in str(raised.value)


def test_frames_without_numbers_contrast_or_size_are_refused(pair: tuple[Frame, Frame]) -> None:
    broken = pair[1].copy()
    broken[3, 4] = np.nan
    with pytest.raises(plica.InvalidInput, match=r"second has nan at row 3, column 4 \(1 such pixels\)"):
        flow(pair[0], broken)
    with pytest.raises(plica.InvalidInput, match="second has nan at row 3, column 4"):
        flow(pair[0], broken, intensity=(0, 255))
    with pytest.raises(plica.InvalidInput, match="every pixel of first is 7; must differ somewhere"):
        flow(np.full((9, 9), 7), np.full((9, 9), 7))
    with pytest.raises(plica.SolveFailed, match="the flow is not finite"):
        flow(*pair, intensity=(0, 1e-30))
    with pytest.raises(plica.InvalidInput, match="2 x 1 px; must have sides of at least 8 px"):
        flow([[1.0, 2.0]], [[2.0, 1.0]])


def test_a_flow_file_is_read_back_with_its_unknown_pixels(tmp_path: Path) -> None:
    path = tmp_path / "a.flo"
    there = np.random.default_rng(3).normal(size=(5, 7, 2)).astype(np.float32)
    there[2, 3, 1] = np.nan
    write_flow(path, there)
    data = path.read_bytes()
    assert struct.unpack("<fii", data[:12]) == (202021.25, 7, 5)
    assert struct.unpack_from("<ff", data, 12 + 8 * (7 * 1 + 2)) == pytest.approx(there[1, 2])
    assert struct.unpack_from("<ff", data, 12 + 8 * (7 * 2 + 3)) > (1e9, 1e9)
    there[2, 3] = np.nan
    np.testing.assert_array_equal(read_flow(path), there)
    assert os.listdir(tmp_path) == ["a.flo"]


def test_the_endpoint_error_leaves_unknown_pixels_out() -> None:
    truth = np.zeros((2, 2, 2))
    truth[0, 0] = np.nan
    found = np.full((2, 2, 2), [3.0, 4.0])
    found[1, 1] = 0
    assert endpoint_error(found, truth) == pytest.approx(10 / 3)
    with pytest.raises(plica.InvalidInput, match="known at 0 pixels"):
        endpoint_error(found, np.full((2, 2, 2), np.nan))


@pytest.mark.parametrize(
    ("name", "errors"), [("RubberWhale", 0.123), ("Venus", 0.233), ("Dimetrodon", 0.203)]
)
@pytest.mark.slow
def test_middlebury_errors_are_those_of_the_reference(name: str, errors: float) -> None:
    folder = shared_data(f"flow/middlebury/{name}")
    frames = [read_image(folder / f"frame{k}.png") for k in (10, 11)]
    truth = read_flow(folder / "flow10.flo")
    within = 1.1 if name == "Venus" else 1.05
    assert endpoint_error(flow(*frames).flow, truth) < within * errors


def test_gradient_has_the_error_of_the_grid_that_chose_it() -> None:
    # Of the three pairs that chose its constants: nothing about peers (docs/verification/optical_flow.md).
    found = []
    for name in ("RubberWhale", "Venus", "Dimetrodon"):
        folder = shared_data(f"flow/middlebury/{name}")
        frames = [read_image(folder / f"frame{k}.png") for k in (10, 11)]
        found.append(endpoint_error(flow(*frames, preset="gradient").flow, read_flow(folder / "flow10.flo")))
    assert np.mean(found) == pytest.approx(0.150, rel=0.02)  # another compiler's round-off


Save = Callable[[str, Frame], str]


@pytest.fixture
def save(tmp_path: Path) -> Save:
    def saved(name: str, frame: Frame) -> str:
        Image.fromarray(np.clip(np.round(frame), 0, 255).astype(np.uint8)).save(tmp_path / name)
        return str(tmp_path / name)

    return saved


def test_the_command_writes_a_flow_and_says_how_good_it_is(
    save: Save, pair: tuple[Frame, Frame], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names, out = [save("a.png", pair[0]), save("b.png", pair[1])], tmp_path / "ab.flo"
    write_flow(tmp_path / "true.flo", np.full((60, 80, 2), MOTION))
    assert main(["flow", *names, "-o", str(out), "--truth", str(tmp_path / "true.flo")]) == 0
    message = capsys.readouterr().out
    for word in ("motion", "residual", "mismatch", "error", "known on 100.0 %", "ab.flo"):
        assert word in message
    assert np.median(read_flow(out), axis=(0, 1)) == pytest.approx(MOTION, abs=0.01)
    mask = save("mask.png", np.full((60, 80), 255, np.float32))
    assert main(["flow", *names, "-o", str(out), "--preset", "fast", "--mask", mask, "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_the_command_names_the_file_that_is_wrong(
    save: Save, pair: tuple[Frame, Frame], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good, small, out = save("a.png", pair[0]), save("s.png", pair[1][:50]), str(tmp_path / "ab.flo")
    text = tmp_path / "text.png"
    text.write_text("no picture")
    cut = tmp_path / "cut.png"
    cut.write_bytes(Path(good).read_bytes()[:200])
    still = tmp_path / "still.gif"
    Image.new("L", (60, 60)).save(still, save_all=True, append_images=[Image.new("L", (60, 60), 9)])
    short = tmp_path / "short.flo"
    write_flow(short, np.zeros((60, 80, 2)))
    short.write_bytes(short.read_bytes()[:-4])
    other = tmp_path / "other.flo"
    write_flow(other, np.zeros((60, 81, 2)))
    for arguments, code, expected in (
        ([good, small], 2, "flow: second is 80 x 50 px; must be 80 x 60 px like first."),
        ([good, str(text)], 2, f"{text} is not a picture"),
        ([good, str(cut)], 2, f"{cut} cannot be read"),
        ([good, str(still)], 2, f"{still} has 2 frames; must have one"),
        ([good, str(tmp_path / "no.png")], 2, "no.png cannot be read: No such file"),
        ([good, str(tmp_path)], 2, "cannot be read: Is a directory"),
        ([good, good, "--preset", "quick"], 2, 'preset = "quick"; must be one of'),
        ([good, good, "--truth", str(text)], 2, f"{text} does not begin with"),
        ([good, good, "--truth", str(short)], 2, "Is it cut off?"),
        ([good, good, "--truth", str(other)], 2, "is 81 x 60 px; must be 80 x 60 px like"),
        ([good, good, "-o", str(tmp_path / "no" / "ab.flo")], 1, "its directory does not exist"),
        ([good, good, "-o", good], 2, "a.png; must end in .flo"),
    ):
        assert main(["flow", "-o", out, *arguments]) == code
        message = capsys.readouterr().err
        assert expected in message, message
        assert not Path(out).exists()


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "P", "1", "LA", "I;16", "F", "CMYK"])
def test_pictures_of_every_kind_are_read_in_their_levels(mode: str, tmp_path: Path) -> None:
    values = np.array([[0, 255], [255, 0]])
    path = tmp_path / "a.tif"
    if mode == "I;16":
        Image.fromarray((values * 257).astype(np.uint16)).save(path)
        values = values * 257
    else:
        Image.fromarray(values.astype(np.uint8)).convert(mode).save(path)
    # The weights of the thesis sum to 0.9999.
    assert read_image(path) == pytest.approx(values, rel=2e-4)


def test_the_warp_error_of_a_translation_is_nothing_and_of_the_opposite_one_is_not() -> None:
    y, x = np.mgrid[0:80, 0:90].astype(float)
    first = 100 + 40 * np.sin(x / 4) * np.cos(y / 5)
    second = 100 + 40 * np.sin((x - 1.5) / 4) * np.cos((y + 0.5) / 5)
    there = np.zeros((80, 90, 2))
    there[...] = (1.5, -0.5)
    assert warp_error(first, second, there).rms < 1  # a rim of two pixels comes from outside
    assert warp_error(first, second, -there).rms > 5
    assert np.abs(warp_error(first, second, there).percent[5:-5, 5:-5]).max() < 1
