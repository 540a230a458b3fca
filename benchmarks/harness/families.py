"""The families of cases: what is measured, and in one sentence each what to use when."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from benchmarks.harness.case import Case
from plica.errors import selected

__all__ = ["FAMILIES", "Family", "chosen_cases", "family_of", "find_case"]


@dataclass(frozen=True)
class Family:
    """Cases of one subject."""

    name: str
    module: str
    """Of benchmarks, which has its cases."""
    title: str
    advice: str
    """What to use when."""

    @cached_property
    def cases(self) -> tuple[Case, ...]:
        """Those of its module, which is imported now."""
        found: tuple[Case, ...] = importlib.import_module(f"benchmarks.{self.module}").CASES
        return found


FAMILIES = {
    family.name: family
    for family in (
        Family(
            "assembly",
            "tissue.assembly",
            "Assembly and natural frequencies",
            "Quadratic tetrahedra for anything that vibrates: linear ones never reach in the same time what "
            "they do, and are for trying things.",
        ),
        Family(
            "dynamics",
            "dynamics.schemes",
            "Time schemes on free vibration",
            "The trapezoidal rule where nothing collides; HHT(-0.3) where something does; Newmark(1, 3/2), "
            "which is of first order, never. Central differences only where you need steps below their "
            "stability limit anyway; they then have half the error of the trapezoidal rule in less than half "
            "the time.",
        ),
        Family(
            "coupling",
            "dynamics.coupling",
            "Coupling of flow and tissue",
            "Iterated, or extrapolated, which is as exact at a step and spares the sweeps; lagged, which is "
            "of first order, only to try things.",
        ),
        Family(
            "contact",
            "contact.bars",
            "Enforcement of contact, time scheme, mass of the surfaces",
            "Multipliers with HHT(-0.3): no penetration, no energy made, no stiffness to choose; with the "
            "trapezoidal rule only where the surfaces' mass is redistributed.",
        ),
        Family(
            "solvers",
            "dynamics.solvers",
            "Linear and saddle-point solvers against tolerance",
            "Leave the choice to plica: a Cholesky factor while it fits in memory, contact condensed; a "
            "tighter tolerance then costs little, so keep the default of 1e-8. At steps of 1 ms "
            "conjugate gradients err by ten thousand times their tolerance: take 1e-10 there.",
        ),
        Family(
            "phonation",
            "voice.convergence",
            "The whole run",
            "Steps of 50 us with the default for a voice; 25 us where a collision is looked at.",
        ),
        Family(
            "imaging",
            "flow.presets",
            "Optical flow and segmentation",
            "`video` for recordings of the larynx, `robust` (the default of plica flow) for two sharp "
            "pictures and for identification, `fast` for a first look; if only speed counts, OpenCV's DIS.",
        ),
        Family(
            "estimation",
            "identification.filters",
            "Kalman filter, smoother, EM",
            "plica from some 60 states on, where settled covariances save most; below, statsmodels spends "
            "less around the arithmetic.",
        ),
        Family(
            "parts",
            "dynamics.parts",
            "Leaving out",
            "Leave out what a scene does not need: a part without effect still costs time (see the table).",
        ),
    )
}
"""By name."""


def _all_cases() -> dict[str, tuple[Family, Case]]:
    return {case.name: (family, case) for family in FAMILIES.values() for case in family.cases}


def find_case(name: str) -> Case:
    """The case of that name."""
    return _all_cases()[name][1]


def family_of(name: str) -> Family:
    """The family of the case of that name."""
    return _all_cases()[name][0]


def chosen_cases(asked: Sequence[str] | None) -> list[Case]:
    """Those asked for by their own names or their families', all where none is, in the order of the families.

    Raises InvalidInput for a name that is neither.
    """
    known = _all_cases()
    names = selected(asked, list(dict.fromkeys([*FAMILIES, *known])), "benchmarks: CASE")
    return [case for family, case in known.values() if {case.name, family.name} & set(names)]
