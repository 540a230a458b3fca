"""The subjects of verification, and their cases judged one after the other."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence

from plica.errors import InvalidInput, nearest, one_of
from plica.verify.case import Case, Row, judged

__all__ = ["SUBJECTS", "cases", "chosen", "verify"]

SUBJECTS: dict[str, str] = {
    "tissue": "constant strains, rigid motion, moduli, creep, natural frequencies",
    "dynamics": "time schemes, energy, momentum, the same bits whatever the threads",
    "airflow": "Bernoulli's and viscous flow, the work of pressures",
    "contact": "impacts, contact at rest, what bodies keep through a collision",
    "video": "motion between frames, the glottis, pitch, quotients and phases",
    "identification": "filter, smoother, likelihood, gradient, a tissue found again",
}
"""Each a package of this room, with what is in it."""


def chosen(asked: Sequence[str] | None) -> list[str]:
    """Those asked for in their order, all where none is; raises InvalidInput for one that is not known."""
    for name in asked or ():
        if name not in SUBJECTS:
            raise InvalidInput(
                f'verify: --subject = "{name}"; must be {one_of(SUBJECTS)}.{nearest(name, SUBJECTS)}'
            )
    return [name for name in SUBJECTS if name in (asked or SUBJECTS)]


def cases(subject: str) -> tuple[Case, ...]:
    """Those of a subject, which is imported now."""
    found: tuple[Case, ...] = importlib.import_module(f"plica.verify.{subject}").CASES
    return found


def verify(subjects: Sequence[str]) -> Iterator[tuple[Case, list[Row]]]:
    """Each case with its rows, as it is done."""
    for subject in subjects:
        for case in cases(subject):
            yield case, judged(subject, case)
