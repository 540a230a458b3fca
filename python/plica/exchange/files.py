"""The exchange file: CSV with one row per time, or HDF5 with sections and positions too; all in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from plica.errors import InvalidInput
from plica.measures.record import Floats
from plica.measures.waveforms import STORED
from plica.runs.results import Run
from plica.scene.scene import Scene
from plica.scene.tube_shapes import read_columns
from plica.storage.files import replaced
from plica.storage.stored import Stored
from plica.storage.table import heading, write_table

__all__ = ["SERIES", "Areas", "read_areas", "suffixes", "write_run", "write_series"]

suffixes = (".csv", ".h5")
SERIES = (
    "flow",
    "subglottal_pressure",
    "supraglottal_pressure",
    "flow_below",
    "flow_above",
    "lip_flow",
)
"""Flows and pressures of a glottis, in the order of the file."""
_DISPLACED = ("displaced_below", "displaced_above")
_PLACES = ("section_area", "section_pressure", "coronal_right", "coronal_left")
_EVEN = 1e-3  # of a step
_NARROW, _WIDE = 0.1, 300.0  # mm^2, of the widest opening of a glottis
_SLOW = 1e-3  # s, the longest step in which a period is seen


@dataclass(frozen=True)
class Areas:
    """Areas of a glottis over time.

    Attributes
    ----------
    time : (k) s, equidistant
    narrowest : (k) m^2
        Of the narrowest section.
    sections : (k, s) m^2 or None
        Of all sections, from below, where they are known.
    displaced : (k, 2) m^3/s or None
        Air that the folds displace below the narrowest section, and above it, where it is known.
    """

    time: Floats
    narrowest: Floats
    sections: Floats | None = None
    displaced: Floats | None = None

    @property
    def doubts(self) -> tuple[str, ...]:
        """What areas of people and times of a voice are not, with values and units."""
        widest = 1e6 * float(self.narrowest.max())
        found = []
        if not _NARROW <= widest <= _WIDE:
            found.append(
                f"The widest of the areas is {widest:.4g} mm^2; in people it is some 5 to 30 mm^2 in "
                "speech and 100 to 200 mm^2 in breathing. Is the unit right?"
            )
        if self.step > _SLOW:
            found.append(
                f"Times are {1e3 * self.step:.4g} ms apart; a period of a voice has 2 to 15 ms. "
                "Is the unit right?"
            )
        return tuple(found)

    @property
    def step(self) -> float:
        """s."""
        return float(self.time[-1] - self.time[0]) / (self.time.size - 1)


def write_run(run: Run, path: Path) -> None:
    """Write areas, flows and pressures of the computed part of a run, and the gas; to ``.h5`` also what
    sections and the mid-coronal points have."""
    columns = {name: run[name] for name in SERIES if name in run}
    if "flow_above" in run:
        displaced = (run["flow_below"] - run["flow"], run["flow"] - run["flow_above"])
        columns |= dict(zip(_DISPLACED, displaced, strict=True))
    if "minimum_area" not in run:
        raise InvalidInput(f"{run.directory}: the run has no airflow; must have one. Add [airflow].")
    if "subglottal_pressure" not in columns:
        assert run.scene.airflow is not None
        columns["subglottal_pressure"] = np.full(run.steps, run.scene.airflow.subglottal_pressure)
    places = {name: run[name] for name in _PLACES if name in run}
    write_series(
        path, run.time, {"area": run["minimum_area"], **columns}, run.scene, places, run.section_height
    )


def write_series(
    path: Path,
    time: Floats,
    columns: Mapping[str, Floats],
    scene: Scene,
    places: Mapping[str, Any] | None = None,
    height: Floats | None = None,
) -> None:
    """Write columns (k) by name, ``area`` or that of a waveform.

    Parameters
    ----------
    path : Path
        ``.csv`` or ``.h5``; replaced as a whole.
    time : (k) s
    columns : mapping of (k)
    scene : Scene
        For its gas.
    places : mapping of (k, s) or (k, s, 3), optional
        For ``.h5``.
    height : (s) m, optional
        Of the sections, at rest.
    """
    gas = _gas(scene)
    units = {name: _UNITS.get(name) or STORED[name].unit for name in columns}
    if path.suffix == ".csv":
        series = {heading(name, units[name]): values for name, values in columns.items()}
        comments = {name: f"{value:g} {unit}" for name, (value, unit) in gas.items()}
        write_table(path, {"time (s)": time, **series}, comments)
        return

    def fill(draft: Path) -> None:
        with h5py.File(draft, "w") as file:
            for name, (value, unit) in gas.items():
                file.attrs[name], file.attrs[f"{name}_unit"] = value, unit
            given: dict[str, Any] = {"time": time, **columns, **(places or {})}
            if height is not None and height.size:
                given["section_height"] = height
            for name, values in given.items():
                data = file.create_dataset(
                    name, data=np.asarray(values, dtype=float), compression="gzip", shuffle=True
                )
                data.attrs["units"] = _UNITS.get(name) or STORED[name].unit
                data.attrs["description"] = _MEANINGS.get(name) or STORED[name].meaning

    replaced(path, fill)


_UNITS = {
    "time": "s",
    "area": "m^2",
    "section_height": "m",
    "displaced_below": "m^3/s",
    "displaced_above": "m^3/s",
}
_MEANINGS = {
    "time": "end of each step",
    "area": "of the narrowest section",
    "section_height": "of the sections at rest, from below",
    "displaced_below": "air that the folds displace below the narrowest section: flow_below - flow",
    "displaced_above": "air that the folds displace above it: flow - flow_above",
}


def _gas(scene: Scene) -> dict[str, tuple[float, str]]:
    air = scene.airflow
    assert air is not None
    found = {"air_density": (air.air_density, "kg/m^3"), "sound_speed": (air.sound_speed, "m/s")}
    if air.model.air_viscosity is not None:
        found["air_viscosity"] = (air.model.air_viscosity, "Pa s")
    return found


def read_areas(path: Path) -> Areas:
    """Areas from a file: ``.csv`` with the columns time and area, in any units, ``.h5`` with the data sets
    ``time`` and ``section_area``, or ``area``.

    Raises
    ------
    InvalidInput
        Where they are missing, no areas, or not at equidistant times; Damaged, which is one, for a broken
        file.
    """
    sections = displaced = None
    if path.suffix.lower() == ".csv":
        time, narrowest = read_columns(path, {"time": ("s", "time (ms)"), "area": ("m^2", "area (mm^2)")})
        displaced = _displaced_columns(path)
    else:
        with Stored(path, verified=False) as file:
            names = [name for name in ("section_area", "area") if name in file]
            if "time" not in file or not names:
                raise InvalidInput(f"{path}: must have the data sets time, and section_area or area.")
            time, values = np.asarray(file.read("time"), float), np.asarray(file.read(names[0]), float)
            if all(name in file for name in _DISPLACED):
                displaced = np.stack([np.asarray(file.read(name), float) for name in _DISPLACED], axis=-1)
        sections = values if names[0] == "section_area" else None
        narrowest = values if sections is None else values.min(axis=1, initial=np.inf)
    _check(path, time, narrowest if sections is None else sections)
    if displaced is not None and (displaced.shape != (time.size, 2) or not np.isfinite(displaced).all()):
        raise InvalidInput(f"{path}: displaced_below and displaced_above must be finite, one a time.")
    return Areas(time, narrowest, sections, displaced)


def _displaced_columns(path: Path) -> Floats | None:
    """(k, 2) m^3/s of a CSV file that has them."""
    with path.open(encoding="utf-8-sig") as file:
        header = next((line for line in file if line.strip() and line[0] != "#"), "")
    if not all(f"{name} (" in header for name in _DISPLACED):
        return None
    columns = {name: ("m^3/s", f"{name} (m^3/s)") for name in _DISPLACED}
    return np.stack(read_columns(path, columns), axis=-1)


def _check(path: Path, time: Floats, areas: Floats) -> None:
    if time.ndim != 1 or areas.shape[:1] != time.shape or time.size < 3:
        raise InvalidInput(
            f"{path}: has times {time.shape} and areas {areas.shape}; must have as many rows, 3 or more."
        )
    if not (np.isfinite(time).all() and np.isfinite(areas).all() and (areas >= 0).all()):
        raise InvalidInput(f"{path}: times and areas must be finite, and areas >= 0.")
    steps = np.diff(time)
    step = float(np.median(steps))
    if step <= 0 or float(np.abs(steps - step).max()) > _EVEN * step:
        raise InvalidInput(
            f"{path}: times are {steps.min():g} to {steps.max():g} s apart; must be equidistant, ascending."
        )
