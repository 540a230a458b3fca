"""Which results of a run are stored."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from plica.scene.part import Part
from plica.units import Length, Time

__all__ = ["Output"]


class Output(Part):
    """Results that are stored in addition to the waveforms, which are stored every step."""

    every: Annotated[Time, Field(gt=0)] | None = None
    """[s] Interval between stored displacement fields, a multiple of the step; default: no fields are
    stored."""
    start: Annotated[Time, Field(ge=0)] = 0.0
    """[s] No fields are stored before this time, a multiple of the step; with 0 the first are those of t =
    0."""
    probes: tuple[tuple[Length, Length, Length], ...] = ()
    """[m] Points in or near the mesh; the displacement of the node nearest to each is stored every step."""
    checkpoint_every: Annotated[Time, Field(gt=0)] = 0.01
    """[s] Simulated time between two checkpoints."""
