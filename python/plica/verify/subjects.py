"""The subjects of verification, and their cases, run one after the other."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence

from plica.verify.case import Case, Row, run_case

__all__ = ["SUBJECTS", "cases", "verify"]

SUBJECTS: dict[str, str] = {
    "tissue": "constant strains, rigid motion, moduli, creep, natural frequencies",
    "dynamics": "time schemes, energy, momentum, the same bits whatever the threads",
    "airflow": "Bernoulli's and viscous flow, the work of pressures",
    "contact": "impacts, contact at rest, what bodies keep through a collision",
    "video": "motion between frames, the glottis, pitch, quotients and phases",
    "identification": "filter, smoother, likelihood, gradient, a tissue found again",
}
"""Packages of cases, with their content."""

_MODULES = {
    "tissue": ("patch", "moduli", "modes"),
    "dynamics": ("oscillator", "ledger", "bits"),
    "airflow": ("bernoulli", "slits", "work"),
    "contact": ("impact", "bounce", "statics", "laws"),
    "video": ("flow", "glottis"),
    "identification": ("gaussian", "evolution", "estimator"),
}
"""Of each package, in the order of the rows."""


def cases(subject: str) -> tuple[Case, ...]:
    """The cases of a subject, which is imported on demand."""
    modules = (importlib.import_module(f"plica.verify.{subject}.{name}") for name in _MODULES[subject])
    return tuple(case for module in modules for case in module.CASES)


def verify(subjects: Sequence[str]) -> Iterator[tuple[Case, list[Row]]]:
    """Run each case; yields it with its rows."""
    for subject in subjects:
        for case in cases(subject):
            yield case, run_case(subject, case)
