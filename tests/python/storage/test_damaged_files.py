"""Damaged analyses, posteriors, films and JSON raise one clear error, or are what they were, to the bit."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from filmed_folds import moved, voiced
from flow_files import SETTINGS, block_scene, flow_file
from plica.identify import Settings, identify
from plica.identify import load as load_identification
from plica.identify.estimator.iterates import EstimateInputs, Iterates
from plica.identify.estimator.scoring import Iteration
from plica.identify.observation.sources import open_motion
from plica.measures.uncertainty import Refinement, Uncertain, Uncertainty, read_uncertainty, write_uncertainty
from plica.storage.json_file import read_json, write_json
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.uncertainty import plan
from plica.video.analysis import analyse
from plica.video.analysis import load as load_analysis
from plica.video.files.recording import Recording
from plica.video.settings import Settings as VideoSettings
from stored_files import DAMAGES, damaged

MOVIE = Synthetic(height=48, width=48, frames=24, frequency=0.12, amplitude=(4, 4), opening=(2, 2))


def flat(value: Any) -> Any:
    """Comparable to the bit."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: flat(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, dict):
        return {name: flat(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [flat(one) for one in value]
    return repr(value) if isinstance(value, float) else value


def names_in(path: Path) -> list[str]:
    """Of the data sets that are read back."""
    found: list[str] = []
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return [name for name in found if not name.startswith("checksums")]


def of_analysis(directory: Path, names: list[str]) -> Any:
    found = load_analysis(directory)
    rows = [found.mask(3), found.flow(2), found.round_trip(5), found.mask(-1)]
    about = (str(found.source), found.settings, found.file_date, found.segmenter, found.camera)
    return flat([rows, about, found.waveforms, found.flow_origin, {name: found[name] for name in names}])


def of_film(path: Path) -> Any:
    found = open_motion(path)
    pairs = range(found.pairs)
    moved = [(found.flow(pair), found.visible(pair)) for pair in pairs]
    return flat([moved, found.area, found.fps, found.mm_per_px, found.camera, found.kind, found.shape])


def of_frames(path: Path) -> Any:
    return flat(list(Recording.open(path, dataset="frames", scale=(0, 255)).frames()))


def outcome(read: Callable[[], Any], whole: Any, file: Path) -> str:
    """Of reading a damaged file: refused, or the same."""
    try:
        found = read()
    except (plica.InvalidInput, plica.StorageFailed) as error:
        said = str(error)
    else:
        assert found == whole
        return "same"
    assert file.name in said
    assert "; must be" in said or "; must have" in said or "cannot be read" in said
    assert "\n" not in said
    return "refused"


def structured(whole: bytes) -> list[bytes]:
    """One bit turned in every so many bytes of the first, where HDF5 says what the rest is."""
    found = []
    for at in [*range(0, 64, 3), *range(64, min(len(whole), 4000), 97)]:
        found.append(whole[:at] + bytes([whole[at] ^ (1 << at % 8)]) + whole[at + 1 :])
    return found


def check_damaged(file: Path, read: Callable[[], Any], count: int = 8) -> None:
    """Every way of damaging `file` is refused, or reading it gives the same."""
    content, whole = file.read_bytes(), read()
    try:
        for kind in (*DAMAGES, "structured"):
            found = []
            for bad in structured(content) if kind == "structured" else damaged(content, kind, count):
                file.write_bytes(bad)
                found.append(outcome(read, whole, file))
            assert "refused" in found or kind in ("zeroed", "swapped")
    finally:
        file.write_bytes(content)
    assert read() == whole


@pytest.fixture(scope="module")
def analysis(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("analysis")
    np.save(directory / "movie.npy", SyntheticGlottis(MOVIE).stack())
    settings = VideoSettings(fps=4000, correct_drift=False, modes=1, preset="fast")
    analyse(directory / "movie.npy", directory / "found", settings, progress=False)
    return directory / "found"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["results.h5", "flow.h5"])
def test_a_damaged_analysis_is_refused_or_reads_the_same(analysis: Path, name: str) -> None:
    flows = [f"flow/{one}" for one in names_in(analysis / "flow.h5") if one != "checksum"]
    names = [one for one in names_in(analysis / "results.h5") if one != "flow/file"]
    check_damaged(analysis / name, lambda: of_analysis(analysis, names + flows))


@pytest.mark.slow
def test_a_bit_of_a_flow_or_an_area_is_named(analysis: Path) -> None:
    found = load_analysis(analysis)
    area, uv = found["sides/left"].tobytes(), found.flow(4).tobytes()
    for name, part, said in (
        ("results.h5", area, r"results\.h5: sides/left is damaged"),
        ("flow.h5", uv, r"flow\.h5: uv\[4\] is damaged"),
    ):
        content = (analysis / name).read_bytes()
        at = content.index(part) + 8
        (analysis / name).write_bytes(content[:at] + bytes([content[at] ^ 64]) + content[at + 1 :])
        try:
            again = load_analysis(analysis)
            with pytest.raises(plica.errors.Damaged, match=said):
                _ = again.area if name == "results.h5" else again.flow(4)
        finally:
            (analysis / name).write_bytes(content)


@pytest.mark.slow
def test_an_analysis_does_not_follow_links_to_other_files(analysis: Path) -> None:
    path, elsewhere = analysis / "results.h5", analysis / "other.h5"
    content = path.read_bytes()
    os.link(path, elsewhere)
    try:
        for name in ("sides", "flow", "trust"):
            with h5py.File(path, "r+") as file:
                del file[name]
                file[name] = h5py.ExternalLink("other.h5", "/glottis")
            with pytest.raises(plica.InvalidInput, match=f"/{name} is a link to elsewhere"):
                _ = load_analysis(analysis)[f"{name}/left"]
            path.write_bytes(content)
    finally:
        path.write_bytes(content)
        elsewhere.unlink()


@pytest.mark.slow
def test_a_damaged_posterior_is_refused_or_reads_the_same(tmp_path: Path) -> None:
    settings = Settings(**SETTINGS | {"max_iterations": 20, "starts": 1})
    identify(flow_file(tmp_path / "flow.h5"), block_scene(), tmp_path / "out", settings, progress=False)
    check_damaged(tmp_path / "out" / "posterior.h5", lambda: flat(load_identification(tmp_path / "out")))


def film() -> plica.film.Clip:
    return plica.film(moved(voiced(), np.arange(3) * 0.5e-3), plica.Camera(width=32, height=48), samples=1)


@pytest.mark.slow
def test_a_damaged_film_is_refused_or_reads_the_same(tmp_path: Path) -> None:
    clip = film()
    plica.write_film(clip, tmp_path / "clip.npy")
    truth, both = tmp_path / "clip.truth.h5", tmp_path / "both.h5"
    plica.write_film(clip, both)
    assert of_film(truth)[-2:] == ["ground truth of a film", [48, 32]]
    check_damaged(truth, lambda: of_film(truth))
    check_damaged(both, lambda: of_frames(both))


def uncertainty() -> Uncertainty:
    step = Refinement(1.0, "other order", 1.9, 3.25, {"run": 2.0, "step-2": 3.0})
    table = {"peak_flow": Uncertain("peak_flow", "m^3/s", 2.0, step, None, 0.1, 0.2, 20)}
    return Uncertainty(12, "a source, with \u2013 more", [{"name": "step-2"}], table, {}, ["none"], "1.0")


def test_a_damaged_uncertainty_is_refused_or_reads_the_same(tmp_path: Path) -> None:
    path = write_uncertainty(uncertainty(), tmp_path / "uncertainty.json")
    assert read_uncertainty(tmp_path, 12) == uncertainty()
    assert read_uncertainty(tmp_path, 13) is None
    check_damaged(path, lambda: flat(read_uncertainty(tmp_path, 12)), 40)


def test_stored_json_may_be_laid_out_otherwise_but_not_say_something_else(tmp_path: Path) -> None:
    content = {"b": [1, 2.5, None, True], "a": {"x": "\u00e9", "y": {}}, "n": -0.0}
    path = write_json(content, tmp_path / "a.json", guarded=True)
    assert read_json(path, "Do") == content
    held = json.loads(path.read_text())
    path.write_text(json.dumps(dict(reversed(held.items())), ensure_ascii=False), encoding="utf-8")
    assert read_json(path, "Do") == content
    for changed in (
        held | {"b": [1, 2.5, None, False]},
        held | {"more": 1},
        content,
        [held],
        held | {"checksum": 5},
    ):
        path.write_text(json.dumps(changed))
        with pytest.raises(plica.errors.Damaged, match=r"a\.json: its content is not what .* edited.* Do\."):
            read_json(path, "Do")
    for text in ("", "[" * 100_000, "{", '{"a": 1e999}', "\ufeff{}"):
        path.write_text(text)
        with pytest.raises(plica.errors.Damaged, match=r"a\.json: its content"):
            read_json(path, "Do")


def test_damaged_iterates_are_refused_or_continue_the_same(tmp_path: Path) -> None:
    inputs = EstimateInputs({"starts": 1}, {"time": {"step": 1e-4}}, None, "a digest")
    kept = Iterates(tmp_path / "iterates.json", inputs)
    for number, x in enumerate([0.1, 0.2]):
        kept.add("scene", Iteration(number, -3.0 + x, np.array([x, -x]), 0.1, start=1))
    check_damaged(kept.path, lambda: flat(Iterates.open(tmp_path, inputs, resume=True)), 30)


def test_a_damaged_plan_is_refused_or_read_the_same(tmp_path: Path) -> None:
    options = {"scene": "a digest", "levels": ["step-2"], "budget": 4.0}
    content = {"options": options, "seconds": {}, "remarks": ["the mesh is left out: it is too expensive"]}
    path = write_json(content, tmp_path / "plan.json", guarded=True)
    assert plan._kept(path, options | {"budget": 5.0}, {}) is None
    check_damaged(path, lambda: flat(plan._kept(path, options, {})), 30)
