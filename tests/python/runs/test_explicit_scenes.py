"""Scenes by central differences: with airflow and contact, resumed, on two threads, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica import _engine as engine
from plica.identify.state_space.scene_evolution import scene_evolution
from plica.verify.dynamics.bits import differing

STEP, STEPS = 4e-7, 500


def explicit(scene: plica.Scene, steps: int = STEPS, **changes: Any) -> plica.Scene:
    return scene.replace(
        {
            "time.scheme": "central_differences",
            "time.step": STEP,
            "time.duration": steps * STEP,
            "output.every": STEP,
            "output.checkpoint_every": STEP * 10,
            **changes,
        }
    )


@pytest.fixture
def voiced(phonating: plica.Scene) -> plica.Scene:
    """Folds that come together at once."""
    return explicit(
        phonating,
        contact=plica.Contact(penalty=plica.Penalty(stiffness=20.0)),
        initial={"opening_velocity": -3.0},
    )


def test_it_is_the_motion_that_hht_converges_to(phonating: plica.Scene) -> None:
    one = explicit(phonating.replace({"contact": None}))
    waves = plica.build_simulation(one).advance(STEPS)
    other = one.replace({"time.scheme": "hht", "time.mass": "lumped", "solver.tolerance": 1e-12})
    expected = plica.build_simulation(other).advance(STEPS)
    for name in ("flow", "kinetic_energy", "elastic_energy", "flow_work", "viscous_loss"):
        largest = np.abs(expected[name]).max()
        assert largest > 0
        # Both are of order 2: what is left is the two schemes' errors at this step.
        np.testing.assert_allclose(waves[name], expected[name], rtol=0, atol=2e-3 * largest, err_msg=name)


def test_a_coupling_has_nothing_to_iterate(phonating: plica.Scene) -> None:
    found = [
        plica.build_simulation(
            explicit(phonating, 50, contact=None, **{"airflow.coupling": coupling})
        ).advance(50)
        for coupling in ("iterated", "extrapolated", "lagged")
    ]
    assert differing(found[0], found[1]) == 0
    assert differing(found[0], found[2]) > 0
    assert np.asarray(found[0]["coupling_residual"]).max() == 0
    assert np.asarray(found[2]["coupling_residual"])[1:].min() > 0


def test_threads_and_restarts_change_no_bit(voiced: plica.Scene) -> None:
    before = engine.threads()
    try:
        plica.set_threads(1)
        whole = plica.build_simulation(voiced)
        waves = whole.advance(STEPS)
        plica.set_threads(2)
        first = plica.build_simulation(voiced)
        first.advance(STEPS // 2)
        second = plica.build_simulation(voiced)
        second.restore(first.state())
        rest = second.advance(STEPS - STEPS // 2)
    finally:
        plica.set_threads(before)
    expected = {name: np.asarray(values)[STEPS // 2 :] for name, values in waves.items()}
    assert np.asarray(expected["contact_rows"]).max() > 0
    assert differing(expected, rest) == 0
    assert differing(whole.state(), second.state()) == 0
    energy = waves["kinetic_energy"] + waves["elastic_energy"]
    assert np.abs(waves["energy_balance_error"]).max() < 1e-10 * energy.max()


def test_a_run_is_stored_resumed_and_reported_like_any_other(bar: plica.Scene, tmp_path: Any) -> None:
    scene = explicit(bar, 40, **{"time.step": 1e-5, "time.duration": 4e-4, "output.every": 1e-5})
    run = plica.run(scene, tmp_path / "run")
    assert len(run.waveforms["time"]) == 40
    longer = scene.replace({"time.duration": 8e-4})
    again = plica.run(longer, tmp_path / "run", resume="if_there")
    whole = plica.run(longer, tmp_path / "whole")
    np.testing.assert_array_equal(again.waveforms["elastic_energy"], whole.waveforms["elastic_energy"])


def test_a_finer_mesh_on_which_the_step_is_too_long_says_what_to_do(bar: plica.Scene, tmp_path: Path) -> None:
    step = 1.4e-4  # stable on the run's mesh, but on no finer one
    changes = {"output.every": None, "output.checkpoint_every": "1 s", "tissue.body.viscosity": 0}
    scene = explicit(bar, **{"time.step": step, "time.duration": 20 * step, **changes})
    plica.run(scene, tmp_path / "run", progress=False)
    found = plica.estimate_uncertainty(tmp_path / "run", progress=False)
    assert [level["kind"] for level in found.levels] == ["step", "step"]
    message = "\n".join(found.remarks)
    assert "time.step = 0.00014 s; must be <= " in message
    assert "run the scene again with that step" in message
    assert "none of the meshes can be used" in message
    assert "--budget" not in message


def test_masses_are_lumped_unless_said_otherwise(bar: plica.Scene) -> None:
    lumped = {"time.mass": "lumped"}
    scenes = (bar, bar.replace(lumped), explicit(bar), explicit(bar, **lumped))
    assert [scene.time.lumped_mass for scene in scenes] == [False, True, True, True]
    waves = [plica.build_simulation(scene).advance(5)["kinetic_energy"] for scene in scenes]
    np.testing.assert_array_equal(waves[2], waves[3])
    assert (waves[0] != waves[1]).all()


def test_the_scene_says_what_it_needs(bar: plica.Scene) -> None:
    with pytest.raises(
        plica.SceneError, match=r'time\.mass = "?consistent"?; must be "lumped" with time\.scheme\.central'
    ):
        bar.replace({"time.scheme": "central_differences", "time.mass": "consistent"})
    with pytest.raises(
        plica.SceneError, match=r": time\.step = 0\.0001 s; must be <= \S+ s\. Central differences"
    ):
        plica.build_simulation(bar.replace({"time.scheme": "central_differences", "tissue.body.E": "2 MPa"}))
    with pytest.raises(
        plica.InvalidInput, match=r"time\.scheme = central_differences; must be hht or newmark"
    ):
        scene_evolution(explicit(bar))


def test_a_reduction_is_refused(bar: plica.Scene) -> None:
    with pytest.raises(
        plica.SceneError, match=r"reduction: must be left out with time\.scheme\.central_differences"
    ):
        explicit(bar, reduction={"basis": "basis.h5"})
