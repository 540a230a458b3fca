"""The parts of a scene beside its mesh. What a scene does not name does not exist.

Every physical field takes a number in SI or a text with a unit: ``E="1 kPa"``. The unit in brackets is
the one in which the field is kept.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from plica.phonation.scene.part import OneOf, Part, engine_default, problem
from plica.units import (
    Density,
    Frequency,
    Length,
    Number,
    PerLength,
    Pressure,
    Stiffness,
    Time,
    Velocity,
    Viscosity,
)

__all__ = [
    "Airflow",
    "Augmented",
    "Automatic",
    "Bernoulli",
    "Cholesky",
    "ConjugateGradients",
    "Contact",
    "Coupling",
    "Cut",
    "Elliptic",
    "Extrapolated",
    "FlowModel",
    "HilberHughesTaylor",
    "Initial",
    "Iterated",
    "Lagged",
    "LinearMethod",
    "Load",
    "Multipliers",
    "Newmark",
    "Nitsche",
    "Output",
    "Penalty",
    "Scheme",
    "SectionArea",
    "Solver",
    "Stepping",
    "Supports",
    "ViscousSlit",
    "VolumePenalty",
]

MAX_COUNT = 10**9
"""Of a whole number that the engine takes, which has 32 bits."""

Count = Annotated[int, Field(ge=1, le=MAX_COUNT)]
Components = Literal["x", "y", "z", "xy", "xz", "yz", "xyz"]


def is_whole(count: float) -> bool:
    """Whether a number of steps is whole but for round-off."""
    return count < 2**53 and abs(count - round(count)) <= 1e-6 * count


class Supports(Part):
    """Where the tissue is held."""

    fixed: tuple[str, ...] = ()
    """Node sets held in all three components, e.g. ``["wall"]``."""
    components: dict[str, Components] = Field(default_factory=dict)
    """Node sets held in some components only, e.g. ``{x_min = "x", z_min = "yz"}`` (in Python a dict)."""
    wall_from_y: Annotated[Length, Field(ge=0)] | None = None
    """[m] Of the node set ``wall``, only nodes with |y| >= this are held; it must be in `fixed`."""


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
    """Sweeps after which the separation section and the stop of Bernoulli's flow, which jump, are held within a
    step; less than `max_sweeps`. Other flows know neither."""


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


class Multipliers(Part):
    """Lagrange multipliers: the constraint holds exactly, by a saddle-point system (Paper A, Eq. 25)."""

    solver: Literal["auto", "condensed", "saddle", "gmres"] = Field(
        default_factory=engine_default("Multipliers", "solver")
    )
    """Condensed to the contact rows (columns of the compliance, kept), the saddle point of each active set by
    conjugate gradients with a constraint preconditioner, or the thesis's GMRES with that of Eq. (29). "auto"
    takes "condensed" for up to 3000 surface nodes and "saddle" above."""
    position: Literal["end_of_step", "weighted"] = Field(
        default_factory=engine_default("Multipliers", "position")
    )
    """Where the gap vanishes: at n + 1, or at (1 + alpha) x_{n+1} - alpha x_n as printed."""


class Penalty(Part):
    """A spring at each node that penetrates (Paper A, Eq. 22)."""

    stiffness: Annotated[Stiffness, Field(gt=0)] = Field(
        default_factory=engine_default("Penalty", "stiffness")
    )
    """[N/m] Of the spring at one node."""


class VolumePenalty(Part):
    """Forces proportional to the volume of inverted airway tetrahedra (Paper A, Eq. 28)."""

    kappa: Annotated[PerLength, Field(gt=0)] = Field(default_factory=engine_default("VolumePenalty", "kappa"))
    """[Pa/m] Four times the force on the penetrating node over the inverted volume."""


class Augmented(Part):
    """Multipliers found by Uzawa's iteration (Paper B, Eqs. 9 and 10), carried from step to step:
    p = max(0, lambda - stiffness * gap) is the next lambda."""

    stiffness: Annotated[Stiffness, Field(gt=0)] = Field(
        default_factory=engine_default("Augmented", "stiffness")
    )
    """[N/m] Of one node, at the start of each step."""
    growth: Annotated[Number, Field(gt=1)] = Field(default_factory=engine_default("Augmented", "growth"))
    """[-] Factor of the stiffness where an augmentation did too little."""
    reduction: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("Augmented", "reduction")
    )
    """[-] Share by which an augmentation has to lower the largest gap error for the stiffness to stay."""
    max_augmentations: Count = Field(default_factory=engine_default("Augmented", "max_augmentations"))
    """Of one step, which keeps the gaps that are left then; Paper B shows 4."""


class Nitsche(Part):
    """Nitsche's method: the tissue's own normal stress at the surface is the force, corrected by the gap."""

    factor: Annotated[Number, Field(gt=0)] = Field(default_factory=engine_default("Nitsche", "factor"))
    """[-] Of the gap's part: pressure a gap, in stiffnesses of a layer of tissue one mean edge thick, its
    inertia within a step included."""


class Contact(OneOf):
    """Contact between two surfaces, joined by airway tetrahedra, with one way to enforce it.

    Multipliers are exact and the default to choose; augmented multipliers find the same forces step by step,
    Nitsche's method nearly the same; penalties are soft and leave gaps. ``surface_mass="redistributed"`` ends
    the chatter of an impact. In Python: ``Contact(multipliers=Multipliers(), friction=0.3)`` or
    ``Contact(nitsche={"factor": 20})``.
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
    """Surface of the one body; of a larynx, the left fold."""
    second: str = "airway_right"
    """Surface of the other body."""
    airway: Literal["matched", "triangulated"] = "matched"
    """How the air between the surfaces is cut: once, between nodes that face each other, or anew each step
    between any two meshes (needs a build with `PLICA_GPL=ON`)."""
    direction: tuple[Number, Number, Number] = (1.0, 0.0, 0.0)
    """[-] Nodes of the two surfaces face each other along this direction; of the matched airway only."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default_factory=engine_default("Contact", "tolerance")
    )
    """[-] Deepest gap left, relative to the mean edge of the interface."""
    max_passes: Count = Field(default_factory=engine_default("Contact", "max_passes"))
    """Rebuildings of the contact rows a step at most."""
    faces: Literal["nodes", "mortar"] = Field(default_factory=engine_default("Contact", "faces"))
    """Where gaps are held: at nodes (Paper A, Eqs. 18-20), quadratic faces being four flat triangles each, or
    in the mean around each corner, forces spread by the faces' shape functions: right on quadratic faces."""
    friction: Annotated[Number, Field(gt=0)] | None = None
    """[-] Coulomb's coefficient between the surfaces, for multipliers (solver "auto" or "condensed") and,
    slower, augmented multipliers; left out, there is no friction. On mortar faces steps may not converge."""
    surface_mass: Literal["kept", "redistributed"] = Field(
        default_factory=engine_default("Contact", "surface_mass")
    )
    """Mass of the nodes that can touch: kept, or given to nodes behind them, against chatter at impact. Use
    `order = 2` with it: coarse linear elements then answer a collision with half the impulse."""

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.direction):
            raise problem("must not be zero.", "direction", value=list(self.direction))
        if self.airway == "triangulated" and self.direction != Contact.model_fields["direction"].default:
            relation = "must be left out. A triangulated airway has no direction."
            raise problem(relation, "direction", value=list(self.direction))
        return self

    @model_validator(mode="after")
    def _has_two_surfaces(self) -> Self:
        if self.first == self.second:
            raise problem(
                "must be another surface than first: contact is between two.", "second", value=self.second
            )
        return self

    @model_validator(mode="after")
    def _faces_fit_the_enforcement(self) -> Self:
        relation = ""
        if self.volume_penalty is not None:
            relation = (
                'must be "nodes" with the volume penalty, whose faces are those of the airway tetrahedra.'
            )
        if self.nitsche is not None:
            relation = "must be \"nodes\" with Nitsche's method, which takes the tissue's stress at nodes."
        if self.faces == "mortar" and relation:
            raise problem(relation, "faces", value=self.faces)
        return self

    @model_validator(mode="after")
    def _friction_has_multipliers(self) -> Self:
        condensed = self.multipliers is not None and self.multipliers.solver in ("auto", "condensed")
        if self.friction is not None and not condensed and self.augmented is None:
            relation = (
                'must come with multipliers (solver "auto" or "condensed") or augmented multipliers. '
                "Leave it out for none."
            )
            raise problem(relation, "friction", value=self.friction)
        return self


