"""Values as text."""

from __future__ import annotations

import numpy as np

from benchmarks.thesis.judging import Value, Verdict


def number(value: Value | None, digits: int, factor: float = 1.0) -> str:
    """``219.3 ± 0.4``, the error being the standard error of the mean; a dash where there is no value.

    Negative digits are significant ones.
    """
    if value is None:
        return "–"
    known = value.error and np.isfinite(value.error)
    if digits < 0:
        text, error = f"{factor * value.mean:.{-digits}g}", f"{factor * value.error:.1g}"
    else:
        text, error = f"{factor * value.mean:.{digits}f}", f"{factor * value.error:.{digits}f}"
    return f"{text} ± {error}" if known else text


def rounded(value: float) -> str:
    """Two significant digits, not as a power of ten."""
    return f"{float(f'{value:.2g}'):,.0f}"


def verdict_text(verdict: Verdict) -> str:
    """What a verdict says of a published trend."""
    words = {"pass": "as published", "fail": "unlike published", "undecided": "undecided here"}
    return words.get(verdict, "no value")


def listed(names: list[str], values: list[Value | None], digits: int, unit: str = "") -> str:
    """``LM 0.87, 1e7 0.85`` and so on, then the unit."""
    text = ", ".join(f"{name} {number(value, digits)}" for name, value in zip(names, values, strict=True))
    return f"{text} {unit}".rstrip()
