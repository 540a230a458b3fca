"""Where a step fails: what is raised, and what it says went wrong first."""

from __future__ import annotations

import errno
import pickle
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica import _engine
from plica.commands.main import main


def test_a_step_that_diverges_has_failed(phonating: plica.Scene) -> None:
    simulation = plica.build_simulation(plica.Scene(**{**dict(phonating), "contact": None}))
    simulation.set_external_force(np.full_like(simulation.displacement, 1e300))  # finite; what it does is not
    with pytest.raises(plica.SolveFailed, match=r"Step 1 \(t = 5e-05 s\): "):
        simulation.advance(3)


@pytest.mark.parametrize("symmetry", [None, "quarter"])
def test_a_state_with_another_velocity_is_refused_until_its_products_are_renewed(
    phonating: plica.Scene, symmetry: str | None
) -> None:
    scene = phonating.replace({"symmetry": symmetry})
    simulation = plica.build_simulation(scene)
    simulation.advance(3)
    state = simulation.state()
    simulation.restore(state)
    kicked = {**state, "velocity": 1.25 * state["velocity"]}
    with pytest.raises(plica.InvalidInput, match=r"stiffness_velocity from K v = 0\.2 of it; .*renewed"):
        simulation.restore(kicked)
    whole = simulation.renewed(kicked)
    assert np.array_equal(whole["velocity"], kicked["velocity"])
    assert whole["kinetic"] == pytest.approx(1.25**2 * state["kinetic"])
    simulation.restore(whole)
    simulation.advance(1)


@pytest.mark.parametrize("part", ["flow_load", "supplied_power", "flow_work", "air_supplied_energy"])
def test_a_state_from_before_the_airflow_had_its_share_is_refused(phonating: plica.Scene, part: str) -> None:
    simulation = plica.build_simulation(phonating)
    simulation.advance(1)
    state = simulation.state()
    del state[part]
    with pytest.raises(plica.InvalidInput, match=f'state lacks "{part}"; it must be one that state'):
        simulation.restore(state)


MEANS = plica.Contact(multipliers=plica.Multipliers(), faces="mortar", max_passes=50)
"""No nodes to hold apart from those they face where passes fail, after a quarter of the usual ones."""


def failing(scene: plica.Scene, case: str) -> plica.Scene:
    """The larynx where it folds over itself, and contact of means finds no solution later."""
    fields = dict(scene)
    fields["contact"] = MEANS
    if case.startswith("25 kPa"):
        fields["airflow"] = plica.Airflow(subglottal_pressure="25 kPa")
    if case == "ten times softer":
        fields["initial"] = plica.Initial(opening_velocity=-2.0)
        fields["tissue"] = {
            layer: plica.Tissue.model_validate(
                tissue.model_dump(exclude_none=True)
                | {name: 0.1 * getattr(tissue, name) for name in ("E", "E_fibre", "mu_fibre")}
            )
            for layer, tissue in scene.tissue.items()
        }
    if case == "25 kPa, quadratic":
        fields["mesh"] = scene.mesh.replace({"order": 2})
    return plica.Scene(**fields)


@dataclass(frozen=True)
class Failed:
    """A larynx advanced one step at a time until it failed, and its state where tissue folded first."""

    scene: plica.Scene
    steps: list[dict[str, Any]]
    error: plica.StepFailed
    first: int
    state: dict[str, Any]
    displacement: np.ndarray


def failed(scene: plica.Scene) -> Failed:
    simulation = plica.build_simulation(scene)
    steps: list[dict[str, Any]] = []
    first: tuple[Any, ...] = ()
    while True:
        try:
            steps.append(simulation.advance(1))
        except plica.StepFailed as error:
            return Failed(scene, steps, error, *first)
        if not first and steps[-1]["inverted_tissue"][0]:
            first = simulation.step_count, simulation.state(), simulation.displacement.copy()


@pytest.fixture(scope="module")
def driven(phonating: plica.Scene) -> Failed:
    return failed(failing(phonating, "25 kPa"))


