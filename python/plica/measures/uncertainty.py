"""Numerical uncertainty of measures by refinement, and its file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from plica.errors import Damaged, UnknownName
from plica.storage.json_file import read_json, write_json

__all__ = [
    "JSON_FILE",
    "VERDICTS",
    "Bound",
    "Refinement",
    "Uncertain",
    "Uncertainty",
    "Verdict",
    "from_json",
    "read_uncertainty",
    "write_uncertainty",
]

JSON_FILE = "uncertainty.json"
_FORMAT = 2
_REMEDY = "Remove it, or let plica uncertainty make it again"

Verdict = Literal[
    "expected order", "other order", "one other level", "within scatter", "no convergence", "no difference"
]
VERDICTS: Mapping[Verdict, str] = {
    "expected order": "two other levels: differences shrink with the theoretical order (safety factor 1.25)",
    "other order": "two other levels: differences shrink, but with another order (safety factor 3)",
    "one other level": "only one other level was compared, so that the order is assumed (safety factor 3)",
    "within scatter": "levels differ by less than cycles do: the bound is what these cycles can resolve",
    "no convergence": "differences do not shrink, or the quantity has no limit: do not rely on the bound",
    "no difference": "all levels give the same value",
}
"""How an uncertainty was determined, and what that means; docs/uncertainty.md has the rule of each."""


@dataclass(frozen=True)
class Bound:
    """A bound on the numerical error of one value.

    Attributes
    ----------
    uncertainty : float
        In the unit of the value: its distance from that of an infinitely small step and mesh is at most this,
        in 95 of 100 cases. Neither the scatter between cycles nor the error of the model.
    source : str
        What it was determined of.
    doubts : tuple of str
        Why it may be too small.
    """

    uncertainty: float
    source: str
    doubts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Refinement:
    """Result of refining the step or the mesh for one quantity.

    Attributes
    ----------
    uncertainty : float
        In the quantity's unit.
    verdict : Verdict
        How it was determined, one of `VERDICTS`; any other raises UnknownName.
    order : float or None
        Observed order, from three levels.
    extrapolated : float or None
        The limit, if three levels converge.
    values : dict of str to float
        Values by level, including the run itself.
    """

    uncertainty: float
    verdict: Verdict
    order: float | None = None
    extrapolated: float | None = None
    values: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.verdict not in get_args(Verdict):
            raise UnknownName("Refinement: verdict", self.verdict, VERDICTS)


@dataclass(frozen=True)
class Uncertain:
    """One quantity of a run with its uncertainty.

    Attributes
    ----------
    name, unit : str
        SI.
    value : float
        Value of the run.
    step, mesh : Refinement or None
        None: not estimated.
    statistical : float or None
        95 % uncertainty of the mean over cycles; None without averaging. Not included in `numerical`.
    spread : float or None
        Standard deviation between cycles.
    cycles : int
    """

    name: str
    unit: str
    value: float
    step: Refinement | None
    mesh: Refinement | None
    statistical: float | None = None
    spread: float | None = None
    cycles: int = 0

    @property
    def numerical(self) -> float | None:
        """Sum of those of step and mesh, as both errors may have the same sign; None if there is neither."""
        parts = [part.uncertainty for part in (self.step, self.mesh) if part is not None]
        return sum(parts) if parts else None

    @property
    def alone(self) -> str:
        """``step alone`` or ``mesh alone`` if only that is estimated; else empty."""
        known = [name for name, part in (("step", self.step), ("mesh", self.mesh)) if part is not None]
        return f"{known[0]} alone" if len(known) == 1 else ""

    @property
    def doubts(self) -> tuple[str, ...]:
        """Reasons to doubt the uncertainty, as text."""
        parts = (("step", self.step), ("mesh", self.mesh))
        found = [name for name, part in parts if part is not None and part.verdict == "no convergence"]
        return (f"no convergence by {' and '.join(found)}: do not rely on it",) if found else ()

    def bound(self, source: str) -> Bound | None:
        """The numerical uncertainty alone; None if there is none."""
        doubts = (*([self.alone] if self.alone else []), *self.doubts)
        return None if self.numerical is None else Bound(self.numerical, source, doubts)

    def as_json(self) -> dict[str, Any]:
        """The entry of uncertainty.json."""
        return {"numerical": self.numerical} | asdict(self)


@dataclass(frozen=True)
class Uncertainty:
    """The uncertainties of a run and their sources.

    Attributes
    ----------
    steps : int
        Steps of the run when it was estimated.
    source : str
        One sentence on the levels and how they were run.
    levels : list of dict
        Each other level: name, kind, step, cells, steps, seconds, cycles, status.
    measures : dict of str to Uncertain
    waveforms : dict of str to Uncertain
        If the run was repeated from its start: relative L2 error, largest value and its instant.
    remarks : list of str
        Quantities that could not be estimated, and why.
    """

    steps: int
    source: str
    levels: list[dict[str, Any]]
    measures: dict[str, Uncertain]
    waveforms: dict[str, Uncertain]
    remarks: list[str]
    plica: str = ""

    @property
    def bounds(self) -> dict[str, Bound]:
        """The numerical uncertainty of each measure that has one."""
        source = "plica uncertainty of this run"
        return {name: one for name, item in self.measures.items() if (one := item.bound(source))}

    def as_json(self) -> dict[str, Any]:
        """The content of uncertainty.json."""
        tables = {"measures": self.measures, "waveforms": self.waveforms}
        return {
            "format": _FORMAT,
            "plica": self.plica,
            "steps": self.steps,
            "source": self.source,
            "remarks": self.remarks,
            "levels": self.levels,
            **{name: {key: item.as_json() for key, item in table.items()} for name, table in tables.items()},
        }


def write_uncertainty(found: Uncertainty, path: Path) -> Path:
    """Write it as JSON; the file is replaced atomically."""
    return write_json(found.as_json(), path, guarded=True)


def read_uncertainty(directory: Path, steps: int) -> Uncertainty | None:
    """The uncertainty of the run of this number of steps in a directory.

    None if there is none, or if it is for another number of steps or of another format. Raises Damaged,
    also for a verdict that is not known.
    """
    path = directory / JSON_FILE
    if not path.is_file():
        return None
    try:
        found = from_json(read_json(path, _REMEDY))
    except UnknownName as error:
        raise Damaged(f"{path}: {error} {_REMEDY}.") from None
    return found if found is not None and found.steps == steps else None


def from_json(data: Mapping[str, Any]) -> Uncertainty | None:
    """The inverse of `Uncertainty.as_json`; None if it is of another format."""
    if data["format"] != _FORMAT:
        return None
    return Uncertainty(
        steps=data["steps"],
        source=data["source"],
        levels=data["levels"],
        measures=_uncertain(data["measures"]),
        waveforms=_uncertain(data["waveforms"]),
        remarks=data["remarks"],
        plica=data["plica"],
    )


def _uncertain(entries: Mapping[str, Mapping[str, Any]]) -> dict[str, Uncertain]:
    parts: Sequence[str] = ("step", "mesh")
    found = {}
    for name, entry in entries.items():
        fields = {key: value for key, value in entry.items() if key != "numerical"}
        fields |= {part: None if entry[part] is None else Refinement(**entry[part]) for part in parts}
        found[name] = Uncertain(**fields)
    return found
