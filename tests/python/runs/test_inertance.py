"""Runs whose air has inertia in the glottis: key, waveforms and their balance, kills, driven areas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from flow_folds import folds
from interrupted_runs import assert_resumes_to_the_bit, longer
from plica.exchange.driven_flow import driven_flow
from plica.exchange.files import read_areas, write_run

INERTIA = {"airflow.model": {"viscous_slit": {"inertance": True}}}
WITHOUT = {"airflow.model": {"viscous_slit": {"inertance": False}}}
TUBES: dict[str, Any] = {
    "trachea": {
        "uniform": {"length": "12 cm", "area": "2.5 cm^2"},
        "supply": {"pressure": {"reflection": 0.7}},
    },
    "tract": {"vowel": {"name": "a"}},
}


def test_a_scene_file_has_it_and_without_it_nothing_changes(phonating: plica.Scene, tmp_path: Path) -> None:
    scene = phonating.replace(INERTIA)
    scene.save(tmp_path / "scene.toml")
    read = plica.Scene.load(tmp_path / "scene.toml")
    assert read.airflow is not None
    assert read.airflow.model.viscous_slit is not None
    assert read.airflow.model.viscous_slit.inertance is True
    off = phonating.replace(WITHOUT)
    one, other, with_it = (plica.build_simulation(each).advance(20) for each in (off, phonating, read))
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)
    assert set(with_it) - set(one) == {"air_inertial_power", "air_inertial_energy"}
    assert np.abs(with_it["flow"] - one["flow"]).max() > 1e-3 * one["flow"].max()


@pytest.mark.parametrize(
    ("model", "text"),
    [
        ({"bernoulli": {"inertance": True}}, "airflow.model.bernoulli.inertance is not known"),
        ({"viscous_slit": {"inertance": 1}}, "airflow.model.viscous_slit.inertance = 1"),
        ({"viscous_slit": {"inertance": "yes"}}, 'airflow.model.viscous_slit.inertance = "yes"'),
    ],
)
def test_what_is_no_inertance_is_told(phonating: plica.Scene, model: dict[str, Any], text: str) -> None:
    with pytest.raises(plica.SceneError) as error:
        phonating.replace({"airflow.model": model})
    assert text in str(error.value)


def test_the_power_of_the_air_is_that_of_jet_friction_and_inertia(phonating: plica.Scene) -> None:
    scene = longer(phonating.replace(INERTIA), 3)
    assert scene.airflow is not None
    w = plica.build_simulation(scene).advance(scene.time.steps)
    area = w["section_area"]
    clear = area.min(axis=1) > 1e-6  # where nothing is as narrow as the least gap
    jet_area = np.minimum(area[:, -1], 1.2 * area.min(axis=1))
    jet = 0.5 * scene.airflow.air_density * np.abs(w["flow"]) ** 3 / jet_area**2
    taken = jet + w["air_viscous_loss"] + w["air_inertial_power"]
    assert clear.sum() > 20
    largest = w["air_power"].max()
    np.testing.assert_allclose(taken[clear], w["air_power"][clear], rtol=0, atol=1e-12 * largest)
    assert np.abs(w["air_inertial_power"]).max() > 0.01 * largest
    # What the air has stored is of the order of its kinetic energy, whatever has gone through it.
    assert abs(w["air_inertial_energy"][-1]) < np.abs(w["air_inertial_power"]).sum() * scene.time.step


def test_folds_in_equilibrium_with_the_flow_stay_there() -> None:
    scene = folds(gap=2e-4).replace({"initial": {"equilibrium": "flow"}, **TUBES, **INERTIA})
    found = plica.build_simulation(scene).advance(40, ["section_area", "air_inertial_power", "air_power"])
    areas = np.asarray(found["section_area"])
    np.testing.assert_allclose(areas[-1], areas[0], rtol=1e-7)
    assert np.abs(found["air_inertial_power"]).max() < 1e-5 * found["air_power"].max()


@pytest.mark.parametrize("tubes", [False, True])
def test_a_runs_areas_give_its_flow_but_for_the_beginning(
    phonating: plica.Scene, tmp_path: Path, tubes: bool
) -> None:
    scene = longer(phonating, 10).replace({**(TUBES if tubes else {}), **INERTIA})
    run = plica.run(scene, tmp_path / "run", progress=False)
    write_run(run, tmp_path / "a.h5")
    areas, late = read_areas(tmp_path / "a.h5"), slice(3 * run.steps // 4, None)
    own = np.asarray(run["flow"])
    found = driven_flow(scene, areas).waveforms["flow"]
    bare = driven_flow(scene.replace(WITHOUT), areas).waveforms["flow"]
    error, without = (np.abs(one - own)[late].max() / np.ptp(own[late]) for one in (found, bare))
    assert error < (0.01 if tubes else 1e-8)
    assert without > 3 * error
    assert without > 0.003


@pytest.mark.slow
@pytest.mark.parametrize("tubes", [False, True])
def test_a_killed_run_is_continued_to_the_bit(phonating: plica.Scene, tmp_path: Path, tubes: bool) -> None:
    assert_resumes_to_the_bit(phonating.replace({**(TUBES if tubes else {}), **INERTIA}), tmp_path, 10)
