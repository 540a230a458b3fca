"""One combination of parts of a scene that is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from plica.scene.composition_faults import Fault

__all__ = ["Combination"]


@dataclass(frozen=True)
class Combination:
    """A combination that is refused.

    Attributes
    ----------
    of : str
        Class of the part in which it is looked for.
    option, other : str
        What cannot be combined, as keys of the scene.
    must : str
        What must hold of the option instead.
    reason : str
        Why.
    kind : {"physics", "construction"}
        construction: it could be built.
    found : callable
        Path of the option in a part, and the value that is shown, where the part has both; else None.
    """

    of: Literal["Scene", "Airflow", "Contact", "Stepping", "MeshFile"]
    option: str
    other: str
    must: str
    reason: str
    kind: Literal["physics", "construction"]
    found: Callable[[Any], Fault]

    @property
    def relation(self) -> str:
        """What must hold, and why, as in messages."""
        return f"{self.must} with {self.other}: {self.reason}"
