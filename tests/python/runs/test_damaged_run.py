"""A run whose files are damaged raises one clear error, or is what it was, to the bit."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.errors import StorageFailed
from plica.runs import checkpoint
from stored_files import DAMAGES, damaged


def content(directory: Path) -> dict[str, Any]:
    """All that a program reads of a run."""
    run = plica.Run.load(directory)
    found: dict[str, Any] = {
        "progress": (run.steps, run.frames, run.seconds, run.status, run.failure),
        "scene": run.scene_text,
        "versions": run.versions,
        "units": run.units,
        "measures": repr(run.measures),
        "layers": run.mesh.layer_names,
        "sections": run.section_height.tobytes() + run.section_major.tobytes(),
    }
    for kind in ("surfaces", "node_sets"):
        found |= {f"{kind}/{name}": values.tobytes() for name, values in getattr(run.mesh, kind).items()}
    for name in ("points", "cells", "cell_layer", "cell_side"):
        found[name] = getattr(run.mesh, name).tobytes()
    found |= {name: values.tobytes() for name, values in run.waveforms.items()}
    found |= {f"fields/{name}": np.asarray(values).tobytes() for name, values in run.fields.items()}
    return found


def outcome(directory: Path, whole: dict[str, Any]) -> str:
    """Of reading it: refused, or the same."""
    try:
        found = content(directory)
    except (plica.InvalidInput, StorageFailed) as error:
        said = str(error)
    else:
        assert found == whole
        return "same"
    assert str(directory) in said
    assert "\n" not in said
    return "refused"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("made") / "run"


@pytest.fixture
def finished(made: Path, phonating: plica.Scene) -> Path:
    """A voice of 12 steps with fields; tests restore what they change."""
    if not made.exists():
        plica.run(phonating.replace({"time.duration": "0.6 ms"}), made, progress=False)
    return made


@pytest.mark.parametrize("kind", DAMAGES)
def test_a_damaged_result_file_is_refused_or_reads_the_same(finished: Path, kind: str) -> None:
    path = finished / "results.h5"
    bytes_whole, whole = path.read_bytes(), content(finished)
    assert outcome(finished, whole) == "same"
    try:
        found = []
        for bad in damaged(bytes_whole, kind, 12):
            path.write_bytes(bad)
            found.append(outcome(finished, whole))
        assert "refused" in found
    finally:
        path.write_bytes(bytes_whole)


def test_a_damaged_waveform_is_named(finished: Path) -> None:
    path = finished / "results.h5"
    bytes_whole = path.read_bytes()
    flow = plica.Run.load(finished)["flow"].tobytes()
    at = bytes_whole.index(flow)
    try:
        path.write_bytes(bytes_whole[:at] + bytes([bytes_whole[at] ^ 1]) + bytes_whole[at + 1 :])
        run = plica.Run.load(finished)
        with pytest.raises(plica.InvalidInput, match=r"results\.h5: waveforms/flow is damaged"):
            run["flow"]
        assert run.mesh.points.size  # what is whole can be read
        assert run.displacement[0].size
    finally:
        path.write_bytes(bytes_whole)


@pytest.mark.slow
@pytest.mark.parametrize("kind", DAMAGES)
@pytest.mark.parametrize("file", ["results.h5", "checkpoint-a.h5", "checkpoint-b.h5", "scene.toml"])
def test_a_run_goes_on_from_damaged_files_to_the_same_bits_or_not_at_all(
    bar: plica.Scene, tmp_path: Path, kind: str, file: str
) -> None:
    plica.run(bar.replace({"time.duration": "2.5 ms"}), tmp_path / "begun", progress=False)
    plica.run(bar, tmp_path / "whole", progress=False)
    whole = content(tmp_path / "whole")
    del whole["progress"]
    for bad in damaged((tmp_path / "begun" / file).read_bytes(), kind, 6):
        shutil.rmtree(tmp_path / "run", ignore_errors=True)
        shutil.copytree(tmp_path / "begun", tmp_path / "run")
        (tmp_path / "run" / file).write_bytes(bad)
        try:
            plica.run(bar, tmp_path / "run", progress=False, resume=True)
        except (plica.InvalidInput, StorageFailed) as error:
            said = str(error)
        else:
            said = ""
            found = content(tmp_path / "run")
            assert {name: found[name] for name in whole} == whole
        assert "mesh changed" not in said


def test_the_checkpoint_that_a_run_goes_on_from_is_not_the_first_to_be_replaced(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plica.run(bar.replace({"time.duration": "2.5 ms"}), tmp_path / "run", progress=False)
    before, _ = checkpoint.whole(tmp_path / "run")
    (newest, held), (older, kept) = before.items()
    path = tmp_path / "run" / "results.h5"
    content = path.read_bytes()
    row = plica.Run.load(tmp_path / "run")["kinetic_energy"][kept.steps : held.steps].tobytes()
    at = content.index(row)
    path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
    written = []
    monkeypatch.setattr(checkpoint, "write", lambda _, one, slot: written.append((slot, one.steps)))
    plica.run(bar, tmp_path / "run", progress=False, resume=True)
    assert written[0][0] == newest  # whose steps are damaged; the older one is what is left
    assert written[0][1] > kept.steps
    assert {slot for slot, _ in written} == {newest, older}
