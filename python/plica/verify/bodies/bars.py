"""Bars that strike an obstacle or each other, with their exact motion (R1, R2, R3 and the bars of 50 MPa).

Every bar is one hexahedron (six tetrahedra) across, on lateral rollers, so that it moves as a bar of modulus
E (1 - nu) / ((1 + nu)(1 - 2 nu)) in one dimension. `depth` is the distance from the end that is struck.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.verify.bodies.body import Body, facing

__all__ = ["PROBLEMS", "Bar", "Collision", "Problem"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bar:
    """A bar's material and the step that goes with it."""

    E: float  # Pa
    density: float  # kg/m^3
    length: float  # m
    elements: int
    courant: float  # step in units of dx / c
    nu: float = 0.0

    @property
    def modulus(self) -> float:
        """Pa, stress over strain along the bar between rollers."""
        return self.E * (1 - self.nu) / ((1 + self.nu) * (1 - 2 * self.nu))

    @property
    def wave(self) -> float:
        """m/s."""
        return float(np.sqrt(self.modulus / self.density))

    @property
    def edge(self) -> float:
        return self.length / self.elements

    @property
    def step(self) -> float:
        return self.courant * self.edge / self.wave


@dataclass(frozen=True)
class Collision:
    """A bar without stress that meets a wall, or its mirror image, at `begin`; exact until it falls back."""

    bar: Bar
    speed: float  # m/s at begin
    begin: float  # s
    gravity: float = 0.0  # m/s^2, towards the wall

    @property
    def end(self) -> float:
        """s, when the wave is back from the far end."""
        return self.begin + 2 * self.bar.length / self.bar.wave

    def pressure(self, time: Array) -> Array:
        """Pa, zero but during contact."""
        on = (time >= self.begin) & (time <= self.end)
        pushed = self.speed + self.gravity * (time - self.begin)
        return np.where(on, self.bar.density * self.bar.wave * pushed, 0.0)

    def displacement(self, depth: Array, time: Array) -> Array:
        """m away from the wall since `begin`, (times, depths).

        Free fall and, of the same shape, the waves that leave the wall and that come back from the free end:
        w = -V(s) + V(s - x/c) + V(s - (2L - x)/c), V(s) = v s + g s^2 / 2 (s > 0), s = t - begin. At 2 L / c
        every point has the velocity v away from the wall. From there the bar falls freely, and the strain
        that gravity has left swings between two free ends: (W(x - cs) + W(x + cs)) / 2, W even about both.
        """
        bar, c = self.bar, self.bar.wave
        since = (time - self.begin)[:, None]
        back = 2 * bar.length / c

        def pushed(s: Array) -> Array:
            s = np.maximum(s, 0.0)
            return self.speed * s + 0.5 * self.gravity * s**2

        def touching(x: Array, s: Array) -> Array:
            fall = -self.speed * s - 0.5 * self.gravity * s**2
            return fall + pushed(s - x / c) + pushed(s - (2 * bar.length - x) / c)

        def left(x: Array) -> Array:
            x = np.mod(x, 2 * bar.length)
            return touching(np.minimum(x, 2 * bar.length - x), np.full_like(x, back))

        after = since - back
        swing = 0.5 * (left(depth - c * after) + left(depth + c * after))
        parted = self.speed * after - 0.5 * self.gravity * after**2 + swing
        return np.where(after < 0, touching(depth, since), parted)

    def drift(self, time: float) -> float:
        """m/s, mean velocity away from the wall after the impact."""
        return self.speed - self.gravity * (time - self.end)


@dataclass(frozen=True)
class Swing:
    """R1: E, density and length 1; held at its far end, strained by -1/2 and let go beside the wall."""

    begin: float = 1.0
    end: float = 2.0

    def pressure(self, time: Array) -> Array:
        t = np.mod(time, 3.0)
        return np.where((t >= self.begin) & (t <= self.end), 0.5, 0.0)

    def displacement(self, depth: Array, time: Array) -> Array:
        """m away from the wall; at `begin` zero everywhere. Contact in the middle third of each period."""
        t = np.mod(time, 3.0)[:, None]
        first = 0.5 * (1 - np.maximum(depth, t))
        touching = -0.5 * np.minimum(np.minimum(depth, 1 - depth), np.minimum(t - 1, 2 - t))
        last = 0.5 * np.minimum(1 - depth, t - 2)
        return np.where(t < 1, first, np.where(t < 2, touching, last))


@dataclass(frozen=True)
class Measured:
    """A simulation, the nodes of the bar that is looked at, and how far from its struck end they are."""

    simulation: Any
    nodes: NDArray[np.int32]
    depth: Array  # m


