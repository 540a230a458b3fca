"""
The compiled engine of plica; private, see the package plica.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "AffineTissue",
    "Airflow",
    "Airway",
    "Assembly",
    "AtNodes",
    "Augmented",
    "Automatic",
    "Bernoulli",
    "CentralDifferences",
    "Cholesky",
    "ConjugateGradients",
    "Contact",
    "ContactEquilibrium",
    "Course",
    "Cut",
    "DEEPEST_LAYER",
    "Elliptic",
    "Extrapolated",
    "FiniteStrain",
    "FlowOptions",
    "FlowSupply",
    "FlowTangent",
    "GlottalFlow",
    "HilberHughesTaylor",
    "InvalidInput",
    "Isotropic",
    "Iterated",
    "Lagged",
    "LastBasis",
    "Load",
    "Material",
    "Mortar",
    "Multipliers",
    "Newmark",
    "Nitsche",
    "Penalty",
    "PressureSupply",
    "Radiation",
    "Reduction",
    "SeenTube",
    "Simulation",
    "SolveFailed",
    "StaticSolver",
    "StrainGauge",
    "StretchedMesh",
    "StretchedStatics",
    "TetMesh",
    "TransverselyIsotropic",
    "Tube",
    "ViscousSlit",
    "VolumePenalty",
    "Waveform",
    "YieldingWall",
    "block_mesh",
    "body_of_nodes",
    "boundary",
    "build_info",
    "check_mesh",
    "cholesky",
    "combine",
    "congruence",
    "contact_equilibrium",
    "corner_normals",
    "dense_flow",
    "elasticity_matrix",
    "equilibrium",
    "first_hits",
    "flat_triangles",
    "flow_residual",
    "free_bodies",
    "gram_update",
    "heights_above",
    "hits_near",
    "interpolated",
    "larynx_mesh",
    "larynx_preset",
    "least_jacobian_ratios",
    "light_gains",
    "matched_airway",
    "periodic_spline",
    "pressure_patterns",
    "product",
    "rasterise_triangles",
    "round_trip",
    "scheme_coefficients",
    "set_threads",
    "signed_volumes",
    "solve_lower",
    "solve_upper",
    "stiffness_coefficients",
    "stiffness_derivative",
    "stiffness_parameters",
    "stretched",
    "symmetric_product",
    "threads",
    "to_quadratic",
    "toeplitz_gram",
    "toeplitz_product",
    "toeplitz_transposed_product",
    "tract",
    "triangulated_airway",
    "waveforms",
    "within_hull",
]

class InvalidInput(ValueError):
    pass

class SolveFailed(RuntimeError):
    pass

class TetMesh:
    def __init__(
        self,
        points: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        cells: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        cell_layer: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]] | None = None,
        cell_side: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]] | None = None,
        layer_names: collections.abc.Sequence[str] = [],
        surfaces: collections.abc.Mapping[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]] = {},
        node_sets: collections.abc.Mapping[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]] = {},
        rest: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None,
    ) -> None: ...
    @property
    def cell_layer(self) -> numpy.typing.NDArray[numpy.int32]: ...
    @property
    def cell_side(self) -> numpy.typing.NDArray[numpy.int32]: ...
    @property
    def cells(self) -> numpy.typing.NDArray[numpy.int32]: ...
    @property
    def layer_names(self) -> list[str]: ...
    @property
    def node_sets(self) -> dict[str, numpy.typing.NDArray[numpy.int32]]: ...
    @property
    def order(self) -> int: ...
    @property
    def points(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def rest(self) -> numpy.typing.NDArray[numpy.float64] | None: ...
    @property
    def surfaces(self) -> dict[str, numpy.typing.NDArray[numpy.int32]]: ...

class Isotropic:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"E": 20000.0, "nu": 0.45}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        E: typing.SupportsFloat | typing.SupportsIndex = 20000.0,
        nu: typing.SupportsFloat | typing.SupportsIndex = 0.45,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def E(self) -> float: ...
    @property
    def nu(self) -> float: ...

class TransverselyIsotropic:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "E": 1000.0,
        "nu": 0.66,
        "E_fibre": 10000.0,
        "nu_fibre": 0.66,
        "mu_fibre": 10000.0,
        "mu": None,
        "fibre": (0.0, 1.0, 0.0),
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        E: typing.SupportsFloat | typing.SupportsIndex = 1000.0,
        nu: typing.SupportsFloat | typing.SupportsIndex = 0.66,
        E_fibre: typing.SupportsFloat | typing.SupportsIndex = 10000.0,
        nu_fibre: typing.SupportsFloat | typing.SupportsIndex = 0.66,
        mu_fibre: typing.SupportsFloat | typing.SupportsIndex = 10000.0,
        mu: typing.SupportsFloat | typing.SupportsIndex | None = None,
        fibre: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
        ] = [0.0, 1.0, 0.0],
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def E(self) -> float: ...
    @property
    def E_fibre(self) -> float: ...
    @property
    def fibre(self) -> tuple[float, float, float]: ...
    @property
    def mu(self) -> float | None: ...
    @property
    def mu_fibre(self) -> float: ...
    @property
    def nu(self) -> float: ...
    @property
    def nu_fibre(self) -> float: ...

class Material:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "density": 1020.0,
        "viscosity": 0.0,
        "stiffening": 0.0,
        "matrix_stiffening": 0.0,
        "active_stress": 0.0,
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        elasticity: Isotropic | TransverselyIsotropic,
        density: typing.SupportsFloat | typing.SupportsIndex = 1020.0,
        viscosity: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        stiffening: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        matrix_stiffening: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        active_stress: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    def validate(self, where: str) -> None: ...
    @property
    def active_stress(self) -> float: ...
    @property
    def density(self) -> float: ...
    @property
    def elasticity(self) -> Isotropic | TransverselyIsotropic: ...
    @property
    def matrix_stiffening(self) -> float: ...
    @property
    def stiffening(self) -> float: ...
    @property
    def viscosity(self) -> float: ...

class Assembly:
    def __init__(
        self,
        mesh: TetMesh,
        materials: collections.abc.Sequence[Material],
        material_names: collections.abc.Sequence[str],
        cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    ) -> None: ...
    def lumped_mass(self) -> numpy.typing.NDArray[numpy.float64]: ...
    def mass(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    def stiffness(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    def stress(self) -> numpy.typing.NDArray[numpy.float64]: ...
    def viscosity(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...

class StrainGauge:
    def __init__(self, mesh: TetMesh, *, green: bool = False) -> None: ...
    def at_points(
        self, displacement: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]
    ) -> numpy.typing.NDArray[numpy.float64]: ...
    def volumes(self) -> numpy.typing.NDArray[numpy.float64]: ...

class YieldingWall:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "mass": 21.0,
        "resistance": 8000.0,
        "stiffness": 845000.0,
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        mass: typing.SupportsFloat | typing.SupportsIndex = 21.0,
        resistance: typing.SupportsFloat | typing.SupportsIndex = 8000.0,
        stiffness: typing.SupportsFloat | typing.SupportsIndex = 845000.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def mass(self) -> float: ...
    @property
    def resistance(self) -> float: ...
    @property
    def stiffness(self) -> float: ...

class Radiation:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...

class PressureSupply:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"reflection": 1.0, "volume": 0.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        reflection: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        volume: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def reflection(self) -> float: ...
    @property
    def volume(self) -> float: ...

class FlowSupply:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"flow": 0.0, "volume": 0.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        flow: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        volume: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def flow(self) -> float: ...
    @property
    def volume(self) -> float: ...

class Tube:
    _defaults: typing.ClassVar[dict[str, typing.Any]]
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        length: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        area: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        end: Radiation | PressureSupply | FlowSupply = ...,
        wall: YieldingWall | None = None,
        friction_frequency: typing.SupportsFloat | typing.SupportsIndex = 1000.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def area(self) -> tuple[typing.Any, ...]: ...
    @property
    def end(self) -> Radiation | PressureSupply | FlowSupply: ...
    @property
    def friction_frequency(self) -> float: ...
    @property
    def length(self) -> tuple[typing.Any, ...]: ...
    @property
    def wall(self) -> YieldingWall | None: ...

class FlowOptions:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "smoothness": 0.045,
        "data_scale": 3.5,
        "smooth_scale": 0.1,
        "data_penalty": "lorentzian",
        "smooth_penalty": "lorentzian",
        "gradient_noise": None,
        "light": "smooth",
        "stages": 3,
        "levels": None,
        "spacing": 2.0,
        "fine_levels": 2,
        "fine_spacing": 1.25,
        "warps": 10,
        "largest_step": 1.0,
        "sweeps": 10,
        "relaxation": 1.9,
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        smoothness: typing.SupportsFloat | typing.SupportsIndex = 0.045,
        data_scale: typing.SupportsFloat | typing.SupportsIndex = 3.5,
        smooth_scale: typing.SupportsFloat | typing.SupportsIndex = 0.1,
        data_penalty: str = "lorentzian",
        smooth_penalty: str = "lorentzian",
        gradient_noise: typing.SupportsFloat | typing.SupportsIndex | None = None,
        light: str = "smooth",
        stages: typing.SupportsInt | typing.SupportsIndex = 3,
        levels: typing.SupportsInt | typing.SupportsIndex | None = None,
        spacing: typing.SupportsFloat | typing.SupportsIndex = 2.0,
        fine_levels: typing.SupportsInt | typing.SupportsIndex = 2,
        fine_spacing: typing.SupportsFloat | typing.SupportsIndex = 1.25,
        warps: typing.SupportsInt | typing.SupportsIndex = 10,
        largest_step: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        sweeps: typing.SupportsInt | typing.SupportsIndex = 10,
        relaxation: typing.SupportsFloat | typing.SupportsIndex = 1.9,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def data_penalty(self) -> str: ...
    @property
    def data_scale(self) -> float: ...
    @property
    def fine_levels(self) -> int: ...
    @property
    def fine_spacing(self) -> float: ...
    @property
    def gradient_noise(self) -> float | None: ...
    @property
    def largest_step(self) -> float: ...
    @property
    def levels(self) -> int | None: ...
    @property
    def light(self) -> str: ...
    @property
    def relaxation(self) -> float: ...
    @property
    def smooth_penalty(self) -> str: ...
    @property
    def smooth_scale(self) -> float: ...
    @property
    def smoothness(self) -> float: ...
    @property
    def spacing(self) -> float: ...
    @property
    def stages(self) -> int: ...
    @property
    def sweeps(self) -> int: ...
    @property
    def warps(self) -> int: ...

class AffineTissue:
    def __init__(
        self,
        mesh: TetMesh,
        materials: collections.abc.Sequence[Material],
        material_names: collections.abc.Sequence[str],
        cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
    ) -> None: ...
    def impulse_responses(
        self,
        *,
        coefficients: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        viscosity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        coefficient_derivatives: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        viscosity_derivatives: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        patterns: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        observed: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        steps: typing.SupportsInt | typing.SupportsIndex,
        alpha: typing.SupportsFloat | typing.SupportsIndex,
        step: typing.SupportsFloat | typing.SupportsIndex,
        tolerance: typing.SupportsFloat | typing.SupportsIndex = 1e-12,
    ) -> numpy.typing.NDArray[numpy.float64]: ...
    def mass(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    def stiffness(
        self, coefficients: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    def viscosity(
        self, viscosity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    @property
    def groups(self) -> int: ...

class Airway:
    def __init__(
        self,
        first: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        second: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        tets: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    ) -> None: ...
    @property
    def first(self) -> numpy.typing.NDArray[numpy.int32]: ...
    @property
    def second(self) -> numpy.typing.NDArray[numpy.int32]: ...
    @property
    def tets(self) -> numpy.typing.NDArray[numpy.int32]: ...

class Simulation:
    def __init__(
        self,
        mesh: TetMesh,
        materials: collections.abc.Sequence[Material],
        material_names: collections.abc.Sequence[str],
        cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
        *,
        scheme: Newmark | HilberHughesTaylor | CentralDifferences,
        step: typing.SupportsFloat | typing.SupportsIndex = 5e-05,
        solver_tolerance: typing.SupportsFloat | typing.SupportsIndex = 1e-08,
        solver: Automatic | Cholesky | ConjugateGradients = ...,
        lumped_mass: bool = False,
        airflow: Airflow | None = None,
        contact: Contact | None = None,
        loads: collections.abc.Sequence[Load] = [],
        gravity: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
        ]
        | None = None,
        displacement: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None,
        velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None,
        probes: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]] | None = None,
        reduction: Reduction | None = None,
        last_basis: LastBasis | None = None,
        symmetry: str | None = None,
        strain: FiniteStrain | None = None,
    ) -> None: ...
    def advance(
        self,
        steps: typing.SupportsInt | typing.SupportsIndex,
        waveforms: collections.abc.Sequence[str] | None = None,
    ) -> dict[str, typing.Any]: ...
    def info(self) -> dict[str, typing.Any]: ...
    def largest_step(self) -> float | None: ...
    def renewed(self, state: dict[str, typing.Any]) -> dict[str, typing.Any]: ...
    def restore(self, state: dict[str, typing.Any]) -> None: ...
    def set_external_force(self, force: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> None: ...
    def state(self) -> dict[str, typing.Any]: ...
    def times(self) -> dict[str, typing.Any]: ...
    @property
    def acceleration(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def contact_force(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def contact_pressure(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def displacement(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def images(self) -> numpy.typing.NDArray[numpy.int32] | None: ...
    @property
    def mass(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    @property
    def section_height(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def section_major(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def step_count(self) -> int: ...
    @property
    def stiffness(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    @property
    def time(self) -> float: ...
    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def viscosity(self) -> tuple[typing.Any, ...] | None: ...

class Waveform:
    @property
    def meaning(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def per(self) -> str: ...
    @property
    def shown(self) -> str: ...
    @property
    def since_start(self) -> bool: ...
    @property
    def unit(self) -> str: ...

class Newmark:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"beta": 0.25, "gamma": 0.5}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        beta: typing.SupportsFloat | typing.SupportsIndex = 0.25,
        gamma: typing.SupportsFloat | typing.SupportsIndex = 0.5,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def beta(self) -> float: ...
    @property
    def gamma(self) -> float: ...

class HilberHughesTaylor:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"alpha": -0.3}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, alpha: typing.SupportsFloat | typing.SupportsIndex = -0.3) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def alpha(self) -> float: ...

class CentralDifferences:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...

class Automatic:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"memory": 1000000000.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, memory: typing.SupportsFloat | typing.SupportsIndex = 1000000000.0) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def memory(self) -> float: ...

class Cholesky:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"max_iterations": 200}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, max_iterations: typing.SupportsInt | typing.SupportsIndex = 200) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def max_iterations(self) -> int: ...

class ConjugateGradients:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"max_iterations": 2000}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, max_iterations: typing.SupportsInt | typing.SupportsIndex = 2000) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def max_iterations(self) -> int: ...

class Lagged:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...

class Extrapolated:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...

class Iterated:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "tolerance": 1e-05,
        "max_sweeps": 40,
        "freeze_after": 8,
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        tolerance: typing.SupportsFloat | typing.SupportsIndex = 1e-05,
        max_sweeps: typing.SupportsInt | typing.SupportsIndex = 40,
        freeze_after: typing.SupportsInt | typing.SupportsIndex = 8,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def freeze_after(self) -> int: ...
    @property
    def max_sweeps(self) -> int: ...
    @property
    def tolerance(self) -> float: ...

class ViscousSlit:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "separation_ratio": 1.2,
        "air_viscosity": 1.8e-05,
        "least_gap": 0.0003,
        "inertance": False,
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        separation_ratio: typing.SupportsFloat | typing.SupportsIndex = 1.2,
        air_viscosity: typing.SupportsFloat | typing.SupportsIndex = 1.8e-05,
        least_gap: typing.SupportsFloat | typing.SupportsIndex = 0.0003,
        inertance: bool = False,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def air_viscosity(self) -> float: ...
    @property
    def inertance(self) -> bool: ...
    @property
    def least_gap(self) -> float: ...
    @property
    def separation_ratio(self) -> float: ...

class Bernoulli:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"zero_flow_fraction": 0.5}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, zero_flow_fraction: typing.SupportsFloat | typing.SupportsIndex = 0.5) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def zero_flow_fraction(self) -> float: ...

class Cut:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"sections": 200}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, sections: typing.SupportsInt | typing.SupportsIndex = 200) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def sections(self) -> int: ...

class Elliptic:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...

class Course:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        time: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        pressure: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def pressure(self) -> tuple[typing.Any, ...]: ...
    @property
    def time(self) -> tuple[typing.Any, ...]: ...

class Airflow:
    _defaults: typing.ClassVar[dict[str, typing.Any]]
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        surface: str = "airway",
        subglottal_pressure: typing.SupportsFloat | typing.SupportsIndex = 800.0,
        rise: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        course: Course | None = None,
        air_density: typing.SupportsFloat | typing.SupportsIndex = 1.23,
        model: ViscousSlit | Bernoulli = ...,
        area: Cut | Elliptic = ...,
        load_shape: str = "reference",
        coupling: Lagged | Extrapolated | Iterated = ...,
        trachea: Tube | None = None,
        tract: Tube | None = None,
        sound_speed: typing.SupportsFloat | typing.SupportsIndex = 350.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def air_density(self) -> float: ...
    @property
    def area(self) -> Cut | Elliptic: ...
    @property
    def coupling(self) -> Lagged | Extrapolated | Iterated: ...
    @property
    def course(self) -> Course | None: ...
    @property
    def load_shape(self) -> str: ...
    @property
    def model(self) -> ViscousSlit | Bernoulli: ...
    @property
    def rise(self) -> float: ...
    @property
    def sound_speed(self) -> float: ...
    @property
    def subglottal_pressure(self) -> float: ...
    @property
    def surface(self) -> str: ...
    @property
    def trachea(self) -> Tube | None: ...
    @property
    def tract(self) -> Tube | None: ...

class Load:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"frequency": 0.0, "phase": 0.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        surface: str,
        traction: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
        ],
        frequency: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        phase: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def frequency(self) -> float: ...
    @property
    def phase(self) -> float: ...
    @property
    def surface(self) -> str: ...
    @property
    def traction(self) -> tuple[float, float, float]: ...

class Multipliers:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"solver": "auto", "position": "end_of_step"}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, solver: str = "auto", position: str = "end_of_step") -> None: ...
    def __repr__(self) -> str: ...
    @property
    def position(self) -> str: ...
    @property
    def solver(self) -> str: ...

class Penalty:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"stiffness": 100.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, stiffness: typing.SupportsFloat | typing.SupportsIndex = 100.0) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def stiffness(self) -> float: ...

class VolumePenalty:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"kappa": 100000000.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, kappa: typing.SupportsFloat | typing.SupportsIndex = 100000000.0) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def kappa(self) -> float: ...

class Augmented:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "stiffness": 1.0,
        "growth": 10.0,
        "reduction": 0.75,
        "max_augmentations": 50,
    }
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        stiffness: typing.SupportsFloat | typing.SupportsIndex = 1.0,
        growth: typing.SupportsFloat | typing.SupportsIndex = 10.0,
        reduction: typing.SupportsFloat | typing.SupportsIndex = 0.75,
        max_augmentations: typing.SupportsInt | typing.SupportsIndex = 50,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def growth(self) -> float: ...
    @property
    def max_augmentations(self) -> int: ...
    @property
    def reduction(self) -> float: ...
    @property
    def stiffness(self) -> float: ...

class Nitsche:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"factor": 10.0}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self, *, factor: typing.SupportsFloat | typing.SupportsIndex = 10.0) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def factor(self) -> float: ...

class AtNodes:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(self) -> None: ...
    def __repr__(self) -> str: ...

class Mortar:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {}
    def __init__(
        self,
        first: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        second: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    ) -> None: ...
    def __repr__(self) -> str: ...

class Contact:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {
        "tolerance": 1e-05,
        "max_passes": 200,
        "friction": None,
        "surface_mass": "kept",
        "faces": "nodes",
    }
    def __init__(
        self,
        *,
        airway: Airway,
        enforcement: Multipliers | Penalty | VolumePenalty | Augmented | Nitsche,
        tolerance: typing.SupportsFloat | typing.SupportsIndex = 1e-05,
        max_passes: typing.SupportsInt | typing.SupportsIndex = 200,
        friction: typing.SupportsFloat | typing.SupportsIndex | None = None,
        surface_mass: str = "kept",
        faces: AtNodes | Mortar = ...,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def enforcement(self) -> Multipliers | Penalty | VolumePenalty | Augmented | Nitsche: ...
    @property
    def faces(self) -> str: ...
    @property
    def friction(self) -> float | None: ...
    @property
    def max_passes(self) -> int: ...
    @property
    def surface_mass(self) -> str: ...
    @property
    def tolerance(self) -> float: ...

class LastBasis:
    def __init__(self) -> None: ...

class Reduction:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"watch_every": 20, "damping_ratio": None}
    def __init__(
        self,
        *,
        basis: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"],
        watch_every: typing.SupportsInt | typing.SupportsIndex = 20,
        damping_ratio: typing.SupportsFloat | typing.SupportsIndex | None = None,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def damping_ratio(self) -> float | None: ...
    @property
    def watch_every(self) -> int: ...

class FiniteStrain:
    _defaults: typing.ClassVar[dict[str, typing.Any]] = {"tolerance": 0.0001, "max_iterations": 60}
    def __eq__(self, arg0: typing.Any) -> bool: ...
    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        tolerance: typing.SupportsFloat | typing.SupportsIndex = 0.0001,
        max_iterations: typing.SupportsInt | typing.SupportsIndex = 60,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def max_iterations(self) -> int: ...
    @property
    def tolerance(self) -> float: ...

class StaticSolver:
    def __init__(self, simulation: Simulation) -> None: ...
    def solve(
        self, forces: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"]
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]: ...

class StretchedMesh:
    @property
    def iterations(self) -> int: ...
    @property
    def mesh(self) -> TetMesh: ...
    @property
    def parts(self) -> int: ...

class StretchedStatics:
    def __init__(
        self,
        mesh: TetMesh,
        materials: collections.abc.Sequence[Material],
        material_names: collections.abc.Sequence[str],
        cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
        fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
        *,
        loads: collections.abc.Sequence[Load] = [],
        gravity: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
        ]
        | None = None,
    ) -> None: ...
    def solver(
        self, displacement: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]
    ) -> StaticSolver: ...
    def unbalanced(
        self, displacement: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]
    ) -> numpy.typing.NDArray[numpy.float64]: ...

class ContactEquilibrium:
    @property
    def contact_force(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def contact_pressure(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def displacement(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def passes(self) -> int: ...
    @property
    def pivots(self) -> int: ...
    @property
    def rows(self) -> int: ...

class FlowTangent:
    @property
    def flow(self) -> float: ...
    @property
    def flow_by_area(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def flow_by_drop(self) -> float: ...
    @property
    def from_below(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def kink(self) -> float: ...
    @property
    def momentum_by_area(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def momentum_by_drop(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def pressure(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def pressure_by_area(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def pressure_by_drop(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def pressure_by_expansion(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def separation(self) -> int: ...

class SeenTube:
    longest_element: typing.ClassVar[float] = 0.004
    longest_substep: typing.ClassVar[float] = 6.25e-06
    @property
    def outflow(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def rates(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def source(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def steady_resistance(self) -> float: ...
    @property
    def storage(self) -> numpy.typing.NDArray[numpy.float64]: ...

class GlottalFlow:
    def __init__(self, simulation: Simulation) -> None: ...
    def areas(
        self, widths: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]
    ) -> numpy.typing.NDArray[numpy.float64]: ...
    def evaluate(
        self,
        areas: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        below: typing.SupportsFloat | typing.SupportsIndex,
        above: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> tuple[numpy.typing.NDArray[numpy.float64], float]: ...
    def inertance(self, areas: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> float: ...
    def load_patterns(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    def tangent(
        self,
        areas: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        below: typing.SupportsFloat | typing.SupportsIndex,
        above: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> FlowTangent: ...
    def width_map(
        self,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.int32],
        numpy.typing.NDArray[numpy.int32],
    ]: ...
    def width_spacing(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def height(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def reference_load(self) -> bool: ...
    @property
    def trachea(self) -> SeenTube | None: ...
    @property
    def tract(self) -> SeenTube | None: ...

def block_mesh(
    corner: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
    ] = [0.0, 0.0, 0.0],
    size: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
    ] = [1.0, 1.0, 1.0],
    divisions: typing.Annotated[
        collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], "FixedSize(3)"
    ] = [1, 1, 1],
) -> TetMesh: ...
def body_of_nodes(mesh: TetMesh) -> numpy.typing.NDArray[numpy.int32]: ...
def boundary(
    cells: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.int32]]: ...
def build_info() -> dict[str, typing.Any]: ...
def check_mesh(mesh: TetMesh) -> None: ...
def cholesky(
    a: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def combine(
    first: TetMesh, second: TetMesh, first_prefix: str = "a.", second_prefix: str = "b."
) -> TetMesh: ...
def congruence(
    g: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    p: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    plus: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def contact_equilibrium(
    mesh: TetMesh,
    materials: collections.abc.Sequence[Material],
    material_names: collections.abc.Sequence[str],
    cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
    *,
    contact: Contact,
    loads: collections.abc.Sequence[Load] = [],
    gravity: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
    ]
    | None = None,
    displacement: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None,
) -> ContactEquilibrium: ...
def corner_normals(
    corners: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    triangles: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
) -> numpy.typing.NDArray[numpy.float64]: ...
def dense_flow(
    first: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    second: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    options: FlowOptions,
    used: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None,
    sides: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None,
    measured: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None,
    displacement: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None,
    across: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"
    ] = [1.0, 0.0],
) -> tuple[numpy.typing.NDArray[numpy.float32], typing.Annotated[list[float], "FixedSize(6)"], float]: ...
def elasticity_matrix(material: Material) -> numpy.typing.NDArray[numpy.float64]: ...
def equilibrium(
    mesh: TetMesh,
    materials: collections.abc.Sequence[Material],
    material_names: collections.abc.Sequence[str],
    cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
    *,
    loads: collections.abc.Sequence[Load] = [],
    gravity: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
    ]
    | None = None,
    finite_strain: bool = False,
) -> numpy.typing.NDArray[numpy.float64]: ...
def first_hits(
    nodes: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    faces: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64]]: ...
def flat_triangles(
    faces: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
) -> numpy.typing.NDArray[numpy.int32]: ...
def flow_residual(
    first: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    second: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    flow: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
) -> numpy.typing.NDArray[numpy.float32]: ...
def free_bodies(
    mesh: TetMesh, fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool]
) -> list[tuple[int, bool]]: ...
def gram_update(
    p: numpy.typing.NDArray[numpy.float64],
    w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    scale: typing.SupportsFloat | typing.SupportsIndex,
) -> None: ...
def heights_above(
    places: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    corners: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    triangles: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    rows: typing.SupportsInt | typing.SupportsIndex,
    columns: typing.SupportsInt | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float64]: ...
def hits_near(
    nodes: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    faces: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    face: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    start: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64]]: ...
def interpolated(
    weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    rows: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    values: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def larynx_mesh(
    *,
    order: typing.SupportsInt | typing.SupportsIndex = 1,
    sections: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None,
    major: typing.SupportsFloat | typing.SupportsIndex = 0.007,
    radius: typing.SupportsFloat | typing.SupportsIndex = 0.008,
    layer_thickness: typing.SupportsFloat | typing.SupportsIndex = 0.0005,
    ligament_thickness: typing.SupportsFloat | typing.SupportsIndex | None = None,
    layers_from_section: typing.SupportsInt | typing.SupportsIndex = 4,
    layers_to_section: typing.SupportsInt | typing.SupportsIndex = 7,
    layers_along: str = "level",
    around: typing.SupportsInt | typing.SupportsIndex | None = None,
    size: typing.SupportsFloat | typing.SupportsIndex = 0.00035,
    growth: typing.SupportsFloat | typing.SupportsIndex = 0.7,
    tip_cut: typing.SupportsFloat | typing.SupportsIndex = 0.1,
    levels: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex] | None = None,
    cover_rings: typing.SupportsInt | typing.SupportsIndex = 1,
    ligament_rings: typing.SupportsInt | typing.SupportsIndex = 1,
    body_rings: typing.SupportsInt | typing.SupportsIndex = 2,
) -> TetMesh: ...
def larynx_preset(name: str) -> dict[str, typing.Any]: ...
def least_jacobian_ratios(
    points: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    cells: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
) -> numpy.typing.NDArray[numpy.float64]: ...
def light_gains(
    gain: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(6)"
    ],
    rows: typing.SupportsInt | typing.SupportsIndex,
    columns: typing.SupportsInt | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float32]: ...
def matched_airway(
    points: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    first: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    second: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    direction: typing.Annotated[
        collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"
    ],
) -> Airway: ...
def periodic_spline(
    tile: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    places: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    degree: typing.SupportsInt | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float64]: ...
def pressure_patterns(
    mesh: TetMesh,
    faces: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    heights: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def product(
    a: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    b: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def rasterise_triangles(
    corners: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    triangles: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    within: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64]]: ...
def round_trip(
    forward: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    backward: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
) -> numpy.typing.NDArray[numpy.float32]: ...
def scheme_coefficients(
    scheme: Newmark | HilberHughesTaylor | CentralDifferences,
) -> tuple[float, float, float]: ...
def set_threads(count: typing.SupportsInt | typing.SupportsIndex) -> None: ...
def signed_volumes(
    points: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    cells: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
) -> numpy.typing.NDArray[numpy.float64]: ...
def solve_lower(
    r: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], x: numpy.typing.NDArray[numpy.float64]
) -> None: ...
def solve_upper(
    r: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], x: numpy.typing.NDArray[numpy.float64]
) -> None: ...
def stiffness_coefficients(material: Material) -> numpy.typing.NDArray[numpy.float64]: ...
def stiffness_derivative(material: Material, parameter: str) -> numpy.typing.NDArray[numpy.float64]: ...
def stiffness_parameters(material: Material) -> list[str]: ...
def stretched(
    mesh: TetMesh,
    materials: collections.abc.Sequence[Material],
    material_names: collections.abc.Sequence[str],
    cell_material: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    fixed: typing.Annotated[numpy.typing.ArrayLike, numpy.bool],
    held: collections.abc.Callable[[float], typing.Annotated[numpy.typing.ArrayLike, numpy.float64]],
) -> StretchedMesh: ...
def symmetric_product(
    a: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    b: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def threads() -> int: ...
def to_quadratic(mesh: TetMesh) -> TetMesh: ...
def toeplitz_gram(
    first: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    second: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    weights: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def toeplitz_product(
    lags: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def toeplitz_transposed_product(
    lags: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    x: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.float64]: ...
def tract(airflow: Airflow) -> SeenTube: ...
def triangulated_airway(
    points: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    first: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
    second: numpy.ndarray[typing.Any, numpy.dtype[typing.Any]],
) -> Airway: ...
def waveforms() -> list[Waveform]: ...
def within_hull(
    sides: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    places: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> numpy.typing.NDArray[numpy.bool]: ...

DEEPEST_LAYER: float = 0.3
