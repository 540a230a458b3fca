"""Waveforms as a table of text."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import plica
from plica.commands.main import main
from plica.storage.table import heading, write_table


def columns(path: Path) -> dict[str, list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return {name: list(values) for name, *values in zip(*csv.reader(file), strict=True)}


def test_numbers_read_back_to_the_same_bits_and_what_is_none_is_empty(tmp_path: Path) -> None:
    values = np.array([0.1, 1 / 3, np.nan, -5e-324, np.inf])
    count = np.array([0, 1, -1, 2, 3], dtype=np.int8)
    write_table(tmp_path / "t.csv", {heading("flow", "m^3/s"): values, heading("sweeps", "1"): count})
    read = columns(tmp_path / "t.csv")
    assert list(read) == ["flow (m^3/s)", "sweeps"]
    assert read["flow (m^3/s)"][2] == ""
    again = np.array([float(text or "nan") for text in read["flow (m^3/s)"]])
    assert again.tobytes() == values.tobytes()
    assert read["sweeps"] == ["0", "1", "-1", "2", "3"]


@pytest.mark.slow
def test_a_run_ends_with_a_table_of_its_waveforms(phonating: plica.Scene, tmp_path: Path) -> None:
    probed = phonating.replace(
        {"output.probes": [(0.0, 0.0, 0.0), ("5 mm", 0.0, 0.0)], "time.duration": "0.5 ms"}
    )
    probed.save(tmp_path / "s.toml")
    assert main(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"]) == 0
    run = plica.Run.load(tmp_path / "run")
    read = columns(tmp_path / "run" / "waveforms.csv")
    assert next(iter(read)) == "time (s)"
    assert [float(text) for text in read["flow (m^3/s)"]] == run["flow"].tolist()
    assert [float(text) for text in read["probe_2_x (m)"]] == run["probes"][:, 1, 0].tolist()
    force = [float(text) for text in read["contact_force_first_z (N)"]]
    assert force == run["contact_force_first"][:, 2].tolist()
    assert [int(text) for text in read["coupling_sweeps"]] == run["coupling_sweeps"].tolist()
    assert not any(name.startswith(("section_", "coronal_")) for name in read)
    named = {name.split(" ")[0] for name in read}
    assert {name for name, values in run.items() if values.ndim == 1} <= named
    (tmp_path / "run" / "waveforms.csv").unlink()
    assert main(["measures", str(tmp_path / "run")]) == 0
    assert columns(tmp_path / "run" / "waveforms.csv") == read


@pytest.mark.slow
def test_a_failed_run_leaves_the_table_of_what_it_computed(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from interrupted_runs import StopsAfter
    from plica import _engine

    bar.save(tmp_path / "s.toml")
    monkeypatch.setattr(_engine, "Simulation", StopsAfter(17))
    assert main(["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run"), "--quiet"]) == 1
    assert len(columns(tmp_path / "run" / "waveforms.csv")["time (s)"]) == 17
