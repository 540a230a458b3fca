"""`plica bench extremes`: no probe ends in a forbidden way, and a forbidden end is seen."""

from __future__ import annotations

import csv
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import plica
from plica import _engine as engine
from plica.bench.extremes import broken, larynxes, solids, voices
from plica.bench.extremes.apart import _Worker
from plica.bench.extremes.catalogue import PROBES, SUBJECTS
from plica.bench.extremes.probe import Found, Probe, Wrong, judged
from plica.cli import main
from plica.phonation.run.build import build_simulation
from plica.phonation.scene.mesh_source import build_mesh
from plica.video.errors import VideoError
from plica.video.sources import open_source

ROOT = Path(__file__).resolve().parents[2]
SUBJECTS_OF_ROWS = tuple(f"| {subject} |" for subject in SUBJECTS)


def raised(error: BaseException) -> Found:
    raise error


@pytest.mark.slow
def test_no_small_probe_ends_in_a_forbidden_way(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "extremes.csv"
    assert main(["bench", "extremes", "--size", "small", "--quiet", "-o", str(path)]) == 0
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(probe.small for probe in PROBES) > 15
    assert {row["verdict"] for row in rows} == {"right", "said", "refused"}
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("find", "word"),
    [
        (lambda: Found(1e-6, 1e-5), "right"),
        (lambda: Found(1e-4, 1e-5, ("time_step",)), "said"),
        (lambda: Found(1e-4, 1e-5), "WRONG"),
        (lambda: Found(np.nan, 1e-5, ("time_step",)), "NaN"),
        (lambda: raised(plica.InvalidInput("Load: traction = nan Pa; must be finite.")), "refused"),
        (lambda: raised(plica.SolveFailed("Step 3: no solution.")), "refused"),
        (lambda: raised(plica.InvalidInput("x" * 1000)), "WRONG"),
        (lambda: plica.Scene.model_validate({"x" * 1000: 0}), "WRONG"),
        (lambda: raised(Wrong("flow is not finite")), "WRONG"),
        (lambda: raised(KeyError("flow")), "CRASH"),
        (lambda: Found(float(plica.Airflow(subglottal_pressure=0).air_density), 0.0), "refused"),
    ],
)
def test_a_verdict_tells_what_is_forbidden_from_what_is_not(find: object, word: str) -> None:
    assert judged(find).word == word  # type: ignore[arg-type]


def test_a_ratio_that_is_no_number_is_forbidden_wherever_it_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Folds that are shut for good: no jet to hold the flow against, while ledger and forces are in order."""
    waves, said = larynxes.ran(larynxes.larynx({"time.duration": 2 * larynxes.STEP}))
    shut = waves | {"minimum_area": 0 * waves["minimum_area"], "flow": 0 * waves["flow"]}
    assert judged(voices.conserved).word == "right"
    monkeypatch.setattr(voices, "ran", lambda scene: (shut, said))
    with np.errstate(invalid="ignore"):
        assert judged(voices.conserved).word == "NaN"


def test_a_motion_that_is_no_number_in_one_layer_is_seen() -> None:
    mesh = solids.layered()
    moved = np.array(mesh.points)
    assert solids._worst(mesh, 1.001 * moved, moved) == pytest.approx(1e-3)
    lost = moved.copy()
    lost[np.argmin(moved[:, 0])] = np.nan
    assert np.isnan(solids._worst(mesh, lost, moved))


def test_random_scenes_that_are_nearly_all_refused_are_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(broken, "build_simulation", lambda scene: raised(plica.InvalidInput("no")))
    verdict = judged(lambda: broken.random_scenes(4, 2))
    assert verdict.word == "WRONG"
    assert "4 of 4" in verdict.note


def test_a_probe_that_hangs_or_ends_its_process_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _Worker()
    slow = Probe("1e6 steps", "none", lambda: Found(0, 0), limit=0.05)
    assert worker.judge(slow).word == "HANG"
    assert not worker.alive
    worker = _Worker()
    worker._process.kill()
    worker._process.join()
    assert worker.judge(slow).word == "CRASH"
    assert worker._pipe.closed


def test_the_page_has_every_probe_and_none_that_is_not() -> None:
    page = (ROOT / "docs" / "extremes.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith(SUBJECTS_OF_ROWS)]
    assert [row[1] for row in rows] == [probe.name for probe in PROBES]
    assert len({probe.name for probe in PROBES}) == len(PROBES)  # a worker finds them by name
    assert {row[3] for row in rows} <= {"right", "said", "refused"}


def far(mesh: engine.TetMesh, by: float) -> engine.TetMesh:
    return larynxes.placed(mesh, np.asarray(mesh.points) + by)


def test_sections_of_a_larynx_far_away_are_where_they_are_at_the_origin() -> None:
    scene = larynxes.larynx()
    mesh, place = build_mesh(scene.mesh), 1e5
    near, away = (build_simulation(scene, one) for one in (mesh, far(mesh, place)))
    # coordinates there are 1.5e-11 m apart, heights follow from areas of 1e-6 m^2
    np.testing.assert_allclose(np.asarray(away.section_height) - place, near.section_height, atol=1e-7)
    assert np.ptp(near.section_height) > 0.01


@pytest.mark.parametrize("coupling", ["lagged", "extrapolated"])
def test_a_coupling_without_sweeps_says_by_how_much_its_pressures_are_off(coupling: str) -> None:
    long_step = {"airflow.coupling": coupling, "time.step": 1e-3, "time.duration": 8e-3}
    rough, said = larynxes.ran(larynxes.larynx(long_step))
    assert "unconverged_coupling" in said
    fine, said = larynxes.ran(larynxes.larynx({"airflow.coupling": coupling}))
    assert "unconverged_coupling" not in said
    assert np.isfinite(rough["coupling_residual"]).all()
    assert rough["coupling_residual"].max() > 10 * np.median(fine["coupling_residual"]) > 0


def test_a_damaged_hdf5_recording_is_a_video_error(tmp_path: Path) -> None:
    import h5py

    path = tmp_path / "frames.h5"
    with h5py.File(path, "w") as file:
        file["frames"] = np.zeros((4, 32, 48), np.uint8)
    data = bytearray(path.read_bytes())
    rng = np.random.default_rng(3)
    refused = 0
    for _ in range(40):
        at = int(rng.integers(0, 2000))
        path.write_bytes(data[:at] + bytes(rng.integers(0, 256, 8, dtype=np.uint8)) + data[at + 8 :])
        with suppress(VideoError):
            source = open_source(path)
            for _, pixels in source.pixels(0, source.count):
                assert pixels.shape == (32, 48)
            continue
        refused += 1
    assert refused > 3


def test_a_worker_answers_by_name() -> None:
    worker = _Worker()
    assert (
        worker.judge(next(probe for probe in PROBES if probe.name == "layers of one element")).word == "right"
    )
    worker.end()
