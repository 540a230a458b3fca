"""Small oscillations of tissue about its equilibrium with the airflow: a linear system, its eigenvalues."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.runs.build import build_simulation, equilibrium_branch, fixed_components, whole_tissue
from plica.runs.flow_equilibrium import FlowEquilibrium
from plica.runs.nodal_matrices import NodalMatrices, ritz
from plica.runs.scene_mesh import scene_mesh
from plica.scene.scene import Scene
from plica.scene.symmetry import symmetry_planes
from plica.stability.modes import basis_of
from plica.units import number, whole_number

__all__ = ["Damping", "SmallMotion", "Spectrum"]

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SLOWEST, _FASTEST = 1.0, 5e3  # Hz, of what counts as an oscillation: faster ones are tubes' elements
MODES, _MOST_MODES = 50, 1000


@dataclass(frozen=True)
class Damping:
    """How the tissue is damped in the linear analysis: by its viscosity, or by one of these instead."""

    ratio: float | None = None
    """[-] Of critical, of every mode."""
    loss_factor: float | None = None
    """[-] The stiffness is K (1 + i loss_factor), whatever the frequency: twice the damping ratio."""

    def __post_init__(self) -> None:
        for name, value in (("zeta", self.ratio), ("loss_factor", self.loss_factor)):
            if value is not None:
                number("onset", name, value, 1e-6, 1.0, "")
        if self.ratio is not None and self.loss_factor is not None:
            raise InvalidInput(
                f"onset: zeta = {self.ratio:g} with loss_factor = {self.loss_factor:g}; must be one of them."
            )

    @property
    def description(self) -> str:
        """In words."""
        if self.ratio is not None:
            return f"damping ratio {self.ratio:g} of every mode"
        if self.loss_factor is not None:
            return f"loss factor {self.loss_factor:g}"
        return "viscosity of the tissue"


def damping_of(zeta: float | None, loss_factor: float | None) -> Damping | None:
    """None: the scene's own."""
    return None if zeta is None and loss_factor is None else Damping(zeta, loss_factor)


