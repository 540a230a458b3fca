"""Cases of verification: checks of values against references, and their result rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["Case", "Check", "Row", "run_case", "worst", "zero"]


@dataclass(frozen=True, kw_only=True)
class Check:
    """A value and its reference."""

    name: str
    """Within the case."""
    quantity: str
    unit: str = "1"
    """SI; "1" for a pure number."""
    value: float
    reference: float
    tolerance: float
    because: str
    """The reason of the tolerance: rounding, an order of convergence, a sampling."""
    of: Literal["reference", "unit"] = "reference"
    """Unit of error and tolerance: relative to the reference, or absolute."""

    @property
    def error(self) -> float:
        """|value - reference|, over |reference| or in the unit."""
        off = abs(self.value - self.reference)
        return off / abs(self.reference) if self.of == "reference" else off


def zero(**given: Any) -> Check:
    """A value that is to vanish: error and tolerance are in its unit."""
    return Check(reference=0.0, of="unit", **given)


@dataclass(frozen=True)
class Case:
    """A computation, and what it proves."""

    name: str
    proves: str
    """One sentence."""
    source: str
    """Source of the reference."""
    checks: Callable[[], Iterable[Check]]


@dataclass(frozen=True)
class Row:
    """Result of a check; a case that failed before its checks has one row without a value."""

    name: str
    subject: str
    case: str
    quantity: str
    unit: str
    value: float | None
    reference: float | None
    error: float | None
    tolerance: float | None
    error_of: str
    because: str
    source: str
    failure: str
    passed: bool

    def as_json(self) -> dict[str, Any]:
        """An object of strict JSON: numbers are finite, or null; whether it passed is under "pass"."""
        fields = dict(vars(self))
        fields["pass"] = fields.pop("passed")
        return fields


def run_case(subject: str, case: Case) -> list[Row]:
    """Run a case: a row for each check, and one for an error if it was raised."""
    rows: list[Row] = []
    try:
        for check in case.checks():
            rows.append(_row(subject, case, check))
        if not rows:
            raise ValueError("the case has no check")
    except Exception as error:
        failure = f"{type(error).__name__}: {' '.join(str(error).split())}"
        nothing = (None, None, None, None)
        rows.append(
            Row(case.name, subject, case.name, "result", "1", *nothing, "", "", case.source, failure, False)
        )
    return rows


def _row(subject: str, case: Case, check: Check) -> Row:
    error, tolerance = check.error, check.tolerance
    passed = bool(math.isfinite(error) and math.isfinite(tolerance) and error <= tolerance)
    return Row(
        name=f"{case.name}.{check.name}",
        subject=subject,
        case=case.name,
        quantity=check.quantity,
        unit=check.unit,
        value=_finite(check.value),
        reference=_finite(check.reference),
        error=_finite(error),
        tolerance=_finite(tolerance),
        error_of=check.of,
        because=check.because,
        source=case.source,
        failure="" if math.isfinite(error) else "not a number",
        passed=passed,
    )


def _finite(number: float) -> float | None:
    return float(number) if math.isfinite(number) else None


def worst(values: ArrayLike, references: ArrayLike) -> tuple[float, float]:
    """The value with the largest relative error, and its reference."""
    found, exact = np.ravel(np.asarray(values, float)), np.ravel(np.asarray(references, float))
    if found.shape != exact.shape or not found.size:
        raise ValueError(f"{found.size} values, {exact.size} references")
    k = int(np.argmax(np.abs(found - exact) / np.abs(exact)))  # NaN counts as the largest error
    return float(found[k]), float(exact[k])
