"""A basis from the motion of a full run: what is taken, shared and refused."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.sparse import csr_array

import plica
from plica.runs import store
from plica.runs.basis import PRESSURE_VECTORS
from plica.runs.basis_file import BASIS
from plica.runs.build import build_simulation
from plica.runs.reduce import basis_of
from plica.scene.mesh.build import build_mesh
from stored_files import set_status


@pytest.fixture
def full_run(phonating: plica.Scene, tmp_path: Path) -> plica.Run:
    """Every step's displacements stored."""
    return plica.run(phonating.replace({"output.every": 5e-5}), tmp_path / "full", progress=False)


def test_all_components_of_a_full_run_give_its_motion_again(full_run: plica.Run) -> None:
    mesh = build_mesh(full_run.scene.mesh)
    basis = basis_of(full_run.scene, mesh, full_run, components=20)
    frames = np.asarray(full_run.displacement, dtype=float).reshape(len(full_run.displacement), -1).T
    left = frames - basis @ np.linalg.lstsq(basis, frames)[0]
    assert np.linalg.norm(left) < 0.01 * np.linalg.norm(frames)
    full = full_run["minimum_area"]
    assert full_run["contact_rows"].max() > 0
    errors = []
    for components in (3, 35):
        basis = basis_of(full_run.scene, mesh, full_run, components=components)
        waves = build_simulation(full_run.scene, mesh, basis=basis).advance(40)
        errors.append(np.abs(waves["minimum_area"] - full).max() / full.max())
        assert np.abs(waves["energy_balance_error"]).max() < 1e-10 * waves["elastic_energy"].max()
    assert errors[1] < min(0.005, 0.2 * errors[0])


def test_components_are_those_that_hold_most_elastic_energy(full_run: plica.Run) -> None:
    """Of all frames as much as the largest eigenvalues of F' K F."""
    mesh = build_mesh(full_run.scene.mesh)
    taken = basis_of(full_run.scene, mesh, full_run, components=7)[:, :7]
    K = csr_array(build_simulation(full_run.scene, mesh).stiffness, shape=2 * (len(taken),))
    frames = np.asarray(full_run.displacement, dtype=float).reshape(len(full_run.displacement), -1).T
    shared = taken.T @ (K @ frames)
    held = np.sum(shared * np.linalg.solve(taken.T @ (K @ taken), shared))
    assert held == pytest.approx(np.linalg.eigvalsh(frames.T @ (K @ frames))[-7:].sum(), rel=1e-7)


def test_components_come_without_modes_and_contact_vectors_unless_asked_for(full_run: plica.Run) -> None:
    mesh, scene = build_mesh(full_run.scene.mesh), full_run.scene
    assert basis_of(scene, mesh, full_run, components=7).shape[1] == 7 + PRESSURE_VECTORS
    more = basis_of(scene, mesh, full_run, components=7, modes=3, contact_vectors=5, contact_reach=10e-3)
    assert more.shape[1] == 7 + 3 + PRESSURE_VECTORS + 5


def test_components_left_out_are_as_many_as_a_short_run_has_frames(full_run: plica.Run) -> None:
    mesh, scene = build_mesh(full_run.scene.mesh), full_run.scene
    frames = len(full_run.displacement)
    assert frames < 60
    left_out = basis_of(scene, mesh, full_run)
    assert left_out.shape[1] == frames + PRESSURE_VECTORS
    np.testing.assert_array_equal(left_out, basis_of(scene, mesh, full_run, components=frames))


def test_one_file_serves_voices_of_other_pressure_step_and_tissue(
    full_run: plica.Run, tmp_path: Path
) -> None:
    file = tmp_path / "basis.h5"
    assert plica.reduce(full_run.directory, file, components=10) == 10 + PRESSURE_VECTORS
    voice = full_run.scene.replace({"reduction": {"basis": str(file)}, "time.duration": "0.5 ms"})
    kept = []
    for name, changes in (
        ("same", {}),
        ("louder", {"airflow.subglottal_pressure": "0.9 kPa", "time.step": "25 us", "initial": None}),
        ("stiffer", {"tissue.cover.E": 1.1 * full_run.scene.tissue["cover"].E}),
    ):
        run = plica.run(voice.replace(changes), tmp_path / name, progress=False)
        assert np.abs(run.displacement[-1]).max() > 0
        with h5py.File(run.directory / BASIS, "r") as stored:
            kept.append(stored["basis"][()])
    assert np.array_equal(kept[0], kept[1])
    assert np.array_equal(kept[0], kept[2])
    file.unlink()
    again = plica.run(
        voice.replace({"time.duration": "1 ms"}), tmp_path / "same", resume=True, progress=False
    )
    assert again.steps == 20


@pytest.mark.parametrize(
    ("changes", "asked", "text"),
    [
        ({}, {"components": 500}, r"components = 500; must be in \[1, "),
        ({"mesh.options.around": 12}, {}, "full is on another mesh"),
        ({"supports.components": {"wall": "xy"}, "supports.fixed": []}, {}, "full has other fixed nodes"),
    ],
)
def test_a_full_run_that_does_not_fit_is_refused(
    full_run: plica.Run, tmp_path: Path, changes: dict[str, object], asked: dict[str, int], text: str
) -> None:
    with pytest.raises(plica.InvalidInput, match=text):
        plica.reduce(full_run, tmp_path / "basis.h5", scene=full_run.scene.replace(changes), **asked)
    with pytest.raises(plica.InvalidInput, match="nowhere: there is no such directory"):
        plica.reduce(tmp_path / "nowhere", tmp_path / "basis.h5")


def test_vectors_are_not_taken_from_a_reduced_run_or_one_without_fields(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    short = phonating.replace({"time.duration": "0.2 ms"})
    bare = plica.run(short.replace({"output.every": None}), tmp_path / "bare", progress=False)
    with pytest.raises(plica.InvalidInput, match="has no stored displacements"):
        plica.reduce(bare, tmp_path / "basis.h5")
    stopped = plica.run(short, tmp_path / "stopped", progress=False)
    set_status(stopped.path, store.INTERRUPTED)
    with pytest.raises(plica.InvalidInput, match="is interrupted after 4 of 4 steps; must be finished"):
        plica.reduce(stopped.directory, tmp_path / "basis.h5")
    plica.reduce(short, tmp_path / "basis.h5", modes=10, contact_vectors=5, contact_reach="10 mm")
    scene = short.replace({"reduction": {"basis": str(tmp_path / "basis.h5")}})
    other = plica.run(scene, tmp_path / "reduced", progress=False)
    with pytest.raises(plica.InvalidInput, match="is itself reduced"):
        plica.reduce(other, tmp_path / "other.h5")
