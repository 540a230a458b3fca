"""Probes of extreme inputs, and verdicts on their results."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from pydantic import ValidationError

from plica.errors import InvalidInput, SolveFailed
from plica.scene.problems import describe
from plica.scene.scene import Scene

__all__ = ["FORBIDDEN", "LONGEST", "Found", "Probe", "Verdict", "Wrong", "run_probe"]

Word = Literal["right", "said", "refused", "WRONG", "NaN", "CRASH", "HANG"]

FORBIDDEN: tuple[Word, ...] = ("WRONG", "NaN", "CRASH", "HANG")
LONGEST = 900
"""Longest acceptable error message, characters."""


class Wrong(Exception):  # noqa: N818 (what was found)
    """The result of a probe contradicts its reference."""


@dataclass(frozen=True)
class Found:
    """Error of a result against its reference."""

    error: float
    allowed: float
    cautions: tuple[str, ...] = ()
    """Names of the cautions that a user would get."""
    note: str = ""


@dataclass(frozen=True)
class Probe:
    """One extreme."""

    name: str
    reference: str
    """Reference of its error."""
    find: Callable[[], Found]
    small: bool = False
    """Whether it is part of the small size."""
    limit: float = 180.0
    """s; longer is a hang."""


@dataclass(frozen=True)
class Verdict:
    """Outcome of a probe."""

    word: Word
    note: str
    error: float | None = None
    allowed: float | None = None


def run_probe(find: Callable[[], Found]) -> Verdict:
    """Run a probe: right within the allowed error, announced by a caution, or refused with a proper
    exception."""
    try:
        found = find()
    except (InvalidInput, SolveFailed) as refusal:
        return _refused(str(refusal))
    except ValidationError as refusal:
        return _refused(" ".join(describe(refusal, "Scene", Scene)))
    except Wrong as wrong:
        return Verdict("WRONG", str(wrong))
    except Exception as crash:
        return Verdict("CRASH", f"{type(crash).__name__}: {' '.join(str(crash).split())}")
    numbers = (found.error, found.allowed)
    if not math.isfinite(found.error):
        return Verdict("NaN", found.note)
    if found.error <= found.allowed:
        return Verdict("right", found.note, *numbers)
    if found.cautions:
        return Verdict("said", "; ".join(filter(None, (", ".join(found.cautions), found.note))), *numbers)
    return Verdict("WRONG", found.note, *numbers)


def _refused(message: str) -> Verdict:
    text = " ".join(message.split())
    if len(text) > LONGEST:
        return Verdict("WRONG", f"refused in {len(text)} characters: {text[:200]} ...")
    return Verdict("refused", text)
