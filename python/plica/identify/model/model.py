"""The linear map from pressures to observed motion, and its derivatives: y = mu(theta) + T(theta) w."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.model.forcing import Forcing
from plica.identify.observation.observation import Observation
from plica.identify.parameters import TissueParameter, TissueParameters
from plica.runs.build import fixed_components
from plica.runs.materials import materials_of
from plica.runs.scene_mesh import scene_mesh
from plica.scene.parts import HilberHughesTaylor
from plica.scene.scene import Scene

__all__ = ["MotionModel", "Responses", "require_linear", "require_parameters"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Responses:
    """Observed motion in response to the pressures, and its derivatives with respect to the coordinates
    (entry 0: the value itself)."""

    mean: Array
    """(1 + p, N, m) px/frame"""
    lags: Array
    """(1 + p, N, m, q) px/frame per Pa: block k - i of T, for a pressure constant during frame i"""


class MotionModel:
    """A scene without contact, seen by a camera.

    Parameters
    ----------
    scene : Scene
        Mesh, tissue, supports and the time step; the pressures are those of `forcing`.
    parameters : sequence of TissueParameter or str
    observation : Observation
        Its frame interval must be a whole number of the scene's steps.
    forcing : Forcing
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.
    tolerance : float
        Relative tolerance of the linear solves.

    Raises
    ------
    InvalidInput
        For a scene with contact, loads, gravity or initial values, a scheme other than HHT, or arguments that
        do not fit.
    """

    def __init__(
        self,
        scene: Scene,
        parameters: Sequence[TissueParameter | str],
        observation: Observation,
        forcing: Forcing,
        mesh: _engine.TetMesh | None = None,
        tolerance: float = 1e-10,
    ) -> None:
        require_linear(scene)
        mesh = scene_mesh(scene) if mesh is None else mesh
        materials, names, cell_material = materials_of(scene, mesh)
        self.tissue = TissueParameters(materials, names, parameters)
        self.observation, self.forcing = observation, forcing
        scheme = scene.time.scheme.choice
        assert isinstance(scheme, HilberHughesTaylor)
        self.alpha, self.step = scheme.alpha, scene.time.step
        self.steps_per_frame = _steps_per_frame(self.step, observation.frame_rate)
        self.points = np.asarray(mesh.points)
        """(n, 3) m"""
        unknowns = 3 * len(self.points)
        if len(forcing.patterns) != unknowns:
            raise InvalidInput(
                f"MotionModel: patterns have {len(forcing.patterns)} rows; must have {unknowns}, three per "
                "node."
            )
        if int(observation.points.nodes.max()) >= unknowns // 3:
            raise InvalidInput(
                f"MotionModel: observation.points.nodes has {int(observation.points.nodes.max())}; must be < "
                f"{unknowns // 3}, the number of nodes of the mesh."
            )
        if forcing.drive is not None and len(forcing.drive) != self.steps:
            raise InvalidInput(
                f"MotionModel: drive has {len(forcing.drive)} steps; must have {self.steps}: "
                f"{observation.frames} frames of {self.steps_per_frame}."
            )
        if observation.closed.any() and forcing.collision is None:  # type: ignore[union-attr]
            raise InvalidInput(
                "MotionModel: frames are closed, but forcing.collision is missing; must have patterns on the "
                "medial surface. Otherwise collision forces would be attributed to the tissue."
            )
        self._engine = _engine.AffineTissue(
            mesh, materials, names, cell_material, fixed_components(scene, mesh)
        )
        self._observed = observation.displacements()[0]
        self._tolerance = tolerance

    def seeing(self, flow: Array) -> MotionModel:
        """The same model for another recording (N, r, 2) by the same camera; matrices are shared."""
        other = copy.copy(self)
        other.observation = replace(self.observation, flow=flow)
        if other.observation.frames != self.observation.frames:
            raise InvalidInput(
                f"MotionModel: flow has {other.observation.frames} frames; must have "
                f"{self.observation.frames}."
            )
        return other

    def of_first(self, frames: int) -> MotionModel:
        """The same model for the first frames alone; matrices are shared."""
        other = copy.copy(self)
        other.observation = self.observation.of_first(frames)
        if self.forcing.drive is not None:
            other.forcing = replace(self.forcing, drive=self.forcing.drive[: other.steps])
        return other

    @property
    def steps(self) -> int:
        """Number of time steps over all frames."""
        return self.observation.frames * self.steps_per_frame

    @property
    def image_positions(self) -> Array:
        """(r, 2) px, column and row of the observed points at rest."""
        points = self.observation.points
        rest = np.einsum("rk,rkc->rc", points.weights, self.points[points.nodes])
        at: Array = self.observation.camera.project(rest)[:, :2]
        return at

    @property
    def patterns(self) -> Array:
        """(3 n, q + c): those of the pressure, then those of the collision."""
        if self.forcing.collision is None:
            return self.forcing.patterns
        return np.ascontiguousarray(np.hstack([self.forcing.patterns, self.forcing.collision]))

    def responses(
        self, log_theta: Array, derivatives: bool = True, angles: tuple[float, float] | None = None
    ) -> Responses:
        """Mean and lags at log theta (p), with their derivatives: one factorisation, one sweep.

        angles are the camera's tilt and lean (degrees) instead of its own; derivatives by them, if they have
        a prior, come last. Without derivatives the cost is lower by a factor 1 + p. Raises InvalidInput where
        a material is not positive definite, and SolveFailed.
        """
        stiffness, viscosity, d_stiffness, d_viscosity = self.tissue.coefficients(
            np.asarray(log_theta, dtype=float)
        )
        if not derivatives:
            d_stiffness, d_viscosity = d_stiffness[:0], d_viscosity[:0]
        patterns = self.patterns
        impulse = self._engine.impulse_responses(
            coefficients=stiffness,
            viscosity=viscosity,
            coefficient_derivatives=d_stiffness,
            viscosity_derivatives=d_viscosity,
            patterns=patterns,
            observed=self._observed,
            steps=self.steps,
            alpha=self.alpha,
            step=self.step,
            tolerance=self._tolerance,
        )
        camera = self.observation.camera
        if angles is not None:
            camera = replace(camera, tilt=angles[0], lean=angles[1])
        parts = [self._projected(camera.projection, impulse)]
        if derivatives and self.observation.tilt_sd:
            width = patterns.shape[1]
            parts += [self._projected(P, impulse[:, :, :width]) for P in camera.tilt_derivatives()]
        seen = np.concatenate(parts, axis=1)
        return Responses(self._mean(seen), self._lags(seen))

    def _projected(self, projection: Array, impulse: Array) -> Array:
        """Positions in the image, (steps, kinds, m, q + c), of displacements (steps, o, kinds (q + c))."""
        steps, observed, columns = impulse.shape
        width = self.patterns.shape[1]
        flat = np.moveaxis(impulse, 1, 0).reshape(observed, steps * columns)
        rows = self.observation.displacements(projection)[1] @ flat
        seen: Array = rows.reshape(-1, steps, columns // width, width).transpose(1, 2, 0, 3)
        return seen

    def _frames(self, position: Array) -> Array:
        """From positions after each step to motions from frame to frame."""
        at_frames = position[self.steps_per_frame - 1 :: self.steps_per_frame]
        return np.diff(at_frames, axis=0, prepend=0.0)

    def _lags(self, seen: Array) -> Array:
        held = np.cumsum(seen, axis=0)
        held[self.steps_per_frame :] -= held[: -self.steps_per_frame].copy()
        return np.ascontiguousarray(self._frames(held).transpose(1, 0, 2, 3))

    def _mean(self, seen: Array) -> Array:
        """The response to the drive: its convolution with the impulse responses."""
        steps, kinds, m, _ = seen.shape
        if self.forcing.drive is None:
            return np.zeros((kinds, self.observation.frames, m))
        length = fft.next_fast_len(2 * steps, real=True)
        total: Array = np.zeros((length // 2 + 1, kinds, m), dtype=complex)
        for i in np.flatnonzero(np.any(self.forcing.drive, axis=0)):
            wave = fft.rfft(self.forcing.drive[:, i], length)
            total += fft.rfft(seen[..., i], length, axis=0) * wave[:, None, None]
        position = fft.irfft(total, length, axis=0)[:steps]
        return np.ascontiguousarray(self._frames(position).transpose(1, 0, 2))


def require_parameters(
    parameters: Sequence[TissueParameter | str], scene: Scene, mesh: _engine.TetMesh
) -> None:
    """Raises InvalidInput unless the tissue of a scene has these parameters."""
    materials, names, _ = materials_of(scene, mesh)
    TissueParameters(materials, names, parameters)


def require_linear(scene: Scene) -> None:
    """Raises InvalidInput, naming all parts to leave out, for a scene whose motion is not linear in the
    pressures or does not start from rest."""
    if scene.posture is not None:
        raise InvalidInput(
            f"{scene.source}: posture is given; must be left out: stretched tissue bears a stress that "
            "depends on its stiffness, so that its matrices are not linear in what is identified."
        )
    if scene.strain is not None:
        raise InvalidInput(
            f"{scene.source}: strain is given; must be left out: the motion of tissue at finite strain is "
            'not linear in the pressures. With voice: without = ["strain"], softer tissue with another pitch.'
        )
    given = [name for name in ("contact", "loads", "gravity", "initial", "symmetry") if getattr(scene, name)]
    if given:
        contact = (
            "With contact the motion is not linear in the pressures: in closed frames, unknown forces on the "
            "medial surface replace the contact. "
        )
        raise InvalidInput(
            f"{scene.source}: {', '.join(given)} {'is' if len(given) == 1 else 'are'} given; must be left "
            f"out. {contact if scene.contact else ''}The model starts from rest, is driven only by "
            "pressures on its surface, and has both folds."
        )
    if not isinstance(scene.time.scheme.choice, HilberHughesTaylor):
        raise InvalidInput(f"{scene.source}: time.scheme must be hht.")
    if scene.time.lumped_mass:
        raise InvalidInput(f'{scene.source}: time.mass = "lumped"; must be "consistent".')


def _steps_per_frame(step: float, frame_rate: float) -> int:
    ratio = 1.0 / (step * frame_rate)
    whole = round(ratio)
    if whole < 1 or abs(ratio - whole) > 1e-6 * whole:
        raise InvalidInput(
            f"MotionModel: frame interval / step = {ratio:g}; must be a whole number. At {frame_rate:g} Hz "
            f"try a step of {1 / (frame_rate * max(1, whole)):.6g} s."
        )
    return whole
