"""A network of one's own: its masks are its own to half a pixel, and what does not fit is refused."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

from onnx import TensorProto

from onnx_models import apart, bare, darker, smaller, sums, two_inputs
from picture_files import refused
from plica import video
from plica.commands.main import main
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.glottis.network import Network, Placement, fingerprint

LEVEL = 0.4
SHAPES = {
    "channels first": {"shape": (1, 1, "h", "w")},
    "three channels": {"shape": ("n", 3, "h", "w")},
    "channels last": {"shape": (1, "h", "w", 1)},
    "three channels last": {"shape": (1, "h", "w", 3)},
    "half precision": {"kind": TensorProto.FLOAT16},
    "bytes": {"kind": TensorProto.UINT8},
    "logits": {"last": "", "plica_output": "logits"},
    "two channels": {"channels_out": 2},
    "two channels of logits": {"channels_out": 2, "last": "", "plica_output": "logits"},
    "no channel": {"channels_out": 0},
    "size of the frame": {"shape": (1, 1, 48, 70)},
}


@pytest.mark.parametrize("kind", SHAPES)
def test_every_form_of_the_contract_gives_the_mask_that_is_known(kind: str, tmp_path: Path) -> None:
    frame = np.random.default_rng(3).integers(0, 256, (48, 70)).astype(np.float32)
    frame[np.abs(frame - 255 * LEVEL) < 1] = 0  # half precision rounds
    network = Network(darker(tmp_path / "m.onnx", level=LEVEL, **SHAPES[kind]))
    assert np.array_equal(network.outline(frame, 0).mask, frame < 255 * LEVEL)


def test_the_threshold_is_the_models_and_the_band_lies_about_it(tmp_path: Path) -> None:
    ramp = np.tile(np.linspace(60, 140, 64, dtype=np.float32), (32, 1))
    found = Network(darker(tmp_path / "m.onnx", level=LEVEL, plica_threshold="0.8")).outline(ramp, 0)
    chance = 1 / (1 + np.exp(-60 * (LEVEL - ramp.astype(float) / 255)))
    assert np.array_equal(found.mask, chance >= 0.8)
    assert (found.least, found.largest) == ((chance >= 0.9).sum(), (chance >= 0.7).sum())


@pytest.mark.parametrize("resize", ["fit", "stretch"])
@pytest.mark.parametrize("size", [(256, 256), (64, 96), (512, 256), (70, 50)])
def test_masks_come_back_to_half_a_pixel(size: tuple[int, int], resize: str, tmp_path: Path) -> None:
    y, x = np.mgrid[:100, :140].astype(float)
    inside = np.hypot((y - 41.3) / 1.6, x - 88.7) - 18.2  # px from the edge, less than so along y
    frame = (200 - 170 / (1 + np.exp(4 * inside / 3))).astype(np.float32)  # halfway, 115, at the edge
    network = Network(darker(tmp_path / "m.onnx", (1, 1, *size), level=115 / 255, plica_resize=resize))
    mask = network.outline(frame, 0).mask
    pixel = max(1, 140 / size[1], 100 / size[0])  # of the coarser of the two
    assert np.abs(inside[mask != (inside < 0)]).max(initial=0) < 0.5 * pixel
    centre = np.argwhere(mask).mean(axis=0)
    assert centre == pytest.approx((41.3, 88.7), abs=0.1 * pixel)


def test_a_frame_keeps_its_aspect_and_lies_in_the_middle() -> None:
    place = Placement.of((100, 140), (256, 256), "fit")
    assert (place.inner, place.top, place.left) == ((183, 256), 36, 0)
    free = Placement.of((100, 140), None, "fit")
    assert (free.inner, free.outer, free.top, free.left) == ((100, 140), (128, 160), 14, 10)
    frame = np.random.default_rng(1).random((100, 140), dtype=np.float32)
    assert np.array_equal(free.back(free.into(frame)), frame)


# ---- In a recording ----------------------------------------------------------------------------

GLOTTIS = SyntheticGlottis(
    Synthetic(height=64, width=64, frames=42, amplitude=(4, 4), opening=(2, 2), frequency=0.12, texture=10)
)


@pytest.fixture(scope="module")
def movie(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("movie") / "movie.npy"
    np.save(path, GLOTTIS.stack())
    return path


@pytest.mark.usefixtures("few_draws")
def test_a_recording_is_measured_by_the_networks_masks(movie: Path, tmp_path: Path) -> None:
    model, drawn = darker(tmp_path / "m.onnx", level=0.3), GLOTTIS.mask(3)
    settings = video.Settings(segmenter=str(model), correct_drift=False)
    found = video.analyse(
        movie, tmp_path / "out", settings, masks={3: drawn}, until="glottis", progress=False
    )
    frames = list(found.frames().frames())
    for index in (0, 1, 2, 9):
        assert np.array_equal(found.mask(index), frames[index] < 0.3 * 255)
    assert np.array_equal(found.mask(3), drawn)
    overlaps = [
        (found.mask(k) & GLOTTIS.mask(k)).sum() / (found.mask(k) | GLOTTIS.mask(k)).sum()
        for k in range(42)
        if k != 3 and GLOTTIS.mask(k).sum() > 150
    ]
    assert min(overlaps) > 0.8  # this level loses pixels at the edges that are half glottis
    assert found.measures["fundamental_frequency"].value == pytest.approx(0.12, rel=0.03)
    assert (found["glottis/least"] <= found["glottis/largest"]).all()


@pytest.mark.usefixtures("few_draws", "unrendered")
def test_an_analysis_goes_on_with_the_same_model_alone(
    movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out = darker(tmp_path / "m.onnx", level=0.3), tmp_path / "out"
    command = ["glottis", str(movie), "-o", str(out), "--no-drift", "--quiet", "--segmenter"]
    assert main([*command, str(model)]) == 0
    assert "glottis found by the network m.onnx" in (out / "report.html").read_text()
    moved = shutil.copy(model, tmp_path / "moved.onnx")
    assert main([*command, str(moved)]) == 0
    darker(model, level=0.25)
    assert "another model than when the analysis" in refused([*command, str(model)], capsys)
    assert "segmenter is not given; must be" in refused(command[:-1], capsys)


@pytest.mark.parametrize("name", ["m.onnx.data", "weights.bin", "w" * 150, "Gewichte für m"])
def test_weights_in_a_file_of_any_name_are_of_the_models_content(name: str, tmp_path: Path) -> None:
    frame = np.full((32, 32), 0.35 * 255, np.float32)
    model = apart(tmp_path / "m.onnx", name, level=0.4)
    graph, first = model.read_bytes(), fingerprint(model)
    assert Network(model).probability(frame).mean() > 0.9
    assert fingerprint(model) == first
    apart(model, name, level=0.3)
    assert Network(model).probability(frame).mean() < 0.1
    assert model.read_bytes() == graph
    assert fingerprint(model) != first


# ---- What does not fit -------------------------------------------------------------------------


def text(path: Path) -> Path:
    path.write_text("no model")
    return path


MODELS: dict[str, tuple[Callable[[Path], Any], str]] = {
    "no file": (lambda path: path, "is no file; must be an ONNX model"),
    "text": (text, "m.onnx cannot be read as an ONNX model"),
    "rank three": (lambda path: bare(path, (1, "h", "w")), "an input of shape (1, h, w); must be"),
    "four channels": (lambda path: darker(path, (1, 4, "h", "w")), "must be of 1 or 3 channels"),
    "free channels": (lambda path: darker(path, (1, "c", "h", "w")), "must be of 1 or 3 channels"),
    "two at a time": (lambda path: darker(path, (2, 1, 64, 64)), "shape (2, 1, 64, 64); must be (1, C"),
    "one side free": (
        lambda path: darker(path, (1, 1, 64, "w")),
        "fixed in height and width, or free in both",
    ),
    "double precision": (
        lambda path: darker(path, kind=TensorProto.DOUBLE),
        "an input of tensor(double); must be one of tensor(float)",
    ),
    "two inputs": (two_inputs, "2 inputs (a, b); must be one"),
    "half the size": (smaller, "an output of shape (1, 1, 32, 32) for frame 0; must be (1, C, 64, 64)"),
    "three channels out": (lambda path: darker(path, channels_out=3), "an output of shape (1, 3, 64, 64)"),
    "not a number": (
        lambda path: darker(path, last="Log"),
        "of its output for frame 0; must be finite numbers",
    ),
    "logits unsaid": (lambda path: darker(path, last=""), 'Then set its metadata "plica.output" to "logits"'),
    "sums": (sums, "two channels whose sums are not 1"),
    "unknown metadata": (
        lambda path: darker(path, plica_treshold="0.4"),
        'metadata "plica.treshold"; must be one of plica.output, plica.threshold, plica.resize. Did you mean',
    ),
    "unknown output": (lambda path: darker(path, plica_output="mask"), "must be one of probability, logits"),
    "threshold": (
        lambda path: darker(path, plica_threshold="1.5"),
        'plica.threshold = "1.5"; must be in (0, 1)',
    ),
    "finds nothing": (lambda path: darker(path, level=-5.0), "finds no glottis in any of 42 frames"),
}


@pytest.mark.parametrize("kind", MODELS)
def test_a_model_that_would_mislead_is_refused(
    kind: str, movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make, said = MODELS[kind]
    make(tmp_path / "m.onnx")
    out = tmp_path / "out"
    command = ["glottis", str(movie), "-o", str(out), "--no-drift", "--segmenter", str(tmp_path / "m.onnx")]
    assert said in refused([*command, "--quiet"], capsys)
    assert not (out / "report.html").exists()


def test_without_onnx_runtime_it_is_said_what_to_install(
    movie: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    model = darker(tmp_path / "m.onnx")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    said = refused(["glottis", str(movie), "-o", str(tmp_path / "out"), "--segmenter", str(model)], capsys)
    assert "m.onnx needs ONNX Runtime, which is not installed; must be: pip install 'plica[onnx]'" in said
    assert not (tmp_path / "out").exists()


def test_dark_specks_beside_the_glottis_are_the_models_to_leave_out(tmp_path: Path) -> None:
    frame = np.full((32, 32), 200, np.float32)
    frame[8:24, 15:17] = frame[3, 3] = 10
    mask = Network(darker(tmp_path / "m.onnx")).outline(frame, 0).mask
    assert ndimage.label(mask)[1] == 2
