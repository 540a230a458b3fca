"""Onsets of many scenes of one kind, in processes of one thread each, and how they are summed up.

A process of its own lets NumPy's libraries begin with one thread: on a busy machine the small eigenproblems
of an onset are several times as quick so.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

import numpy as np

import plica
from benchmarks.validation import m5

__all__ = ["INLET", "SUMMED", "Case", "Found", "find", "grow", "in_processes", "spread", "summed"]

INLET = 2.86e-4  # m^2: 17 mm by 16.8 mm, what the folds are between at the wall; the area of all tubes
REACH = 3000.0  # Pa, up to which an onset is looked for
SECTIONS, MODES = 60, 40
T = TypeVar("T")


@dataclass(frozen=True)
class Case:
    """Folds of silicone of 1030 kg/m^3 in their rig."""

    shape: str = "cast"
    E: float = 13.7e3
    """Pa, of the body if there is a cover."""
    cover: float | None = None
    """Pa, of a cover of 2 mm."""
    nu: float = 0.45
    gap: float = 0.2
    """mm"""
    separation: float = 1.2
    zeta: float = 0.06
    trachea: float = 0.0
    """m, 0: none"""
    tract: float = 0.0
    """m"""
    area: float = INLET
    """m^2, of both"""
    edge: float = 1.2
    along: int = 4
    sections: int = SECTIONS
    modes: int = MODES
    reach: float = REACH


@dataclass(frozen=True)
class Found:
    """The onset: Pa and Hz, None where there is none up to `reached` Pa, and why that is not all of it."""

    pressure: float | None
    frequency: float | None
    reached: float
    end: str = ""
    at_most: bool = False
    """An oscillation grows at the lowest pressure already."""

    @property
    def text(self) -> str:
        if self.pressure is not None:
            least = "at most " if self.at_most else ""
            return f"{least}{self.pressure / 1e3:.2f} kPa, {self.frequency:.0f} Hz"
        return f"none to {self.reached / 1e3:.2g} kPa" + (f" ({self.end})" if self.end else "")


def scene(case: Case, folder: Path) -> plica.Scene:
    """Its mesh is written into the folder."""
    shape = m5.M5.cast() if case.shape == "cast" else m5.M5.static()
    thickness = None if case.cover is None else 2.0
    quarter = m5.Quarter(shape, case.gap, case.edge, case.along, thickness)
    path = m5.write_quarter(quarter, folder / "quarter.msh")
    body = plica.Tissue(E=case.E, nu=case.nu, density=1030)
    cover = None if case.cover is None else plica.Tissue(E=case.cover, nu=case.nu, density=1030)
    changes: dict[str, object] = {
        "airflow.area": {"cut": {"sections": case.sections}},
        "airflow.model": {"viscous_slit": {"separation_ratio": case.separation}},
    }
    if case.trachea:
        changes["trachea"] = {"uniform": {"length": case.trachea, "area": case.area}}
    if case.tract:
        changes["tract"] = {"uniform": {"length": case.tract, "area": case.area}, "wall": "rigid"}
    return m5.scene(path, body, cover).replace(changes)


def find(case: Case) -> Found:
    """Its onset up to its reach."""
    with tempfile.TemporaryDirectory() as folder:
        found = plica.onset(scene(case, Path(folder)), stop=case.reach, modes=case.modes, zeta=case.zeta)
    lowest, reached = found.least_stable[0], float(found.pressure[-1])
    onset = np.inf if found.first is None else found.first.pressure
    left = found.pressure[(found.fastest > 0) & (found.pressure <= onset)]
    if lowest.real > 0:
        return Found(float(found.pressure[0]), float(lowest.imag) / (2 * np.pi), reached, at_most=True)
    if len(left):
        return Found(None, None, float(left[0]), "the equilibrium is left without oscillation")
    if found.first is None:
        return Found(None, None, reached, "folds touch beyond" if "touch" in found.end else found.end)
    return Found(found.first.pressure, found.first.frequency, reached)


def grow(case: Case) -> tuple[float, float]:
    """Growth (1/s) and frequency (Hz) of its least stable oscillation under the pressure `reach`; nan where
    there is no equilibrium, or it is left without oscillation."""
    with tempfile.TemporaryDirectory() as folder:
        made = scene(case, Path(folder))
        try:
            pair = plica.growth(made, case.reach, modes=case.modes, zeta=case.zeta)[0]
        except plica.SolveFailed:
            return np.nan, np.nan
    return float(pair.real), float(pair.imag) / (2 * np.pi)


def in_processes(
    cases: Sequence[Case], processes: int, work: Callable[[Case], T]
) -> Iterator[tuple[Case, T]]:
    """Each case with what is found, in the order of the cases."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        yield from zip(cases, pool.map(work, cases), strict=True)


def spread(values: Sequence[float], digits: int) -> str:
    """Median and range."""
    if not values:
        return "-"
    middle, least, most = np.median(values), min(values), max(values)
    return f"{middle:.{digits}f} ({least:.{digits}f} to {most:.{digits}f})"


SUMMED = (
    "draws",
    "phonate to 3 kPa",
    "onset (kPa): median (range)",
    "f0 (Hz): median (range)",
    "the equilibrium ends before",
)


def summed(found: Sequence[Found]) -> list[object]:
    """The entries of `SUMMED`."""
    voiced = [one for one in found if one.pressure is not None]
    return [
        len(found),
        f"{len(voiced)} of {len(found)}",
        spread([one.pressure / 1e3 for one in voiced if one.pressure], 2),
        spread([one.frequency for one in voiced if one.frequency], 0),
        sum(one.pressure is None and bool(one.end) for one in found),
    ]
