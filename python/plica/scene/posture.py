"""The posture of a larynx: how it is stretched, and which muscles pull, before it moves."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from plica.scene.part import Part, problem
from plica.units import Number, Pressure

__all__ = ["Muscles", "Posture"]

Activation = Annotated[Number, Field(ge=0, le=1)]


class Muscles(Part):
    """Activations of the muscles that set the length of the folds, from 0 to 1; the rule of Titze and Story
    (2002): ``elongation = 0.2 (3 cricothyroid - thyroarytenoid) - 0.2 lateral_cricoarytenoid``."""

    cricothyroid: Activation = 0.0
    """[-] Lengthens the folds."""
    thyroarytenoid: Activation = 0.0
    """[-] Shortens them. What it does to the stress of the body is `posture.active_stress`."""
    lateral_cricoarytenoid: Activation = 0.0
    """[-] Shortens them a little."""

    @property
    def elongation(self) -> float:
        """[-] Of the folds, in shares of their length at rest."""
        return 0.2 * (3 * self.cricothyroid - self.thyroarytenoid) - 0.2 * self.lateral_cricoarytenoid


class Posture(Part):
    """A larynx that is stretched before it moves: the mesh of the scene is its shape at rest, what is held is
    moved along y, and the equilibrium of the stretched tissue is the shape that all else sees. The motion
    about it is linear, with the stiffness that the tissue has there, unless `strain` is finite
    (docs/posture.md)."""

    elongation: Annotated[Number, Field(gt=-0.5, le=1)] | None = None
    """[-] By how much what is held is lengthened along y, in shares of its length at rest: it moves by this
    times its distance from the middle of the mesh. `plica mesh` prints what becomes of the glottis."""
    contraction: Annotated[Number, Field(ge=0, le=1)] = 0.5
    """[-] What is held moves along x and z, too: it becomes (1 + elongation)^-contraction times as wide and
    high. 0.5 keeps its volume; 0 leaves it where it is, and tissue that becomes thinner draws the folds
    apart, most at the ends of the glottis."""
    muscles: Muscles | None = None
    """Activations that set the elongation instead."""
    active_stress: dict[str, Annotated[Pressure, Field(ge=0)]] = Field(default_factory=dict)
    """[Pa] Layer to the stress with which it pulls along its fibre, by area at rest: of a body, that of the
    thyroarytenoid muscle. Layers without fibre pull along y."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if self.elongation is not None and self.muscles is not None:
            raise problem("must be left out: muscles set it.", "elongation", value=self.elongation)
        if self.elongation is None and self.muscles is None and not self.active_stress:
            raise problem("elongation, muscles or active_stress is missing: give one.")
        return self

    @property
    def stretch(self) -> float:
        """[-] The elongation, however it is given."""
        if self.muscles is not None:
            return self.muscles.elongation
        return self.elongation or 0.0
