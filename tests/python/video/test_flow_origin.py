"""What found a stored flow is known: flows of two programs are never mixed, and a comparison says so."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from plica.storage.hdf5 import set_text
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video import chain
from plica.video.analysis import Analysis, analyse, load
from plica.video.motion.flow_origin import FlowOrigin
from plica.video.report.comparison import compare
from plica.video.settings import Settings
from stored_files import forget, rewrite

FRAMES = 24
MOVIE = SyntheticGlottis(
    Synthetic(height=48, width=48, frames=FRAMES, frequency=0.12, amplitude=(4, 4), opening=(2, 2))
)
SETTINGS = Settings(fps=4000, correct_drift=False, modes=1, preset="fast")


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    where = tmp_path_factory.mktemp("origin")
    np.save(where / "movie.npy", MOVIE.stack())
    return analyse(where / "movie.npy", where / "found", SETTINGS, progress=False)


@pytest.fixture
def found(analysed: Analysis, tmp_path: Path) -> Analysis:
    """A copy, to be changed."""
    return load(shutil.copytree(analysed.directory, tmp_path / "found"))


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry for each pair whose flow is found from now on."""
    calls: list[int] = []
    whole = chain.flow

    def count(*args: object, **named: object) -> object:
        calls.append(1)
        return whole(*args, **named)

    monkeypatch.setattr(chain, "flow", count)
    return calls


def stopped(found: Analysis, *, constants: str | None = None, probe: Any = 0.0) -> None:
    """As if the analysis had been stopped five pairs before its end, and what found it was another."""
    forget(found.path, "flow", "trust", "paths", "modes", "waves")
    flows = found.directory / "flow.h5"
    rewrite(flows, "uv", 7.0)
    with h5py.File(flows, "r+") as file:
        file["checksum"][-5:] = 0
        probe += file["probe"][:]
        if constants is not None:
            set_text(file["probe"], "constants", constants)
    rewrite(flows, "probe", probe)


def again(found: Analysis) -> Analysis:
    return analyse(found.source, found.directory, SETTINGS, progress=False)


def test_a_flow_that_the_same_program_began_is_gone_on_with(
    found: Analysis, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped(found, probe=0.001)  # libraries round otherwise
    calls = counted(monkeypatch)
    uv = again(found)["flow/uv"]
    assert len(calls) == 5
    assert (uv[:-5] == 7.0).all()


@pytest.mark.parametrize("other", [{"probe": 0.05}, {"constants": '{"smoothness": 0.5}'}])
def test_a_flow_that_another_program_began_is_found_anew_as_a_whole(
    found: Analysis, monkeypatch: pytest.MonkeyPatch, other: dict[str, float | str]
) -> None:
    before = found["flow/uv"]
    stopped(found, **other)  # type: ignore[arg-type]
    calls = counted(monkeypatch)
    now = again(found)
    assert len(calls) == FRAMES - 1
    assert np.array_equal(now["flow/uv"], before)
    assert now.flow_origin is not None
    assert now.flow_origin.difference(FlowOrigin.of("fast")) == ""


def test_an_analysis_that_is_done_stays_as_it_was_found(
    found: Analysis, monkeypatch: pytest.MonkeyPatch
) -> None:
    rewrite(found.directory / "flow.h5", "probe", 1.0)
    calls = counted(monkeypatch)
    again(found)
    assert not calls


@pytest.mark.usefixtures("few_draws")
def test_a_comparison_says_that_the_motion_was_found_by_different_means(
    found: Analysis, tmp_path: Path
) -> None:
    assert not any("motion was found" in said for said in compare(found, found).remarks)
    copy = shutil.copytree(found.directory, tmp_path / "other")
    with h5py.File(copy / "flow.h5", "r+") as file:
        set_text(file["probe"], "constants", '{"smoothness": 0.5}')
    other = load(copy)
    remarks = compare(found, other).remarks
    assert any("motion was found" in said and "smoothness" in said for said in remarks)
    assert other.flow_origin is not None
    here = FlowOrigin.of("fast")
    assert "smoothness 0.045 and 0.5" in here.difference(other.flow_origin)


def test_the_probe_sees_constants_and_folds() -> None:
    fast, video = FlowOrigin.of("fast"), FlowOrigin.of("video")
    assert "gradient_noise None and 1.0" in fast.difference(video)
    assert "their versions of plica" in fast.difference(replace(fast, probe=video.probe))
    assert fast.probe[20, 5, 0] < -1  # the left fold goes to the left, the right one by a fifth less
    assert 0.7 < fast.probe[20, 34, 0] / -fast.probe[20, 5, 0] < 0.9
