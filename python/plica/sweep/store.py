"""A sweep's directory: its plan, each case as it ends, and whole chunks of cases as Zarr.

A case that ends is a small file in ``pending`` until all of its chunk have ended; then these are written to
``results.zarr``, its status last, and removed. So a kill at any instant loses no case that had ended, and a
chunk whose statuses are there is whole.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from plica.errors import Damaged, InvalidInput, StorageFailed
from plica.measures.catalogue import CATALOGUE
from plica.measures.waveforms import STORED
from plica.scene.problems import differences
from plica.storage.files import PLAN, replaced, storage_errors
from plica.storage.json_file import read_json, write_json
from plica.storage.npz import read_npz
from plica.sweep.case import STATISTICS, CaseResult, Status
from plica.sweep.needed import needed
from plica.sweep.plan import Plan
from plica.sweep.values import Values

__all__ = [
    "CHUNK",
    "STATUSES",
    "Store",
    "attributes_of",
    "columns_of",
    "holds_sweep",
    "open_results",
    "pending",
    "read_plan",
    "require_sweep",
    "stored_names",
    "units_of",
    "waveform_name",
    "worded",
]

CHUNK = 256
RESULTS, PENDING = "results.zarr", "pending"
_NONE: Mapping[str, str] = {}
STATUSES: tuple[Status, ...] = get_args(Status)
_AGAIN = "Delete the directory and run the sweep again"


def holds_sweep(directory: Path) -> bool:
    """Whether there is a sweep in it."""
    return (directory / PLAN).is_file()


def require_sweep(directory: Path) -> None:
    """Raise InvalidInput, with what is there instead, unless there is a sweep in it."""
    if holds_sweep(directory):
        return
    if (directory / "results.h5").is_file():
        found = f"holds a run or an analysis (results.h5), and no sweep (no {PLAN})"
    else:
        found = f"there is no sweep in it (no {PLAN})"
    raise InvalidInput(f"{directory}: {found}; must be the directory of one.")


def read_plan(directory: Path) -> dict[str, Any]:
    """The record of a plan (`Plan.record`) with its table of values; raises InvalidInput without one."""
    require_sweep(directory)
    return read_json(directory / PLAN, _AGAIN)


def open_results(directory: Path, mode: Literal["r", "r+", "w"]) -> Any:
    """The Zarr group of a sweep."""
    zarr = needed("zarr")
    with storage_errors(directory / RESULTS, "read" if mode == "r" else "written"):
        return zarr.open_group(str(directory / RESULTS), mode=mode)


class Store:
    """The cases of a plan in a directory whose lock is held.

    Attributes
    ----------
    statuses : (cases) int8
        Positions in `STATUSES`.
    """

    def __init__(self, directory: Path, plan: Plan) -> None:
        self.directory, self.plan = directory, plan
        self.statuses = np.zeros(len(plan), dtype=np.int8)
        if holds_sweep(directory):
            _require_same(directory, plan)
            self.group = open_results(directory, "r+")
            self._read()
        else:
            self.group = self._begun()

    def waiting(self, first: int | None = None) -> Iterator[int]:
        """Cases that have not ended, in order; of the `first` ones alone if it is given."""
        return (int(case) for case in np.flatnonzero(self.statuses[:first] == 0))

    def keep(self, result: CaseResult) -> None:
        """Store a case that has ended, and its chunk if it was the last of it."""
        path = self._pending(result.case)
        if result.waveforms:
            arrays = {name: np.asarray(values) for name, values in result.waveforms.items()}
            replaced(path.with_suffix(".npz"), lambda draft: _save(draft, arrays))
        fields = asdict(result)
        for name in ("waveforms", "fault"):
            del fields[name]
        write_json(fields, path, guarded=True)
        self.statuses[result.case] = STATUSES.index(result.status)
        self._write_if_whole(result.case // CHUNK)

    def _pending(self, case: int) -> Path:
        return self.directory / PENDING / f"{case:06d}.json"

    def _begun(self) -> Any:
        plan = self.plan
        with storage_errors(self.directory):
            (self.directory / PENDING).mkdir(exist_ok=True)
        plan.subject.save(self.directory)
        group = open_results(self.directory, "w")
        with storage_errors(self.directory):
            for k, one in enumerate(plan.varied):
                words = one.words if isinstance(one, Values) else ()
                kind = str if words else np.float64
                unit = {} if words else {"units": one.key.unit or "1"}
                made = _array(group, one.key.key, len(plan), kind, unit)
                made[:] = worded(plan.values[:, k], words)
            _array(group, "status", len(plan), np.int8, attributes_of("status"))
            group.attrs.update(coordinates=" ".join(key.key for key in plan.keys), title="plica sweep")
        write_json({**plan.record, "table": plan.values.tolist()}, self.directory / PLAN, guarded=True)
        return group

    def _read(self) -> None:
        """The statuses of what is stored; chunks that a kill left unwritten are written."""
        with storage_errors(self.directory):
            for draft in (self.directory / RESULTS).rglob("*.partial"):  # Zarr's, of a kill
                draft.unlink()
        for chunk in self._chunks():
            part = slice(*self._ends(chunk))
            stored = np.asarray(self.group["status"][part])
            self.statuses[part] = stored
            if stored.all():
                self._remove_pending(chunk)
        for path in sorted((self.directory / PENDING).glob("*.json")):
            case = int(path.stem)
            result = _read_pending(self.directory, case)
            if result is None or result.digest != self.plan.case_digest(case):
                raise Damaged(f"{path}: is of another case; must be of case {case} of this plan. {_AGAIN}.")
            self.statuses[case] = STATUSES.index(result.status)
        for chunk in self._chunks():
            self._write_if_whole(chunk)

    def _chunks(self) -> range:
        return range(-(-len(self.plan) // CHUNK))

    def _ends(self, chunk: int) -> tuple[int, int]:
        return chunk * CHUNK, min((chunk + 1) * CHUNK, len(self.plan))

    def _write_if_whole(self, chunk: int) -> None:
        """Write what a chunk whose cases have all ended lacks."""
        begin, end = self._ends(chunk)
        if not self.statuses[begin:end].all():
            return
        rows = np.flatnonzero(np.asarray(self.group["status"][begin:end]) == 0)
        if not rows.size:
            return
        results = []
        for row in rows:
            case = begin + int(row)
            result = _read_pending(self.directory, case)
            if result is None:
                raise Damaged(
                    f"{self._pending(case)}: is missing; must be there until its chunk is written. {_AGAIN}."
                )
            results.append(result)
        with storage_errors(self.directory / RESULTS):
            units = units_of(results)
            for name, values in columns_of(results).items():
                attributes = attributes_of(name, units)
                _written(self.group, name, len(self.plan), slice(begin, end), rows, values, attributes)
            self._write_waveforms(results, slice(begin, end), rows)
            os.sync()  # before the status says that they are there
            self.group["status"][begin:end] = self.statuses[begin:end]
        self._remove_pending(chunk)

    def _write_waveforms(self, results: list[CaseResult], part: slice, rows: NDArray[np.intp]) -> None:
        done = [result for result in results if result.waveforms]
        if not done:
            return
        time = np.asarray(done[0].waveforms["time"])
        if "time" not in self.group:
            self.group.create_array(
                "time",
                shape=time.shape,
                dtype=np.float64,
                chunks=time.shape,
                dimension_names=["time"],
                attributes={"units": "s"},
            )
        self.group["time"][:] = time  # each time: a kill may have left it empty
        for name in self.plan.waveforms:
            values = np.full((len(results), time.size), np.nan)
            for k, result in enumerate(results):
                if result.waveforms:
                    values[k] = result.waveforms[name]
            stored = waveform_name(name)
            _written(self.group, stored, len(self.plan), part, rows, values, attributes_of(stored))

    def retry(self) -> None:
        """Let the cases that have failed wait again."""
        failed = self.statuses == STATUSES.index("failed")
        for chunk in self._chunks():
            part = slice(*self._ends(chunk))
            stored = np.asarray(self.group["status"][part])
            if stored.all() and failed[part].any():
                self.group["status"][part] = np.where(failed[part], 0, stored)
        for case in np.flatnonzero(failed):
            self._remove(int(case))
        self.statuses[failed] = 0

    def _remove_pending(self, chunk: int) -> None:
        with storage_errors(self.directory / PENDING):
            for case in range(*self._ends(chunk)):
                self._remove(case)

    def _remove(self, case: int) -> None:
        for suffix in (".json", ".npz"):
            self._pending(case).with_suffix(suffix).unlink(missing_ok=True)


def pending(directory: Path) -> list[CaseResult]:
    """The cases that have ended and are not in the Zarr store yet."""
    cases = sorted(int(path.stem) for path in (directory / PENDING).glob("*.json"))
    found = (_read_pending(directory, case) for case in cases)
    return [one for one in found if one is not None]


def _read_pending(directory: Path, case: int) -> CaseResult | None:
    """A case that has ended and is not in the Zarr store yet; None if it is not there."""
    path = directory / PENDING / f"{case:06d}.json"
    try:
        fields = read_json(path, _AGAIN)
    except StorageFailed:
        if path.exists():
            raise
        return None  # a driver has just moved it to the Zarr store
    waveforms: dict[str, Any] = {}
    if path.with_suffix(".npz").exists():
        names = [name for name, one in STORED.items() if one.per == "step"]
        waveforms = read_npz(path.with_suffix(".npz"), names)
    measures = {name: tuple(values) for name, values in fields.pop("measures").items()}
    cautions = tuple(fields.pop("cautions"))
    return CaseResult(**fields, cautions=cautions, measures=measures, waveforms=waveforms)


def waveform_name(name: str) -> str:
    """The name of a waveform in the store: measures may have the same."""
    return f"waveform_{name}"


def columns_of(results: list[CaseResult]) -> dict[str, NDArray[Any]]:
    """What cases gave besides status and waveforms: a column a measure, its spread and its uncertainty."""
    found: dict[str, NDArray[Any]] = {
        "message": np.array([result.message for result in results], dtype=object),
        "cautions": np.array([len(result.cautions) for result in results], dtype=np.int16),
        "caution_names": np.array([" ".join(result.cautions) for result in results], dtype=object),
        "seconds": np.array([result.seconds for result in results]),
    }
    names = dict.fromkeys(name for result in results for name in result.measures)
    for name in names:
        rows = [result.measures.get(name, (None,) * len(STATISTICS)) for result in results]
        table = np.array(rows, dtype=float)  # None is NaN
        for k, statistic in enumerate(STATISTICS):
            if k == 0 or not np.isnan(table[:, k]).all():
                found[column_name(name, statistic)] = table[:, k]
    return found


def column_name(measure: str, statistic: str) -> str:
    """``open_quotient``, ``open_quotient_spread``."""
    return measure if statistic == "value" else f"{measure}_{statistic}"


def units_of(results: list[CaseResult]) -> dict[str, str]:
    """Units of measures that are not as in the catalogue."""
    return {name: unit for result in results for name, unit in result.units.items()}


def worded(values: NDArray[np.float64], words: Sequence[str]) -> NDArray[Any]:
    """The words at these positions; the values themselves where there are no words."""
    return np.array(words, dtype=object)[values.astype(int)] if words else values


def attributes_of(column: str, units: Mapping[str, str] = _NONE) -> dict[str, Any]:
    """Unit and name of a column, of measures from the catalogue unless `units` has them, of waveforms as they
    are stored."""
    if column == "status":
        return {
            "flag_values": list(range(len(STATUSES))),
            "flag_meanings": " ".join(STATUSES),
            "long_name": "status",
        }
    if column == "seconds":
        return {"units": "s", "long_name": "wall time of the case"}
    waveform = STORED.get(column.removeprefix("waveform_"))
    if column.startswith("waveform_") and waveform is not None:
        return {"units": waveform.unit, "long_name": waveform.meaning}
    for statistic in STATISTICS:
        name = column.removesuffix(f"_{statistic}") if statistic != "value" else column
        if (name in CATALOGUE or name in units) and (statistic == "value" or name != column):
            one = CATALOGUE.get(name)
            what = "" if statistic == "value" else f", {statistic}"
            label = name if one is None else one.label
            unit = units[name] if one is None or name in units else one.unit
            return {"units": unit, "long_name": f"{label}{what}"}
    return {"units": "1"} if column == "cautions" else {}


def stored_names(group: Any) -> list[str]:
    """Names of the arrays of a group, which a driver may be writing."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of drafts of files
        return list(group.array_keys())


