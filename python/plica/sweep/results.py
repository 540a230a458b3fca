"""A stored sweep: complete, or as far as it has come."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, UnknownName, nearest
from plica.measures.catalogue import CATALOGUE
from plica.measures.scale import shown_unit
from plica.report.wording import headline
from plica.scene.toml_text import toml_text
from plica.storage.files import replaced
from plica.storage.table import heading, write_table
from plica.sweep.case import STATISTICS, CaseResult, Status
from plica.sweep.needed import needed
from plica.sweep.store import (
    STATUSES,
    attributes_of,
    columns_of,
    open_results,
    pending,
    read_plan,
    stored_names,
    waveform_name,
    worded,
)

if TYPE_CHECKING:
    import xarray

__all__ = ["Sweep"]

_SHOWN = 4  # measures of tables and pictures, where nothing else is asked for
_NUMBERS = ("seconds", "cautions")
_TEXTS = ("message", "caution_names")


class Sweep:
    """The cases of a sweep, and what they gave.

    Open with `Sweep.load`; a sweep that is still computed, or was killed, has the cases that have ended.

    Attributes
    ----------
    directory : Path
    record : dict
        The plan: `design`, `samples`, `seed`, `keys`, what it is of (`scene`, `settings`), ...
    values : (cases, keys)
        In SI; of words (recordings, presets) their positions in `words`.
    columns : dict of (cases) ndarray
        What is stored of each case: measures (``open_quotient``), their spreads and uncertainties
        (``open_quotient_spread``), NaN where there is none; ``seconds``, ``steps``, ``cautions``,
        ``caution_names``, ``message``.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.record = read_plan(directory)
        self.values = np.array(self.record.pop("table"), dtype=float)
        group = open_results(directory, "r")
        self._ended = pending(directory)  # first: a driver may write these to the group meanwhile
        self._waveforms: list[str] = self.record["waveforms"]
        names = [name for name in stored_names(group) if not name.startswith("waveform_")]
        self._codes = np.asarray(group["status"][:])
        others = {"status", "time", *self.keys}
        self.columns: dict[str, NDArray[Any]] = {
            name: np.asarray(group[name][:]) for name in sorted(set(names) - others)
        }
        self._attributes: dict[str, dict[str, Any]] = {
            name: dict(group[name].attrs) for name in (*self.columns, "status")
        }
        for result in self._ended:
            self._add(result)
        for name in (*_NUMBERS, *_TEXTS):
            self.columns.setdefault(name, np.full(len(self), "" if name in _TEXTS else 0))
            self._attributes.setdefault(name, attributes_of(name))

    @classmethod
    def load(cls, directory: str | Path) -> Sweep:
        """Open the sweep in `directory`; raises InvalidInput if there is none, or it is damaged."""
        return cls(Path(directory))

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {name}" for name, count in self.counts.items() if count)
        return f"<Sweep {self.directory}: {len(self)} cases, {counts}>"

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A measure of every case, in SI; NaN where there is none."""
        if name not in self.columns:
            raise UnknownName(f"Sweep {self.directory}", name, self.measures)
        return self.columns[name]

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that change."""
        return tuple(one["key"] for one in self.record["keys"])

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of each key; empty for a pure number."""
        return {one["key"]: one["unit"] for one in self.record["keys"]}

    @property
    def words(self) -> Mapping[str, tuple[str, ...]]:
        """What each key stands for whose values are words."""
        return {key: tuple(words) for key, words in self.record.get("words", {}).items()}

    def given(self, key: str) -> NDArray[Any]:
        """(cases) What every case has for a key: a number in SI, or a word."""
        if key not in self.keys:
            raise UnknownName(f"Sweep {self.directory}", key, self.keys)
        return worded(self.values[:, self.keys.index(key)], self.words.get(key, ()))

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures that some case has, in the catalogue's order; then those of tissue."""
        of_measures = self.columns.keys() - {*_NUMBERS, *_TEXTS}
        derived = {f"{name}_{one}" for name in of_measures for one in STATISTICS[1:]}
        others = sorted(of_measures - derived - CATALOGUE.keys())
        return (*(name for name in CATALOGUE if name in self.columns), *others)

    def unit(self, name: str) -> str:
        """Unit of a measure, as it is stored."""
        if name not in self._attributes:
            raise UnknownName(f"Sweep {self.directory}", name, self.measures)
        return str(self._attributes[name]["units"])

    def shown(self, name: str) -> tuple[float, str]:
        """Factor to the unit in which people read a measure, and that unit."""
        unit = self.unit(name)
        if name in CATALOGUE and CATALOGUE[name].unit == unit:
            return CATALOGUE[name].people()
        return shown_unit(unit)

    @property
    def main_measures(self) -> tuple[str, ...]:
        """The first four headlines of these; without any the first four that some case determines."""
        found = [name for name in self.measures if np.isfinite(self.columns[name]).any()]
        return tuple(([name for name in headline if name in found] or found)[:_SHOWN])

    @property
    def status(self) -> list[Status]:
        """Of each case: waiting, done, refused (there is no such scene) or failed."""
        return [STATUSES[code] for code in self._codes]

    @property
    def counts(self) -> dict[Status, int]:
        """Number of cases of each status."""
        return {name: int((self._codes == k).sum()) for k, name in enumerate(STATUSES)}

    @property
    def caution_counts(self) -> dict[str, int]:
        """In how many cases there is each caution, by its name; the most frequent first."""
        names = Counter(name for text in self.columns["caution_names"] for name in str(text).split())
        return dict(names.most_common())

    @property
    def without_result(self) -> list[tuple[int, Status, str]]:
        """Number, status and message of each case that was refused or has failed."""
        return [
            (int(case), STATUSES[self._codes[case]], str(self.columns["message"][case]))
            for case in np.flatnonzero(self._codes > STATUSES.index("done"))
        ]

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """All cases as one labelled data set: over the keys of a grid, else over ``case``; in SI."""
        import xarray

        over, coordinates = self._axes()
        variables: dict[str, Any] = {}
        for name, values in (("status", self._codes), *self.columns.items()):
            texts = values.dtype.kind in "OTU"
            shaped = (values.astype(object) if texts else values).reshape(tuple(over.values()))
            variables[name] = (tuple(over), shaped, dict(self._attributes[name]))
        variables["status"][2]["flag_values"] = np.arange(len(STATUSES), dtype=np.int8)  # as netCDF has it
        attributes = {name: self.record[name] for name in ("design", "plica_version")}
        if "scene" in self.record:
            attributes["scene"] = toml_text(self.record["scene"])
        if "settings" in self.record:
            attributes["settings"] = json.dumps(self.record["settings"])
        made = xarray.Dataset(variables, coordinates, attributes)
        return made if not self._waveforms else made.merge(self._waveform_set(over))

    def _axes(self) -> tuple[dict[str, int], dict[str, Any]]:
        """Dimensions with their lengths, and coordinates."""
        labels = {key: {"units": unit or "1", "long_name": key} for key, unit in self.units.items()}
        for key in self.words:
            del labels[key]["units"]
        if self.record["design"] != "grid":
            columns = {key: ("case", self.given(key), labels[key]) for key in self.keys}
            return {"case": len(self)}, {"case": np.arange(len(self)), **columns}
        ends = {key: tuple(dict.fromkeys(self.given(key))) for key in self.keys}
        return (
            {key: len(values) for key, values in ends.items()},
            {key: (key, np.array(values), labels[key]) for key, values in ends.items()},
        )

    def _waveform_set(self, over: Mapping[str, int]) -> xarray.Dataset:
        """The waveforms, read when they are used unless cases are still pending."""
        import xarray

        group = open_results(self.directory, "r")
        held = [one for one in self._ended if one.waveforms]
        if "time" in group:
            time = np.asarray(group["time"][:])
        elif held:
            time = np.asarray(held[0].waveforms["time"])
        else:
            return xarray.Dataset()
        array = needed("dask.array")
        variables: dict[str, Any] = {}
        for name in self._waveforms:
            stored = waveform_name(name)
            values: Any = array.full((len(self), time.size), np.nan)
            if stored in group:
                values = array.from_zarr(group[stored])
            if held:
                values = np.array(values)
                for one in held:
                    values[one.case] = one.waveforms[name]
            shaped = values.reshape((*over.values(), time.size))
            variables[stored] = ((*over, "time"), shaped, attributes_of(stored))
        return xarray.Dataset(variables, {"time": ("time", time, {"units": "s"})})

    def write(self) -> list[Path]:
        """Write ``cases.csv`` and, once no case waits, ``sweep.nc``; returns their paths."""
        written = [self.directory / "cases.csv"]
        write_table(written[0], self._table())
        if not self.counts["waiting"]:
            needed("h5netcdf")
            written.append(self.directory / "sweep.nc")
            replaced(written[1], lambda draft: self.dataset.to_netcdf(draft, engine="h5netcdf"))
        return written

    def _table(self) -> dict[str, NDArray[Any]]:
        """The columns of cases.csv, by heading, in SI."""
        found: dict[str, NDArray[Any]] = {"case": np.arange(len(self))}
        for key in self.keys:
            found[heading(key, self.units[key])] = self.given(key)
        found["status"] = np.array(self.status)
        for name in (*_TEXTS[:1], *_NUMBERS, *_TEXTS[1:]):
            found[heading(name, self._attributes[name].get("units", ""))] = self.columns[name]
        for name in self.measures:
            for column in (name, f"{name}_spread", f"{name}_uncertainty"):
                if column in self.columns:
                    found[heading(column, self.unit(column))] = self.columns[column]
        return found

    def text(self, measures: tuple[str, ...] = ()) -> str:
        """A line a case, in common units: its keys, status, measures (default: the main ones), cautions."""
        for name in measures:
            if name not in self.measures:
                raise InvalidInput(
                    f'{self.directory}: measure "{name}"; must be one that the cases have (plica keys '
                    f"measures).{nearest(name, self.measures)}"
                )
        columns = [["case", *(str(k) for k in range(len(self)))]]
        for k, key in enumerate(self.keys):
            factor, unit = shown_unit(self.units[key])
            told = self.given(key) if key in self.words else [f"{factor * v:.6g}" for v in self.values[:, k]]
            columns.append([heading(key, unit), *map(str, told)])
        columns.append(["status", *self.status])
        for name in measures or self.main_measures:
            factor, unit = self.shown(name)
            shown = ("-" if np.isnan(value) else f"{factor * value:.5g}" for value in self.columns[name])
            columns.append([heading(name, unit), *shown])
        columns.append(["cautions", *(str(value) for value in self.columns["cautions"])])
        widths = [max(map(len, column)) for column in columns]
        return "\n".join(
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            for row in zip(*columns, strict=True)
        )

    def _add(self, result: CaseResult) -> None:
        """A case that is not in the store yet."""
        self._codes[result.case] = STATUSES.index(result.status)
        for name, (value,) in columns_of([result]).items():
            self._attributes.setdefault(name, attributes_of(name, result.units))
            if name not in self.columns:
                empty = "" if name in _TEXTS else 0 if name in _NUMBERS[1:] else np.nan
                self.columns[name] = np.full(len(self), empty, dtype=object if name in _TEXTS else None)
            elif name in _TEXTS:
                self.columns[name] = self.columns[name].astype(object)
            self.columns[name][result.case] = value
