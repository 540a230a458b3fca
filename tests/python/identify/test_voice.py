"""A voice that its own airflow drives, filmed and identified: its intervals are refused, and have to be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from flow_files import SETTINGS, block_scene, flow_file
from plica.identify import Settings, identify, load
from plica.identify.estimator.posterior import GAUSSIAN_FALL
from plica.identify.model.pressures import fed_back
from plica.identify.report.page import rows
from stored_files import add_noise

FRAME, NOISE = 250e-6, 0.05  # s, px
CAMERA = plica.Camera(mm_per_px=0.1, width=96, height=144)
CHOSEN: dict[str, Any] = {
    "parameters": (
        {"targets": ("cover.viscosity", "ligament.viscosity", "body.viscosity"), "name": "viscosity"},
    ),
    "coarser": "none",
    "sd": NOISE,
    "spacing": 12,
    "lead": 8e-3,
}


def _voice() -> plica.Scene:
    """Linear elements: a minute part of the work, and a voice all the same."""
    return plica.Scene(
        plica.Larynx(larynx="coarse"),
        "thesis_corrected",
        airflow=plica.Airflow(subglottal_pressure="0.6 kPa"),
        initial=plica.Initial(opening_velocity="1 m/s"),
        time=plica.Stepping(step="50 us", duration="38 ms"),
        output=plica.Output(every=FRAME, start=30e-3),
    )


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("voice")
    run = plica.run(_voice(), where / "run", progress=False)
    plica.write_film(plica.film(run, CAMERA), where / "clip.npy")
    add_noise(where / "clip.truth.h5", NOISE, np.random.default_rng(1))
    return where / "clip.truth.h5"


@pytest.mark.slow
def test_intervals_of_a_voice_are_refused_because_they_would_not_hold_the_truth(filmed: Path) -> None:
    """The guess is the truth: what the estimate moves is its error."""
    scene = _voice().replace({"initial": None, "output": plica.Output()})
    found = identify(filmed, scene, filmed.parent / "tissue", Settings(**CHOSEN), progress=False)
    posterior = found.posterior
    assert found.picture.explained > 0.8
    assert posterior.fed_back
    assert not posterior.answered
    assert posterior.refused.all()
    assert "the motion generates them" in found.warnings[0]
    assert "refused" in found.table
    # what would have been said: a tight interval, far off
    assert posterior.sd[0] < 0.3
    assert abs(posterior.mean[0] - posterior.prior_mean[0]) > 4 * posterior.sd[0]
    assert load(filmed.parent / "tissue").posterior.fed_back


def test_a_voice_is_a_scene_with_airflow_or_a_larynx_of_unknown_pressures() -> None:
    block = block_scene()
    larynx = plica.Scene(plica.Larynx(larynx="coarse"), "thesis_corrected", time=block.time)
    breathing = block.replace({"airflow": {}})
    known = Settings(drive=Path("drive.csv"))
    assert [fed_back(Settings(), scene) for scene in (larynx, block, breathing)] == [True, False, True]
    assert [fed_back(known, scene) for scene in (larynx, block, breathing)] == [False, False, True]
    assert not fed_back(Settings(voiced=False), breathing)
    assert fed_back(Settings(voiced=True), block)


@pytest.mark.slow
def test_who_says_that_a_block_is_voiced_gets_no_interval(tmp_path: Path) -> None:
    file = flow_file(tmp_path / "flow.h5")
    found = {
        voiced: identify(
            file, block_scene(), tmp_path / str(voiced), Settings(**SETTINGS, voiced=voiced), progress=False
        )
        for voiced in (True, False)
    }
    assert np.array_equal(found[True].posterior.mean, found[False].posterior.mean)
    assert "motion generates its own pressures" in found[True].table
    assert "motion generates its own pressures" in rows(found[True])[0].verdict
    assert "the motion generates them" in found[True].warnings[0]
    assert not any("phonation" in text for text in found[False].warnings)
    sure = {"follows": 1.0, "mesh_shift": None, "inflation": np.ones(1), "falls": np.full(2, GAUSSIAN_FALL)}
    assert [replace(one.posterior, **sure).answered for one in found.values()] == [False, True]
    assert [replace(one.posterior, **sure).refused.any() for one in found.values()] == [True, False]
    assert load(tmp_path / "True").posterior.fed_back
    assert not load(tmp_path / "False").posterior.fed_back
    csv = (tmp_path / "True" / "posterior.csv").read_text().splitlines()
    assert csv[1].split(",")[3:6] == ["", "", ""]