def _array(
    group: Any, name: str, cases: int, kind: Any, attributes: dict[str, Any], inner: tuple[int, ...] = ()
) -> Any:
    """A new array over cases, in chunks of these; without values NaN, 0 or empty."""
    number = kind is not str and np.dtype(kind).kind == "f"
    return group.create_array(
        name,
        shape=(cases, *inner),
        chunks=(min(CHUNK, cases), *inner),
        dtype=kind,
        fill_value="" if kind is str else np.nan if number else 0,
        dimension_names=["case", "time"][: 1 + len(inner)],
        attributes=attributes,
    )


def _written(
    group: Any,
    name: str,
    cases: int,
    part: slice,
    rows: NDArray[np.intp],
    values: NDArray[Any],
    attributes: dict[str, Any],
) -> None:
    """Write rows of a part of the cases, which is a chunk."""
    if name not in group:
        kind = str if values.dtype == object else values.dtype
        _array(group, name, cases, kind, attributes, values.shape[1:])
    array = group[name]
    if len(rows) < part.stop - part.start:
        others = np.array(array[part])
        others[rows] = values
        values = others
    array[part] = values


def _save(draft: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    with draft.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def _first_value(table: list[list[float]], plan: Plan) -> tuple[str, str, str]:
    """Key, old and new value where the values of the same keys first differ; else that they do."""
    before = np.array(table, dtype=float)
    if before.shape == plan.values.shape and (rows := np.argwhere(before != plan.values)).size:
        case, column = rows[0]
        key = plan.keys[column]
        old, new = (f"{x[case, column]:.6g} {key.unit}".rstrip() for x in (before, plan.values))
        return f"values: {key.key} of case {case}", old, new
    return "values", "others", "these"


def _require_same(directory: Path, plan: Plan) -> None:
    """Raise InvalidInput, with what differs, unless the directory's sweep is of this plan."""
    stored = read_plan(directory)
    table = stored.pop("table")
    changed = list(differences(stored, plan.record))
    if changed:
        changed = [_first_value(table, plan) if one[0] == "values" else one for one in changed]
        shown = "; ".join(f"{key}: {old} before, {new} now" for key, old, new in changed[:3])
        more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
        raise InvalidInput(
            f"{directory}: holds a sweep of another plan ({shown}{more}); must be of this one to go on. Use "
            "another directory."
        )