@dataclass(frozen=True)
class Problem:
    """A bar problem: its exact first impact, and how to set it up."""

    title: str
    bar: Bar
    exact: Collision | Swing
    duration: float  # s simulated
    offset: float  # m, displacement at exact.begin
    potential: float  # J at the start, in loads; energy is counted with it
    build: Callable[..., tuple[Body, dict[str, Any]]]

    def simulation(self, scheme: Any, contact: dict[str, Any], tolerance: float) -> Measured:
        """A simulation with probes on the bar that `exact` describes."""
        body, parts = self.build(self.bar)
        nodes = np.flatnonzero(parts.pop("measured")).astype(np.int32)
        depth = body.mesh.points[nodes, 0] - body.mesh.points[nodes, 0].min()
        simulation = body.simulation(
            scheme=scheme,
            step=self.bar.step,
            solver_tolerance=tolerance,
            contact=engine.Contact(airway=parts.pop("airway"), **contact),
            probes=nodes,
            **parts,
        )
        return Measured(simulation, nodes, depth)


def _body(bar: Bar, mesh: Any, rigid: NDArray[np.bool_]) -> Body:
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[:, 1:] = True
    fixed[rigid] = True
    return Body(mesh, engine.Material(engine.Isotropic(bar.E, bar.nu), bar.density, 0.0), fixed)


def _on_obstacle(bar: Bar, gap: float) -> tuple[Any, NDArray[np.bool_], Any]:
    """The bar on [gap, gap + L] and a cube below it."""
    w = bar.edge
    own = engine.block_mesh(corner=(gap, 0, 0), size=(bar.length, w, w), divisions=(bar.elements, 1, 1))
    return facing(engine.block_mesh(corner=(-w, 0, 0), size=(w, w, w)), own)


def _swinging(bar: Bar) -> tuple[Body, dict[str, Any]]:
    mesh, measured, airway = _on_obstacle(bar, 0.0)
    far = mesh.points[:, 0] > bar.length * (1 - 1e-9)
    displacement = np.zeros((len(mesh.points), 3))
    displacement[measured, 0] = (1 - mesh.points[measured, 0]) / 2
    parts = {"measured": measured, "airway": airway, "displacement": displacement}
    return _body(bar, mesh, ~measured | far), parts


def _dropped(height: float, gravity: float) -> Callable[[Bar], tuple[Body, dict[str, Any]]]:
    def build(bar: Bar) -> tuple[Body, dict[str, Any]]:
        mesh, measured, airway = _on_obstacle(bar, height)
        parts = {"measured": measured, "airway": airway, "gravity": (-gravity, 0.0, 0.0)}
        return _body(bar, mesh, ~measured), parts

    return build


def _meeting(speed: float, gap: float) -> Callable[[Bar], tuple[Body, dict[str, Any]]]:
    """Two alike, each at `speed`."""

    def build(bar: Bar) -> tuple[Body, dict[str, Any]]:
        w = bar.edge
        shape: dict[str, Any] = {"size": (bar.length, w, w), "divisions": (bar.elements, 1, 1)}
        left = engine.block_mesh(corner=(-bar.length, 0, 0), **shape)
        right = engine.block_mesh(corner=(gap, 0, 0), **shape)
        mesh, measured, airway = facing(left, right)
        velocity = np.zeros((len(mesh.points), 3))
        velocity[:, 0] = np.where(measured, -speed, speed)
        parts = {"measured": measured, "airway": airway, "velocity": velocity}
        return _body(bar, mesh, np.zeros(len(mesh.points), bool)), parts

    return build


def _periodic(elements: int) -> Problem:
    bar = Bar(1.0, 1.0, 1.0, elements, 0.5)
    return Problem("periodic bar on a rigid obstacle", bar, Swing(), 3.0, 0.0, 0.0, _swinging)


def _bouncing(elements: int) -> Problem:
    bar, height, gravity = Bar(900.0, 1.0, 10.0, elements, 1.0), 5.0, 10.0
    exact = Collision(bar, np.sqrt(2 * gravity * height), np.sqrt(2 * height / gravity), gravity)
    weight = bar.density * bar.length * bar.edge**2 * gravity
    return Problem("bouncing bar", bar, exact, 2.5, -height, weight * height, _dropped(height, gravity))


def _pair(title: str, bar: Bar, speed: float, gap: float) -> Problem:
    exact = Collision(bar, speed, 0.5 * gap / speed)
    duration = exact.begin + 2.6 * bar.length / bar.wave
    return Problem(title, bar, exact, duration, -0.5 * gap, 0.0, _meeting(speed, gap))


def _fast(elements: int, nu: float) -> Problem:
    bar = Bar(2e9, 1000.0, 2.7, elements, 1.0, nu)
    return _pair(f"bars at +-35 m/s, 7 mm apart, nu = {nu:g}", bar, 35.0, 0.007)


PROBLEMS: dict[str, Callable[[int], Problem]] = {
    "R1": _periodic,
    "R2": _bouncing,
    "R3": lambda n: _pair("equal bars that meet at 1 m/s", Bar(20e3, 1040.0, 0.01, n, 1.0), 0.5, 0.0),
    "bars": lambda n: _fast(n, 0.0),
    "bars-0.3": lambda n: _fast(n, 0.3),
}
"""By name, from the number of elements along a bar."""
