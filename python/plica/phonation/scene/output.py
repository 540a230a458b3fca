"""What of a run is stored."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from plica.phonation.scene.part import Part
from plica.units import Length, Time

__all__ = ["Output"]


class Output(Part):
    """What is stored beside the waveforms, which are stored every step."""

    every: Annotated[Time, Field(gt=0)] | None = None
    """[s] Between stored displacement fields, whole steps; left out, no fields are stored."""
    start: Annotated[Time, Field(ge=0)] = 0.0
    """[s] No fields before this time, whole steps; at 0 the first ones are those of t = 0."""
    probes: tuple[tuple[Length, Length, Length], ...] = ()
    """[m] The displacement of the node nearest to each point, which must be in or near the mesh, is stored
    every step."""
    checkpoint_every: Annotated[Time, Field(gt=0)] = 0.01
    """[s] Of simulated time between two checkpoints."""
