"""Observed points of the tissue surface and their motion from frame to frame, in pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from plica import _engine
from plica.camera.pose import Camera
from plica.camera.visible_faces import meet, shapes
from plica.errors import InvalidInput

__all__ = ["Observation", "SurfacePoints"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SurfacePoints:
    """Material points of a surface, each inside one face: x = sum_k weights[k] x[nodes[k]]."""

    nodes: NDArray[np.int32]
    """(r, k)"""
    weights: Array
    """(r, k)"""

    @classmethod
    def at_nodes(cls, nodes: ArrayLike) -> SurfacePoints:
        """Points at nodes."""
        rows = np.asarray(nodes, dtype=np.int32).reshape(-1, 1)
        return cls(rows, np.ones(rows.shape))

    @classmethod
    def seen(cls, mesh: _engine.TetMesh, surface: str, camera: Camera, pixels: Array) -> SurfacePoints:
        """The points that the camera sees at pixels (r, 2), column and row.

        Each is on the nearest face that is turned towards the camera, where the line of sight meets the
        curved face. Raises InvalidInput if there is none.
        """
        pixels = np.asarray(pixels, dtype=float)
        points, there = cls.met(mesh, surface, camera, pixels)
        if not there.all():
            k = int(np.argmin(there))
            raise InvalidInput(
                f"SurfacePoints: pixels[{k}] = [{pixels[k, 0]:g}, {pixels[k, 1]:g}] px; must show the "
                f'surface "{surface}". Is the camera where the mesh is?'
            )
        return points

    @classmethod
    def met(
        cls, mesh: _engine.TetMesh, surface: str, camera: Camera, pixels: Array
    ) -> tuple[SurfacePoints, NDArray[np.bool_]]:
        """`seen` for the pixels that show the surface, and (r) which these are."""
        faces = np.asarray(mesh.surfaces[surface])
        found = meet(camera.project(np.asarray(mesh.points, dtype=float)), faces, pixels)
        there = found.face >= 0
        nodes = np.asarray(faces[found.face[there]], dtype=np.int32)
        return cls(nodes, shapes(faces.shape[1], found.place[there])), there


@dataclass(frozen=True)
class Observation:
    """The motion of surface points between frames, y_k = c P S (u_k - u_{k-1}).

    Frame 0 is the state of rest from which the model starts; entry k of `flow` is the motion from frame k to
    frame k + 1. A recording that starts during a vibration has missing frames before it, in which the unknown
    pressures set the model in motion.
    """

    points: SurfacePoints
    """r points."""
    camera: Camera
    flow: Array
    """(N, r, 2) pixels per frame, to the right and down in the image; nan where missing."""
    sd: ArrayLike = 0.1
    """[px] Stated sd of the flow's error: a number or an array that broadcasts to (N, r, 2), > 0. A common
    factor is estimated with the tissue, so only ratios matter, with one exception: the prior sd of pressures
    before the first frame with data is 1e4 Pa times that factor, so stating ten times the sd allows a tenth
    of these pressures."""
    frame_rate: float = 4000.0
    """[Hz] > 0"""
    closed: NDArray[np.bool_] | None = None
    """(N,) Whether the folds touch between frame k and frame k + 1; default: never."""
    tilt_sd: float = 0.0
    """[degrees] Prior standard deviation of the camera's tilt and lean about its own values, in [0, 45); if
    > 0, both are estimated with the tissue."""

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
        if not 0 <= self.tilt_sd < 45:
            raise InvalidInput(
                f"Observation: tilt_sd = {self.tilt_sd:g} degrees; must be in [0, 45). Is it in radians?"
            )
        closed = np.zeros(len(flow), dtype=bool) if self.closed is None else np.asarray(self.closed)
        if closed.shape != (len(flow),) or closed.dtype != bool:
            raise InvalidInput(f"Observation: closed must be {len(flow)} booleans, one per frame.")
        for name, value in (("flow", flow), ("sd", sd), ("closed", closed)):
            object.__setattr__(self, name, value)

    @property
    def frames(self) -> int:
        """N"""
        return len(self.flow)

    def of_first(self, frames: int) -> Observation:
        """The observation of the first frames alone."""
        sd, closed = np.asarray(self.sd), np.asarray(self.closed)
        return replace(self, flow=self.flow[:frames], sd=sd[:frames], closed=closed[:frames])

    @property
    def rows(self) -> Array:
        """(N, 2 r) pixels per frame, zero where missing; x and y of one point after another."""
        return np.nan_to_num(self.flow).reshape(self.frames, -1)

    @property
    def weights(self) -> Array:
        """(N, 2 r) 1 / sd^2 in 1/px^2, zero where missing."""
        return np.where(np.isnan(self.flow), 0.0, 1.0 / np.asarray(self.sd) ** 2).reshape(self.frames, -1)

    def displacements(self, projection: Array | None = None) -> tuple[NDArray[np.int32], sparse.csr_array]:
        """The observed unknowns (o), and the map (2 r, o) px/m from their displacement to image rows.

        Uses the camera's projection, or a derivative of it (3, 4).
        """
        nodes, weights = self.points.nodes, self.points.weights
        used, place = np.unique(nodes, return_inverse=True)
        place = place.reshape(nodes.shape)
        unknowns = (3 * used[:, None] + np.arange(3)).ravel().astype(np.int32)
        seen = (self.camera.projection if projection is None else projection)[:2, :3]
        r, k = nodes.shape
        rows = np.broadcast_to((2 * np.arange(r)[:, None, None, None] + np.arange(2)[:, None]), (r, k, 2, 3))
        columns = np.broadcast_to(3 * place[:, :, None, None] + np.arange(3), (r, k, 2, 3))
        values = weights[:, :, None, None] * seen
        shape = (2 * r, len(unknowns))
        return unknowns, sparse.coo_array(
            (values.ravel(), (rows.ravel(), columns.ravel())), shape=shape
        ).tocsr()
