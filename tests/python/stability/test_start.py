"""Runs that begin in the equilibrium with the flow: below onset they stay there, above it motion grows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from benchmarks.voice.onset_steps import pairs_of
from flow_folds import folds
from interrupted_runs import assert_resumes_to_the_bit

TRACHEA = {"uniform": {"length": "20 cm", "area": "2.5 cm^2"}, "supply": {"pressure": {"reflection": 0.2}}}
TRACT = {"uniform": {"length": "17 cm", "area": "3 cm^2"}, "wall": "yielding"}
TUBES = {"trachea": TRACHEA, "tract": TRACT}
EXPLICIT = {"time.scheme": "central_differences", "time.step": 1e-6}
BERNOULLI = {"airflow.model": "bernoulli"}


def resting(pressure: float, **changes: Any) -> plica.Scene:
    """Folds that begin in the equilibrium with the flow."""
    begun = {"initial": {"equilibrium": "flow"}, "airflow.subglottal_pressure": pressure}
    return folds(gap=2e-4).replace(begun).replace(changes)


@pytest.fixture(scope="module")
def basis(tmp_path_factory: pytest.TempPathFactory) -> dict[str | None, str]:
    """Of so few modes that the equilibrium of all nodes is none of theirs, by symmetry."""
    folder = tmp_path_factory.mktemp("bases")
    made: dict[str | None, str] = {}
    for symmetry in (None, "quarter"):
        made[symmetry] = str(folder / f"{symmetry}.h5")
        plica.reduce(
            folds(gap=2e-4).replace({"symmetry": symmetry, "airflow": None}), made[symmetry], modes=12
        )
    return made


@pytest.mark.parametrize(
    ("symmetry", "reduced", "changes"),
    [
        (None, False, {}),
        (None, False, {**TUBES, "gravity": [0, 0, -9.81]}),
        ("quarter", False, {"trachea": TRACHEA}),
        ("quarter", False, {"tract": TRACT, **BERNOULLI}),
        (None, True, {**TUBES, **BERNOULLI}),
        ("quarter", True, {"trachea": TRACHEA, "gravity": [0, 0, -9.81]}),
        ("quarter", True, {"tract": TRACT, "airflow.area": "elliptic"}),
        ("quarter", False, {"posture": {"elongation": 0.05}, "tissue.cover.stiffening": 2.0}),
        (None, False, EXPLICIT),
        (None, False, {**EXPLICIT, **TUBES}),
    ],
)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_below_onset_a_run_stays_where_it_begins(
    basis: dict[str | None, str], symmetry: Any, reduced: bool, changes: dict[str, Any], tolerance: float
) -> None:
    """To round-off, whatever the coupling's tolerance: the first sweep finds the pressure that is there."""
    kept = {"basis": basis[symmetry]} if reduced else None
    coupling = {"airflow.coupling": {"iterated": {"tolerance": tolerance}}}
    scene = resting(100.0, symmetry=symmetry, reduction=kept, **coupling).replace(changes)
    simulation = plica.build_simulation(scene)
    begun = np.array(simulation.displacement)
    names = ["section_area", "section_pressure", "flow"]
    waves = simulation.advance(min(round(20e-3 / scene.time.step), 4000), names)
    assert np.abs(begun).max() > 1e-6
    assert np.abs(np.asarray(simulation.displacement) - begun).max() < 1e-9 * np.abs(begun).max()
    for name in names:
        values = np.asarray(waves[name])
        assert np.ptp(values, axis=0).max() < 1e-9 * np.abs(values).max(), name


def test_few_coordinates_begin_in_an_equilibrium_of_their_own(basis: dict[str | None, str]) -> None:
    whole = np.asarray(plica.build_simulation(resting(100.0)).displacement)
    few = np.asarray(plica.build_simulation(resting(100.0, reduction={"basis": basis[None]})).displacement)
    np.testing.assert_array_equal(whole, plica.flow_equilibrium(resting(100.0)).displacement)
    assert 1e-3 < np.abs(few - whole).max() / np.abs(whole).max() < 1.0


