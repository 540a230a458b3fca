"""Matrices of an elastic block, and what follows from them: strain energy, natural frequency (block.py)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level, Row
from benchmarks.harness.claims import of_order
from benchmarks.tissue.peers import (
    MASS,
    OMEGA,
    STRAIN_ENERGY,
    Assembled,
    discrete_mode,
    ngsolve_assembly,
    plica_assembly,
    scikit_fem_assembly,
)

__all__ = ["CASES"]

Start = Callable[[Level], Callable[[], Any]]


def _energies(level: Level, made: Assembled, truth: None) -> dict[str, float]:
    """Of the mode on the mesh, over those of the mode; and of a rigid turn."""
    unknowns = made.unknowns()
    u, turn = unknowns.mode, unknowns.turn
    strain = 0.5 * float(u @ (made.stiffness @ u))
    kinetic = 0.5 * float(u @ (made.mass @ u))
    size = float(np.abs(turn) @ (abs(made.stiffness) @ np.abs(turn)))
    return {
        "strain energy": abs(strain / STRAIN_ENERGY - 1),
        "kinetic energy": abs(2 * kinetic / MASS - 1),
        "rigid turn": abs(float(turn @ (made.stiffness @ turn))) / size,
    }


def _frequency_of(start: Start) -> Start:
    def prepare(level: Level) -> Callable[[], float]:
        made = start(level)
        return lambda: discrete_mode(made())[1]

    return prepare


def _methods(wrap: Callable[[Start], Start]) -> tuple[Method, ...]:
    return (
        Method("plica", wrap(plica_assembly)),
        Method("scikit-fem", wrap(scikit_fem_assembly), "skfem", "scikit-fem"),
        Method("NGSolve", wrap(ngsolve_assembly), "ngsolve"),
    )


def _ten_times(rows: Sequence[Row]) -> bool | None:
    """At 55,566 linear tetrahedra, on one thread; the median of the ratios within the rounds."""
    at = {"cells": 21, "elements": "linear"}
    found = {row.method: row for row in rows if row.threads == 1 and at.items() <= row.level.items()}
    if not {"plica", "scikit-fem"} <= found.keys():
        return None
    return bool(np.median(np.divide(found["scikit-fem"].seconds, found["plica"].seconds)) >= 10)


def _orders(error: str) -> tuple[Claim, ...]:
    """2 and 4, to 15 % on the coarse meshes of the small size."""
    return tuple(
        Claim(
            f"the error of plica's {error} falls with order {order} on {elements} tetrahedra",
            of_order("plica", error, "cells", 0.85 * order, elements=elements),
        )
        for elements, order in (("linear", 2), ("quadratic", 4))
    )


def _levels(linear: Sequence[int], quadratic: Sequence[int]) -> tuple[Level, ...]:
    pairs = [*((n, "linear") for n in linear), *((n, "quadratic") for n in quadratic)]
    return tuple({"elements": elements, "cells": cells} for cells, elements in pairs)


CASES = (
    Case(
        name="assembly",
        does="Stiffness and mass matrix of a block of isotropic tissue, from a mesh in memory to CSR.",
        reference="energies of a shear mode in closed form (R7)",
        errors={
            "strain energy": "of the mode on the mesh, relative",
            "kinetic energy": "likewise",
            "rigid turn": "energy of an infinitesimal turn, over the size of its terms",
        },
        levels={"small": _levels((2, 4), (1, 2)), "full": _levels((7, 14, 21), (4, 8))},
        methods=_methods(lambda start: start),
        truth=lambda level: None,
        judge=_energies,
        claims=(
            *_orders("strain energy"),
            Claim("plica is ten times as fast as scikit-fem at 55,566 linear tetrahedra", _ten_times, True),
        ),
    ),
    Case(
        name="frequency",
        does="The frequency of a shear mode: assembly, then shift and invert about it (ARPACK, SuperLU).",
        reference="closed form (R7)",
        errors={"frequency": "relative"},
        levels={"small": _levels((2, 4), (2, 3)), "full": _levels((4, 7, 10), (2, 3, 5))},
        methods=_methods(_frequency_of),
        truth=lambda level: None,
        judge=lambda level, found, truth: {"frequency": abs(found / OMEGA - 1)},
        claims=_orders("frequency"),
        threads=(1,),
    ),
)
