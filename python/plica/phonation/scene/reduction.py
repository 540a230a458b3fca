"""A scene in few coordinates."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from plica.phonation.scene.part import MAX_COUNT, Count, Part, engine_default, problem
from plica.units import Length

__all__ = ["Reduction"]

Vectors = Annotated[int, Field(ge=0, le=MAX_COUNT)]


class Reduction(Part):
    """Displacements as combinations of few vectors: principal components of a full run's motion, modes of
    vibration, and static responses to the pressure of each section and to forces on contact nodes. Airflow
    and contact stay as they are. Experimental: the error is not known before a full run is compared
    (docs/reduction.md).
    """

    full_run: Annotated[Path, AfterValidator(Path.resolve)] | None = None
    """Directory of a run without reduction, on the same mesh with the same supports, that stored
    displacements of some settled cycles: principal components of these are the basis. With ``symmetry`` it
    has to be given, has that symmetry or none, and its symmetric part is taken. A path beside the scene
    file."""
    components: Vectors | None = None
    """Principal components of `full_run`, those that hold most elastic energy. Left out: 150, or as many
    as it has stored frames; without `full_run` none."""
    modes: Vectors | None = None
    """Lowest modes of vibration. Left out: 200, with `full_run` none."""
    contact_vectors: Vectors | None = None
    """Static responses to normal forces on the contact's nodes: of all, those combinations that hold most
    elastic energy. Without contact there are none. Left out: 100, or as many as the mesh has; with `full_run`
    none."""
    contact_reach: Annotated[Length, Field(gt=0)] = Field(
        default_factory=engine_default("Reduction", "contact_reach")
    )
    """[m] Contact is looked for, and has vectors, where the surfaces are no further apart than this at rest;
    a run in which it goes further fails and says so. With ``symmetry`` it is looked for everywhere."""
    watch_every: Count = Field(default_factory=engine_default("Reduction", "watch_every"))
    """Steps between two looks at strains and folded tissue, which take the whole mesh; waveforms keep the
    last one's values in between."""

    @model_validator(mode="after")
    def _components_are_of_a_run(self) -> Self:
        if self.components is not None and self.full_run is None:
            relation = "must be left out without full_run, whose principal components they are."
            raise problem(relation, "components", value=self.components)
        return self
