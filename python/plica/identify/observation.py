"""What a camera sees of the tissue: points of its surface and their motion from frame to frame, in pixels."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from plica import _engine
from plica.errors import InvalidInput

__all__ = ["Camera", "Observation", "SurfacePoints"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """An orthographic camera."""

    pixels_per_metre: float
    """[1/m] > 0; 20 px/mm is 20e3."""
    axes: Array = field(default_factory=lambda: np.eye(2, 3))
    """(2, 3) To the right and up in the image, in the coordinates of the mesh, orthonormal: their cross
    product points to the camera. Left out: seen from above."""

    tilt_sd: float = 0.0
    """[rad] Prior standard deviation of two small rotations about the image's axes, which are then
    estimated with the tissue; 0: the axes are known."""

    def __post_init__(self) -> None:
        axes = np.asarray(self.axes, dtype=float)
        object.__setattr__(self, "axes", axes)
        if not (np.isfinite(self.tilt_sd) and self.tilt_sd >= 0):
            raise InvalidInput(f"Camera: tilt_sd = {self.tilt_sd:g} rad; must be >= 0. 5 degrees are 0.087.")
        if not (np.isfinite(self.pixels_per_metre) and self.pixels_per_metre > 0):
            raise InvalidInput(
                f"Camera: pixels_per_metre = {self.pixels_per_metre:g} 1/m; must be > 0. Is it per "
                "millimetre?"
            )
        if axes.shape != (2, 3) or not np.allclose(axes @ axes.T, np.eye(2), atol=1e-9):
            raise InvalidInput("Camera: axes must be two orthonormal rows of three.")

    def tilted(self, about_x: float, about_y: float) -> Camera:
        """The camera turned about the image's y axis, then about its x axis (rad)."""
        return replace(self, axes=self._turned(about_x, about_y)[0])

    def tilt_derivatives(self, about_x: float, about_y: float) -> tuple[Array, Array]:
        """Of the axes (2, 3) of `tilted`, with respect to its two angles."""
        return self._turned(about_x, about_y)[1:]

    def _turned(self, about_x: float, about_y: float) -> tuple[Array, Array, Array]:
        x, y = self.axes
        z = np.cross(x, y)
        cx, sx, cy, sy = np.cos(about_x), np.sin(about_x), np.cos(about_y), np.sin(about_y)
        turned_z = sy * x + cy * z
        axes = np.array([cy * x - sy * z, cx * y + sx * turned_z])
        by_x = np.array([np.zeros(3), -sx * y + cx * turned_z])
        by_y = np.array([-sy * x - cy * z, sx * (cy * x - sy * z)])
        return axes, by_x, by_y

    @property
    def towards(self) -> Array:
        """(3) from the tissue to the camera."""
        return np.cross(self.axes[0], self.axes[1])


@dataclass(frozen=True)
class SurfacePoints:
    """Material points of a surface, each within one face: x = sum_k weights[k] x[nodes[k]]."""

    nodes: NDArray[np.int32]
    """(r, k)"""
    weights: Array
    """(r, k)"""

    @classmethod
    def at_nodes(cls, nodes: ArrayLike) -> SurfacePoints:
        """The nodes themselves."""
        rows = np.asarray(nodes, dtype=np.int32).reshape(-1, 1)
        return cls(rows, np.ones(rows.shape))

    @classmethod
    def seen(cls, mesh: _engine.TetMesh, surface: str, camera: Camera, image: Array) -> SurfacePoints:
        """Those that the camera sees at image positions (r, 2), in metres along its axes.

        Of the faces that look at the camera and lie behind a position, the nearest is taken, with the shape
        functions of its nodes where its corners' plane is met. Raises InvalidInput where there is none.
        """
        faces, x = np.asarray(mesh.surfaces[surface]), np.asarray(mesh.points)
        corners = x[faces[:, :3]]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ camera.towards
        faces, corners = faces[facing > 0], corners[facing > 0]
        flat = corners @ camera.axes.T  # (f, 3, 2)
        edges = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=2)
        inverse = np.linalg.inv(edges)
        depth = corners @ camera.towards
        nodes, weights = [], []
        for k, position in enumerate(np.asarray(image, dtype=float)):
            rs = np.einsum("fij,fj->fi", inverse, position - flat[:, 0])
            bary = np.column_stack([1 - rs.sum(axis=1), rs])
            behind = np.flatnonzero(bary.min(axis=1) >= -1e-9)
            if not len(behind):
                raise InvalidInput(
                    f"SurfacePoints: image[{k}] = [{position[0]:g}, {position[1]:g}] m; must lie before the "
                    f'surface "{surface}". Do the origins of image and mesh agree?'
                )
            face = behind[np.argmax((bary[behind] * depth[behind]).sum(axis=1))]
            nodes.append(faces[face])
            weights.append(_shape_functions(bary[face], faces.shape[1]))
        return cls(np.array(nodes, dtype=np.int32), np.array(weights))


