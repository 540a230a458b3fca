"""A body that rattles in a frame, both free along x: collisions without end (R10).

The body, 6 x 2 x 1 cells of 1 mm, is in a frame of 10 x 6 x 1 cells with a cavity of 6 x 4; it is shorter
than the cavity by a tenth of a cell at each end, and touches there. All nodes are on rollers along x, so
momentum along x is free, and nothing can slip out of the frame. As every impact turns some of the relative
motion into vibration, an alternating force goes between them, F sin(2 pi t / T) on the body and its opposite
on the frame. Its sum is zero and its work is in the energy balance.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plica import _engine as engine
from plica.verify.bodies.blocks import CELL, DENSITY, NU, E
from plica.verify.bodies.body import Body

__all__ = ["Box"]

CLEARANCE = 1e-4  # m
LONG, WIDE, WALL, RAIL, BESIDE = 6, 2, 2, 1, 1  # cells: the body, the frame's parts, room beside the body
VISCOSITY = 0.1  # Pa s
SPEED = 0.1  # m/s, of the body against the frame, at the start
PUSH = 5.0  # m/s^2, the alternating force over the body's mass
PERIOD = 200  # steps


class Box:
    """Both bodies, the air between them, and how they start."""

    def __init__(self) -> None:
        frame = _frame()
        length, width = LONG * CELL - 2 * CLEARANCE, WIDE * CELL
        body = engine.block_mesh(
            corner=(CLEARANCE, -0.5 * width, 0), size=(length, width, CELL), divisions=(LONG, WIDE, 1)
        )
        self.mesh = engine.combine(frame, body, "frame.", "body.")
        self.is_body = np.arange(len(self.mesh.points)) >= len(frame.points)
        self.step = CELL / float(np.sqrt(E / DENSITY))
        self.airway = _air(self.mesh)
        whole = (LONG + 2 * WALL) * (WIDE + 2 * BESIDE + 2 * RAIL) - LONG * (WIDE + 2 * BESIDE)
        areas = {"body": length * width, "frame": whole * CELL**2}
        self.mass = {name: DENSITY * CELL * area for name, area in areas.items()}  # kg
        force, frequency = self.mass["body"] * PUSH, 1 / (PERIOD * self.step)
        self.loads = [
            engine.Load(
                surface=f"{name}.z_max",
                traction=(sign * force / area, 0, 0),
                frequency=frequency,
                phase=-0.5 * np.pi,
            )
            for (name, area), sign in zip(areas.items(), (1, -1), strict=True)
        ]

    @property
    def momentum(self) -> float:
        """kg m/s of the body at the start; the frame's is its opposite."""
        body, frame = self.mass["body"], self.mass["frame"]
        return body * frame / (body + frame) * SPEED

    def simulation(self, scheme: Any, contact: dict[str, Any], tolerance: float) -> engine.Simulation:
        points = self.mesh.points
        fixed = np.zeros(points.shape, bool)
        fixed[:, 1:] = True
        velocity = np.zeros(points.shape)
        velocity[:, 0] = np.where(
            self.is_body, self.momentum / self.mass["body"], -self.momentum / self.mass["frame"]
        )
        material = engine.Material(engine.Isotropic(E, NU), DENSITY, VISCOSITY)
        return Body(self.mesh, material, fixed).simulation(
            scheme=scheme,
            step=self.step,
            solver_tolerance=tolerance,
            contact=engine.Contact(airway=self.airway, **contact),
            loads=self.loads,
            velocity=velocity,
        )


def _frame() -> Any:
    """A ring; its surfaces are the ends of the cavity where the body meets them, and the upper face."""
    half = 0.5 * WIDE + BESIDE  # of the cavity, in cells
    whole = engine.block_mesh(
        corner=(-WALL * CELL, -(half + RAIL) * CELL, 0),
        size=((LONG + 2 * WALL) * CELL, 2 * (half + RAIL) * CELL, CELL),
        divisions=(LONG + 2 * WALL, round(2 * (half + RAIL)), 1),
    )
    middle = whole.points[whole.cells].mean(axis=1) / CELL
    hollow = (middle[:, 0] > 0) & (middle[:, 0] < LONG) & (np.abs(middle[:, 1]) < half)
    kept, cells = np.unique(whole.cells[~hollow], return_inverse=True)
    points, cells = whole.points[kept], cells.reshape(-1, 4)
    triangles = engine.boundary(cells)[0]
    corners = points[triangles] / CELL
    facing = np.abs(corners[:, :, 1]).max(axis=1) < 0.5 * WIDE + 1e-9
    surfaces = {
        name: triangles[facing & np.isclose(corners[:, :, 0], end).all(axis=1)]
        for name, end in (("x_min", 0), ("x_max", LONG))
    }
    surfaces["z_max"] = triangles[np.isclose(corners[:, :, 2], 1).all(axis=1)]
    of_cell = np.zeros(len(cells), int)
    return engine.TetMesh(points, cells, of_cell, of_cell, ["frame"], surfaces, {})


def _air(mesh: Any) -> Any:
    """Of both ends."""
    parts = [
        engine.matched_airway(
            mesh.points, mesh.surfaces[f"frame.{end}"], mesh.surfaces[f"body.{end}"], (along, 0, 0)
        )
        for end, along in (("x_min", 1), ("x_max", -1))
    ]
    return engine.Airway(
        *(np.vstack([getattr(part, what) for part in parts]) for what in ("first", "second", "tets"))
    )