class Initial(Part):
    """The state at t = 0 where it is not rest. Held components stay zero.

    The opening patterns are for a larynx. With b the half-length of the airway, R the cylinder's radius,
    a and z_e the minor half-axis and the height of the upper glottal edge (the thesis's S26), z_0 and z_1 the
    heights at which the airway has widened to four times a (below and above), the pattern is lateral, away
    from the mid-plane on each fold, and has the size

        cos(pi y / 2b) * H(z) * D(x, y),   |y| < b, else 0
        H = 1/2 (1 + cos(pi (z - z_e) / (z_0 - z_e))) for z_0 < z <= z_e, likewise with z_1 above, else 0
        D = (sqrt(R^2 - y^2) - |x|) / (sqrt(R^2 - y^2) - a sqrt(1 - y^2 / b^2)), held within [0, 1]

    so it is one at the upper glottal edge in the mid-plane and falls to zero at the wall.
    """

    opening_velocity: Velocity | None = None
    """[m/s] Size of the opening pattern; larynx only."""
    opening_displacement: Length | None = None
    """[m] Size of the opening pattern; larynx only."""
    velocity: dict[str, tuple[Velocity, Velocity, Velocity]] = Field(default_factory=dict)
    """[m/s] Uniform over the nodes of a layer, e.g. ``{a = [35, 0, 0]}`` (in Python a dict), or of a fold,
    ``{left = [1, 0, 0], right = [-1, 0, 0]}``; nodes of both folds then stay at rest. Where a node is in
    several that are named, it takes the value of the mesh's last such layer, a fold's where there is none."""
    displacement: dict[str, tuple[Length, Length, Length]] = Field(default_factory=dict)
    """[m] Uniform over the nodes of a layer, or of a fold."""
    equilibrium: bool = False
    """Start from the displacement at rest under gravity and loads, without airflow and contact."""


