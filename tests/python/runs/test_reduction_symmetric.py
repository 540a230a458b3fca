"""A symmetric scene in few coordinates: beside the whole in the same ones, its basis, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

import plica
from plica import _engine
from plica.errors import SceneError
from plica.runs.build import build_simulation, fixed_components
from plica.runs.reduce import basis_of
from plica.scene.mesh.build import build_mesh
from plica.scene.symmetry import mirrored_mean


@pytest.fixture
def voice(phonating: plica.Scene) -> plica.Scene:
    """A larynx of 672 nodes whose folds collide from step 4 on; every step's displacements are stored."""
    larynx = plica.Larynx(larynx="coarse", options=plica.LarynxOptions(size="2 mm", growth=0.6, around=24))
    return phonating.replace({"mesh": larynx, "output.every": 5e-5})


@pytest.fixture
def full_run(voice: plica.Scene, tmp_path: Path) -> plica.Run:
    """Of a whole, whose motion is symmetric to the tolerances."""
    return plica.run(voice, tmp_path / "full", progress=False)


def of(run: plica.Run, symmetry: str | None) -> plica.Scene:
    return run.scene.replace({"symmetry": symmetry, "contact.tolerance": 1e-9})


def vectors(run: plica.Run, symmetry: str | None, components: int = 20) -> np.ndarray:
    scene = of(run, symmetry)
    return basis_of(scene, build_mesh(scene.mesh), run, components=components)


@pytest.mark.parametrize("symmetry", ["half", "quarter"])
def test_a_symmetric_voice_is_that_of_the_whole_in_the_same_basis(full_run: plica.Run, symmetry: str) -> None:
    """What contact of two surfaces finds pass by pass, and contact with the plane at once."""
    mesh = build_mesh(full_run.scene.mesh)
    scene = of(full_run, symmetry)
    basis = vectors(full_run, symmetry)
    part = build_simulation(scene, mesh, basis=basis)
    whole = build_simulation(of(full_run, None), mesh, basis=basis)
    found, expected = part.advance(40), whole.advance(40)
    assert (expected["contact_rows"] > 0).sum() > 3
    np.testing.assert_array_equal(found["contact_rows"] > 0, expected["contact_rows"] > 0)
    for name in (
        "flow",
        "minimum_area",
        "section_area",
        "section_pressure",
        "coronal_left",
        "coronal_right",
        "kinetic_energy",
        "elastic_energy",
        "contact_force_first",
        "contact_force_second",
        "contact_area",
        "contact_length",
        "largest_contact_pressure",
        "strain_largest",
    ):
        largest = np.abs(expected[name]).max()
        assert largest > 0, name
        assert np.abs(found[name] - expected[name]).max() < 2e-5 * largest, name
    u, v = np.asarray(whole.displacement), np.asarray(part.displacement)
    assert np.abs(u - v).max() < 1e-7 * np.abs(u).max()
    energy = (found["kinetic_energy"] + found["elastic_energy"]).max()
    assert np.abs(found["energy_balance_error"]).max() < 1e-10 * energy


def test_vectors_are_the_symmetric_part_of_what_a_full_run_shows(full_run: plica.Run) -> None:
    mesh = build_mesh(full_run.scene.mesh)
    points = np.asarray(mesh.points)
    basis = vectors(full_run, "half", 10).T.reshape(-1, *points.shape)
    image = np.array([np.argmin(((points - p) ** 2).sum(axis=1)) for p in points * (-1, 1, 1)])
    np.testing.assert_array_equal(basis[:, image] * (-1, 1, 1), basis)
    whole = vectors(full_run, None, 10)
    left = (
        whole - basis.reshape(len(basis), -1).T @ np.linalg.lstsq(basis.reshape(len(basis), -1).T, whole)[0]
    )
    assert np.linalg.norm(left) < 0.02 * np.linalg.norm(whole)


def test_a_symmetric_full_run_serves_a_scene_of_its_symmetry_alone(
    voice: plica.Scene, tmp_path: Path
) -> None:
    symmetric = voice.replace({"symmetry": "quarter"})
    run = plica.run(symmetric, tmp_path / "full", progress=False)
    waves = build_simulation(of(run, "quarter"), basis=vectors(run, "quarter")).advance(40)
    full = run["minimum_area"]
    assert np.abs(waves["minimum_area"] - full).max() < 0.01 * full.max()
    with pytest.raises(plica.InvalidInput, match=r'has symmetry = "quarter"; must have none, like the'):
        vectors(run, None)
    with pytest.raises(plica.InvalidInput, match=r'has symmetry = "quarter"; must have none or "half"'):
        vectors(run, "half")