@pytest.mark.parametrize(
    ("pressure", "tubes"),
    [(800.0, {}), (1200.0, {"trachea": TRACHEA}), (400.0, {"tract": TRACT}), (700.0, TUBES)],
)
def test_above_onset_a_small_opening_grows_as_its_pair_says(pressure: float, tubes: dict[str, Any]) -> None:
    scene = resting(pressure, symmetry="quarter", **tubes)
    scene = scene.replace({"initial.opening_displacement": "0.2 um", "time.duration": "40 ms"})
    s = plica.growth(scene, pressure, modes=60)[0]
    assert s.real > 10
    areas = np.asarray(
        plica.build_simulation(scene).advance(scene.time.steps, ["section_area"])["section_area"]
    )
    rest = plica.flow_equilibrium(scene).area
    moved = (areas - rest)[round(15e-3 / scene.time.step) :]  # faster oscillations have died away
    assert np.abs(moved / rest).max() < 0.05
    found = pairs_of(moved, scene.time.step)
    nearest = found[np.abs(found - s).argmin()]
    assert nearest.real == pytest.approx(s.real, rel=0.01)
    assert nearest.imag == pytest.approx(s.imag, rel=1e-3)


def test_what_the_scene_adds_is_added() -> None:
    rest = np.asarray(plica.build_simulation(resting(100.0)).displacement)
    added = {"opening_displacement": "0.1 mm", "opening_velocity": "0.1 m/s"}
    moved = plica.build_simulation(folds(gap=2e-4).replace({"initial": added}))
    both = plica.build_simulation(resting(100.0, initial={"equilibrium": "flow", **added}))
    np.testing.assert_array_equal(np.asarray(both.displacement), rest + np.asarray(moved.displacement))
    np.testing.assert_array_equal(np.asarray(both.velocity), np.asarray(moved.velocity))
    assert np.abs(np.asarray(both.velocity)).max() > 0


def test_a_run_whose_branch_ends_below_its_pressure_is_refused_before_its_first_step(tmp_path: Path) -> None:
    scene = resting(1e5)
    with pytest.raises(plica.SolveFailed) as told:
        plica.flow_equilibrium(scene)
    with pytest.raises(plica.SolveFailed) as error:
        plica.run(scene, tmp_path / "run", progress=False)
    assert str(error.value).startswith(str(told.value))
    assert "the one that begins at rest ends at" in str(told.value)
    assert not (tmp_path / "run").exists()


def test_folds_that_touch_at_rest_are_refused(tmp_path: Path) -> None:
    closing = [
        {"surface": name, "traction": (sign * 3000.0, 0.0, 0.0)}
        for name, sign in (("airway_left", 1.0), ("airway_right", -1.0))
    ]
    with pytest.raises(plica.InvalidInput, match=r"width of the glottis at rest = -.* mm at z = "):
        plica.run(resting(100.0, loads=closing), tmp_path / "run", progress=False)
    assert not (tmp_path / "run").exists()


def test_a_basis_is_made_of_a_scene_that_has_no_such_equilibrium(tmp_path: Path) -> None:
    assert plica.reduce(resting(1e5), tmp_path / "basis.h5", modes=5) > 5


@pytest.mark.slow
@pytest.mark.parametrize("reduced", [False, True])
def test_a_killed_run_that_began_in_the_flow_is_continued_to_the_bit(
    basis: dict[str | None, str], tmp_path: Path, reduced: bool
) -> None:
    scene = resting(
        800.0,
        symmetry="quarter",
        reduction={"basis": basis["quarter"]} if reduced else None,
        **TUBES,
        **{"initial.opening_velocity": "1 mm/s", "time.duration": "20 ms"},
        output={"every": "0.2 ms", "checkpoint_every": "0.2 ms"},
    )
    assert_resumes_to_the_bit(scene, tmp_path, 20)
