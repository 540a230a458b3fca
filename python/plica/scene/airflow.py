"""The airflow of a scene: flow model, section areas, and coupling to the motion."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from plica.scene.part import Count, OneOf, Part, engine_default, problem
from plica.units import Density, Number, Pressure, Time, Velocity, Viscosity

__all__ = [
    "Airflow",
    "Bernoulli",
    "Coupling",
    "Cut",
    "Elliptic",
    "Extrapolated",
    "FlowModel",
    "Iterated",
    "Lagged",
    "SectionArea",
    "ViscousSlit",
]


class Lagged(Part):
    """The airflow's load is that at the start of the step, as in the thesis. It adds energy."""


class Extrapolated(Part):
    """The airflow's load is evaluated at displacements extrapolated to the time at which the scheme balances
    forces."""


class Iterated(Part):
    """The airflow's load and the motion are iterated within a step until they agree."""

    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("Iterated", "tolerance")
    )
    """[-] Largest change of a section's pressure between sweeps, in subglottal pressures, that ends them."""
    max_sweeps: Count = Field(default_factory=engine_default("Iterated", "max_sweeps"))
    """Largest number of sweeps per step."""
    freeze_after: Count = Field(default_factory=engine_default("Iterated", "freeze_after"))
    """Sweeps after which the separation section and the stop of Bernoulli's flow, which are discontinuous,
    are kept within a step; less than `max_sweeps`. Other flow models have neither."""


class Coupling(OneOf):
    """How the airflow's load follows the motion: ``"lagged"``, ``"extrapolated"`` or ``"iterated"``."""

    kinds: ClassVar[dict[str, type[Part]]] = {
        "lagged": Lagged,
        "extrapolated": Extrapolated,
        "iterated": Iterated,
    }
    lagged: Lagged | None = None
    extrapolated: Extrapolated | None = None
    iterated: Iterated | None = None


class ViscousSlit(Part):
    """A jet that separates from the wall between sections, where the glottis widens, with the viscous loss
    of a slit. Continuous in the shape; a closed glottis is a gap with almost no flow."""

    separation_ratio: Annotated[Number, Field(gt=1, le=2)] = Field(
        default_factory=engine_default("ViscousSlit", "separation_ratio")
    )
    """[-] Area at which the jet separates, over the smallest area upstream; 1.1 to 1.3 are in use."""
    air_viscosity: Annotated[Viscosity, Field(ge=0, lt=1)] = Field(
        default_factory=engine_default("ViscousSlit", "air_viscosity")
    )
    """[Pa s] Of the air in the glottis: 1.8e-5 at 20, 1.9e-5 at 37 degrees Celsius."""
    least_gap: Annotated[Number, Field(gt=0, le=0.01)] = Field(
        default_factory=engine_default("ViscousSlit", "least_gap")
    )
    """[-] Lower limit of the mean gap of a section, relative to the length of the glottis."""


class Bernoulli(Part):
    """The flow of the thesis (Paper A, Eqs. 1 and 2): inviscid, separated at the section of smallest area,
    stopped by contact. It is discontinuous where that section changes and where the flow stops."""

    zero_flow_fraction: Annotated[Number, Field(ge=0, le=1)] = Field(
        default_factory=engine_default("Bernoulli", "zero_flow_fraction")
    )
    """[-] Contact within this fraction of the half-length stops the flow (tau of Paper A, Sec. 2.4)."""


class FlowModel(OneOf):
    """The flow model in the glottis: ``"viscous_slit"`` or, as in the thesis, ``"bernoulli"``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"viscous_slit": ViscousSlit, "bernoulli": Bernoulli}
    viscous_slit: ViscousSlit | None = None
    bernoulli: Bernoulli | None = None


class Cut(Part):
    """Sections cut from the interface at rest that move with the tissue, denser where the glottis is
    narrow."""

    sections: Annotated[int, Field(ge=2, le=1000)] = Field(default_factory=engine_default("Cut", "sections"))
    """Number of sections, independent of the levels of the mesh."""


class Elliptic(Part):
    """Sections at the mesh's levels: two half-ellipses by their mid-coronal half-axes (Paper A, Eq. 3).
    A straight slit has 4 / pi of its ellipse's area."""


class SectionArea(OneOf):
    """How section areas are computed from the shape: ``"cut"``, or ``"elliptic"`` as in the thesis."""

    kinds: ClassVar[dict[str, type[Part]]] = {"cut": Cut, "elliptic": Elliptic}
    cut: Cut | None = None
    elliptic: Elliptic | None = None


class Airflow(Part):
    """One-dimensional flow through the glottis."""

    surface: str = Field(default_factory=engine_default("Airflow", "surface"))
    """The whole airway interface of the mesh."""
    subglottal_pressure: Annotated[Pressure, Field(gt=0)] = Field(
        default_factory=engine_default("Airflow", "subglottal_pressure")
    )
    """[Pa] Below the glottis, or behind the trachea of a scene that has one, above the room's pressure; the
    final value if it rises."""
    rise: Annotated[Time, Field(ge=0)] = Field(default_factory=engine_default("Airflow", "rise"))
    """[s] Time over which the pressure rises from 0 to its value, as half a cosine: p (1 - cos(pi t / rise))
    / 2. 0: it is there at once, and strains the tissue more than the voice does."""
    air_density: Annotated[Density, Field(gt=0)] = Field(
        default_factory=engine_default("Airflow", "air_density")
    )
    """[kg/m^3] Mass per volume of the air."""
    model: FlowModel = Field(default_factory=lambda: FlowModel(viscous_slit=ViscousSlit()))
    """The flow model in the glottis."""
    area: SectionArea = Field(default_factory=lambda: SectionArea(cut=Cut()))
    """How section areas are computed from the shape."""
    sound_speed: Annotated[Velocity, Field(gt=0)] = Field(
        default_factory=engine_default("Airflow", "sound_speed")
    )
    """[m/s] Of the air in trachea and tract, where the scene has them: 343 at 20, 353 at 37 degrees
    Celsius."""
    load_shape: Literal["reference", "current"] = Field(
        default_factory=engine_default("Airflow", "load_shape")
    )
    """Surface on which the pressure acts: at rest, consistent with linear tissue, or deformed (Paper A, Eq.
    17)."""
    coupling: Coupling = Field(default_factory=lambda: Coupling(iterated=Iterated()))
    """How the load follows the motion in time."""

    @model_validator(mode="after")
    def _sweeps_exceed_freeze(self) -> Self:
        iterated = self.coupling.iterated
        if self.model.bernoulli is None or iterated is None or iterated.max_sweeps > iterated.freeze_after:
            return self
        relation = f"must be > freeze_after = {iterated.freeze_after} with Bernoulli's flow."
        raise problem(relation, "coupling", "iterated", "max_sweeps", value=iterated.max_sweeps)
