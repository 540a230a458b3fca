"""How large the strains of a scene's tissue may be."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from plica.scene.part import Count, OneOf, Part, engine_default
from plica.units import Number

__all__ = ["FiniteStrain", "Strain"]


class FiniteStrain(Part):
    """The tissue's force is that of its law at the whole deformation (docs/theory/finite_strain.md): it
    stiffens and softens as it is strained, and turns without strain. A step costs some four times that of
    linear tissue."""

    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("FiniteStrain", "tolerance")
    )
    """[-] What a step may leave out of balance, of the tissue's force."""
    max_iterations: Count = Field(default_factory=engine_default("FiniteStrain", "max_iterations"))
    """Largest number in a step; beyond it the step fails."""


class Strain(OneOf):
    """``"finite"``, or a table, ``{finite = {tolerance = 1e-5}}``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"finite": FiniteStrain}
    finite: FiniteStrain | None = None
