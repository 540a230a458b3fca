"""What a run stores, and how it is read."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import h5py
import numpy as np
import pytest

import plica
from plica.measures.file import write_measures
from plica.measures.run.measure import measure


def test_a_run_stores_every_step_and_the_frames_asked_for(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    assert (run.status, run.steps, run.frames) == ("finished", 40, 9)
    np.testing.assert_allclose(run.time, 1e-4 * np.arange(1, 41), rtol=1e-12)
    np.testing.assert_allclose(run.fields["time"], 5e-4 * np.arange(9), rtol=1e-12)
    assert run.displacement.shape == (9, len(run.mesh.points), 3)
    probe = np.argmin(((run.mesh.points - [0.01, 0, 0]) ** 2).sum(axis=1))
    stored = run.displacement[:, probe]
    assert np.abs(stored).max() > 1e-6
    # the fields are stored in single precision
    np.testing.assert_allclose(stored[1:], run["probes"][4::5, 0], rtol=1e-6, atol=1e-12)
    assert not stored[0].any()
    np.testing.assert_array_equal(np.asarray(run.displacement)[-1], run.displacement[-1])
    assert run.scene == bar
    assert run.units["kinetic_energy"] == "J"
    assert not any(np.isnan(values).any() for values in run.values())


def test_a_loaded_run_is_the_run(bar: plica.Scene, tmp_path: Path) -> None:
    made = plica.run(bar, tmp_path / "run", progress=False)
    loaded = plica.Run.load(tmp_path / "run")
    assert set(loaded) == set(made)
    assert all(np.array_equal(loaded[name], made[name]) for name in made)
    assert plica.Scene.load(tmp_path / "run" / "scene.toml") == bar


def test_a_run_says_which_contact_solver_it_took(
    bar: plica.Scene, colliding: plica.Scene, tmp_path: Path
) -> None:
    assert "contact solver" not in plica.run(bar, tmp_path / "bar", progress=False).versions
    for asked, taken in {"auto": "condensed", "saddle": "saddle"}.items():
        data = colliding.resolved()
        data["contact"]["multipliers"]["solver"] = asked
        run = plica.run(plica.Scene.model_validate(data), tmp_path / asked, progress=False)
        assert run.versions["contact solver"] == taken


def test_without_fields_there_are_none(bar: plica.Scene, tmp_path: Path) -> None:
    scene = plica.Scene.from_text(bar.text().replace("every = 0.0005", ""))
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert run.fields == {}
    assert not (tmp_path / "run" / "fields.xdmf").exists()
    with pytest.raises(plica.InvalidInput, match=r"output\.every"):
        run.displacement  # noqa: B018
    with h5py.File(run.path, "r") as file:
        assert set(file) == {"checksums", "mesh", "plica_version", "progress", "scene", "waveforms"}


def test_fields_can_begin_late(bar: plica.Scene, tmp_path: Path) -> None:
    scene = plica.Scene.from_text(bar.text().replace("start = 0.0", "start = 0.003"))
    run = plica.run(scene, tmp_path / "run", progress=False)
    np.testing.assert_allclose(run.fields["time"], [3e-3, 3.5e-3, 4e-3], rtol=1e-12)


def test_the_first_frame_is_the_state_at_the_start(phonating: plica.Scene, tmp_path: Path) -> None:
    opened = phonating.replace({"initial": plica.Initial(opening_displacement="0.3 mm")})
    run = plica.run(opened, tmp_path / "run", progress=False)
    simulation = plica.build_simulation(opened)
    np.testing.assert_array_equal(run.fields["time"][:2], [0.0, 2e-4])
    first = np.asarray(simulation.displacement, dtype=np.float32)
    assert np.abs(first).max() == pytest.approx(0.3e-3, rel=0.3)
    np.testing.assert_array_equal(run.displacement[0], first)
    assert not run.fields["contact_pressure"][0].any()
    grid = ElementTree.parse(tmp_path / "run" / "fields.xdmf").find(".//Grid[@Name='frame 0']/Time")
    assert grid is not None
    assert grid.get("Value") == "0"


def test_a_table_of_the_waveforms_has_a_row_a_step_without_probes(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    assert run["probes"].shape == (40, 0, 3)
    data = run.to_xarray()
    assert set(data) == set(run) - {"time", "probes", "inverted_by_layer"}
    assert len(data[["flow", "kinetic_energy"]].to_dataframe()) == 40
    assert len(data.to_dataframe()) == 40 * len(run.section_height) * 3


def test_what_was_measured_while_a_run_went_on_is_not_taken_for_its_measures(
    bar: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    half = measure(run.between(None, 0.5 * float(run.time[-1])))
    write_measures(half, tmp_path / "run" / "measures.json")
    assert half["steps"].value != run.steps
    assert plica.Run.load(tmp_path / "run").measures == measure(run)


def test_a_waveform_that_is_not_there_is_answered_with_the_nearest(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    with pytest.raises(KeyError) as missing:
        run["prbes"]
    assert isinstance(missing.value, plica.InvalidInput)
    assert str(missing.value).startswith(f'Run {tmp_path / "run"}: "prbes"; must be one of ')
    assert str(missing.value).endswith(' Did you mean "probes"?')
    assert all(name in str(missing.value) for name in run)
    assert run.get("flow") is None
    assert "flow" not in run
    for named in (run.waveforms, run.units, run.between().waveforms):
        with pytest.raises(plica.InvalidInput, match=r'"prbes"; must be one of .* Did you mean "probes"\?'):
            named["prbes"]
    with pytest.raises(plica.InvalidInput, match=r'"displacment"; must be .* Did you mean "displacement"\?'):
        run.fields["displacment"]


def test_an_xarray_has_the_waveforms_with_units(phonating: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(phonating, tmp_path / "run", progress=False)
    data = run.to_xarray()
    assert data["flow"].dims == ("time",)
    assert data["section_area"].dims == ("time", "section")
    assert data["coronal_left"].dims == ("time", "section", "component")
    assert data["contact_force_first"].dims == ("time", "component")
    assert data["flow"].attrs["units"] == "m^3/s"
    np.testing.assert_array_equal(data["section"], run.section_height)
    assert np.abs(run["flow"]).max() > 0


def test_steps_whose_coupling_does_not_converge_are_kept_and_counted(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    text = (
        phonating.replace({"airflow.model": "bernoulli"}).text().replace("max_sweeps = 40", "max_sweeps = 2")
    )
    scene = plica.Scene.from_text(text.replace("freeze_after = 8", "freeze_after = 1"))
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert (run.status, run.steps) == ("finished", 40)
    converged, frozen = run["coupling_converged"] == 1, run["coupling_frozen"] == 1
    assert 0 < converged.sum() < 40
    np.testing.assert_array_equal(converged, run["coupling_residual"] <= 1e-5)
    np.testing.assert_array_equal(frozen, run["coupling_sweeps"] == 2)
    assert frozen[~converged].all()
    assert run.measures["coupling_converged_fraction"].value == pytest.approx(converged.mean())
    assert run.measures["coupling_frozen_fraction"].value == pytest.approx(frozen.mean())


def test_measures_are_not_taken_from_a_file_beside_the_run(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    wrong = {name: entry | {"value": 3} for name, entry in run.measures.as_json().items()}
    (tmp_path / "run" / "measures.json").write_text(json.dumps(wrong))
    assert plica.Run.load(tmp_path / "run").measures == run.measures
    with pytest.raises(plica.InvalidInput, match=r'"f0"; must be one of '):
        run.measures["f0"]


def test_paraviews_index_points_at_what_is_there(colliding: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(colliding, tmp_path / "run", progress=False)
    tree = ElementTree.parse(tmp_path / "run" / "fields.xdmf")
    grids = tree.findall(".//Grid[@GridType='Collection']/Grid")
    assert len(grids) == run.frames == 11
    with h5py.File(run.path, "r") as file:
        for item in tree.iter("DataItem"):
            if item.get("Format") == "HDF":
                name = (item.text or "").split(":")[1]
                assert file[name].shape == tuple(int(extent) for extent in item.get("Dimensions", "").split())
    assert {item.get("Name") for item in grids[0].findall("Attribute")} == {
        "displacement",
        "contact_pressure",
        "cell_layer",
        "cell_side",
    }
