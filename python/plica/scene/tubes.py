"""The tubes of a scene, below and above the glottis: shapes, walls and far ends (docs/theory/tubes.md)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from plica.errors import InvalidInput
from plica.scene.part import OneOf, Part, engine_default, problem
from plica.scene.tube_shapes import LONGEST, WIDEST, Profile, read_profile, vowel_profile
from plica.units import (
    Area,
    Frequency,
    Length,
    MassPerArea,
    Number,
    PerLength,
    SpecificImpedance,
    Volume,
    VolumeFlow,
)

__all__ = [
    "Closed",
    "FlowSupply",
    "Open",
    "PressureSupply",
    "Reflecting",
    "Rigid",
    "Sections",
    "Supply",
    "Trachea",
    "Tract",
    "TractEnd",
    "Uniform",
    "Vowel",
    "Wall",
    "YieldingWall",
]


class Uniform(Part):
    """A tube of one area."""

    length: Annotated[Length, Field(gt=0, le=LONGEST)]
    """[m] From the glottis to the far end."""
    area: Annotated[Area, Field(gt=0, le=WIDEST)]
    """[m^2] Of the cross-section."""

    def profile(self) -> Profile:
        """Lengths and areas of its parts, from the glottis on."""
        return (self.length,), (self.area,)


class Sections(Part):
    """A tube of parts that are uniform each, from the glottis on."""

    length: Annotated[
        tuple[Annotated[Length, Field(gt=0, le=LONGEST)], ...], Field(min_length=1, max_length=10_000)
    ]
    """[m] Of each part."""
    area: Annotated[
        tuple[Annotated[Area, Field(gt=0, le=WIDEST)], ...], Field(min_length=1, max_length=10_000)
    ]
    """[m^2] Of each part."""

    @model_validator(mode="after")
    def _one_area_each(self) -> Self:
        if len(self.area) != len(self.length):
            relation = (
                f"must have one area for each of the {len(self.length)} lengths; it has {len(self.area)}."
            )
            raise problem(relation, "area")
        if sum(self.length) > LONGEST:
            raise problem(
                f"must add up to at most {LONGEST:g} m.",
                "length",
                value=sum(self.length),
                unit=" m. Is the unit right?",
            )
        return self

    def profile(self) -> Profile:
        """Lengths and areas of its parts, from the glottis on."""
        return self.length, self.area


class Vowel(Part):
    """A smooth tract of Plica's own, A(x) = A exp(sum_n b_n cos((2 n - 1) pi x / L)), whose formants are near
    those of the vowel (docs/tubes.md)."""

    name: Literal["schwa", "a", "i", "u"]
    """Which one."""
    length: Annotated[Length, Field(gt=0, le=LONGEST)] = 0.17
    """[m] From the glottis to the lips. Shorter, formants are higher, the first less than in proportion."""

    def profile(self) -> Profile:
        """Lengths and areas of its parts, from the glottis on."""
        return vowel_profile(self.name, self.length)


class Rigid(Part):
    """A wall that does not move."""


class YieldingWall(Part):
    """A wall that yields, each part on its own under the pressure there. By default that of a relaxed cheek
    (Ishizaka, French and Flanagan 1975)."""

    mass: Annotated[MassPerArea, Field(gt=0)] = Field(default_factory=engine_default("YieldingWall", "mass"))
    """[kg/m^2] Of a unit of area."""
    resistance: Annotated[SpecificImpedance, Field(ge=0)] = Field(
        default_factory=engine_default("YieldingWall", "resistance")
    )
    """[Pa s/m] Of a unit of area."""
    stiffness: Annotated[PerLength, Field(gt=0)] = Field(
        default_factory=engine_default("YieldingWall", "stiffness")
    )
    """[Pa/m] Of a unit of area."""


class Wall(OneOf):
    """The wall of a tube: ``"rigid"`` or ``"yielding"``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"rigid": Rigid, "yielding": YieldingWall}
    rigid: Rigid | None = None
    yielding: YieldingWall | None = None


class Open(Part):
    """Open into the room: the field before a piston in a wall."""


class Closed(Part):
    """Closed."""


class Reflecting(Part):
    """The pressure of the room behind a resistance that gives back a share of each wave."""

    reflection: Annotated[Number, Field(ge=0, le=1)] = Field(
        default_factory=engine_default("PressureSupply", "reflection")
    )
    """[-] 1: the pressure at the end is that of the room; 0: nothing comes back."""


