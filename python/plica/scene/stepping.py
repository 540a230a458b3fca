"""Time steps and time scheme of a scene."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from plica.scene.composition import require_combinable
from plica.scene.part import OneOf, Part, engine_default, problem
from plica.units import Number, Time

__all__ = ["CentralDifferences", "HilberHughesTaylor", "Newmark", "Scheme", "Stepping", "is_whole"]


def is_whole(count: float) -> bool:
    """Whether a number of steps is an integer to round-off."""
    return count < 2**53 and abs(count - round(count)) <= 1e-6 * count


class HilberHughesTaylor(Part):
    """HHT-alpha, gamma = 1/2 - alpha, beta = (1 - alpha)^2 / 4."""

    alpha: Annotated[Number, Field(ge=-1 / 3, le=0)] = Field(
        default_factory=engine_default("HilberHughesTaylor", "alpha")
    )
    """[-] From -1/3, most numerical damping of high frequencies, to 0, none."""


class Newmark(Part):
    """Newmark's family; beta = 1/4, gamma = 1/2 is the trapezoidal rule, which creates energy at impact."""

    beta: Annotated[Number, Field(gt=0)] = Field(default_factory=engine_default("Newmark", "beta"))
    """[-] Weight of the new acceleration in the displacement; at least gamma / 2."""
    gamma: Annotated[Number, Field(ge=0.5)] = Field(default_factory=engine_default("Newmark", "gamma"))
    """[-] Weight of the new acceleration in the velocity; above 1/2 the scheme damps and is of first
    order."""

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if 2 * self.beta < self.gamma:
            relation = f"must be >= gamma / 2 = {self.gamma / 2:g}, or the step is limited."
            raise problem(relation, "beta", value=self.beta)
        return self


class CentralDifferences(Part):
    """Explicit: a step needs no linear solve, but must be short; mass is lumped, contact must be a penalty.

    A step above the largest stable one is refused, with its value; of tissue at finite strain a run stops
    where the tissue has become too stiff for the step. It does not pay for phonation, whose meshes need about
    a hundred steps in place of one of hht; it does if the motion itself needs such steps, as waves on coarse
    meshes do.
    """


class Scheme(OneOf):
    """The time scheme: ``"hht"``, ``"newmark"``, ``"central_differences"``, or a table,
    ``{hht = {alpha = -0.1}}``."""

    kinds: ClassVar[dict[str, type[Part]]] = {
        "hht": HilberHughesTaylor,
        "newmark": Newmark,
        "central_differences": CentralDifferences,
    }
    hht: HilberHughesTaylor | None = None
    newmark: Newmark | None = None
    central_differences: CentralDifferences | None = None


class Stepping(Part):
    """Time stepping with a constant step."""

    step: Annotated[Time, Field(gt=0)]
    """[s] Time step."""
    duration: Annotated[Time, Field(gt=0)]
    """[s] Simulated time, a multiple of the step."""
    scheme: Scheme = Field(default_factory=lambda: Scheme(hht=HilberHughesTaylor()))
    """The time scheme."""
    mass: Literal["consistent", "lumped"] | None = None
    """The mass matrix; lumped: row sums of linear tetrahedra, diagonal scaling (HRZ) of quadratic ones.
    Default: lumped with central_differences, otherwise consistent."""

    @property
    def lumped_mass(self) -> bool:
        """Whether the mass matrix is diagonal: as `mass` says, or the scheme."""
        explicit = isinstance(self.scheme.choice, CentralDifferences)
        return explicit if self.mass is None else self.mass == "lumped"

    @property
    def steps(self) -> int:
        """Number of steps in the duration."""
        return max(1, round(self.duration / self.step))

    @model_validator(mode="after")
    def _is_combinable(self) -> Self:
        require_combinable(self)
        return self

    @model_validator(mode="after")
    def _whole_steps(self) -> Self:
        count = self.duration / self.step
        if count < 1 - 1e-9 or not is_whole(count):
            relation = f"must be a whole number of steps of {self.step:g} s."
            raise problem(relation, "duration", value=self.duration, unit=" s")
        return self
