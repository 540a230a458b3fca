"""Runs on a mirrored mesh: those of the larynx that was cut; left and right alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

import plica
from mesh_parts import mirrored_larynx, write_fold
from plica.scene.symmetry import nearest_image

STEPS = 40
SYMMETRIES = [None, "half", "quarter"]
TISSUE = {
    "cover": plica.Tissue(E="3 kPa", nu=0.4, viscosity=0.1),
    "body": plica.Tissue(E="10 kPa", nu=0.4, viscosity=0.2),
}


def nodule(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Half a gap of 0.3 mm, in front of and above its middle 0.15 mm less."""
    return np.asarray(0.3 - 0.15 * np.exp(-0.5 * ((y - 8) ** 2 + (z - 6) ** 2)))


def relative(own: Any, other: Any) -> float:
    return float(np.abs(np.asarray(own) - np.asarray(other)).max() / np.abs(other).max())


@pytest.mark.parametrize("mirror", ["fold", "quarter"])
@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_the_voice_of_a_cut_and_mirrored_larynx_is_that_of_the_larynx(
    phonating: plica.Scene, symmetry: str | None, mirror: str, tmp_path: Path
) -> None:
    scene = phonating.replace({"symmetry": symmetry, "supports": {"fixed": ["wall"]}})
    assert isinstance(scene.mesh, plica.Larynx)
    file = mirrored_larynx(scene.mesh, tmp_path / "part.vtu", mirror)
    built, own = (plica.build_simulation(one) for one in (scene, scene.replace({"mesh": file})))
    expected, found = (simulation.advance(STEPS) for simulation in (built, own))
    assert np.abs(expected["contact_force_first"]).max() > 1e-3  # N
    # The nodes have other numbers: sums round otherwise, and what sweeps and contact leave is otherwise too.
    for name in ("flow", "minimum_area", "elastic_energy", "kinetic_energy", "flow_work"):
        assert relative(found[name], expected[name]) < 1e-6
    assert np.abs(found["energy_balance_error"]).max() < 1e-12  # J, of 1e-5
    points = [np.asarray(plica.build_mesh(mesh).points) for mesh in (scene.mesh, file)]
    number = cKDTree(points[1]).query(points[0])[1]
    assert relative(np.asarray(own.displacement)[number], built.displacement) < 1e-6


def folds(fields: dict[str, Any], mirror: str = "fold", symmetry: str | None = None) -> plica.Scene:
    """Two folds of a file that collide within the steps."""
    return plica.Scene(
        plica.MeshFile(mirror=mirror, **fields),
        TISSUE,
        time=plica.Stepping(step="50 us", duration=STEPS * 50e-6),
        airflow=plica.Airflow(area=plica.Cut(sections=40)),
        contact=plica.Multipliers(),
        initial=plica.Initial(opening_velocity=-1.0),
        supports=plica.Supports(fixed=["lateral", "ends"]),
        symmetry=symmetry,
    )


def test_an_uneven_fold_moves_as_its_mirror_image(tmp_path: Path) -> None:
    scene = folds(write_fold(tmp_path / "nodule.vtu", gap=nodule))
    simulation = plica.build_simulation(scene)
    found = simulation.advance(STEPS)
    assert np.abs(found["contact_force_first"]).max() > 0.01  # N
    points = np.asarray(plica.build_mesh(scene.mesh).points)
    u = np.asarray(simulation.displacement)
    assert relative(u[nearest_image(points, 0)] * [-1, 1, 1], u) < 1e-6  # what sweeps and contact leave
    left, right = (np.asarray(found[f"coronal_{side}"]) for side in ("left", "right"))
    assert relative(left * [-1, 1, 1], right) < 1e-7
    assert relative(found["contact_force_first"] * [-1, 1, 1], found["contact_force_second"]) < 1e-6
    behind = np.abs(u[points[:, 1] < 5e-3]).max(), np.abs(u[points[:, 1] > 7e-3]).max()
    assert abs(behind[0] / behind[1] - 1) > 0.02  # it is uneven
    assert np.abs(found["energy_balance_error"]).max() < 1e-14  # J
    half = plica.build_simulation(scene.replace({"symmetry": "half"})).advance(STEPS)
    assert relative(half["flow"], found["flow"]) < 1e-5


def test_a_stored_run_has_the_mirrored_mesh_and_goes_on(tmp_path: Path) -> None:
    scene = folds(write_fold(tmp_path / "nodule.vtu", gap=nodule), symmetry="half")
    scene = scene.replace({"output.every": "0.2 ms", "output.checkpoint_every": "0.5 ms"})
    plica.run(scene.replace({"time.duration": "1 ms"}), tmp_path / "run", progress=False)
    run = plica.run(scene, tmp_path / "run", resume=True, progress=False)
    assert run.scene.mesh == scene.mesh
    assert np.array_equal(run.mesh.points, plica.build_mesh(scene.mesh).points)
    at_once = plica.build_simulation(scene).advance(STEPS)
    assert np.array_equal(run["flow"], at_once["flow"])


@pytest.mark.parametrize("mirror", ["fold", "quarter"])
def test_folds_apart_have_the_same_voice_with_any_symmetry(mirror: str, tmp_path: Path) -> None:
    part = (0.0, 6.0) if mirror == "quarter" else (-6.0, 6.0)
    fields = write_fold(tmp_path / "part.vtu", y=part, divisions=(4, 3 if mirror == "quarter" else 6, 8))
    if mirror == "quarter":
        fields["surfaces"] |= {"ends": 14}
    planes = SYMMETRIES if mirror == "quarter" else SYMMETRIES[:2]  # a box is divided along one diagonal
    found = [plica.build_simulation(folds(fields, mirror, one)).advance(STEPS) for one in planes]
    assert np.abs(found[0]["contact_force_first"]).max() > 0.01  # N
    for other in found[1:]:
        assert relative(other["flow"], found[0]["flow"]) < 1e-4  # tolerances of solver, sweeps and contact
        assert relative(other["elastic_energy"], found[0]["elastic_energy"]) < 1e-5


def test_folds_of_a_mirrored_mesh_are_pushed_outwards(tmp_path: Path) -> None:
    scene = folds(write_fold(tmp_path / "part.vtu", gap=nodule)).replace({"initial.opening_velocity": 0.2})
    mesh = plica.build_mesh(scene.mesh)
    side = {k: np.unique(np.asarray(mesh.cells)[np.asarray(mesh.cell_side) == k]) for k in (1, 2)}
    velocity = np.asarray(plica.build_simulation(scene).velocity)
    assert velocity[side[1], 0].min() < -0.1
    assert velocity[side[1], 0].max() == 0
    assert velocity[side[2], 0].max() > 0.1
    assert velocity[side[2], 0].min() == 0
    assert np.array_equal(velocity[nearest_image(np.asarray(mesh.points), 0)] * [-1, 1, 1], velocity)
    each = {"left": (-0.3, 0, 0), "right": (0.3, 0, 0)}
    pushed = scene.replace({"initial": None}).replace({"initial": {"velocity": each}})
    velocity = np.asarray(plica.build_simulation(pushed).velocity)
    assert np.unique(velocity[side[1], 0]).tolist() == [-0.3, 0.0]  # held at ends and wall
    assert np.unique(velocity[side[2], 0]).tolist() == [0.0, 0.3]
