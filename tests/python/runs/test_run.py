"""Runs: what is stored, what survives a kill, and that a continued run is the same run."""

from __future__ import annotations

import errno
import os
import random
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

import plica
import stored_files
from interrupted_runs import StopsAfter, assert_identical, kill_after, longer, start, steps_stored
from plica import _engine
from plica.commands.main import main
from plica.runs import checkpoint
from plica.storage.hdf5 import put_text
from plica.storage.stored import Stored


def test_an_occupied_directory_is_left_alone(bar: plica.Scene, tmp_path: Path) -> None:
    plica.run(bar, tmp_path / "run", progress=False)
    before = {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}
    with pytest.raises(
        plica.InvalidInput,
        match=r"already holds a run\. Continue it with --resume \(resume=True\), or use another directory\.",
    ):
        plica.run(bar, tmp_path / "run", progress=False)
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}


@pytest.mark.parametrize("last", [1, 17, 39])
def test_a_step_that_fails_costs_no_step_before_it(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, last: int
) -> None:
    whole = plica.run(bar, tmp_path / "whole", progress=False)
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(last))
    with pytest.raises(plica.SolveFailed, match=f"{last} of 40 steps are kept"):
        plica.run(bar, tmp_path / "run", progress=False)
    monkeypatch.undo()
    run = plica.Run.load(tmp_path / "run")
    assert (run.status, run.steps) == ("failed", last)
    assert run.failure.startswith(f"Step {last + 1} (t = ")
    assert all(np.array_equal(run[name], whole[name][:last]) for name in whole)
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def forget_waveform(directory: Path) -> None:
    """As if an older version had written the run, which did not record this yet."""
    with h5py.File(directory / "results.h5", "r+") as file:
        del file["waveforms/inverted_tissue"]


def forget_first_frame(directory: Path) -> None:
    """As if an older version had written the run, which did not store the state at t = 0."""
    with h5py.File(directory / "results.h5", "r+") as file:
        for name, values in [(name, values[1:]) for name, values in file["fields"].items()]:
            del file[f"fields/{name}"]
            file[f"fields/{name}"] = values


def forget_state(directory: Path) -> None:
    """As if an older version had written the checkpoints, which did not need this yet."""
    held = checkpoint.newest(directory)
    assert held is not None
    for slot in directory.glob("checkpoint-*.h5"):
        slot.unlink()
    state = {name: values for name, values in held.state.items() if name != "depth"}
    without = checkpoint.Checkpoint(held.steps, held.scene, state, held.sums)
    checkpoint.write(directory, without, checkpoint.SLOTS[0])


def forget_digest(directory: Path) -> None:
    """As if an older version had written the checkpoints, which belonged to one duration."""
    held = checkpoint.newest(directory)
    assert held is not None
    for slot in directory.glob("checkpoint-*.h5"):
        slot.unlink()
    other = checkpoint.Checkpoint(held.steps, "0" * 64, held.state, held.sums)
    checkpoint.write(directory, other, checkpoint.SLOTS[0])


def forget_description(directory: Path) -> None:
    """As if an older version had written the checkpoints, an array a data set."""
    for slot in directory.glob("checkpoint-*.h5"):
        stored_files.forget(slot, "description", "state")
        with Stored(slot, "r+") as file:
            put_text(file.file, "scene", "0" * 64)


@pytest.mark.parametrize(
    ("forget", "name"),
    [
        (forget_waveform, "waveforms"),
        (forget_first_frame, "frame at t = 0"),
        (forget_state, "depth"),
        (forget_digest, "checkpoint of this scene"),
        (forget_description, "checkpoint of an earlier"),
    ],
    ids=["waveform", "frame", "state", "digest", "description"],
)
def test_a_run_of_an_older_version_is_not_continued_and_left_alone(
    bar: plica.Scene,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    forget: Callable[[Path], None],
    name: str,
) -> None:
    directory = tmp_path / "run"
    bar.save(tmp_path / "scene.toml")
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(17))
    with pytest.raises(plica.SolveFailed):
        plica.run(bar, directory, progress=False)
    monkeypatch.undo()
    forget(directory)
    before = {path.name: path.read_bytes() for path in directory.iterdir()}
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(directory), "--resume", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert name in said
    assert "version of plica" in said
    assert before == {path.name: path.read_bytes() for path in directory.iterdir()}


