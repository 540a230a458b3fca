"""A scene in few coordinates: its basis, its run beside the full one, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

import plica
from plica import _engine as engine
from plica.commands.main import main
from plica.runs.basis import PRESSURE_VECTORS, contact_nodes
from plica.runs.basis_file import BASIS
from plica.runs.build import build_simulation, fixed_components
from plica.runs.reduce import basis_of
from plica.scene.mesh.build import build_mesh

REACH = 10e-3


def vectors(scene: plica.Scene, mesh: engine.TetMesh, modes: int, contact: int) -> np.ndarray:
    return basis_of(scene, mesh, modes=modes, contact_vectors=contact, contact_reach=REACH)


def reduced(scene: plica.Scene, modes: int, contact: int, file: Path) -> plica.Scene:
    """In a basis of these vectors, which is stored."""
    plica.reduce(scene, file, modes=modes, contact_vectors=contact, contact_reach=REACH)
    return scene.replace({"reduction": {"basis": str(file), "watch_every": 4}})


def test_modes_are_those_of_a_dense_eigenproblem(bar: plica.Scene) -> None:
    mesh = build_mesh(bar.mesh)
    free = ~fixed_components(bar, mesh).ravel()
    simulation = build_simulation(bar, mesh)
    from scipy.linalg import eigh
    from scipy.sparse import csr_array

    K, M = (
        csr_array(matrix, shape=(free.size, free.size)).toarray()[np.ix_(free, free)]
        for matrix in (simulation.stiffness, simulation.mass)
    )
    expected = eigh(K, M)[0][:6]
    shapes = vectors(bar, mesh, 6, 0)[free]
    squares = np.einsum("ij,ij->j", shapes, K @ shapes) / np.einsum("ij,ij->j", shapes, M @ shapes)
    np.testing.assert_allclose(squares, expected, rtol=1e-6)


def test_the_response_to_any_contact_force_is_in_a_basis_of_all_contact_vectors(
    phonating: plica.Scene,
) -> None:
    mesh = build_mesh(phonating.mesh)
    simulation = build_simulation(phonating, mesh)
    sides = [np.unique(np.asarray(mesh.surfaces[name])) for name in ("airway_left", "airway_right")]
    free = ~fixed_components(phonating, mesh).any(axis=1)
    count = sum(int(free[side].sum()) for side in sides)
    basis = vectors(phonating, mesh, 0, count)
    from scipy.sparse import csr_array

    K = csr_array(simulation.stiffness, shape=(basis.shape[0],) * 2)
    forces = (K @ basis).reshape(len(mesh.points), 3, -1)
    forces[~free] = 0
    inside = np.setdiff1d(np.arange(len(mesh.points)), np.concatenate(sides))
    assert np.abs(forces[np.concatenate(sides)]).max() > 0
    assert np.abs(forces[inside]).max() < 1e-6 * np.abs(forces).max()


def test_more_vectors_come_nearer_to_the_full_motion(phonating: plica.Scene) -> None:
    mesh = build_mesh(phonating.mesh)
    full = build_simulation(phonating, mesh)
    wave = full.advance(40)
    assert wave["contact_rows"].max() > 0
    errors = []
    for modes, contact in ((10, 0), (40, 20), (150, 60)):
        basis = vectors(phonating, mesh, modes, contact)
        waves = build_simulation(phonating, mesh, basis=basis).advance(40)
        errors.append(np.abs(waves["minimum_area"] - wave["minimum_area"]).max() / wave["minimum_area"].max())
        energy = (waves["kinetic_energy"] + waves["elastic_energy"]).max()
        assert np.abs(waves["energy_balance_error"]).max() < 1e-10 * energy
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.02


def test_a_stopped_run_continues_in_its_own_basis(phonating: plica.Scene, tmp_path: Path) -> None:
    scene = reduced(phonating, 20, 10, tmp_path / "basis.h5")
    whole = plica.run(scene, tmp_path / "whole", progress=False)
    short = scene.replace({"time.duration": "1 ms"})
    plica.run(short, tmp_path / "parts", progress=False)
    kept = (tmp_path / "parts" / BASIS).stat().st_mtime_ns
    parts = plica.run(scene, tmp_path / "parts", resume=True, progress=False)
    assert (tmp_path / "parts" / BASIS).stat().st_mtime_ns == kept
    assert set(parts.waveforms) == set(whole.waveforms)
    for name, values in whole.waveforms.items():
        np.testing.assert_array_equal(parts.waveforms[name], values, err_msg=name)
    assert parts.displacement.shape == whole.displacement.shape == (11, len(whole.mesh.points), 3)
    np.testing.assert_array_equal(parts.displacement[-1], whole.displacement[-1])
    assert np.abs(whole.displacement[-1]).max() > 0


def test_a_run_does_not_go_on_in_another_basis(phonating: plica.Scene, tmp_path: Path) -> None:
    scene = reduced(phonating, 20, 10, tmp_path / "basis.h5")
    plica.run(scene.replace({"time.duration": "1 ms"}), tmp_path / "run", progress=False)
    (tmp_path / "run" / BASIS).unlink()
    with pytest.raises(plica.InvalidInput, match=r"basis\.h5: is missing"):
        plica.run(scene, tmp_path / "run", resume=True, progress=False)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"mesh.options.around": 12}, "is a basis of another mesh; must be of the scene's"),
        ({"supports.components": {"wall": "xy"}, "supports.fixed": []}, "is a basis of another supports"),
        ({"symmetry": "half"}, r"is a basis of another symmetry \(none\); must be of the scene's \(half\)"),
        ({"reduction.basis": "nowhere.h5"}, r"nowhere\.h5: is missing; must be .*plica reduce RUN"),
    ],
)
def test_a_basis_of_another_mesh_supports_or_symmetry_is_refused(
    phonating: plica.Scene, tmp_path: Path, changes: dict[str, object], text: str
) -> None:
    scene = reduced(phonating, 4, 2, tmp_path / "basis.h5")
    with pytest.raises(plica.InvalidInput, match=text):
        build_simulation(scene.replace(changes))
    louder = scene.replace({"airflow.subglottal_pressure": "0.9 kPa", "tissue.cover.E": 500.0})
    assert np.isfinite(build_simulation(louder).advance(2)["flow"]).all()


@pytest.mark.parametrize("key", ["full_run", "components", "modes", "contact_vectors", "contact_reach"])
def test_what_makes_a_basis_is_no_key_of_a_scene(phonating: plica.Scene, key: str) -> None:
    with pytest.raises(plica.SceneError, match=rf"reduction\.{key}.*plica reduce RUN -o basis\.h5"):
        phonating.replace({"reduction": {key: 10}})


def test_a_scene_without_reduction_has_no_basis(bar: plica.Scene, tmp_path: Path) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    assert not (tmp_path / "run" / BASIS).exists()


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        ({"modes": 100_000}, "modes = 100000 with 10 contact vectors; must be <= "),
        ({"contact_vectors": 5_000, "modes": 0}, "contact_vectors = 5000; must be <= "),
        ({"components": 5}, "components = 5; must be left out with a scene"),
        ({"contact_reach": "10 kg"}, 'contact_reach = "10 kg"'),
    ],
)
def test_a_basis_that_asks_for_too_much_is_refused(
    phonating: plica.Scene, tmp_path: Path, asked: dict[str, object], text: str
) -> None:
    given = {"modes": 10, "contact_vectors": 10, "contact_reach": REACH} | asked
    with pytest.raises(plica.InvalidInput, match=text):
        plica.reduce(phonating, tmp_path / "basis.h5", **given)
    assert not list(tmp_path.iterdir())


def test_a_basis_is_announced_when_it_is_made_and_not_before_it_is_refused(
    phonating: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    phonating.save(tmp_path / "scene.toml")
    command = [
        "reduce",
        str(tmp_path / "scene.toml"),
        "-o",
        str(tmp_path / "basis.h5"),
        "--contact-vectors",
        "0",
    ]
    assert main([*command, "--modes", "100000"]) == 2
    refused = capsys.readouterr().err
    assert "--modes = 100000 with 0 contact vectors; must be <= " in refused
    assert "computing" not in refused
    assert main([*command, "--modes", "3"]) == 0
    said = capsys.readouterr()
    assert said.err == "plica: computing the basis\n"
    assert said.out == f"written: {tmp_path / 'basis.h5'}, {3 + PRESSURE_VECTORS} vectors\n"
    assert main([*command, "--modes", "4"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert main([*command, "--modes", "4", "--overwrite"]) == 0


def test_a_basis_that_its_scene_could_not_use_is_not_made(phonating: plica.Scene, tmp_path: Path) -> None:
    finite = phonating.replace({"strain": "finite", "airflow.model": "viscous_slit"})
    with pytest.raises(plica.InvalidInput, match=r"cannot be reduced: reduction: must be left out.*--scene"):
        plica.reduce(finite, tmp_path / "basis.h5")
    assert not (tmp_path / "basis.h5").exists()


def test_bodies_without_supports_are_refused(colliding: plica.Scene, tmp_path: Path) -> None:
    with pytest.raises(plica.InvalidInput, match=r"reduce: .*supports"):
        plica.reduce(colliding, tmp_path / "basis.h5", modes=10)


def test_a_basis_left_to_its_defaults_takes_what_a_small_mesh_has(phonating: plica.Scene) -> None:
    reach = 3e-3
    mesh = build_mesh(phonating.mesh)
    fixed = fixed_components(phonating, mesh)
    first, second = (np.asarray(mesh.surfaces[name]) for name in ("airway_left", "airway_right"))
    near = contact_nodes(np.asarray(mesh.points), (first, second), reach)[0]
    contact = int((~fixed[near].all(axis=1)).sum())
    assert 0 < contact < 100
    modes = min(200, int((~fixed).sum()) - contact)
    basis = basis_of(phonating, mesh, contact_reach=reach)
    assert basis.shape[1] == modes + PRESSURE_VECTORS + contact


def held_energy(basis: np.ndarray, K: csr_array, responses: np.ndarray) -> float:
    """Elastic energy of static responses that the span of the basis holds, twice and summed."""
    shared = basis.T @ (K @ responses)
    return float(np.sum(shared * np.linalg.solve(basis.T @ (K @ basis), shared)))


def test_static_responses_are_taken_in_the_combinations_that_hold_most_elastic_energy(
    phonating: plica.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As much as the largest eigenvalues of F' K^-1 F, of unit forces and of the patterns of pressure."""
    count, reach = 7, 10e-3
    mesh = build_mesh(phonating.mesh)
    fixed = fixed_components(phonating, mesh)
    free, full = ~fixed.ravel(), build_simulation(phonating, mesh)
    K = csr_array(full.stiffness, shape=2 * (len(free),))[free][:, free].tocsc()
    sides = (np.asarray(mesh.surfaces["airway_left"]), np.asarray(mesh.surfaces["airway_right"]))
    nodes, normals = contact_nodes(np.asarray(mesh.points), sides, reach)
    along = np.zeros((*fixed.shape, len(nodes)))
    along[nodes, :, np.arange(len(nodes))] = normals
    patterns = engine.pressure_patterns(mesh, mesh.surfaces[phonating.airflow.surface], full.section_height)
    monkeypatch.setattr("plica.runs.basis.PRESSURE_VECTORS", count)
    basis = vectors(phonating, mesh, 0, count)[free]
    assert basis.shape[1] == 2 * count
    for taken, all_forces in (
        (basis[:, :count], np.asarray(patterns)),
        (basis[:, count:], along.reshape(len(free), -1)),
    ):
        forces = np.ascontiguousarray(all_forces[free])
        responses = splu(K).solve(forces)
        energies = np.linalg.eigvalsh(forces.T @ responses)
        assert energies[-count:].sum() > 3 * energies[:count].sum()
        assert held_energy(taken, K, responses) == pytest.approx(energies[-count:].sum(), rel=1e-7)


