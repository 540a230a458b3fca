"""Reduced basis of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from plica.scene.part import MAX_COUNT, Count, Part, engine_default, problem
from plica.units import Length

__all__ = ["Reduction"]

Vectors = Annotated[int, Field(ge=0, le=MAX_COUNT)]


class Reduction(Part):
    """Displacements as combinations of few vectors: principal components of a full run's motion, vibration
    modes, and static responses to the pressure of each section and to forces on contact nodes. Airflow and
    contact are unchanged. Experimental: the error is only known by comparison with a full run
    (docs/reduction.md).
    """

    full_run: Annotated[Path, AfterValidator(Path.resolve)] | None = None
    """Directory of a run without reduction, on the same mesh with the same supports, that stored
    displacements of some steady cycles: their principal components are the basis. Required with
    ``symmetry``; the run must have that symmetry or none, and its symmetric part is used. A path relative to
    the scene file."""
    components: Vectors | None = None
    """Number of principal components of `full_run`, those with the most elastic energy. Default: 150, or as
    many as it has stored frames; without `full_run` none."""
    modes: Vectors | None = None
    """Number of lowest vibration modes. Default: 200, with `full_run` none."""
    contact_vectors: Vectors | None = None
    """Number of static responses to normal forces on contact nodes: the combinations with the most elastic
    energy. Without contact there are none. Default: 100, or as many as the mesh has; with `full_run` none."""
    contact_reach: Annotated[Length, Field(gt=0)] = 6e-3
    """[m] Contact has vectors where the surfaces are within this distance at rest; it is detected everywhere."""
    watch_every: Count = Field(default_factory=engine_default("Reduction", "watch_every"))
    """Steps between two computations of strains and inverted tissue, which use the whole mesh; in between,
    waveforms keep the last values."""

    @model_validator(mode="after")
    def _components_are_of_a_run(self) -> Self:
        if self.components is not None and self.full_run is None:
            relation = "must be left out without full_run, whose principal components they are."
            raise problem(relation, "components", value=self.components)
        return self
