"""The contact of a scene: its surfaces and its enforcement."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self, get_args

from pydantic import Field, field_validator, model_validator

from plica.errors import nearest, one_of
from plica.scene.composition import require_combinable
from plica.scene.part import Count, OneOf, Part, engine_default, problem
from plica.units import Number, PerLength, Stiffness

__all__ = ["Augmented", "Contact", "Multipliers", "Nitsche", "Penalty", "VolumePenalty"]

Airway = Literal["matched", "triangulated"]


class Multipliers(Part):
    """Lagrange multipliers: the constraint holds exactly, by a saddle-point system (Paper A, Eq. 25)."""

    solver: Literal["auto", "condensed", "saddle", "gmres"] = Field(
        default_factory=engine_default("Multipliers", "solver")
    )
    """Condensation to the contact rows (with stored columns of the compliance), the saddle-point system of
    each active set by conjugate gradients with a constraint preconditioner, or the thesis's GMRES with the
    preconditioner of Eq. (29). "auto" uses "condensed" for up to 5000 surface nodes and "saddle" above."""
    position: Literal["end_of_step", "weighted"] = Field(
        default_factory=engine_default("Multipliers", "position")
    )
    """Position at which the gap is zero: at n + 1, or at (1 + alpha) x_{n+1} - alpha x_n as printed."""


class Penalty(Part):
    """A spring at each node that penetrates (Paper A, Eq. 22)."""

    stiffness: Annotated[Stiffness, Field(gt=0)] = Field(
        default_factory=engine_default("Penalty", "stiffness")
    )
    """[N/m] Stiffness of the spring at one node."""


class VolumePenalty(Part):
    """Forces proportional to the volume of inverted airway tetrahedra (Paper A, Eq. 28)."""

    kappa: Annotated[PerLength, Field(gt=0)] = Field(default_factory=engine_default("VolumePenalty", "kappa"))
    """[Pa/m] Four times the force on the penetrating node divided by the inverted volume."""


class Augmented(Part):
    """Multipliers found by Uzawa's iteration (Paper B, Eqs. 9 and 10), carried from step to step:
    p = max(0, lambda - stiffness * gap) is the next lambda."""

    stiffness: Annotated[Stiffness, Field(gt=0)] = Field(
        default_factory=engine_default("Augmented", "stiffness")
    )
    """[N/m] Stiffness of one node, at the start of each step."""
    growth: Annotated[Number, Field(gt=1)] = Field(default_factory=engine_default("Augmented", "growth"))
    """[-] Factor on the stiffness after an augmentation with too little effect."""
    reduction: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("Augmented", "reduction")
    )
    """[-] Share by which an augmentation must reduce the largest gap error for the stiffness to be kept."""
    max_augmentations: Count = Field(default_factory=engine_default("Augmented", "max_augmentations"))
    """Largest number per step; remaining gaps are then accepted. Paper B shows 4."""


class Nitsche(Part):
    """Nitsche's method: the force is the tissue's normal stress at the surface, corrected by the gap."""

    factor: Annotated[Number, Field(gt=0)] = Field(default_factory=engine_default("Nitsche", "factor"))
    """[-] Pressure per gap, in units of the stiffness of a layer of tissue one mean edge thick, including its
    inertia within a step."""


class Contact(OneOf):
    """Contact between two surfaces, joined by airway tetrahedra, with one enforcement method.

    Multipliers are exact and recommended; augmented multipliers find the same forces iteratively, Nitsche's
    method nearly the same; penalties are soft and leave gaps. ``surface_mass="redistributed"`` prevents
    chatter at impacts and makes their pressure converge. In Python:
    ``Contact(multipliers=Multipliers(), friction=0.3)`` or ``Contact(nitsche={"factor": 20})``.
    """

    kinds: ClassVar[dict[str, type[Part]]] = {
        "multipliers": Multipliers,
        "penalty": Penalty,
        "volume_penalty": VolumePenalty,
        "augmented": Augmented,
        "nitsche": Nitsche,
    }
    multipliers: Multipliers | None = None
    penalty: Penalty | None = None
    volume_penalty: VolumePenalty | None = None
    augmented: Augmented | None = None
    nitsche: Nitsche | None = None
    first: str = "airway_left"
    """Surface of the first body; in a larynx, the left fold."""
    second: str = "airway_right"
    """Surface of the other body."""
    airway: Airway = "matched"
    """How the air between the surfaces is meshed: once, between nodes that face each other, or again in each
    step between any two meshes (needs a build with `PLICA_GPL=ON`)."""
    direction: tuple[Number, Number, Number] = (1.0, 0.0, 0.0)
    """[-] Direction along which nodes of the two surfaces face each other; only for the matched airway."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("Contact", "tolerance")
    )
    """[-] Largest remaining penetration, relative to the mean edge of the interface."""
    max_passes: Count = Field(default_factory=engine_default("Contact", "max_passes"))
    """Largest number of updates of the contact rows per step; beyond it, with a symmetry beyond 40, nodes are
    held apart from those that they face at rest (docs/theory/contact_solve.md)."""
    faces: Literal["nodes", "mortar"] = Field(default_factory=engine_default("Contact", "faces"))
    """Where gaps are constrained: at nodes (Paper A, Eqs. 18-20), with quadratic faces as four flat triangles
    each, or in the mean around each corner, with forces distributed by the faces' shape functions:
    consistent on quadratic faces."""
    friction: Annotated[Number, Field(gt=0)] | None = None
    """[-] Coulomb friction coefficient of the surfaces, for multipliers (solver "auto" or "condensed") and,
    slower, augmented multipliers; default: no friction. On mortar faces steps may not converge."""
    surface_mass: Literal["kept", "redistributed"] = Field(
        default_factory=engine_default("Contact", "surface_mass")
    )
    """Mass of the nodes that can touch: kept, or moved to nodes behind them, so that impacts do not chatter
    and their impulse and pressure converge with the step. Use `order = 2` and a fine mesh with it, for
    phonation `larynx = "finest"`: on coarse meshes collisions are too weak."""

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.direction):
            raise problem("must not be zero.", "direction", value=list(self.direction))
        return self

    @field_validator("airway", mode="before")
    @classmethod
    def _is_no_surface(cls, airway: object) -> object:
        """The surfaces are `first` and `second`; a mesh file's surface `airway` has its name in common."""
        if isinstance(airway, str) and airway not in get_args(Airway):
            relation = (
                f"must be {one_of(get_args(Airway))}: how the air between the surfaces is "
                f"meshed.{nearest(airway, get_args(Airway))} "
                "The surfaces themselves are contact.first and contact.second."
            )
            raise problem(relation, value=airway)
        return airway

    @model_validator(mode="after")
    def _has_two_surfaces(self) -> Self:
        if self.first == self.second:
            raise problem(
                "must differ from first: contact is between two surfaces.", "second", value=self.second
            )
        return self

    @model_validator(mode="after")
    def _is_combinable(self) -> Self:
        require_combinable(self)
        return self