@pytest.mark.parametrize("threads", [1, 2])
def test_it_continues_bit_for_bit_with_any_number_of_threads(full_run: plica.Run, threads: int) -> None:
    scene = of(full_run, "quarter")
    mesh = build_mesh(scene.mesh)
    basis = vectors(full_run, "quarter")
    waves = build_simulation(scene, mesh, basis=basis).advance(40)
    before = _engine.threads()
    _engine.set_threads(threads)
    try:
        first, second = (build_simulation(scene, mesh, basis=basis) for _ in range(2))
        first.advance(6)
        second.restore(first.state())
        rest = second.advance(34)
    finally:
        _engine.set_threads(before)
    assert waves["contact_rows"][6:].max() > 0
    for name, values in rest.items():
        np.testing.assert_array_equal(values, waves[name][6:], err_msg=name)


def test_a_run_stores_all_nodes_and_continues(full_run: plica.Run, tmp_path: Path) -> None:
    scene = of(full_run, "quarter")
    plica.reduce(full_run, tmp_path / "basis.h5", scene=scene, components=20)
    scene = scene.replace({"reduction": {"basis": str(tmp_path / "basis.h5")}})
    plica.run(scene.replace({"time.duration": "1 ms"}), tmp_path / "two", progress=False)
    two = plica.run(scene, tmp_path / "two", resume=True, progress=False)
    one = plica.run(scene, tmp_path / "one", progress=False)
    assert two.displacement.shape[1] == len(two.mesh.points)
    np.testing.assert_array_equal(two.displacement, one.displacement)
    np.testing.assert_array_equal(two["flow"], one["flow"])


@pytest.mark.parametrize("symmetry", ["half", "quarter"])
def test_symmetric_modes_and_contact_vectors_are_those_of_the_part(voice: plica.Scene, symmetry: str) -> None:
    """All symmetric modes of a dense eigenproblem, and a basis of all that is symmetric gives its motion."""
    from scipy.linalg import eigh

    scene = voice.replace({"symmetry": symmetry})
    mesh = build_mesh(scene.mesh)
    part = build_simulation(scene, mesh)
    free = ~fixed_components(scene, mesh).ravel()
    K, M = (
        csr_array(values, shape=2 * (free.size,))[free][:, free].toarray()
        for values in (part.stiffness, part.mass)
    )
    squares, shapes = eigh(K, M)
    points = np.asarray(mesh.points)
    fields = np.zeros((len(squares), free.size))
    fields[:, free] = shapes.T
    own = mirrored_mean(fields.reshape(-1, *points.shape), points, {"half": 1, "quarter": 2}[symmetry])
    share = np.linalg.norm(own.reshape(len(own), -1), axis=1) / np.linalg.norm(fields, axis=1)
    found = basis_of(scene.replace({"airflow": None}), mesh, modes=6, contact_vectors=0)[free]
    of_found = np.einsum("ij,ij->j", found, K @ found) / np.einsum("ij,ij->j", found, M @ found)
    np.testing.assert_allclose(of_found, squares[share > 0.99][:6], rtol=1e-6)
    full = build_simulation(scene, mesh).advance(40)["minimum_area"]
    errors = []
    for modes, contact in ((20, 10), (120, 60)):
        basis = basis_of(scene, mesh, modes=modes, contact_vectors=contact, contact_reach=10e-3)
        waves = build_simulation(scene, mesh, basis=basis).advance(40)
        errors.append(np.abs(waves["minimum_area"] - full).max() / full.max())
    assert errors[1] < min(0.06, 0.5 * errors[0])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"contact": {"penalty": {}}}, r"with symmetry contact must be by multipliers"),
        (
            {"contact.surface_mass": "redistributed"},
            r'contact.surface_mass = "redistributed"; must be "kept"',
        ),
    ],
)
def test_what_a_symmetric_reduction_cannot_have_is_refused(
    full_run: plica.Run, changes: dict[str, Any], text: str
) -> None:
    with pytest.raises(SceneError, match=text):
        build_simulation(of(full_run, "quarter").replace(changes), basis=vectors(full_run, "quarter"))
