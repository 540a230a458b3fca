"""Solvers of the linear systems of a scene."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from plica.scene.part import Count, OneOf, Part, engine_default
from plica.units import Number

__all__ = ["Automatic", "Cholesky", "ConjugateGradients", "LinearMethod", "Solver"]


class Automatic(Part):
    """Cholesky if its factor fits in memory and moves no more bytes than conjugate gradients, which are used
    otherwise."""

    memory: Annotated[Number, Field(ge=0)] = Field(default_factory=engine_default("Automatic", "memory"))
    """[bytes] Largest size of the factor."""


class Cholesky(Part):
    """A sparse factor in single precision, computed once, with iterative refinement."""

    max_iterations: Count = Field(default_factory=engine_default("Cholesky", "max_iterations"))
    """Largest number of solves with the factor per solution; beyond it the step fails."""


class ConjugateGradients(Part):
    """Preconditioned by the diagonal blocks; needs no memory besides the matrix."""

    max_iterations: Count = Field(default_factory=engine_default("ConjugateGradients", "max_iterations"))
    """Largest number per solution; beyond it the step fails."""


class LinearMethod(OneOf):
    """The method for a step's linear systems: ``"auto"``, ``"cholesky"`` or ``"conjugate_gradients"``."""

    kinds: ClassVar[dict[str, type[Part]]] = {
        "auto": Automatic,
        "cholesky": Cholesky,
        "conjugate_gradients": ConjugateGradients,
    }
    auto: Automatic | None = None
    cholesky: Cholesky | None = None
    conjugate_gradients: ConjugateGradients | None = None


class Solver(Part):
    """The linear systems of a step."""

    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 1e-8
    """[-] Relative residual. The relative error of the motion is some tens of times as large with a Cholesky
    factor, and with conjugate gradients at steps that resolve the motion; at steps of 1 ms ten thousand
    times."""
    method: LinearMethod = Field(default_factory=lambda: LinearMethod(auto=Automatic()))
    """The solution method."""