@pytest.mark.parametrize("mode", [0, 5])
def test_a_damping_ratio_damps_every_mode_alike(bar: plica.Scene, tmp_path: Path, mode: int) -> None:
    """As the oscillator of the closed form, whatever the frequency and the viscosity of the tissue."""
    mesh = build_mesh(bar.mesh)
    basis, ratio = vectors(bar, mesh, 8, 0), 0.06
    full = build_simulation(bar, mesh)
    K, M = (csr_array(matrix, shape=2 * (len(basis),)) for matrix in (full.stiffness, full.mass))
    shape = basis[:, mode] / np.sqrt(basis[:, mode] @ (M @ basis[:, mode]))
    omega = np.sqrt(shape @ (K @ shape))
    step = 2 * np.pi / omega / 400
    scene = reduced(bar, 8, 0, tmp_path / "basis.h5").replace(
        {
            "reduction.damping_ratio": ratio,
            "time.step": step,
            "time.duration": 800 * step,
            "output.every": 10 * step,
            "output.checkpoint_every": 10 * step,
            "time.scheme": {"newmark": {}},
            "initial": None,
        }
    )
    simulation = build_simulation(scene, mesh, displacement=1e-6 * shape.reshape(-1, 3))
    amplitude = []
    for _ in range(80):
        waves = simulation.advance(10)
        amplitude.append(shape @ (M @ simulation.displacement.ravel()))
        energy = (waves["kinetic_energy"] + waves["elastic_energy"]).max()
        assert np.abs(waves["energy_balance_error"]).max() < 1e-10 * energy
    time = 10 * step * np.arange(1, 81)
    damped = omega * np.sqrt(1 - ratio**2)
    exact = np.exp(-ratio * omega * time) * (
        np.cos(damped * time) + ratio / np.sqrt(1 - ratio**2) * np.sin(damped * time)
    )
    np.testing.assert_allclose(np.array(amplitude) / 1e-6, exact, atol=1e-3)


@pytest.mark.parametrize("ratio", [0.0, -0.1, 1.5, float("nan")])
def test_a_damping_ratio_that_is_none_is_refused(bar: plica.Scene, tmp_path: Path, ratio: float) -> None:
    scene = reduced(bar, 4, 0, tmp_path / "basis.h5")
    with pytest.raises(plica.InvalidInput, match=r"reduction\.damping_ratio.* must be"):
        scene.replace({"reduction.damping_ratio": ratio})
