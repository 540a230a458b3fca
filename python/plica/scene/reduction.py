"""Reduced basis of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field, model_validator

from plica.scene.part import Count, Part, engine_default, problem
from plica.units import Number

__all__ = ["Reduction"]

_OF_COMMAND = ("full_run", "components", "modes", "contact_vectors", "contact_reach")


class Reduction(Part):
    """Displacements as combinations of few vectors, which ``plica reduce`` makes: principal components of a
    full run's motion, vibration modes, and static responses to the pressure of each section and to forces on
    contact nodes. Airflow and contact are unchanged. Experimental: the error is only known by comparison with
    a full run (docs/reduction.md).
    """

    basis: Annotated[Path, AfterValidator(Path.resolve)]
    """File of the vectors, made with ``plica reduce`` on the same mesh, with the same supports and symmetry.
    A path relative to the scene file."""
    watch_every: Count = Field(default_factory=engine_default("Reduction", "watch_every"))
    """Steps between two computations of strains and inverted tissue, which use the whole mesh; in between,
    waveforms keep the last values."""

    damping_ratio: Annotated[Number, Field(gt=0, le=1)] | None = None
    """[-] Of critical, of every coordinate, in place of the viscosity of the tissue: silicone is nearer
    to it than to a viscosity, with which damping rises with frequency."""

    @model_validator(mode="before")
    @classmethod
    def _vectors_are_made_once(cls, data: Any) -> Any:
        for name in _OF_COMMAND:
            if isinstance(data, dict) and name in data:
                relation = (
                    "must be left out: a basis is made once, with plica reduce RUN -o basis.h5, and given as "
                    'reduction.basis = "basis.h5". See plica reduce --help.'
                )
                raise problem(relation, name)
        return data
