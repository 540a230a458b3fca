"""What the impact benchmarks combine: enforcement of contact, time scheme, mass of the contact surfaces."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from plica import _engine as engine
from plica.bench.body import SCHEMES
from plica.errors import InvalidInput, nearest, one_of

__all__ = ["ENFORCEMENTS", "MASSES", "Combination", "chosen", "combinations"]

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


def chosen(asked: Sequence[str] | None, known: Sequence[str], option: str) -> list[str]:
    """The requested names, all for none; raises InvalidInput for an unknown one."""
    for name in asked or ():
        if name not in known:
            raise InvalidInput(f'bench: {option} = "{name}"; must be {one_of(known)}.{nearest(name, known)}')
    return list(asked or known)


def combinations(
    contacts: Sequence[str] | None, schemes: Sequence[str] | None, masses: Sequence[str] | None
) -> list[Combination]:
    """All combinations of the requested names."""
    names = (
        chosen(contacts, list(ENFORCEMENTS), "--contacts"),
        chosen(schemes, list(SCHEMES), "--schemes"),
        chosen(masses, MASSES, "--masses"),
    )
    return [Combination(*parts) for parts in itertools.product(*names)]