def write_cube(path: Path, *, bottom: tuple[int, int] = (11, 11)) -> None:
    """A cube with its tetrahedra labelled 1, the two triangles of its bottom as given, of its top 12."""
    cube = plica.build_mesh(plica.Block(size=(0.01, 0.01, 0.01), divisions=(1, 1, 1)))
    cells = [("tetra", np.asarray(cube.cells))]
    cells += [("triangle", np.concatenate([cube.surfaces["z_min"], cube.surfaces["z_max"]]))]
    labels = [np.ones(len(cells[0][1]), dtype=int), np.array([*bottom, 12, 12])]
    meshio.Mesh(np.asarray(cube.points), cells, cell_data={"label": labels}).write(path)


def on_a_file(file: str) -> plica.Scene:
    return plica.Scene(
        plica.MeshFile(file=file, layers={"body": 1}, surfaces={"bottom": 11, "ends": (11, 12)}),
        {"body": plica.Tissue(E=20e3, nu=0.3)},
        time=plica.Stepping(step=1e-4, duration=2e-3),
        supports=plica.Supports(fixed=["bottom"]),
        initial=plica.Initial(velocity={"body": (0.0, 0.0, 0.1)}),
    )


def test_a_scene_made_in_python_is_continued_from_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_cube(tmp_path / "cube.vtu")
    scene = on_a_file("cube.vtu")
    plica.run(scene, tmp_path / "whole", progress=False)
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(7))
    with pytest.raises(plica.SolveFailed):
        plica.run(scene, tmp_path / "run", progress=False)
    monkeypatch.undo()
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert plica.Run.load(tmp_path / "run").scene == scene
    plica.run(scene, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_a_run_is_not_continued_where_the_surfaces_have_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "cube.vtu"
    write_cube(path)
    scene = on_a_file(str(path))
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(7))
    with pytest.raises(plica.SolveFailed):
        plica.run(scene, tmp_path / "run", progress=False)
    monkeypatch.undo()
    write_cube(path, bottom=(11, 12))
    with pytest.raises(plica.SceneError, match="surfaces are not those of the run"):
        plica.run(scene, tmp_path / "run", progress=False, resume=True)


def test_a_finished_run_is_not_that_of_a_mesh_file_that_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "cube.vtu"
    write_cube(path)
    scene = on_a_file(str(path))
    run = plica.run(scene, tmp_path / "run", progress=False)
    write_cube(path, bottom=(11, 12))
    with pytest.raises(plica.SceneError, match="surfaces are not those of the run"):
        plica.run(scene, tmp_path / "run", progress=False, resume="if_there")
    path.unlink()  # nothing to compare with
    assert plica.run(scene, tmp_path / "run", progress=False, resume="if_there").steps == run.steps


def test_a_first_step_that_fails_leaves_nothing(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(0))
    with pytest.raises(plica.SolveFailed):
        plica.run(bar, tmp_path / "run", progress=False)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("damage", ["cut", "turned", "gone", "both"])
