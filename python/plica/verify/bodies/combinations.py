"""What impacts combine: enforcement of contact, time scheme, mass of the contact surfaces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from plica import _engine as engine
from plica.verify.bodies.body import SCHEMES

__all__ = ["ENFORCEMENTS", "MASSES", "Combination"]

ENFORCEMENTS: dict[str, Callable[[float, float], Any]] = {
    "multipliers": lambda stiffness, area: engine.Multipliers(),
    "multipliers, GMRES": lambda stiffness, area: engine.Multipliers(solver="gmres"),
    "multipliers, Eq. (25)": lambda stiffness, area: engine.Multipliers(position="weighted"),
    "augmented": lambda stiffness, area: engine.Augmented(),
    "Nitsche": lambda stiffness, area: engine.Nitsche(),
    "penalty": lambda stiffness, area: engine.Penalty(stiffness=stiffness * area),
    # Of the three tetrahedra of a prism two push, with kappa V / 4 each.
    "volume penalty": lambda stiffness, area: engine.VolumePenalty(kappa=6 * stiffness),
}
"""By name, from a penalty's stiffness (Pa/m) and a node's area (m^2)."""

MASSES = ("kept", "redistributed")
"""Of the nodes of the contact surfaces."""


@dataclass(frozen=True)
class Combination:
    """One enforcement with one scheme and one mass, by their names."""

    contact: str
    scheme: str
    mass: str

    def __str__(self) -> str:
        return f"{self.contact}, {self.scheme}, mass {self.mass}"

    def parts(self, stiffness: float, area: float) -> tuple[Any, dict[str, Any]]:
        """The scheme, and the arguments of engine.Contact besides the airway."""
        enforcement = ENFORCEMENTS[self.contact](stiffness, area)
        return SCHEMES[self.scheme], {"enforcement": enforcement, "surface_mass": self.mass}