class TractEnd(OneOf):
    """The far end of the vocal tract: ``"open"``, ``"closed"`` or ``"reflecting"``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"open": Open, "closed": Closed, "reflecting": Reflecting}
    open: Open | None = None
    closed: Closed | None = None
    reflecting: Reflecting | None = None


class PressureSupply(Part):
    """The subglottal pressure of the airflow stands behind the trachea."""

    reflection: Annotated[Number, Field(ge=0, le=1)] = Field(
        default_factory=engine_default("PressureSupply", "reflection")
    )
    """[-] Share of a wave that comes back: 1 where the end holds the pressure itself, 0 where nothing comes
    back. The steady flow pays for it: the resistance in between is rho c / A (1 - r) / (1 + r)."""
    volume: Annotated[Volume, Field(ge=0)] = Field(default_factory=engine_default("PressureSupply", "volume"))
    """[m^3] Of air at the far end, which gives way; with a reflection below 1."""

    @model_validator(mode="after")
    def _gives_way(self) -> Self:
        if self.volume > 0 and self.reflection == 1:
            relation = "must be 0: nothing is behind a pressure that is held. Give a reflection < 1."
            raise problem(relation, "volume", value=self.volume)
        return self


class FlowSupply(Part):
    """A flow enters behind the trachea and rises as `airflow.rise` says; the pressure follows from it. The
    airflow's subglottal pressure is then only the unit of the coupling's tolerance: give what is expected."""

    flow: Annotated[VolumeFlow, Field(gt=0)]
    """[m^3/s] From the end of its rise on."""
    volume: Annotated[Volume, Field(ge=0)] = Field(default_factory=engine_default("FlowSupply", "volume"))
    """[m^3] Of air at the far end, which gives way."""


class Supply(OneOf):
    """What drives the air behind the trachea: ``"pressure"`` or a flow, ``{flow = {flow = "200 ml/s"}}``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"pressure": PressureSupply, "flow": FlowSupply}
    pressure: PressureSupply | None = None
    flow: FlowSupply | None = None


class _Tube(OneOf):
    """What both tubes have."""

    friction_frequency: Annotated[Frequency, Field(ge=0)] = Field(
        default_factory=engine_default("Tube", "friction_frequency")
    )
    """[Hz] The air's friction at the wall is that of a boundary layer at this frequency; 0: none."""

    @model_validator(mode="before")
    @classmethod
    def _read_file(cls, data: Any) -> Any:
        """A file of distances and areas, as its sections: a scene that is stored needs it no more."""
        if not isinstance(data, dict) or "file" not in data:
            return data
        if not isinstance(data["file"], (str, Path)):
            raise problem("must be the path of a CSV file of distance and area.", "file", value=data["file"])
        if "sections" in data:
            raise problem("is given beside sections; must be one of them: both are the tube's shape.", "file")
        try:
            length, area = read_profile(Path(data["file"]))
        except InvalidInput as error:
            raise problem(str(error), "file") from None
        rest = {name: value for name, value in data.items() if name != "file"}
        return {**rest, "sections": {"length": list(length), "area": list(area)}}

    @property
    def profile(self) -> Profile:
        """Lengths (m) and areas (m^2) of its parts, from the glottis on."""
        shape: Any = self.choice
        found: Profile = shape.profile()
        return found


class Tract(_Tube):
    """The vocal tract, from the glottis to the lips: one of three shapes, or ``file = "tract.csv"``, a table
    of distance from the glottis and area there, with units in its header: ``distance (cm),area (cm^2)``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"uniform": Uniform, "sections": Sections, "vowel": Vowel}
    uniform: Uniform | None = None
    sections: Sections | None = None
    vowel: Vowel | None = None
    wall: Wall = Field(default_factory=lambda: Wall(yielding=YieldingWall()))
    """Its wall."""
    end: TractEnd = Field(default_factory=lambda: TractEnd(open=Open()))
    """Its far end, the lips."""


class Trachea(_Tube):
    """The air below the glottis, between it and the supply: one of two shapes, or ``file = "trachea.csv"``,
    a table of distance from the glottis and area there, with units in its header: ``distance (cm),area
    (cm^2)``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"uniform": Uniform, "sections": Sections}
    uniform: Uniform | None = None
    sections: Sections | None = None
    wall: Wall = Field(default_factory=lambda: Wall(rigid=Rigid()))
    """Its wall."""
    supply: Supply = Field(default_factory=lambda: Supply(pressure=PressureSupply()))
    """What drives the air at its far end."""