def _scene_damping(scene: Scene) -> Damping:
    """That of its time steps."""
    return Damping(None if scene.reduction is None else scene.reduction.damping_ratio)


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues s of small oscillations, exp(s t), about an equilibrium."""

    equilibrium: FlowEquilibrium
    pairs: Complex
    """(k) 1/s, one of each pair of 1 to 5000 Hz, Im > 0, the least stable first."""
    fastest: float
    """[1/s] The largest real eigenvalue; -inf without any. Above 0 the equilibrium is left without
    oscillation."""
    vectors: Complex | None = None
    """(coordinates, k) of the tissue, phi^T M phi = 1."""

    @property
    def growth(self) -> float:
        """[1/s] Of the least stable oscillation; -inf without any."""
        return float(self.pairs[0].real) if len(self.pairs) else -np.inf

    @property
    def frequency(self) -> float:
        """[Hz] Of the least stable oscillation."""
        return float(self.pairs[0].imag) / (2 * np.pi) if len(self.pairs) else np.nan


class SmallMotion:
    """Tissue in the span of its lowest modes and of static responses to the pressures of the sections.

    Parameters
    ----------
    scene : Scene
        With an airflow; as of `plica.flow_equilibrium`. With a symmetry motions are symmetric.
    modes : int, optional
        Number of modes. Default: 50, or as many as the mesh has.
    damping : Damping, optional
        Default: as the scene is damped in time steps.
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.
    """

    def __init__(
        self,
        scene: Scene,
        modes: int | None = None,
        damping: Damping | None = None,
        mesh: _engine.TetMesh | None = None,
    ) -> None:
        from plica.runs.basis import reduction_basis

        if modes is not None:
            whole_number("onset", "modes", modes, 1, _MOST_MODES)
        _require_linear_tissue(scene)
        mesh = scene_mesh(scene) if mesh is None else mesh
        fixed = fixed_components(scene, mesh)
        simulation = build_simulation(whole_tissue(scene), mesh)
        self.branch = equilibrium_branch(scene, mesh, simulation)
        assert scene.airflow is not None
        if modes is None:
            modes = min(MODES, int((~fixed).sum()) // 2 ** (1 + symmetry_planes(scene.symmetry)))
        with basis_of(scene, "onset", "modes"):
            basis = reduction_basis(
                simulation,
                mesh,
                fixed,
                modes=modes,
                surface=scene.airflow.surface,
                symmetry=scene.symmetry,
            )
        matrices = NodalMatrices(simulation, fixed)
        if matrices.viscosity is not None:  # what viscosity adds to the responses, to first order
            lag = self.branch.moved_by(matrices.viscosity @ basis[:, modes:])
            basis = np.concatenate((basis, lag), axis=1)
        squares, shapes = ritz(matrices, basis)
        self.scene, self.mesh, self.shapes = scene, mesh, shapes
        self.modes = modes
        """Number of coordinates that are modes; the others complete the responses to pressures."""
        self.damping = _scene_damping(scene) if damping is None else damping
        self.squares = squares
        """(r) 1/s^2, ascending."""
        self.viscosity: Floats = np.zeros((len(squares), len(squares)))
        """(r, r) 1/s"""
        if matrices.viscosity is not None:
            self.viscosity = shapes.T @ (matrices.viscosity @ shapes)
        self.loads: Floats = self.branch.patterns.T @ shapes
        """(s + 2, r) m^2/kg^(1/2): unit pressures on the coordinates; what their rates displace."""
        self.widths: Floats = self.branch.width_map @ shapes[0::3]
        """(w, r) m/kg^(1/2)"""
        self._basis = shapes.T @ (matrices.mass @ basis)
        self.trachea, self.tract = self.branch.flow.trachea, self.branch.flow.tract
        if self.damping == Damping() and not self.viscosity.any():
            raise InvalidInput(
                f"{scene.source}: no tissue has a viscosity; must be damped: without damping any flow that "
                "feeds an oscillation makes it grow. Add viscosity to it, or give zeta or loss_factor."
            )

    def with_modes(self, modes: int) -> Self:
        """The same with fewer modes."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        kept = np.concatenate((self._basis[:, :modes], self._basis[:, self.modes :]), axis=1)
        kept = kept / np.linalg.norm(kept, axis=0)
        axes, sizes, _ = np.linalg.svd(kept, full_matrices=False)
        axes = axes[:, sizes > 1e-6 * sizes[0]]
        other.squares, turned = np.linalg.eigh(axes.T @ (self.squares[:, None] * axes))
        turned = axes @ turned
        other.viscosity = turned.T @ self.viscosity @ turned
        other.loads, other.widths = self.loads @ turned, self.widths @ turned
        other.shapes = self.shapes @ turned
        other.modes, other._basis = modes, turned.T @ kept
        return other

    @property
    def frequencies(self) -> Floats:
        """(r) Hz, without air."""
        return np.sqrt(self.squares) / (2 * np.pi)

    def spectrum(self, pressure: float, vectors: bool = False) -> Spectrum:
        """Eigenvalues about the equilibrium under this subglottal pressure (Pa).

        Raises
        ------
        SolveFailed
            If there is no equilibrium of the branch under this pressure.
        """
        rest = self.branch.at(pressure)
        matrix = self.matrix(rest)
        if vectors:
            values, found = np.linalg.eig(matrix)
        else:
            values, found = np.linalg.eigvals(matrix), None
        values = np.asarray(values, dtype=complex)
        speed = values.imag / (2 * np.pi)
        still = self._still(values) if self.damping.loss_factor is None else self._still_by_viscosity(rest)
        swinging = np.flatnonzero((speed > _SLOWEST) & (speed < _FASTEST))
        swinging = swinging[np.argsort(-values.real[swinging], kind="stable")]
        shapes = None if found is None else np.asarray(found[: len(self.squares), swinging], dtype=complex)
        return Spectrum(rest, values[swinging], still, shapes)

    @staticmethod
    def _still(values: Complex) -> float:
        return float(values.real[np.abs(values.imag) <= 2 * np.pi * _SLOWEST].max(initial=-np.inf))

    def _still_by_viscosity(self, rest: FlowEquilibrium) -> float:
        """A loss factor makes complex what does not oscillate; with viscosity its sign is the same."""
        viscous = copy(self)
        viscous.damping = Damping()
        return self._still(np.asarray(np.linalg.eigvals(viscous.matrix(rest)), dtype=complex))

    def matrix(self, rest: FlowEquilibrium) -> NDArray[Any]:
        """(m, m) of z' = A z: z are coordinates, their rates, the states of the tubes, and with inertance of
        the air in the glottis the drop of pressure without what accelerates it."""
        r = len(self.squares)
        air = _Air(self, rest)
        stiffness = np.diag(self.squares).astype(complex if self.damping.loss_factor else float)
        if self.damping.loss_factor:
            stiffness *= 1 + 1j * self.damping.loss_factor
        tubes = [(tube, sign) for tube, sign in ((self.trachea, -1), (self.tract, 1)) if tube is not None]
        first = {}
        lag = 2 * r  # with inertance, the drop that drives the flow without
        for tube, sign in tubes:
            first[sign] = lag
            lag += len(tube.storage)
        size = lag if air.inertia is None else lag + 1
        A = np.zeros((size, size), dtype=np.result_type(stiffness, air.force_by_motion))
        motion, rates = slice(0, r), slice(r, 2 * r)
        A[motion, rates] = np.eye(r)
        A[rates, motion] = air.force_by_motion - stiffness
        A[rates, rates] = -self._damping_matrix()
        for sign, column in first.items():  # what the pressure at a tube's end does to the tissue
            A[rates, column] = air.force_by_end[sign]
        flow = np.zeros(size, dtype=A.dtype)  # through the glottis
        flow[motion] = air.flow_by_motion
        for sign, column in first.items():
            flow[column] = air.flow_by_end[sign]
        if air.inertia is not None:
            A[lag, lag], A[lag, rates] = -1.0, -air.inertia.momentum_by_motion
            for sign, column in first.items():
                A[lag, column] = -sign
            A[lag] /= air.inertia.momentum_by_drop
            for rows, (by_drop, by_rates, by_lag) in (
                (A[rates], air.inertia.forces),
                (flow, air.inertia.flows),
            ):
                rows[..., lag] += by_drop
                rows[..., rates] += by_rates
                rows += np.multiply.outer(by_lag, A[lag])
        for tube, sign in tubes:
            row, own = first[sign], slice(first[sign], first[sign] + len(tube.storage))
            storage = np.asarray(tube.storage)
            A[own, own] = np.asarray(tube.rates) / storage[:, None]
            into = flow.copy()  # the tube
            into[rates] += air.flow_by_rates[sign]
            A[row] += sign * into / storage[0]
        return A

    def _damping_matrix(self) -> Floats:
        if self.damping.loss_factor is not None:
            return np.zeros_like(self.viscosity)
        if self.damping.ratio is not None:
            return np.diag(2 * self.damping.ratio * np.sqrt(self.squares))
        return self.viscosity


