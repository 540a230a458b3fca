"""The meshes that the uncertainty of a run is estimated on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from conftest import THESIS_TISSUE
from plica import _engine
from plica.uncertainty.meshes import coarser, finer


def test_a_mesh_file_is_refined_uniformly(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(10.0, 2.0, 2.0), divisions=(4, 1, 1))
    meshio.Mesh(np.asarray(mesh.points), [("tetra", np.asarray(mesh.cells))]).write(tmp_path / "bar.vtu")
    scene = plica.Scene(
        plica.MeshFile(
            file=tmp_path / "bar.vtu",
            unit="1 mm",
            surfaces={"left": {"plane": {"point": (0, 0, 0), "normal": (1, 0, 0)}}},
        ),
        {"body": plica.Tissue(E="20 kPa", nu=0.3)},
        time=plica.Stepping(step="0.1 ms", duration="2 ms"),
        supports=plica.Supports(fixed=["left"]),
        initial=plica.Initial(velocity={"body": (0.0, 0.0, 0.1)}),
        output=plica.Output(probes=[("10 mm", 0.0, 0.0)]),
    )
    plica.run(scene, tmp_path / "run", progress=False)
    found = plica.estimate_uncertainty(tmp_path / "run", progress=False)
    assert found.levels[1]["cells"] == 8 * len(mesh.cells)
    mesh_part = found.waveforms["probes.relative_error"].mesh
    assert mesh_part is not None
    assert mesh_part.verdict == "one other level"
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(10.0, 2.0, 3.0), divisions=(4, 1, 1))
    meshio.Mesh(np.asarray(mesh.points), [("tetra", np.asarray(mesh.cells))]).write(tmp_path / "bar.vtu")
    with pytest.raises(plica.SceneError, match="its points are not those of the run"):
        plica.estimate_uncertainty(tmp_path / "run", progress=False)


def test_a_level_on_a_mesh_file_that_changed_is_computed_anew(bar: plica.Scene, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    (tmp_path / "own").mkdir()
    finer = bar.replace({"mesh": _bar_file(meshio, tmp_path, (8, 2, 2))})
    own = bar.replace({"mesh": _bar_file(meshio, tmp_path / "own", (4, 1, 1))})
    plica.run(own, tmp_path / "run", progress=False)
    first = plica.estimate_uncertainty(tmp_path / "run", mesh=finer, progress=False)
    _bar_file(meshio, tmp_path, (10, 2, 2))
    second = plica.estimate_uncertainty(tmp_path / "run", mesh=finer, progress=False)
    assert [level["name"] for level in first.levels] == [level["name"] for level in second.levels]
    assert [level["cells"] for level in first.levels if level["kind"] == "mesh"] == [8 * 2 * 2 * 6]
    assert [level["cells"] for level in second.levels if level["kind"] == "mesh"] == [10 * 2 * 2 * 6]


def _bar_file(meshio: Any, folder: Path, divisions: tuple[int, int, int]) -> plica.MeshFile:
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(10.0, 2.0, 2.0), divisions=divisions)
    meshio.Mesh(np.asarray(mesh.points), [("tetra", np.asarray(mesh.cells))]).write(folder / "bar.vtu")
    return plica.MeshFile(
        file=folder / "bar.vtu",
        unit="1 mm",
        surfaces={"x_min": {"plane": {"point": (0, 0, 0), "normal": (1, 0, 0)}}},
    )


@pytest.mark.parametrize("sections", [200, 1000, 2])
def test_sections_of_the_airflow_are_refined_with_the_mesh(sections: int) -> None:
    scene = plica.Scene(
        plica.Larynx(larynx="demo", order=2),
        {layer: plica.Tissue(**fields) for layer, fields in THESIS_TISSUE.items()},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        airflow=plica.Airflow(subglottal_pressure="0.8 kPa", area=plica.Cut(sections=sections)),
    )
    factors = []
    for other in (finer(scene), coarser(scene)):
        assert other is not None
        factors.append(other.factor)
        assert other.scene.airflow is not None
        assert other.scene.airflow.area.cut is not None
        count = other.scene.airflow.area.cut.sections
        assert 2 <= count <= 1000
        assert abs(count - sections * other.factor) <= 0.5 or count in (2, 1000)
    assert factors[0] > 1 > factors[1]


def test_sections_at_the_levels_follow_the_mesh_by_themselves() -> None:
    scene = plica.Scene(
        plica.Larynx(larynx="thesis_demo"),
        {layer: plica.Tissue(**fields) for layer, fields in THESIS_TISSUE.items()},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        airflow=plica.Airflow(subglottal_pressure="0.8 kPa", area="elliptic"),
    )
    other = finer(scene)
    assert other is not None
    assert other.scene.airflow == scene.airflow
