"""What ``plica identify`` keeps of an estimate that was begun, and with what it goes on."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plica
from flow_files import PAIRS, SETTINGS, SHAPE, block_scene, flow_file
from plica.commands.main import main
from plica.identify import Iteration, Settings, identify, load
from plica.identify.estimator.iterates import EstimateInputs, Iterates
from plica.identify.estimator.progress import EstimateProgress


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """An identification that stopped after its first iteration."""
    source = flow_file(tmp_path / "flow.h5")
    with pytest.raises(plica.SolveFailed, match="after 1 iterations"):
        identify(source, block_scene(), tmp_path / "out", _one(), progress=False)
    return tmp_path


def _one(**changes: Any) -> Settings:
    return Settings(**SETTINGS | {"max_iterations": 1} | changes)


def test_what_was_begun_continues_with_the_same_alone(begun: Path) -> None:
    source, out = begun / "flow.h5", begun / "out"
    kept = (out / "iterates.json").read_bytes()

    def text(recording: Path, scene: plica.Scene, settings: Settings, resume: bool = True) -> str:
        with pytest.raises(plica.InvalidInput) as found:
            identify(recording, scene, out, settings, resume=resume, progress=False)
        return str(found.value)

    assert "already holds an identification. Continue it with --resume" in text(
        source, block_scene(), _one(), resume=False
    )
    softer = block_scene().replace({"tissue.body.nu": 0.3})
    assert "was started with scene: tissue.body.nu = 0.4, now 0.3; must be" in text(source, softer, _one())
    other = flow_file(begun / "other.h5", flow=0.5 * np.ones((PAIRS, *SHAPE, 2)))
    assert "was started with another recording" in text(other, block_scene(), _one())
    assert "was started with log_sd = 0.7, now 0.5" in text(source, block_scene(), _one(log_sd=0.5))
    parameters = ({"targets": "body.E", "log_sd": 0.4},)
    both = text(source, block_scene(), _one(max_iterations=2, parameters=parameters))
    assert "parameters[0].log_sd = none, now 0.4; max_iterations = 1, now 2; must be" in both
    with pytest.raises(plica.InvalidInput, match="has not finished"):
        load(out)
    assert (out / "iterates.json").read_bytes() == kept
    (out / "iterates.json").write_text(json.dumps({"marks": {}}))
    assert "must be as plica wrote it. It is damaged, was edited" in text(source, block_scene(), _one())


def test_the_last_point_of_each_start_is_kept(begun: Path) -> None:
    first = json.loads((begun / "out" / "iterates.json").read_text())["points"]["scene"][0]
    kept = Iterates(begun / "iterates.json", EstimateInputs({}, {}, None, ""), {"scene": [first]})
    assert first["start"] == 1
    for number, (start, x) in enumerate([(1, first["point"][0]), (1, 2.0), (2, 3.0), (2, 4.0), (1, 2.0)]):
        kept.add("scene", Iteration(number, -1.0, np.array([x]), 0.1, start=start))
    assert {start: list(point) for start, point in kept.last("scene").items()} == {1: [2.0], 2: [4.0]}
    stored = json.loads((begun / "iterates.json").read_text())["points"]["scene"]
    assert [(p["number"], p["start"]) for p in stored] == [(0, 1), (1, 1), (2, 2), (3, 2)]


def test_fewer_starts_than_it_was_begun_with_are_refused(begun: Path) -> None:
    with pytest.raises(plica.InvalidInput, match=r"was started with starts = 3, now 2; must be the same"):
        identify(begun / "flow.h5", block_scene(), begun / "out", _one(starts=2), resume=True, progress=False)


@pytest.mark.slow
def test_ctrl_c_says_what_is_kept_and_the_command_that_continues(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    flow_file(tmp_path / "flow.h5")
    block_scene().save(tmp_path / "scene.toml")
    chosen = 'surface = "x_max"\nseen = "z_max"\nfrom_rest = true\nspacing = 8.0\nparameters = ["body.E"]'
    (tmp_path / "set.toml").write_text(f'[identify]\ncoarser = "none"\n{chosen}\n')
    monkeypatch.chdir(tmp_path)
    command = ["identify", "flow.h5", "--scene", "scene.toml", "-o", "my tissue", "--settings", "set.toml"]
    add = Iterates.add

    def stopped(self: Iterates, mesh: str, at: Iteration) -> None:
        add(self, mesh, at)
        if at.number == 1:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Iterates, "add", stopped)
        assert main([*command, "--quiet"]) == 130
    again = "identify --resume flow.h5 --scene scene.toml -o 'my tissue' --settings set.toml --quiet"
    assert capsys.readouterr().err == (
        "plica: stopped. Kept in my tissue/iterates.json: 2 points of 1 start on the scene's mesh. "
        f"Continue with --resume: plica {again}\n"
    )
    assert main(shlex.split(again)) == 0
    assert (tmp_path / "my tissue" / "report.html").exists()


@pytest.mark.slow
def test_points_of_all_starts_are_stored_with_their_number(tmp_path: Path) -> None:
    """A flow that no block makes: its residuals fail, and it is begun again."""
    source = flow_file(tmp_path / "flow.h5")
    found = identify(source, block_scene(), tmp_path / "out", Settings(**SETTINGS), progress=False)
    kept = json.loads((tmp_path / "out" / "iterates.json").read_text())["points"]["scene"]
    assert found.posterior.starts == 2
    assert set(found.starts) == {1, 2}
    assert found.starts.tolist() == [point["start"] for point in kept]
    assert found.iterations.tolist() == [[point["value"], point["step"]] for point in kept]


def test_what_is_kept_is_reported_for_both_meshes(tmp_path: Path) -> None:
    kept = Iterates(tmp_path / "iterates.json", EstimateInputs({}, {}, None, ""))
    with pytest.raises(KeyboardInterrupt, match=r"^$"), kept.listed_on_interrupt():
        raise KeyboardInterrupt
    for mesh, start in (("coarser", 1), ("coarser", 2), ("coarser", 0), ("scene", 1)):
        kept.add(mesh, Iteration(0, -1.0, np.array([float(start)]), 0.1, start=start))
    kept.end("coarser", np.array([1.0]))
    message = (
        "2 points of 2 starts on the coarser mesh, which has finished; "
        "1 point of 1 start on the scene's mesh$"
    )
    with pytest.raises(KeyboardInterrupt, match=message), kept.listed_on_interrupt():
        raise KeyboardInterrupt


def test_what_is_reported_for_an_estimate_while_it_runs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = iter([0.0, 12.0, 24.0, 36.0, 48.0, 60.0])
    clock = SimpleNamespace(monotonic=lambda: next(now))
    monkeypatch.setattr("plica.identify.estimator.progress.time", clock)
    progress = EstimateProgress("735 unknowns")
    for number, (value, start) in enumerate([(5.0, 1), (9.0, 1), (7.0, 2), (20.0, 0), (18.5, 0)]):
        progress(Iteration(number, value, np.zeros(1), 0.1, start=start))
    assert capsys.readouterr().err.splitlines() == [
        "plica: 735 unknowns: first sweep",
        "plica: 735 unknowns: iteration 0, log density 5, step 0.1 sd, 12 s",
        "plica: 735 unknowns: about 12 s per iteration, usually 60 s to 4 min per start",
        "plica: 735 unknowns: iteration 1, log density 9, step 0.1 sd, 24 s",
        "plica: 735 unknowns: start 2, iteration 2, log density 7, step 0.1 sd, 36 s",
        "plica: 735 unknowns: with the learned error, iteration 3, log density 20, step 0.1 sd, 48 s",
        "plica: 735 unknowns: with the learned error, iteration 4, log density 18.5 (1.5 lower than before: "
        "the flow's error was learned again), step 0.1 sd, 60 s",
    ]


def test_nothing_continues_where_nothing_was_begun(tmp_path: Path) -> None:
    source = flow_file(tmp_path / "flow.h5")
    with pytest.raises(plica.InvalidInput, match="there is no identification to continue"):
        identify(source, block_scene(), tmp_path / "out", _one(), resume=True, progress=False)
    with pytest.raises(plica.InvalidInput, match="must be the directory of an identification"):
        load(tmp_path)


def test_results_are_not_written_over_a_file(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a letter")
    with pytest.raises(plica.InvalidInput, match="out: is a file; must be a directory"):
        identify(flow_file(tmp_path / "flow.h5"), block_scene(), tmp_path / "out", _one(), progress=False)
    assert (tmp_path / "out").read_text() == "a letter"