class Load(Part):
    """A traction prescribed on a surface, t(t) = traction * cos(2 pi frequency t + phase)."""

    surface: str
    """The surface of the mesh."""
    traction: tuple[Pressure, Pressure, Pressure]
    """[Pa] Force per reference area."""
    frequency: Annotated[Frequency, Field(ge=0)] = 0.0
    """[Hz] Of the traction in time; 0: constant."""
    phase: Number = 0.0
    """[rad] Of the traction at t = 0."""


class HilberHughesTaylor(Part):
    """HHT-alpha, gamma = 1/2 - alpha, beta = (1 - alpha)^2 / 4."""

    alpha: Annotated[Number, Field(ge=-1 / 3, le=0)] = Field(
        default_factory=engine_default("HilberHughesTaylor", "alpha")
    )
    """[-] From -1/3, most damping of short waves, to 0, none."""


class Newmark(Part):
    """Newmark's family; beta = 1/4, gamma = 1/2 is the trapezoidal rule, which creates energy at impact."""

    beta: Annotated[Number, Field(gt=0)] = Field(default_factory=engine_default("Newmark", "beta"))
    """[-] Weight of the new acceleration in the displacement; at least gamma / 2."""
    gamma: Annotated[Number, Field(ge=0.5)] = Field(default_factory=engine_default("Newmark", "gamma"))
    """[-] Weight of the new acceleration in the velocity; above 1/2 the scheme damps, to first order."""

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if 2 * self.beta < self.gamma:
            relation = f"must be >= gamma / 2 = {self.gamma / 2:g}, or the step is limited."
            raise problem(relation, "beta", value=self.beta)
        return self


class Scheme(OneOf):
    """The time scheme: ``"hht"``, ``"newmark"``, or a table, ``{hht = {alpha = -0.1}}``."""

    kinds: ClassVar[dict[str, type[Part]]] = {"hht": HilberHughesTaylor, "newmark": Newmark}
    hht: HilberHughesTaylor | None = None
    newmark: Newmark | None = None


class Stepping(Part):
    """Time stepping with a constant step."""

    step: Annotated[Time, Field(gt=0)]
    """[s] Between two instants."""
    duration: Annotated[Time, Field(gt=0)]
    """[s] Simulated in all, whole steps."""
    scheme: Scheme = Field(default_factory=lambda: Scheme(hht=HilberHughesTaylor()))
    """The time scheme."""
    mass: Literal["consistent", "lumped"] = "consistent"
    """The mass matrix; lumped: row sums of linear tetrahedra, diagonal scaling (HRZ) of quadratic ones."""

    @property
    def steps(self) -> int:
        """Number of steps that covers the duration."""
        return max(1, round(self.duration / self.step))

    @model_validator(mode="after")
    def _whole_steps(self) -> Self:
        count = self.duration / self.step
        if count < 1 - 1e-9 or not is_whole(count):
            raise problem(
                f"must be a whole number of steps of {self.step:g} s.", "duration", value=self.duration
            )
        return self


class Automatic(Part):
    """Cholesky where its factor fits and moves no more bytes than conjugate gradients, these otherwise."""

    memory: Annotated[Number, Field(ge=0)] = Field(default_factory=engine_default("Automatic", "memory"))
    """[bytes] That the factor may take."""


class Cholesky(Part):
    """A sparse factor in single precision, computed once, with iterative refinement."""

    max_iterations: Count = Field(default_factory=engine_default("Cholesky", "max_iterations"))
    """Solves with the factor of one solution; beyond them the step fails."""


class ConjugateGradients(Part):
    """Preconditioned by the diagonal blocks; keeps nothing beside the matrix."""

    max_iterations: Count = Field(default_factory=engine_default("ConjugateGradients", "max_iterations"))
    """Of one solution; beyond them the step fails."""


class LinearMethod(OneOf):
    """How a step's linear systems are solved: ``"auto"``, ``"cholesky"`` or ``"conjugate_gradients"``."""

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
    """[-] Relative residual."""
    method: LinearMethod = Field(default_factory=lambda: LinearMethod(auto=Automatic()))
    """How they are solved."""


class Output(Part):
    """What is stored beside the waveforms, which are stored every step."""

    every: Annotated[Time, Field(gt=0)] | None = None
    """[s] Between stored displacement fields, whole steps; left out, no fields are stored."""
    start: Annotated[Time, Field(ge=0)] = 0.0
    """[s] No fields before this time, whole steps; at 0 the first ones are those of t = 0."""
    probes: tuple[tuple[Length, Length, Length], ...] = ()
    """[m] The displacement of the node nearest to each point, which must be in or near the mesh, is stored
    every step."""
    checkpoint_every: Annotated[Time, Field(gt=0)] = 0.01
    """[s] Of simulated time between two checkpoints."""
