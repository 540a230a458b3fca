"""The airflow of a scene: flow model, section areas, and coupling to the motion."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from plica.scene.composition import require_combinable
from plica.scene.part import Count, OneOf, Part, engine_default, problem
from plica.units import Density, Number, Pressure, Time, Velocity, Viscosity

__all__ = [
    "Airflow",
    "Bernoulli",
    "Coupling",
    "Course",
    "Cut",
    "Elliptic",
    "Extrapolated",
    "FlowModel",
    "Iterated",
    "Lagged",
    "SectionArea",
    "ViscousSlit",
]

Floats = NDArray[np.floating]


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
    inertance: Annotated[bool, Field(strict=True)] = Field(
        default_factory=engine_default("ViscousSlit", "inertance")
    )
    """Whether the air between the first and the last section has inertia: the flow then lags behind the
    pressure. Without it flow and pressures follow the areas at once."""


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

    @property
    def air_viscosity(self) -> float | None:
        """Pa s; None where the model has no such key."""
        return getattr(self.choice, "air_viscosity", None)


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


class Course(Part):
    """A pressure that changes over time: straight lines between points, that of the first before them, of the
    last after them. A run of it has measures of where it stays, or a caution (`moving_pressure`)."""

    time: Annotated[tuple[Annotated[Time, Field(ge=0)], ...], Field(min_length=2)]
    """[s] Rising, two or more, e.g. ``["50 ms", "0.4 s"]``."""
    pressure: tuple[Annotated[Pressure, Field(ge=0)], ...]
    """[Pa] As many, e.g. ``["0.8 kPa", "0.2 kPa"]``; not all 0."""

    @model_validator(mode="after")
    def _is_a_course(self) -> Self:
        count = len(self.time)
        if len(self.pressure) != count:
            relation = f"must have as many entries as time, {count}."
            raise problem(relation, "pressure", value=list(self.pressure), unit=" Pa")
        for k in range(1, count):
            if not self.time[k] > self.time[k - 1]:
                relation = f"must be > the one before, {self.time[k - 1]:g} s."
                raise problem(relation, "time", k, value=self.time[k], unit=" s")
        if not self.greatest > 0:
            raise problem("must have one > 0 Pa.", "pressure", value=list(self.pressure), unit=" Pa")
        return self

    @property
    def greatest(self) -> float:
        """[Pa]"""
        return max(self.pressure, default=0.0)


class Airflow(Part):
    """One-dimensional flow through the glottis."""

    surface: str = Field(default_factory=engine_default("Airflow", "surface"))
    """The whole airway interface of the mesh."""
    subglottal_pressure: Annotated[Pressure, Field(gt=0)] = Field(
        default_factory=engine_default("Airflow", "subglottal_pressure")
    )
    """[Pa] Below the glottis, or behind the trachea of a scene that has one, above the room's pressure; the
    final value if it rises, the greatest if it has a course."""
    rise: Annotated[Time, Field(ge=0)] = Field(default_factory=engine_default("Airflow", "rise"))
    """[s] Time over which the pressure rises from 0 to its value, as half a cosine: p (1 - cos(pi t / rise))
    / 2; p may have a course. 0: it is there at once, and strains the tissue more than the voice does."""
    course: Course | None = None
    """The subglottal pressure over time, e.g. ``{time = ["50 ms", "0.4 s"], pressure = ["0.8 kPa",
    "0.2 kPa"]}``; `subglottal_pressure` is then left out. Default: it stays as it is."""
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

    @model_validator(mode="before")
    @classmethod
    def _greatest_of_its_course(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("course") is None:
            return data
        if data.get("subglottal_pressure") is not None:  # 0 Pa is told, too
            return data
        try:
            greatest = Course.model_validate(data["course"]).greatest
        except ValidationError:  # which the field says
            return data
        return {**data, "subglottal_pressure": greatest}

    @model_validator(mode="after")
    def _is_the_greatest_of_its_course(self) -> Self:
        require_combinable(self)
        if self.course is not None and self.subglottal_pressure != self.course.greatest:
            raise problem(
                f"must be the greatest of airflow.course, {self.course.greatest:g} Pa, or be left out; where "
                'the voice gives it, by without = ["airflow.subglottal_pressure"].',
                "subglottal_pressure",
                value=self.subglottal_pressure,
                unit=" Pa",
            )
        return self

    def pressure_at(self, time: Floats) -> Floats:
        """The subglottal pressure (k) Pa at times (k) s: what `subglottal_pressure` or `course` says, times
        the half cosine of `rise`."""
        course = self.course
        held = (
            np.full(np.shape(time), self.subglottal_pressure)
            if course is None
            else np.interp(time, course.time, course.pressure)
        )
        if not self.rise:
            return held
        share = np.clip(np.asarray(time) / self.rise, 0.0, 1.0)
        return np.asarray(held * (1 - np.cos(np.pi * share)) / 2)

    @property
    def pressure_at_start(self) -> float:
        """[Pa] The subglottal pressure at t = 0; without a rise."""
        return self.subglottal_pressure if self.course is None else self.course.pressure[0]

    @model_validator(mode="after")
    def _sweeps_exceed_freeze(self) -> Self:
        iterated = self.coupling.iterated
        if self.model.bernoulli is None or iterated is None or iterated.max_sweeps > iterated.freeze_after:
            return self
        relation = f"must be > freeze_after = {iterated.freeze_after} with Bernoulli's flow."
        raise problem(relation, "coupling", "iterated", "max_sweeps", value=iterated.max_sweeps)
