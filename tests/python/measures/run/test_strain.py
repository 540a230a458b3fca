"""Strain at nodes and at the points of cells, against closed forms and against what the engine recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import plica
from plica.measures.run.strain import NodalStrain, is_finite


@pytest.mark.parametrize("order", [1, 2])
def test_a_constant_strain_is_found_at_every_node(order: int) -> None:
    mesh = plica.build_mesh(plica.Block(size=(0.01, 0.002, 0.002), divisions=(4, 2, 2), order=order))
    gradient = np.array([[0.02, 0.03, 0.0], [0.01, -0.05, 0.0], [0.0, 0.0, 0.01]])
    displacement = np.asarray(mesh.points) @ gradient.T
    small = 0.5 * (gradient + gradient.T)
    for green, strain in ((False, small), (True, small + 0.5 * gradient.T @ gradient)):
        found = NodalStrain(mesh, green=green)
        largest = np.abs(np.linalg.eigvalsh(strain)).max()
        np.testing.assert_allclose(found.at_nodes(displacement), largest, rtol=1e-9)
        assert found.volumes.sum() == pytest.approx(0.01 * 0.002 * 0.002, rel=1e-12)


def test_a_node_has_the_mean_of_its_cells_by_volume() -> None:
    """Two cells of unlike volume that share a face, one strained, the other not."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -3]])
    mesh = plica._engine.TetMesh(points=points, cells=np.array([[0, 1, 2, 3], [0, 2, 1, 4]]))
    displacement = np.zeros((5, 3))
    displacement[3, 2] = 0.4  # the upper cell is stretched by 0.4 in z
    found = NodalStrain(mesh, green=False).at_nodes(displacement)
    np.testing.assert_allclose(found, [0.1, 0.1, 0.1, 0.4, 0.0], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("strain", [None, "finite"])
def test_the_points_of_a_stored_field_have_the_strains_of_the_waveforms(
    strain: str | None, bar: plica.Scene, tmp_path: Path
) -> None:
    scene = bar if strain is None else bar.replace({"strain": "finite"})
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert is_finite(run.scene_text) == (strain is not None)
    reader = NodalStrain(run.mesh, green=is_finite(run.scene_text))
    for frame in (3, 8):
        step = int(np.argmin(np.abs(run.time - run.fields["time"][frame])))
        at_points = reader.at_points(run.displacement[frame])
        assert run["strain_largest"][step] > 1e-3
        assert at_points.max() == pytest.approx(run["strain_largest"][step], rel=1e-5)  # fields: 24 bits