def test_advance_raises_at_once_and_hands_over_the_steps_before(driven: Failed) -> None:
    steps, alone = driven.steps, driven.error
    at_once = plica.build_simulation(driven.scene)
    assert len(steps) > 10
    with pytest.raises(plica.SolveFailed) as together:
        at_once.advance(200)
    assert str(together.value) == str(alone)
    assert isinstance(together.value, plica.StepFailed)
    kept = together.value.waveforms
    assert set(kept) == set(steps[0])
    for name, values in kept.items():
        assert np.array_equal(values, np.concatenate([step[name] for step in steps]), equal_nan=True)
    assert at_once.step_count == len(steps)
    assert len(alone.waveforms["time"]) == 0
    again = pickle.loads(pickle.dumps(together.value))
    assert str(again) == str(together.value)
    assert np.array_equal(again.waveforms["time"], kept["time"])


@pytest.mark.parametrize(
    "case",
    ["25 kPa", "ten times softer", pytest.param("25 kPa, quadratic", marks=pytest.mark.slow)],
)
def test_a_failure_names_the_first_folded_tissue_and_when_also_after_a_resume(
    phonating: plica.Scene, driven: Failed, case: str
) -> None:
    one = driven if case == "25 kPa" else failed(failing(phonating, case))
    mesh = plica.build_mesh(one.scene.mesh)
    x = np.asarray(mesh.points) + one.displacement
    cells = np.asarray(mesh.cells)
    resumed = plica.build_simulation(one.scene, mesh)
    resumed.restore(one.state)
    with pytest.raises(plica.SolveFailed) as failure:
        resumed.advance(200)
    assert resumed.step_count == len(one.steps) > one.first  # long before
    message = str(one.error)
    assert str(failure.value) == message
    assert f"First sign: at t = {one.first * 5e-5:g} s " in message
    found = re.search(
        r"(\d+) of (\d+) tissue cells folded, the first cell (\d+) at \((\S+), (\S+), (\S+)\) m; "
        r"(\d+) are now",
        message,
    )
    assert found is not None
    number, every, cell, *place, now = found.groups()
    assert int(every) == len(cells)
    if cells.shape[1] == 4:
        inverted = np.flatnonzero(_engine.signed_volumes(x, cells) <= 0)
        assert (int(number), int(cell)) == (len(inverted), inverted[0])
    assert np.array(place, float) == pytest.approx(x[cells[int(cell), :4]].mean(0), rel=1e-5)
    assert int(now) == int(failure.value.waveforms["inverted_tissue"][-1])


def test_cautions_are_given_only_for_a_scene_that_runs(
    phonating: plica.Scene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    scene = phonating.replace({"airflow.subglottal_pressure": 1.0, "time.duration": 1e-4})

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "")

    with monkeypatch.context() as patch:
        patch.setattr("plica.storage.files.os.posix_fallocate", full)
        with pytest.raises(plica.StorageFailed, match="No space left"):
            plica.run(scene, tmp_path / "run")
    assert capsys.readouterr().err == ""
    with pytest.warns(plica.CautionWarning, match="airflow.subglottal_pressure = 1 Pa"):
        plica.run(scene, tmp_path / "run")


@pytest.mark.parametrize(("pressure", "there"), [("1e9 Pa", False), ("60 kPa", True)])
def test_a_failure_leads_to_what_is_implausible_in_the_scene_before_the_step(
    phonating: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str], pressure: str, there: bool
) -> None:
    """In the first step, before anything is stored, and later."""
    scene = phonating.replace(
        {"airflow.subglottal_pressure": pressure, "time.duration": "10 ms", "contact": MEANS}
    )
    scene.save(tmp_path / "scene.toml")
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "run"), "--quiet"]) == 1
    *_, last = capsys.readouterr().err.splitlines()
    assert (tmp_path / "run").exists() == there
    caution = r"airflow\.subglottal_pressure = \S+ Pa\. .* 200 Pa to 4 kPa\."
    assert re.search(rf"Step \d+ .* First check the scene: {caution}$", last)


def test_a_scene_that_was_in_the_directory_outlives_a_first_step_that_fails(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    scene = phonating.replace({"airflow.subglottal_pressure": "1e9 Pa", "contact": MEANS})
    scene.save(tmp_path / "scene.toml")
    with pytest.raises(plica.SolveFailed, match=r"Step 1 "):
        plica.run(scene, tmp_path, progress=False, resume=True)
    assert plica.Scene.load(tmp_path / "scene.toml") == scene
    assert not (tmp_path / "results.h5").exists()
