"""A mesh lies where it lies: what is measured does not depend on it, nor on which way the patient looks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica
from conftest import THESIS_TISSUE, TINY_LARYNX
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure
from plica.measures.pulses import pulses
from plica.measures.run.folds import rest_width
from plica.measures.run.measure import measure
from plica.report.run import write_report
from plica.report.run.cycle import Outline
from plica.report.run.reading import read

SURFACES = {"airway_left": 11, "airway_right": 12, "wall": 13}
SOFT_LEFT = {"left": {"E": 0.8e3, "mu_fibre": 8e3}}  # so that the folds differ


def scene(directory: Path, place: Callable[[Any], Any], sides: object = "labelled") -> plica.Scene:
    """The very coarse larynx from a file, its points put elsewhere; it is blown open from rest."""
    mesh = plica.build_mesh(plica.Larynx(larynx="thesis_coarse", options=plica.LarynxOptions(**TINY_LARYNX)))
    cells, outer = np.asarray(mesh.cells), np.asarray(plica._engine.boundary(mesh.cells)[0])
    wall = outer[np.isin(outer, mesh.node_sets["wall"]).all(axis=1)]
    faces = [np.asarray(mesh.surfaces["airway_left"]), np.asarray(mesh.surfaces["airway_right"]), wall]
    labels = [1 + np.asarray(mesh.cell_layer) + 3 * (np.asarray(mesh.cell_side) - 1)]
    labels += [np.full(len(one), label) for one, label in zip(faces, SURFACES.values(), strict=True)]
    file = meshio.Mesh(
        place(np.asarray(mesh.points)),
        [("tetra", cells), *(("triangle", one) for one in faces)],
        cell_data={"label": labels},
    )
    file.write(directory / "larynx.vtu")
    tissue = {name: plica.Tissue(**fields) for name, fields in THESIS_TISSUE.items()}
    tissue["cover"] = plica.Tissue(**THESIS_TISSUE["cover"], **SOFT_LEFT)
    by_label = plica.Sides(left=(1, 2, 3), right=(4, 5, 6))
    return plica.Scene(
        plica.MeshFile(
            file=directory / "larynx.vtu",
            layers={name: (1 + k, 4 + k) for k, name in enumerate(("body", "ligament", "cover"))},
            surfaces={"airway": (11, 12), **SURFACES},
            sides=by_label if sides == "labelled" else sides,
        ),
        tissue,
        time=plica.Stepping(step=5e-5, duration=20e-3),
        supports=plica.Supports(fixed=("wall",)),
        airflow=plica.Airflow(subglottal_pressure="1.2 kPa", area="cut"),
        contact=plica.Multipliers(),
        # At a larger one, round-off decides how often the factor refines a step, and that is seen.
        solver=plica.Solver(tolerance=1e-12),
        output=plica.Output(every=1e-3),
    )


def shifted(axis: str, length: float) -> Callable[[Any], Any]:
    return lambda points: points + length * np.eye(3)["xyz".index(axis)]


def half_turn(points: Any) -> Any:
    return points * (-1.0, -1.0, 1.0)


@pytest.fixture(scope="module")
def at_origin(tmp_path_factory: pytest.TempPathFactory) -> plica.Run:
    directory = tmp_path_factory.mktemp("origin")
    return plica.run(scene(directory, lambda points: points), directory / "run", progress=False)


def measured(run: plica.Run) -> dict[str, Measure]:
    """Over all pulses: in its first 20 ms this voice has no period that would be chosen."""
    time, area = (np.asarray(part, dtype=float) for part in (run.time, run.waveforms["minimum_area"]))
    return measure(run, Cycles(pulses(time, area)))


def assert_alike(found: dict[str, Measure], expected: dict[str, Measure], tolerance: float) -> None:
    assert found.keys() == expected.keys()
    for name, there in expected.items():
        here = found[name]
        if name in {"energy_balance_error", "contact_force_balance", "deepest_gap", "largest_multiplier"}:
            continue  # round-off themselves
        assert (here.value is None) == (there.value is None), (name, here, there)
        if here.value is not None and there.value is not None:
            assert here.value == pytest.approx(there.value, rel=tolerance, abs=1e-30), name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "length", "sides"),
    [
        ("x", 0.3e-3, "labelled"),
        ("x", 0.3e-3, "x"),
        ("y", 0.3e-3, "labelled"),
        ("z", 0.3e-3, "labelled"),
        ("x", 1.0, "x"),
        ("y", 1.0, "labelled"),
        ("z", 1.0, "labelled"),
    ],
)
def test_a_larynx_elsewhere_has_the_same_measures(
    at_origin: plica.Run, tmp_path: Path, axis: str, length: float, sides: str
) -> None:
    run = plica.run(scene(tmp_path, shifted(axis, length), sides), tmp_path / "run", progress=False)
    np.testing.assert_array_equal(run.mesh.cell_side, at_origin.mesh.cell_side)
    np.testing.assert_allclose(rest_width(run), rest_width(at_origin), rtol=1e-11)
    # Coordinates of 1 m have a round-off of 1e-16 m, 1e-12 of the glottis, that grows over 400 steps.
    assert_alike(measured(run), measured(at_origin), 1e-10)
    write_report(run, tmp_path / "report.html")
    for before, after in zip(outlines(at_origin), outlines(run), strict=True):
        np.testing.assert_allclose(after, before, atol=1e-4)  # mm; frames are stored in single precision


def outlines(run: plica.Run) -> list[Any]:
    """What the view from above draws of the last frame, about the midline."""
    outline = Outline.of(read(run), -1)
    return [outline.left, outline.right, np.array([outline.widest, outline.length])]


@pytest.mark.slow
def test_a_larynx_turned_by_half_a_turn_has_the_same_measures(at_origin: plica.Run, tmp_path: Path) -> None:
    run = plica.run(scene(tmp_path, half_turn), tmp_path / "run", progress=False)
    np.testing.assert_array_equal(run.mesh.cell_side, at_origin.mesh.cell_side)
    expected = measured(at_origin)
    assert expected["amplitude_left"].value != pytest.approx(expected["amplitude_right"].value, rel=0.01)
    assert_alike(measured(run), expected, 1e-10)
    for before, after in zip(outlines(at_origin), outlines(run), strict=True):
        np.testing.assert_allclose(after, before, atol=1e-4)


@pytest.mark.parametrize("length", [0.3e-3, 1.0])
def test_sides_by_x_are_those_of_the_mesh(tmp_path: Path, length: float) -> None:
    made = plica.build_mesh(scene(tmp_path, shifted("x", length), "x").mesh)
    labelled = plica.build_mesh(scene(tmp_path, shifted("x", length)).mesh)
    np.testing.assert_array_equal(made.cell_side, labelled.cell_side)