def test_a_damaged_checkpoint_is_passed_over(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    plica.run(bar, tmp_path / "whole", progress=False)
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(35))
    with pytest.raises(plica.SolveFailed):
        plica.run(bar, tmp_path / "run", progress=False)
    monkeypatch.undo()
    slots = sorted((tmp_path / "run").glob("checkpoint-*.h5"))
    assert len(slots) == 2
    held = checkpoint.newest(tmp_path / "run")
    assert held is not None
    assert held.steps == 35
    for slot in slots:
        with h5py.File(slot, "r") as file:
            newest = file["steps"][()] == 35
        if damage == "both":
            slot.write_bytes(b"")
        elif newest:
            content = bytearray(slot.read_bytes())
            if damage == "turned":
                with h5py.File(slot, "r+") as file:
                    file["state"][-1] ^= 1
            elif damage == "cut":
                slot.write_bytes(content[: len(content) // 2])
            else:
                slot.unlink()
    left, damaged = checkpoint.whole(tmp_path / "run")
    assert [one.steps for one in left.values()] == ([] if damage == "both" else [30])
    assert len(damaged) == {"both": 2, "gone": 0}.get(damage, 1)
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert_identical(tmp_path / "run", tmp_path / "whole")


def test_one_process_at_a_time(bar: plica.Scene, tmp_path: Path) -> None:
    from plica.storage.files import only_writer

    (tmp_path / "run").mkdir()
    with only_writer(tmp_path / "run"), pytest.raises(plica.InvalidInput, match="another process"):
        plica.run(bar, tmp_path / "run", progress=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "factor", "moments"), [("bar", 10, 3), ("colliding", 5, 3), ("phonating", 4, 5)]
)
def test_a_killed_run_can_be_read_and_continues_to_identical_results(
    name: str, factor: int, moments: int, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    scene = longer(request.getfixturevalue(name), factor)
    total = scene.time.steps
    scene.save(tmp_path / "scene.toml")
    plica.run(scene, tmp_path / "whole", progress=False)
    whole = plica.Run.load(tmp_path / "whole")
    seed = random.Random(name)
    kills = 0
    for attempt in range(moments):
        directory = tmp_path / f"run{attempt}"
        process = start(tmp_path / "scene.toml", directory)
        kills += kill_after(process, directory, seed.randrange(1, total // 2))
        for _ in range(2):  # a second kill while it is being continued
            if steps_stored(directory) >= 0:
                run = plica.Run.load(directory)
                assert all(np.array_equal(run[name], whole[name][: run.steps]) for name in whole)
                assert np.array_equal(
                    np.asarray(run.displacement), np.asarray(whole.displacement)[: run.frames]
                )
            process = start(tmp_path / "scene.toml", directory, *(["--resume"] if directory.exists() else []))
            kill_after(process, directory, min(total - 1, steps_stored(directory) + seed.randrange(1, 20)))
        last = start(tmp_path / "scene.toml", directory, "--resume")
        _, message = last.communicate()
        assert last.returncode == 0, message
        assert_identical(directory, tmp_path / "whole")
    assert kills == moments  # each at its own moment, in the first half of the run


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_asked_to_stop_keeps_everything(bar: plica.Scene, tmp_path: Path, number: int) -> None:
    scene = longer(bar, 1000)
    scene.save(tmp_path / "scene.toml")
    process = start(tmp_path / "scene.toml", tmp_path / "run")
    kill_after(process, tmp_path / "run", 20, number)
    run = plica.Run.load(tmp_path / "run")
    assert run.status == "interrupted"
    assert 20 <= run.steps < scene.time.steps
    held = checkpoint.newest(tmp_path / "run")
    assert held is not None
    assert held.steps == run.steps


@pytest.mark.slow
def test_a_full_disk_is_one_sentence_and_leaves_nothing(bar: plica.Scene, tmp_path: Path) -> None:
    bar.save(tmp_path / "scene.toml")

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    command = [
        sys.executable,
        "-m",
        "plica.commands.main",
        "run",
        str(tmp_path / "scene.toml"),
        "-o",
        str(tmp_path / "run"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=limit, check=False)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "the results need" in done.stderr
    assert "File too large" in done.stderr
    assert not (tmp_path / "run").exists()


def test_a_file_that_cannot_be_replaced_stays_as_it_was(tmp_path: Path) -> None:
    from plica.storage.files import replaced

    def fill_the_disk(path: Path) -> None:
        path.write_text("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "file"
    path.write_text("old")
    with pytest.raises(plica.StorageFailed, match="file: cannot be written: No space left on device"):
        replaced(path, fill_the_disk)
    assert [(left.name, left.read_text()) for left in tmp_path.iterdir()] == [("file", "old")]


def test_what_was_stored_before_is_spoken_of_only_where_there_is_something(tmp_path: Path) -> None:
    from plica.storage.files import storage_errors

    def message() -> str:
        with pytest.raises(plica.StorageFailed) as failed, storage_errors(tmp_path / "measures.json"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return str(failed.value)

    assert message().endswith("No space left on device.")
    (tmp_path / "results.h5").touch()
    assert message().endswith("Earlier results are kept and can be continued.")


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_directory_that_cannot_be_written_is_one_sentence(bar: plica.Scene, tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(plica.StorageFailed, match="Permission denied"):
        plica.run(bar, tmp_path / "closed" / "run", progress=False)