def _shape_functions(bary: Array, count: int) -> Array:
    """Of a face with three or six nodes, VTK order, at barycentric coordinates."""
    if count == 3:
        return bary
    a, b, c = bary
    return np.array([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a])


@dataclass(frozen=True)
class Observation:
    """The motion of surface points between frames, y_k = c P S (u_k - u_{k-1}).

    Frame 0 is the state of rest from which the model starts; entry k of `flow` is the motion from frame k to
    frame k + 1. A recording that begins in the middle of a vibration has missing frames before it, in which
    the unknown pressures bring the model into motion.
    """

    points: SurfacePoints
    """r points."""
    camera: Camera
    flow: Array
    """(N, r, 2) pixels per frame along the camera's two axes; nan where it is missing. In a picture v points
    down, along minus the second axis of a camera that sees the tissue from above: give -v."""
    sd: ArrayLike = 0.1
    """[px] Of the flow's error: a number or what broadcasts to (N, r, 2), > 0. Only their ratios count, as
    the level is estimated with the tissue."""
    frame_rate: float = 4000.0
    """[Hz] > 0"""
    closed: NDArray[np.bool_] | None = None
    """(N,) Whether the folds touch between frame k and frame k + 1; left out: never."""

    def __post_init__(self) -> None:
        flow = np.asarray(self.flow, dtype=float)
        r = len(self.points.nodes)
        if flow.ndim != 3 or flow.shape[1:] != (r, 2) or len(flow) < 2:
            raise InvalidInput(f"Observation: flow has shape {flow.shape}; must be (N, {r}, 2) with N >= 2.")
        if np.isinf(flow).any():
            raise InvalidInput("Observation: flow must be finite, or nan where it is missing.")
        if np.isnan(flow).all():
            raise InvalidInput("Observation: every frame of flow is missing; must have values.")
        if not np.nan_to_num(flow).any():
            raise InvalidInput("Observation: flow is zero everywhere; must show motion.")
        try:
            sd = np.broadcast_to(np.asarray(self.sd, dtype=float), flow.shape)
        except ValueError:
            raise InvalidInput(
                f"Observation: sd has shape {np.shape(self.sd)}; must broadcast to {flow.shape}."
            ) from None
        if not (np.isfinite(sd).all() and (sd > 0).all()):
            raise InvalidInput("Observation: sd must be > 0 and finite everywhere.")
        if not (np.isfinite(self.frame_rate) and self.frame_rate > 0):
            raise InvalidInput(f"Observation: frame_rate = {self.frame_rate:g} Hz; must be > 0.")
        closed = np.zeros(len(flow), dtype=bool) if self.closed is None else np.asarray(self.closed)
        if closed.shape != (len(flow),) or closed.dtype != bool:
            raise InvalidInput(f"Observation: closed must be {len(flow)} truth values, one a frame.")
        for name, value in (("flow", flow), ("sd", sd), ("closed", closed)):
            object.__setattr__(self, name, value)

    @property
    def frames(self) -> int:
        """N"""
        return len(self.flow)

    @property
    def rows(self) -> Array:
        """(N, 2 r) pixels per frame, zero where missing; x and y of one point after another."""
        return np.nan_to_num(self.flow).reshape(self.frames, -1)

    @property
    def weights(self) -> Array:
        """(N, 2 r) 1 / sd^2 in 1/px^2, zero where missing."""
        return np.where(np.isnan(self.flow), 0.0, 1.0 / np.asarray(self.sd) ** 2).reshape(self.frames, -1)

    def displacements(self, axes: Array | None = None) -> tuple[NDArray[np.int32], sparse.csr_array]:
        """The unknowns that are seen (o), and the map (2 r, o) px/m from their displacement to image rows,
        along the camera's axes or those given (2, 3)."""
        nodes, weights = self.points.nodes, self.points.weights
        used, place = np.unique(nodes, return_inverse=True)
        place = place.reshape(nodes.shape)
        unknowns = (3 * used[:, None] + np.arange(3)).ravel().astype(np.int32)
        scaled = self.camera.pixels_per_metre * (self.camera.axes if axes is None else axes)
        r, k = nodes.shape
        rows = np.broadcast_to((2 * np.arange(r)[:, None, None, None] + np.arange(2)[:, None]), (r, k, 2, 3))
        columns = np.broadcast_to(3 * place[:, :, None, None] + np.arange(3), (r, k, 2, 3))
        values = weights[:, :, None, None] * scaled
        shape = (2 * r, len(unknowns))
        return unknowns, sparse.coo_array(
            (values.ravel(), (rows.ravel(), columns.ravel())), shape=shape
        ).tocsr()
