"""Modes of vibration: closed forms, a dense eigenproblem, symmetry, files and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_array

import plica
from plica.commands.main import main
from plica.runs.build import build_simulation, fixed_components
from plica.scene.mesh.build import build_mesh

E, DENSITY, LENGTH, VISCOSITY = 20e3, 1040.0, 10e-3, 0.5


def sliding_bar(divisions: int = 16) -> plica.Scene:
    """Held at one end, without Poisson's ratio, and free to move along itself alone."""
    return plica.Scene(
        plica.Block(size=(LENGTH, 1e-3, 1e-3), divisions=(divisions, 1, 1), order=2),
        {"body": plica.Tissue(E=E, nu=0.0, viscosity=VISCOSITY, density=DENSITY)},
        time=plica.Stepping(step=1e-4, duration=1e-3),
        supports=plica.Supports(
            fixed=["x_min"], components=dict.fromkeys(("y_min", "y_max", "z_min", "z_max"), "yz")
        ),
    )


def test_a_bar_sounds_at_odd_quarters_of_its_wave() -> None:
    found = plica.eigenmodes(sliding_bar(), 3)
    expected = np.array([1, 3, 5]) / (4 * LENGTH) * np.sqrt(E / DENSITY)
    np.testing.assert_allclose(found.frequency, expected, rtol=4e-5)  # (k h)^4 / 1440
    assert found.residual.max() < 1e-8


def test_a_mode_of_a_bar_is_damped_by_the_viscosity_over_its_stiffness() -> None:
    """Without transverse strain C = a K, so that zeta = a omega / 2; a from the engine's matrices."""
    scene = sliding_bar()
    simulation = build_simulation(scene)
    K, C = (csr_array(matrix) for matrix in (simulation.stiffness, simulation.viscosity))
    mesh = build_mesh(scene.mesh)
    along = np.zeros((len(mesh.points), 3))
    along[:, 0] = np.asarray(mesh.points)[:, 0]
    ratio = along.ravel() @ (C @ along.ravel()) / (along.ravel() @ (K @ along.ravel()))
    found = plica.eigenmodes(scene, 3)
    assert ratio > 0
    np.testing.assert_allclose(found.damping_ratio, ratio * np.pi * found.frequency, rtol=1e-9)


def test_modes_are_damped_as_the_time_steps_of_a_reduced_scene(tmp_path: Path) -> None:
    """By the ratio, in place of the viscosity."""
    scene, file = sliding_bar(), tmp_path / "basis.h5"
    plica.reduce(scene, file, modes=4)
    damped = scene.replace({"reduction": {"basis": str(file), "damping_ratio": 0.06}})
    assert (plica.eigenmodes(damped, 3).damping_ratio == 0.06).all()
    without = damped.replace({"reduction.damping_ratio": None})
    by_viscosity = plica.eigenmodes(scene, 3).damping_ratio
    assert (by_viscosity != 0.06).all()
    np.testing.assert_array_equal(plica.eigenmodes(without, 3).damping_ratio, by_viscosity)


def test_modes_are_those_of_a_dense_eigenproblem(bar: plica.Scene) -> None:
    mesh = build_mesh(bar.mesh)
    free = ~fixed_components(bar, mesh).ravel()
    simulation = build_simulation(bar, mesh)
    K, M, C = (
        csr_array(matrix).toarray()[np.ix_(free, free)]
        for matrix in (simulation.stiffness, simulation.mass, simulation.viscosity)
    )
    squares, shapes = eigh(K, M)
    found = plica.eigenmodes(bar, 7, mesh)
    np.testing.assert_allclose((2 * np.pi * found.frequency) ** 2, squares[:7], rtol=1e-9)
    omega = np.sqrt(squares[:7])
    damping = np.einsum("ij,ij->j", shapes[:, :7], C @ shapes[:, :7]) / (2 * omega)
    np.testing.assert_allclose(found.damping_ratio[2], damping[2], rtol=1e-6)  # the first two are a pair
    flat = found.shape.reshape(7, -1)[:, free]
    np.testing.assert_allclose(np.diag(flat @ M @ flat.T), found.modal_mass, rtol=1e-9)
    gram = (flat @ M @ flat.T) / np.sqrt(np.outer(found.modal_mass, found.modal_mass))
    np.testing.assert_allclose(gram, np.eye(7), atol=1e-9)


def test_modes_of_half_and_quarter_are_the_even_ones_of_the_whole(phonating: plica.Scene) -> None:
    whole = plica.eigenmodes(phonating, 30)
    assert {"even", "odd"} <= set(whole.left_right)
    even = np.array(whole.left_right) == "even"
    both = even & (np.array(whole.front_back) == "even")
    assert 3 < both.sum() < even.sum() < 30
    still = phonating.replace({"initial": None})
    for symmetry, chosen in (("half", even), ("quarter", both)):
        found = plica.eigenmodes(still.replace({"symmetry": symmetry}), 4)
        np.testing.assert_allclose(found.frequency, whole.frequency[chosen][:4], rtol=1e-8)
        assert set(found.left_right) == {"even"}


def test_modes_of_folds_of_unequal_tissue_are_neither_even_nor_odd(phonating: plica.Scene) -> None:
    uneven = phonating.replace({"tissue.cover.left": {"E": "2 kPa"}})
    found = plica.eigenmodes(uneven, 6)
    assert "mixed" in found.left_right


def test_the_command_writes_a_table_and_shapes_for_paraview(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "bar.toml"
    scene.write_text(sliding_bar().text())
    out = tmp_path / "modes"
    assert main(["eigenmodes", str(scene), "-o", str(out), "--count", "3"]) == 0
    with (out / "eigenmodes.csv").open() as file:
        rows = list(csv.DictReader(file))
    content = json.loads((out / "eigenmodes.json").read_text())
    assert [float(row["frequency (Hz)"]) for row in rows] == [one["frequency"] for one in content["modes"]]
    with h5py.File(out / "eigenmodes.h5") as file:
        shapes = file["fields/displacement"][()]
        assert file["fields/time"][0] == content["modes"][0]["frequency"]
    assert np.linalg.norm(shapes, axis=2).max(axis=1) == pytest.approx(1e-3, rel=1e-6)
    text = (out / "eigenmodes.xdmf").read_text()
    assert text.count("<Time ") == 3
    assert "eigenmodes.h5:/fields/displacement" in text
    assert main(["eigenmodes", str(scene), "-o", str(out)]) == 2
    assert "eigenmodes.csv" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("count", "text"),
    [
        (0, "must be a whole number in [1"),
        (2.5, "count = 2.5"),
        (-3, "count = -3"),
        (10**6, "count"),
        (200, "unknowns"),
    ],
)
def test_counts_that_cannot_be_are_refused(bar: plica.Scene, count: Any, text: str) -> None:
    with pytest.raises(plica.InvalidInput, match="eigenmodes: count") as error:
        plica.eigenmodes(bar, count)
    assert text in str(error.value)


def test_a_body_that_can_move_without_strain_is_refused(bar: plica.Scene) -> None:
    with pytest.raises(plica.InvalidInput, match="supports let a body move without strain"):
        plica.eigenmodes(bar.replace({"supports": None}), 3)
