"""The airflow of a scene: what the air does, and how its load follows the motion."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from plica.phonation.scene.part import Count, OneOf, Part, engine_default, problem
from plica.units import Density, Number, Pressure, Viscosity

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
    """The airflow's load is that of the step's beginning, as in the thesis. It feeds energy in."""


class Extrapolated(Part):
    """The airflow's load is evaluated at displacements extrapolated to where the scheme balances forces."""


class Iterated(Part):
    """The airflow's load and the motion are iterated within a step until they agree."""

    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("Iterated", "tolerance")
    )
    """[-] Largest change of a section's pressure between sweeps, in subglottal pressures, that ends them."""
    max_sweeps: Count = Field(default_factory=engine_default("Iterated", "max_sweeps"))
    """Sweeps a step at most."""
    freeze_after: Count = Field(default_factory=engine_default("Iterated", "freeze_after"))
    """Sweeps after which the separation section and the stop of Bernoulli's flow, which jump, are held within
    a step; less than `max_sweeps`. Other flows know neither."""


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
    """A jet that leaves the wall between sections, where the glottis widens, with the viscous loss of a slit.
    Continuous in the shape; what is closed is a gap through which next to nothing flows."""

    separation_ratio: Annotated[Number, Field(gt=1, le=2)] = Field(
        default_factory=engine_default("ViscousSlit", "separation_ratio")
    )
    """[-] Area over the least area upstream at which the jet leaves the wall; 1.1 to 1.3 are in use."""
    air_viscosity: Annotated[Viscosity, Field(ge=0, lt=1)] = Field(
        default_factory=engine_default("ViscousSlit", "air_viscosity")
    )
    """[Pa s] Of the air in the glottis: 1.8e-5 at 20, 1.9e-5 at 37 degrees Celsius."""
    least_gap: Annotated[Number, Field(gt=0, le=0.01)] = Field(
        default_factory=engine_default("ViscousSlit", "least_gap")
    )
    """[-] Mean gap, in lengths of the glottis, below which a section counts as no narrower."""


class Bernoulli(Part):
    """The thesis's flow (Paper A, Eqs. 1 and 2): inviscid, separated at the section of least area, stopped by
    contact. It jumps where that section changes and where the flow stops."""

    zero_flow_fraction: Annotated[Number, Field(ge=0, le=1)] = Field(
        default_factory=engine_default("Bernoulli", "zero_flow_fraction")
    )
    """[-] Contact within this fraction of the half-length stops the flow (tau of Paper A, Sec. 2.4)."""


class FlowModel(OneOf):
    """What the air does between the folds: ``"viscous_slit"`` or, as in the thesis, ``"bernoulli"``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"viscous_slit": ViscousSlit, "bernoulli": Bernoulli}
    viscous_slit: ViscousSlit | None = None
    bernoulli: Bernoulli | None = None


class Cut(Part):
    """Sections cut from the interface at rest, carried by the tissue, dense where the glottis is narrow."""

    sections: Annotated[int, Field(ge=2, le=1000)] = Field(default_factory=engine_default("Cut", "sections"))
    """How many, whatever the mesh's levels."""


class Elliptic(Part):
    """Sections at the mesh's levels: two half-ellipses by their mid-coronal half-axes (Paper A, Eq. 3).
    A straight slit has 4 / pi of its ellipse's area."""


class SectionArea(OneOf):
    """How section areas follow from the shape: ``"cut"`` from it, or ``"elliptic"`` as in the thesis."""

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
    """[Pa] Above the pressure at the glottal exit."""
    air_density: Annotated[Density, Field(gt=0)] = Field(
        default_factory=engine_default("Airflow", "air_density")
    )
    """[kg/m^3] Mass per volume of the air."""
    model: FlowModel = Field(default_factory=lambda: FlowModel(viscous_slit=ViscousSlit()))
    """What the air does between the folds."""
    area: SectionArea = Field(default_factory=lambda: SectionArea(cut=Cut()))
    """How section areas follow from the shape."""
    load_shape: Literal["reference", "current"] = Field(
        default_factory=engine_default("Airflow", "load_shape")
    )
    """Surface the pressure acts on: at rest, consistent with linear tissue, or deformed (Paper A, Eq. 17)."""
    coupling: Coupling = Field(default_factory=lambda: Coupling(iterated=Iterated()))
    """How the load follows the motion in time."""

    @model_validator(mode="after")
    def _holds_a_jump_for_a_sweep(self) -> Self:
        iterated = self.coupling.iterated
        if self.model.bernoulli is None or iterated is None or iterated.max_sweeps > iterated.freeze_after:
            return self
        relation = f"must be > freeze_after = {iterated.freeze_after} with Bernoulli's flow."
        raise problem(relation, "coupling", "iterated", "max_sweeps", value=iterated.max_sweeps)
