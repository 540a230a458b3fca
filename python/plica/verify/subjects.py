"""The subjects of verification, and their cases, run one after the other."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence

from plica.errors import InvalidInput, nearest, one_of
from plica.verify.case import Case, Row, run_case

__all__ = ["SUBJECTS", "cases", "selected", "verify"]

SUBJECTS: dict[str, str] = {
    "tissue": "constant strains, rigid motion, moduli, creep, natural frequencies",
    "dynamics": "time schemes, energy, momentum, the same bits whatever the threads",
    "airflow": "Bernoulli's and viscous flow, the work of pressures",
    "contact": "impacts, contact at rest, what bodies keep through a collision",
    "video": "motion between frames, the glottis, pitch, quotients and phases",
    "identification": "filter, smoother, likelihood, gradient, a tissue found again",
}
"""Packages of cases, with their content."""


def selected(requested: Sequence[str] | None) -> list[str]:
    """The requested subjects in their order, all for None; raises InvalidInput for an unknown one."""
    for name in requested or ():
        if name not in SUBJECTS:
            raise InvalidInput(
                f'verify: --subject = "{name}"; must be {one_of(SUBJECTS)}.{nearest(name, SUBJECTS)}'
            )
    return [name for name in SUBJECTS if name in (requested or SUBJECTS)]


def cases(subject: str) -> tuple[Case, ...]:
    """The cases of a subject, which is imported on demand."""
    found: tuple[Case, ...] = importlib.import_module(f"plica.verify.{subject}").CASES
    return found


def verify(subjects: Sequence[str]) -> Iterator[tuple[Case, list[Row]]]:
    """Run each case; yields it with its rows."""
    for subject in subjects:
        for case in cases(subject):
            yield case, run_case(subject, case)
