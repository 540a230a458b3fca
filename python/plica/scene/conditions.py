"""Supports, initial values and loads of a scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from plica.scene.part import Part, problem
from plica.units import Frequency, Length, Number, Pressure, Velocity

__all__ = ["Initial", "Load", "Supports"]

Components = Literal["x", "y", "z", "xy", "xz", "yz", "xyz"]


class Supports(Part):
    """Where the tissue is fixed. A table without keys is refused, as it would free a larynx from its wall:
    tissue that nothing holds is written ``fixed = []``."""

    fixed: tuple[str, ...] = ()
    """Node sets fixed in all three components, e.g. ``["wall"]``; ``[]``: none."""
    components: dict[str, Components] = Field(default_factory=dict)
    """Node sets fixed in some components only, e.g. ``{x_min = "x", z_min = "yz"}`` (in Python a dict)."""
    wall_from_y: Annotated[Length, Field(ge=0)] | None = None
    """[m] Of the node set ``wall``, only nodes with |y| >= this are fixed; it must be in `fixed`."""
    cartilages: bool | None = None
    """Of a larynx: whether all tissue in front of and behind the glottis is fixed, as by the thyroid and
    arytenoid cartilages. Otherwise its ends give way, and are strained without limit on ever finer meshes, as
    the tip of a crack is. Default: false. A table of supports replaces the default: `fixed` must have
    ``"wall"`` for the wall to be held, too."""

    @model_validator(mode="before")
    @classmethod
    def _names_something(cls, data: Any) -> Any:
        if data == {}:
            raise problem(
                "is empty; must name what is fixed, or be left out for the default (a larynx is fixed at its "
                "wall). Tissue that nothing holds: fixed = []."
            )
        return data


class Initial(Part):
    """The state at t = 0 if it is not at rest. Fixed components stay zero.

    The opening pattern is for a larynx, and for a mesh file with a glottis. With b the half-length of the
    airway, R the cylinder's radius, z_e and a the height and the minor half-axis of the superior edge of the
    medial surface (S26 of the thesis), z_0 and z_1 the heights at which the airway has widened to four times
    a (below and above), the pattern is lateral, away from the mid-plane on each fold, and has the size

        cos(pi y / 2b) * H(z) * D(x, y),   |y| < b, else 0
        H = 1/2 (1 + cos(pi (z - z_e) / (z_0 - z_e))) for z_0 < z <= z_e, likewise with z_1 above, else 0
        D = (sqrt(R^2 - y^2) - |x|) / (sqrt(R^2 - y^2) - a sqrt(1 - y^2 / b^2)), clipped to [0, 1]

    so it is one at the upper glottal edge in the mid-plane and decreases to zero at the wall. The medial
    surface is where the mid-coronal contour at rest is within 25 degrees of vertical, about the narrowest
    place. Of a mesh file, all this is measured on the airway's surface (that of the airflow; without one,
    the surface ``airway``): the half-axis is half the width of its mid-coronal contour, x counts from the
    middle of the least width and y from that of the airway, and the wall is half an ellipse on each side,
    through the mesh's smallest and largest x and as long as the mesh.
    """

    opening_velocity: Velocity | None = None
    """[m/s] Size of the opening pattern."""
    opening_displacement: Length | None = None
    """[m] Size of the opening pattern."""
    velocity: dict[str, tuple[Velocity, Velocity, Velocity]] = Field(default_factory=dict)
    """[m/s] Uniform over the nodes of a layer, e.g. ``{a = [35, 0, 0]}`` (in Python a dict), or of a fold,
    ``{left = [1, 0, 0], right = [-1, 0, 0]}``; nodes shared by both folds then stay at rest. A node in
    several of the named regions has the value of the last such layer of the mesh, or if there is none that
    of a fold."""
    displacement: dict[str, tuple[Length, Length, Length]] = Field(default_factory=dict)
    """[m] Uniform over the nodes of a layer, or of a fold."""
    equilibrium: bool | Literal["flow"] = False
    """Start from the displacement at rest, to which initial displacements add: ``true`` that under gravity
    and loads, without airflow; ``"flow"`` that under the steady flow of the whole pressure too, which stands
    in trachea and tract (`plica.flow_equilibrium`): below the onset of phonation nothing happens, above it
    what is added grows. Contact is no part of either."""

    @field_validator("equilibrium", mode="before")
    @classmethod
    def _is_known(cls, value: Any) -> Any:
        if isinstance(value, bool) or value == "flow":
            return value
        raise problem('must be true, false or "flow".', value=value)


class Load(Part):
    """A traction prescribed on a surface, t(t) = traction * cos(2 pi frequency t + phase)."""

    surface: str
    """The surface of the mesh."""
    traction: tuple[Pressure, Pressure, Pressure]
    """[Pa] Force per reference area."""
    frequency: Annotated[Frequency, Field(ge=0)] = 0.0
    """[Hz] Frequency of the traction; 0: constant."""
    phase: Number = 0.0
    """[rad] Phase of the traction at t = 0."""
