"""`python -m benchmarks extremes`: no probe ends in a forbidden way, and a forbidden end is seen."""

from __future__ import annotations

import csv
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array

import plica
from benchmarks.__main__ import main
from benchmarks.extremes import broken, endurance, larynxes, solids, voices
from benchmarks.extremes import worker as worker_module
from benchmarks.extremes.good_files import scene_file
from benchmarks.extremes.probe import Found, Probe, Verdict, Wrong, run_probe
from benchmarks.extremes.worker import PROBES, _Worker, verdicts
from benchmarks.harness.study import RECORDS, Study
from plica import _engine as engine
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.changed import changed_mesh
from plica.verify.bodies.body import Body
from plica.video.errors import VideoError
from plica.video.files.sources import open_source


def raised(error: BaseException) -> Found:
    raise error


@pytest.mark.slow
def test_no_small_probe_ends_in_a_forbidden_way(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "extremes.csv"
    assert main(["extremes", "--size", "small", "--quiet", "-o", str(path)]) == 0
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
    assert run_probe(find).word == word  # type: ignore[arg-type]


def test_a_ratio_that_is_no_number_is_forbidden_wherever_it_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Folds that are shut for good: no jet to hold the flow against, while ledger and forces are in order."""
    waves, message = larynxes.ran(larynxes.larynx({"time.duration": 2 * larynxes.STEP}))
    shut = waves | {"minimum_area": 0 * waves["minimum_area"], "flow": 0 * waves["flow"]}
    assert run_probe(voices.conserved).word == "right"
    monkeypatch.setattr(voices, "ran", lambda scene: (shut, message))
    with np.errstate(invalid="ignore"):
        assert run_probe(voices.conserved).word == "NaN"
    lost = waves | {"contact_rows": np.nan * waves["contact_rows"]}
    monkeypatch.setattr(voices, "ran", lambda scene: (lost, message))
    assert run_probe(voices.conserved).note == "not finite: contact_rows"


def test_waveforms_are_apart_by_their_largest_difference_over_the_largest_value() -> None:
    one = {"flow": [0.0, 2.2], "minimum_area": [0.0, 0.01]}
    other = {"flow": [1e-3, 2.0], "minimum_area": [0.0, 0.0]}
    assert voices._apart(one, other, ["flow", "minimum_area"]) == pytest.approx(0.1)
    assert np.isnan(voices._apart(one | {"flow": [0.0, np.nan]}, other, ["flow", "minimum_area"]))


def test_another_unit_than_a_waveform_has_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(voices, "_WAVES", voices._WAVES | {"flow": (2, -1, 0)})
    assert run_probe(lambda: voices.units(2.0**-13, 1.0, 1.0)).word == "WRONG"


def test_a_forbidden_verdict_is_printed_and_ends_with_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        worker_module,
        "verdicts",
        lambda probes: [(probe, Verdict("WRONG", "off", 1, 0), 0.1) for probe in probes],
    )
    named = ["extremes", "--quiet", "--only", "layers of one element"]
    assert main(named) == 1
    assert capsys.readouterr().err == "plica: layers of one element: WRONG: off\n"
    assert main([*named[:-1], "no such probe"]) == 2
    assert '--only = "no such probe"' in capsys.readouterr().err


def test_a_motion_that_is_no_number_in_one_layer_is_seen() -> None:
    mesh = solids.layered()
    moved = np.array(mesh.points)
    assert solids._worst(mesh, 1.001 * moved, moved) == pytest.approx(1e-3)
    lost = moved.copy()
    lost[np.argmin(moved[:, 0])] = np.nan
    assert np.isnan(solids._worst(mesh, lost, moved))


def test_random_scenes_that_are_nearly_all_refused_are_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(broken, "build_simulation", lambda scene: raised(plica.InvalidInput("no")))
    verdict = run_probe(lambda: broken.random_scenes(4, 2))
    assert verdict.word == "WRONG"
    assert "4 of 4" in verdict.note


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (lambda path: None, "nothing was tried"),
        (lambda path: refused_at_length(path), "refused in 1000 char"),
    ],
)
def test_files_that_are_never_refused_or_at_length_are_wrong(read: object, message: str) -> None:
    verdict = run_probe(lambda: broken.fuzzed(scene_file, read, 20))  # type: ignore[arg-type]
    assert verdict.word == "WRONG"
    assert message in verdict.note


def refused_at_length(path: Path) -> None:
    """Takes the good file alone."""
    if path.read_text(encoding="utf-8", errors="replace") != broken.SCENE:
        raise plica.InvalidInput("x" * 1000)


def test_a_wave_of_a_broken_file_that_is_no_number_is_wrong(
    bar: plica.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken.stepped(bar)

    class Lost:
        def advance(self, steps: int) -> dict[str, np.ndarray]:
            return {"flow": np.array([0.0] * (steps - 1) + [np.nan])}

    monkeypatch.setattr(broken, "build_simulation", lambda scene: Lost())
    with pytest.raises(Wrong, match="flow is not finite"):
        broken.stepped(bar)


def test_round_off_of_many_steps_is_found_and_small() -> None:
    found = endurance.free_block(400, engine.Cholesky())
    assert 0 < found.error <= found.allowed == pytest.approx(2e-7)
    energy, momentum = (float(part.split()[1]) for part in found.note.split(" after ")[0].split(", "))
    assert found.error == pytest.approx(max(energy, momentum), rel=0.06)  # two digits are noted


def test_momentum_that_is_gained_at_equal_energy_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    class Pushed(engine.Simulation):
        @property
        def velocity(self) -> np.ndarray:
            return np.add(super().velocity, [0, 0, 0.05 if self.time > 0 else 0.0])

    monkeypatch.setattr(engine, "Simulation", Pushed)
    found = endurance.free_block(20, engine.Cholesky())
    assert found.error == pytest.approx(0.5)  # the block's own velocity, along x, is 0.1 m/s
    assert run_probe(lambda: found).word == "WRONG"


def test_a_body_that_flies_drifts_by_what_the_rounding_of_its_stiffness_leaves_of_its_path() -> None:
    """The momentum of a force 1' K v t, v rigid: a bias, which grows with the square of the time."""
    mesh = engine.block_mesh(size=(1e-2,) * 3, divisions=(1, 1, 1))
    x = np.asarray(mesh.points)
    velocity = np.array([0.1, 0.05, 0.07]) + np.cross([3.0, -4.0, 5.0], x)
    simulation = Body(
        mesh, engine.Material(engine.Isotropic(1e4, 0.3), 1000.0), np.zeros(x.shape, bool)
    ).simulation(scheme=engine.Newmark(), step=5e-3, solver_tolerance=1e-12, velocity=velocity)
    K, M = (
        csr_array(matrix, shape=(x.size, x.size)).toarray()
        for matrix in (simulation.stiffness, simulation.mass)
    )
    force = (K.astype(np.longdouble) @ velocity.ravel().astype(np.longdouble)).reshape(-1, 3).sum(axis=0)
    found = []
    for _ in range(2):
        simulation.advance(4000)
        gained = (M @ (np.asarray(simulation.velocity) - velocity).ravel()).reshape(-1, 3).sum(axis=0)
        expected = -force.astype(float) * simulation.time**2 / 2
        # The products of the steps are rounded besides, up or down: a walk, of less than 10 % of the bias.
        assert np.abs(gained - expected).max() < 0.25 * np.abs(expected).max()
        found.append(gained.sum())
    assert found[1] / found[0] == pytest.approx(4, rel=0.25)


@pytest.mark.slow
def test_a_probe_after_one_that_hangs_has_a_process_of_its_own() -> None:
    fine = next(probe for probe in PROBES if probe.name == "layers of one element")
    slow = Probe("1e6 steps", "none", lambda: Found(0, 0), limit=0.05)
    found = list(verdicts([slow, fine]))
    assert [verdict.word for _, verdict, _ in found] == ["HANG", "right"]
    assert found[0][2] >= 0.05


def test_a_probe_that_hangs_or_ends_its_process_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    worker = _Worker()
    slow = Probe("1e6 steps", "none", lambda: Found(0, 0), limit=0.05)
    assert worker.judge(slow).word == "HANG"
    assert not worker.alive
    worker = _Worker()
    worker._process.kill()
    worker._process.join()
    assert worker.judge(slow).word == "CRASH"
    assert worker._pipe.closed


def test_the_record_has_every_probe_and_none_that_is_not() -> None:
    rows = Study.read(RECORDS / "extremes.json").rows
    assert [row[1] for row in rows] == [probe.name for probe in PROBES]
    assert len({probe.name for probe in PROBES}) == len(PROBES)  # a worker finds them by name
    assert {row[3] for row in rows} <= {"right", "said", "refused"}


def far(mesh: engine.TetMesh, by: float) -> engine.TetMesh:
    return changed_mesh(mesh, points=np.asarray(mesh.points) + by)


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
    rough, message = larynxes.ran(larynxes.larynx(long_step))
    assert "unconverged_coupling" in message
    fine, message = larynxes.ran(larynxes.larynx({"airflow.coupling": coupling}))
    assert "unconverged_coupling" not in message
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
