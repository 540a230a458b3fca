"""A scene in few coordinates."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from plica.phonation.scene.part import MAX_COUNT, Count, Part, engine_default
from plica.units import Length

__all__ = ["Reduction"]


class Reduction(Part):
    """Displacements as combinations of few vectors: modes of vibration, and static responses to the pressure
    of each section and to forces on contact nodes. Airflow and contact stay as they are. Experimental: the
    error is not known before a full run is compared (docs/reduction.md).
    """

    modes: Annotated[int, Field(ge=0, le=MAX_COUNT)] = 200
    """Lowest modes of vibration."""
    contact_vectors: Annotated[int, Field(ge=0, le=MAX_COUNT)] = 100
    """Static responses to normal forces on the contact's nodes: of all, those combinations that hold most
    elastic energy. Without contact there are none."""
    contact_reach: Annotated[Length, Field(gt=0)] = Field(
        default_factory=engine_default("Reduction", "contact_reach")
    )
    """[m] Contact is looked for, and has vectors, where the surfaces are no further apart than this at rest;
    a run in which it goes further fails and says so."""
    watch_every: Count = Field(default_factory=engine_default("Reduction", "watch_every"))
    """Steps between two looks at strains and folded tissue, which take the whole mesh; waveforms keep the
    last one's values in between."""
