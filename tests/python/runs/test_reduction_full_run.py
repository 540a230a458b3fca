"""A basis from the motion of a full run: what is taken, kept, renewed and refused."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array

import plica
from plica.errors import SceneError
from plica.runs import store
from plica.runs.basis import PRESSURE_VECTORS
from plica.runs.basis_file import BASIS, kept_basis
from plica.runs.build import basis_of, build_simulation
from plica.runs.full_run import motion_digest
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.changed import changed_mesh
from stored_files import rewrite_row, rewrite_text, set_status

REACH = "10 mm"


@pytest.fixture
def full_run(phonating: plica.Scene, tmp_path: Path) -> plica.Run:
    """Every step's displacements stored."""
    return plica.run(phonating.replace({"output.every": 5e-5}), tmp_path / "full", progress=False)


def taken_from(run: plica.Run, components: int) -> plica.Scene:
    given = {"full_run": str(run.directory), "components": components, "contact_reach": REACH}
    return run.scene.replace({"reduction": given})


def test_all_components_of_a_full_run_give_its_motion_again(full_run: plica.Run) -> None:
    mesh = build_mesh(full_run.scene.mesh)
    basis = basis_of(taken_from(full_run, 20), mesh)
    frames = np.asarray(full_run.displacement, dtype=float).reshape(len(full_run.displacement), -1).T
    left = frames - basis @ np.linalg.lstsq(basis, frames)[0]
    assert np.linalg.norm(left) < 0.01 * np.linalg.norm(frames)
    full = full_run["minimum_area"]
    assert full_run["contact_rows"].max() > 0
    errors = []
    for components in (3, 35):
        waves = build_simulation(taken_from(full_run, components), mesh).advance(40)
        errors.append(np.abs(waves["minimum_area"] - full).max() / full.max())
        assert np.abs(waves["energy_balance_error"]).max() < 1e-10 * waves["elastic_energy"].max()
    assert errors[1] < min(0.005, 0.2 * errors[0])


def test_components_are_those_that_hold_most_elastic_energy(full_run: plica.Run) -> None:
    """Of all frames as much as the largest eigenvalues of F' K F."""
    mesh = build_mesh(full_run.scene.mesh)
    taken = basis_of(taken_from(full_run, 7), mesh)[:, :7]
    K = csr_array(build_simulation(full_run.scene, mesh).stiffness, shape=2 * (len(taken),))
    frames = np.asarray(full_run.displacement, dtype=float).reshape(len(full_run.displacement), -1).T
    shared = taken.T @ (K @ frames)
    held = np.sum(shared * np.linalg.solve(taken.T @ (K @ taken), shared))
    assert held == pytest.approx(np.linalg.eigvalsh(frames.T @ (K @ frames))[-7:].sum(), rel=1e-7)


def test_components_come_without_modes_and_contact_vectors_unless_asked_for(full_run: plica.Run) -> None:
    mesh = build_mesh(full_run.scene.mesh)
    scene = taken_from(full_run, 7)
    assert basis_of(scene, mesh).shape[1] == 7 + PRESSURE_VECTORS
    more = scene.replace({"reduction.modes": 3, "reduction.contact_vectors": 5})
    assert basis_of(more, mesh).shape[1] == 7 + 3 + PRESSURE_VECTORS + 5


def test_components_left_out_are_as_many_as_a_short_run_has_frames(full_run: plica.Run) -> None:
    mesh = build_mesh(full_run.scene.mesh)
    frames = len(full_run.displacement)
    assert frames < 60
    scene = taken_from(full_run, 1)
    left_out = basis_of(scene.replace({"reduction.components": None}), mesh)
    assert left_out.shape[1] == frames + PRESSURE_VECTORS
    np.testing.assert_array_equal(left_out, basis_of(taken_from(full_run, frames), mesh))


def test_the_digest_of_a_motion_is_of_every_frame_and_of_the_scene(full_run: plica.Run) -> None:
    digest = motion_digest(full_run.directory)
    assert len(digest) == 64
    kept = full_run.displacement[20]
    assert np.abs(kept).max() > 0
    rewrite_row(full_run.path, "fields/displacement", 20, 1.001 * kept)
    assert motion_digest(full_run.directory) != digest
    rewrite_row(full_run.path, "fields/displacement", 20, kept)
    assert motion_digest(full_run.directory) == digest
    softer = full_run.scene.replace({"airflow.subglottal_pressure": "0.7 kPa"})
    rewrite_text(full_run.path, "scene", softer.text())
    assert motion_digest(full_run.directory) != digest
    assert motion_digest(full_run.directory.parent / "nowhere") == ""


def test_a_basis_is_recomputed_where_its_full_run_has_changed(full_run: plica.Run, tmp_path: Path) -> None:
    scene = taken_from(full_run, 10)
    mesh = build_mesh(scene.mesh)
    kept = kept_basis(tmp_path, scene, mesh)
    assert np.array_equal(kept_basis(tmp_path, scene, mesh), kept)
    longer = full_run.scene.replace({"time.duration": "2.5 ms"})
    plica.run(longer, full_run.directory, resume=True, progress=False)
    assert np.array_equal(kept_basis(tmp_path, scene, mesh, resumed=True), kept)
    assert not np.array_equal(kept_basis(tmp_path, scene, mesh), kept)