def _require_linear_tissue(scene: Scene) -> None:
    """Raise for a scene whose small motion is not that of one stiffness."""
    if scene.strain is not None:
        raise InvalidInput(
            f"{scene.source}: strain is given; must be left out: small motion about an equilibrium is "
            "found with the stiffness of the tissue at t = 0. Use linear tissue; with voice: "
            'without = ["strain"], softer tissue with another pitch.'
        )


class _Air:
    """What the flow does in small oscillations; keys of the ends: -1 below, 1 above.

    What the pressures move outside the span of the shapes they move at once, as if nothing there had mass.
    """

    def __init__(self, motion: SmallMotion, rest: FlowEquilibrium) -> None:
        tangent, branch = rest.tangent, motion.branch
        areas = branch.summed(motion.widths, rest.open_widths)  # (s, r)
        within = areas @ (motion.loads.T / motion.squares[:, None])
        left: NDArray[Any] = branch.area_compliance(rest.open_widths) - within
        if motion.damping.loss_factor:
            left = left / (1 + 1j * motion.damping.loss_factor)
        slope, by_drop = np.asarray(tangent.pressure_by_area), np.asarray(tangent.pressure_by_drop)
        count, flow_by_drop = len(by_drop), tangent.flow_by_drop
        lags = len(tangent.momentum_by_drop) > 0  # the drop is then another variable
        own_drop = 0 * by_drop if lags else by_drop
        right = np.column_stack(
            (slope @ areas, slope @ left[:, -2] + own_drop, slope @ left[:, -1] + 1 - own_drop)
        )
        within_sections = np.eye(count) - slope @ left[:, :-2]
        found = np.linalg.solve(within_sections, right)
        of_motion, of_ends = found[:, :-2], {-1: found[:, -2], 1: found[:, -1]}
        of_sections, loads = motion.loads[:-2], {-1: motion.loads[-2], 1: motion.loads[-1]}
        self.force_by_motion = of_sections.T @ of_motion
        self.force_by_end = {end: loads[end] + of_sections.T @ of_ends[end] for end in of_ends}
        by_area, shares = np.asarray(tangent.flow_by_area), np.asarray(tangent.from_below)
        self.flow_by_motion = by_area @ (areas + left[:, :-2] @ of_motion)
        self.flow_by_end = {
            end: by_area @ (left[:, column] + left[:, :-2] @ of_ends[end])
            - end * (0 if lags else flow_by_drop)
            for end, column in ((-1, -2), (1, -1))
        }
        self.flow_by_rates = {
            -1: loads[-1] + shares @ of_sections,
            1: -loads[1] - (1 - shares) @ of_sections,
        }
        self.inertia: _Inertia | None = None
        if lags:
            momentum = np.asarray(tangent.momentum_by_area) @ areas
            by_lag = np.asarray(tangent.momentum_by_drop)
            by_rates = momentum[-1] - momentum + np.asarray(tangent.pressure_by_expansion) @ of_sections
            right = np.column_stack((by_drop, by_rates, by_lag[-1] - by_lag))
            found = np.linalg.solve(within_sections, right)
            flows = by_area @ left[:, :-2] @ found
            flows[0] += flow_by_drop
            forces = of_sections.T @ found
            self.inertia = _Inertia(
                momentum[-1],
                float(by_lag[-1]),
                (forces[:, 0], forces[:, 1:-1], forces[:, -1]),
                (flows[0], flows[1:-1], flows[-1]),
            )


@dataclass(frozen=True)
class _Inertia:
    """What inertance adds: to forces (r) on the coordinates and to the flow, by the drop D' that drives the
    flow without it, by the rates of the coordinates and by that of D'. What the pressures move outside the
    span of the shapes has no momentum."""

    momentum_by_motion: Floats
    """(r) Pa s kg^(1/2)/m, of the last section, D = D' + rate of it."""
    momentum_by_drop: float
    """[s]"""
    forces: tuple[NDArray[Any], NDArray[Any], NDArray[Any]]
    """(r), (r, r), (r)"""
    flows: tuple[Any, NDArray[Any], Any]
    """[-], (r), [-]"""
