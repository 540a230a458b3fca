"""What a probe of an extreme is, and the verdict on what it finds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from pydantic import ValidationError

from plica.errors import InvalidInput, SolveFailed
from plica.phonation.scene.problems import describe

__all__ = ["FORBIDDEN", "LONGEST", "Found", "Probe", "Verdict", "Wrong", "judged"]

Word = Literal["right", "said", "refused", "WRONG", "NaN", "CRASH", "HANG"]

FORBIDDEN: tuple[Word, ...] = ("WRONG", "NaN", "CRASH", "HANG")
LONGEST = 900
"""Characters of a refusal that a person still reads."""


class Wrong(Exception):  # noqa: N818 (what was found)
    """What a probe holds against a reference does not hold."""


@dataclass(frozen=True)
class Found:
    """A number held against its reference."""

    error: float
    allowed: float
    cautions: tuple[str, ...] = ()
    """Names of those that a user would have been given."""
    note: str = ""


@dataclass(frozen=True)
class Probe:
    """One extreme."""

    name: str
    reference: str
    """What its error is taken against."""
    find: Callable[[], Found]
    small: bool = False
    """Whether the small size has it."""
    limit: float = 180.0
    """s; longer is a hang."""


@dataclass(frozen=True)
class Verdict:
    """How a probe has ended."""

    word: Word
    note: str
    error: float | None = None
    allowed: float | None = None


def judged(find: Callable[[], Found]) -> Verdict:
    """Right within what is allowed, said by a caution, or refused in words, with the right exception."""
    try:
        found = find()
    except (InvalidInput, SolveFailed) as refusal:
        return _refused(str(refusal))
    except ValidationError as refusal:
        return _refused(" ".join(describe(refusal, "Scene")))
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


def _refused(said: str) -> Verdict:
    text = " ".join(said.split())
    if len(text) > LONGEST:
        return Verdict("WRONG", f"refused in {len(text)} characters: {text[:200]} ...")
    return Verdict("refused", text)