def test_the_basis_of_one_voice_is_read_for_another_of_the_same_tissue(
    full_run: plica.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = taken_from(full_run, 10)
    mesh = build_mesh(scene.mesh)
    for name in ("first", "second", "third"):
        (tmp_path / name).mkdir()
    kept = kept_basis(tmp_path / "first", scene, mesh)
    monkeypatch.setattr("plica.runs.basis_file.basis_of", lambda *_: pytest.fail("computed"))
    louder = scene.replace({"airflow.subglottal_pressure": "0.9 kPa", "time.step": "25 us", "initial": None})
    assert np.array_equal(kept_basis(tmp_path / "second", louder, mesh), kept)
    assert np.array_equal(kept_basis(tmp_path / "second", louder, mesh, resumed=True), kept)
    for changes in ({"tissue.cover.E": 500.0}, {"reduction.components": 9}):
        with pytest.raises(pytest.fail.Exception, match="computed"):
            kept_basis(tmp_path / "third", scene.replace(changes), mesh)


def test_voices_that_begin_at_once_share_a_basis(full_run: plica.Run, tmp_path: Path) -> None:
    scene = taken_from(full_run, 10)
    mesh = build_mesh(scene.mesh)
    expected = basis_of(scene, mesh)

    def kept(name: str) -> NDArray[np.float64]:
        (tmp_path / name).mkdir()
        (full_run.directory / BASIS).unlink(missing_ok=True)  # as if no other had begun yet
        return kept_basis(tmp_path / name, scene, mesh)

    with ThreadPoolExecutor(8) as pool:
        for found in pool.map(kept, map(str, range(24))):
            assert np.array_equal(found, expected)
    assert [path.name for path in full_run.directory.glob("*basis*")] == [BASIS]
    assert not list(full_run.directory.glob("tmp*"))


def test_a_basis_of_other_names_or_another_version_is_not_taken(
    full_run: plica.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = taken_from(full_run, 10)
    mesh = build_mesh(scene.mesh)
    kept_basis(tmp_path, scene, mesh)
    monkeypatch.setattr("plica.runs.basis_file.basis_of", lambda *_: pytest.fail("computed"))
    kept_basis(tmp_path, scene, mesh)
    names = list(mesh.layer_names)
    other = changed_mesh(mesh, layer_names=[names[1], names[0], *names[2:]])
    with pytest.raises(pytest.fail.Exception, match="computed"):
        kept_basis(tmp_path, scene, other)
    monkeypatch.setattr("plica.runs.basis_file._version", lambda: "0.0.1")
    kept_basis(tmp_path, scene, mesh, resumed=True)  # of the run itself, whatever wrote it
    with pytest.raises(pytest.fail.Exception, match="computed"):
        kept_basis(tmp_path, scene, mesh)


def test_another_full_run_of_the_same_times_is_another_motion(full_run: plica.Run, tmp_path: Path) -> None:
    scene = taken_from(full_run, 10)
    mesh = build_mesh(scene.mesh)
    kept = kept_basis(tmp_path, scene, mesh)
    before = np.array(full_run.fields["time"])
    shutil.rmtree(full_run.directory)
    softer = full_run.scene.replace({"tissue.cover.E": 500.0})
    other = plica.run(softer, full_run.directory, progress=False)
    assert np.array_equal(other.fields["time"], before)
    assert not np.array_equal(kept_basis(tmp_path, scene, mesh), kept)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"reduction.full_run": None}, r"components = 10; must be left out without full_run"),
        ({"reduction.components": 500}, r"components = 500; must be in \[1, "),
        ({"mesh.options.around": 12}, "full_run = .* is on another mesh"),
        (
            {"supports.components": {"wall": "xy"}, "supports.fixed": []},
            "full_run = .* has other fixed nodes",
        ),
        ({"reduction.full_run": "nowhere"}, "reduction.full_run: .*nowhere: there is no such directory"),
    ],
)
def test_a_full_run_that_does_not_fit_is_refused(
    full_run: plica.Run, changes: dict[str, object], text: str
) -> None:
    with pytest.raises(plica.InvalidInput, match=text):
        build_simulation(taken_from(full_run, 10).replace(changes))


def test_vectors_are_not_taken_from_a_reduced_run_or_one_without_fields(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    short = phonating.replace({"time.duration": "0.2 ms"})
    bare = plica.run(short.replace({"output.every": None}), tmp_path / "bare", progress=False)
    with pytest.raises(SceneError, match="has no stored displacements"):
        build_simulation(taken_from(bare, 2))
    stopped = plica.run(short, tmp_path / "stopped", progress=False)
    set_status(stopped.path, store.INTERRUPTED)
    with pytest.raises(SceneError, match="is interrupted after 4 of 4 steps; must be finished"):
        build_simulation(taken_from(plica.Run.load(stopped.directory), 2))
    other = plica.run(
        short.replace({"reduction": {"modes": 10, "contact_vectors": 5, "contact_reach": REACH}}),
        tmp_path / "reduced",
        progress=False,
    )
    with pytest.raises(SceneError, match="is itself reduced"):
        build_simulation(taken_from(other, 2))
