"""A symmetric scene in few coordinates: beside the whole in the same ones, its basis, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica import _engine
from plica.errors import SceneError
from plica.runs.build import basis_of, build_simulation
from plica.scene.mesh.build import build_mesh

REACH = "10 mm"


@pytest.fixture
def voice(phonating: plica.Scene) -> plica.Scene:
    """A larynx of 672 nodes whose folds collide from step 4 on; every step's displacements are stored."""
    larynx = plica.Larynx(larynx="coarse", options=plica.LarynxOptions(size="2 mm", growth=0.6, around=24))
    return phonating.replace({"mesh": larynx, "output.every": 5e-5})


@pytest.fixture
def full_run(voice: plica.Scene, tmp_path: Path) -> plica.Run:
    """Of a whole, whose motion is symmetric to the tolerances."""
    return plica.run(voice, tmp_path / "full", progress=False)


def reduced(run: plica.Run, symmetry: str | None, components: int = 20) -> plica.Scene:
    given = {"full_run": str(run.directory), "components": components, "contact_reach": REACH}
    return run.scene.replace({"symmetry": symmetry, "reduction": given, "contact.tolerance": 1e-9})


@pytest.mark.parametrize("symmetry", ["half", "quarter"])
def test_a_symmetric_voice_is_that_of_the_whole_in_the_same_basis(full_run: plica.Run, symmetry: str) -> None:
    """What contact of two surfaces finds pass by pass, and contact with the plane at once."""
    mesh = build_mesh(full_run.scene.mesh)
    scene = reduced(full_run, symmetry)
    basis = basis_of(scene, mesh)
    part = build_simulation(scene, mesh, basis=basis)
    whole = build_simulation(reduced(full_run, None), mesh, basis=basis)
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


@pytest.mark.parametrize("symmetry", ["half", "quarter"])
def test_a_gap_that_contact_with_the_plane_leaves_open_is_reported(
    full_run: plica.Run, symmetry: str
) -> None:
    """What keeps equal rows solvable, 1e-9 of the compliance, leaves more than a tolerance of 1e-16."""
    mesh = build_mesh(full_run.scene.mesh)
    scene = reduced(full_run, symmetry)
    basis = basis_of(scene, mesh)
    settled = build_simulation(scene, mesh, basis=basis).advance(40)
    left = build_simulation(scene.replace({"contact.tolerance": 1e-16}), mesh, basis=basis).advance(40)
    assert settled["contact_converged"].all()
    assert (left["contact_rows"] > 0).sum() > 3
    converged = left["contact_converged"] != 0
    assert converged[left["contact_gap_error"] == 0].all()
    assert left["contact_gap_error"][~converged].min() > left["contact_gap_error"][converged].max()


def test_vectors_are_the_symmetric_part_of_what_a_full_run_shows(full_run: plica.Run) -> None:
    mesh = build_mesh(full_run.scene.mesh)
    points = np.asarray(mesh.points)
    basis = basis_of(reduced(full_run, "half", 10), mesh).T.reshape(-1, *points.shape)
    image = np.array([np.argmin(((points - p) ** 2).sum(axis=1)) for p in points * (-1, 1, 1)])
    np.testing.assert_array_equal(basis[:, image] * (-1, 1, 1), basis)
    whole = basis_of(reduced(full_run, None, 10), mesh)
    left = (
        whole - basis.reshape(len(basis), -1).T @ np.linalg.lstsq(basis.reshape(len(basis), -1).T, whole)[0]
    )
    assert np.linalg.norm(left) < 0.02 * np.linalg.norm(whole)


def test_a_symmetric_full_run_serves_a_scene_of_its_symmetry_alone(
    voice: plica.Scene, tmp_path: Path
) -> None:
    symmetric = voice.replace({"symmetry": "quarter"})
    run = plica.run(symmetric, tmp_path / "full", progress=False)
    scene = reduced(run, "quarter")
    waves = build_simulation(scene).advance(40)
    full = run["minimum_area"]
    assert np.abs(waves["minimum_area"] - full).max() < 0.01 * full.max()
    with pytest.raises(SceneError, match=r'full_run = .* has symmetry = "quarter"; must have none, like the'):
        build_simulation(reduced(run, None))
    with pytest.raises(SceneError, match=r'has symmetry = "quarter"; must have none or "half"'):
        build_simulation(reduced(run, "half"))


@pytest.mark.parametrize("threads", [1, 2])
def test_it_continues_bit_for_bit_with_any_number_of_threads(full_run: plica.Run, threads: int) -> None:
    scene = reduced(full_run, "quarter")
    mesh = build_mesh(scene.mesh)
    basis = basis_of(scene, mesh)
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
    scene = reduced(full_run, "quarter")
    plica.run(scene.replace({"time.duration": "1 ms"}), tmp_path / "two", progress=False)
    two = plica.run(scene, tmp_path / "two", resume=True, progress=False)
    one = plica.run(scene, tmp_path / "one", progress=False)
    assert two.displacement.shape[1] == len(two.mesh.points)
    np.testing.assert_array_equal(two.displacement, one.displacement)
    np.testing.assert_array_equal(two["flow"], one["flow"])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        (
            {"reduction.full_run": None, "reduction.components": None},
            r"reduction.full_run: must be given with symmetry",
        ),
        ({"reduction.modes": 5}, r"reduction.modes = 5; must be left out with symmetry"),
        ({"reduction.contact_vectors": 5}, r"reduction.contact_vectors = 5; must be left out with symmetry"),
        ({"contact": {"penalty": {}}}, r"with symmetry contact must be by multipliers"),
        ({"contact.friction": 0.3}, r"contact.friction must be left out"),
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
        build_simulation(reduced(full_run, "quarter").replace(changes))
