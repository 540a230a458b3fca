"""Coupling of flow and tissue, where the flow separates at one section throughout and nothing collides.

The folds of the coarse larynx rest in equilibrium with the flow and get a small velocity in the shape of
their first symmetric mode.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh, splu

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import of_order
from plica import _engine as engine
from plica.verify.bodies.body import Body

__all__ = ["CASES"]

Array = NDArray[np.float64]

PRESSURE, SPEED, SPAN = 400.0, 0.05, 4e-3  # Pa, m/s, s
FLOWS: dict[str, tuple[Any, Any]] = {
    "bernoulli": (engine.Bernoulli(), engine.Elliptic()),
    # So few sections that the jet leaves between the same two all the time: the load is smooth.
    "viscous_slit": (engine.ViscousSlit(), engine.Cut(sections=40)),
}
ITERATED = engine.Iterated(tolerance=1e-11, max_sweeps=60, freeze_after=50)
COUPLINGS = {"lagged": engine.Lagged(), "extrapolated": engine.Extrapolated(), "iterated": ITERATED}
FINER = 8


@dataclass(frozen=True)
class Truth:
    """With the iterated coupling."""

    exact: Motion
    """At the shortest step."""
    same_step: Motion


@dataclass(frozen=True)
class Motion:
    """At the end; m, m/s."""

    u: Array
    v: Array


def _simulation(body: Body, flow: str, coupling: Any, step: float, **initial: Any) -> engine.Simulation:
    model, area = FLOWS[flow]
    airflow = engine.Airflow(
        surface="airway", subglottal_pressure=PRESSURE, model=model, area=area, coupling=coupling
    )
    return body.simulation(
        scheme=engine.HilberHughesTaylor(alpha=-0.3),
        step=step,
        solver_tolerance=1e-12,
        airflow=airflow,
        **initial,
    )


@lru_cache(maxsize=2)
def _start(flow: str) -> tuple[Body, Array, Array]:
    """The folds, their displacement in equilibrium with the flow, and the velocity that they get."""
    mesh = engine.larynx_mesh(**engine.larynx_preset("thesis_coarse"))
    material = engine.Material(engine.Isotropic(12e3, 0.45), density=1040.0, viscosity=1.0)
    body = Body(mesh, material, np.zeros((len(mesh.points), 3), bool)).hold("wall")
    stiffness, mass = (body.on_free(m) for m in (body.assembly.stiffness(), body.assembly.mass()))
    solve = splu(stiffness).solve
    u = np.zeros(len(body.free))
    for _ in range(60):  # K u = f(u)
        load = _simulation(body, flow, engine.Lagged(), 1e-4, displacement=body.field(u)).state()["load"]
        change = solve(np.asarray(load)[body.free]) - u
        u += change
        if np.abs(change).max() < 1e-13:
            break
    else:
        raise RuntimeError(f"the folds find no equilibrium: last change {np.abs(change).max():.3g} m")
    return body, body.field(u), SPEED * _symmetric_mode(body, stiffness, mass)


def _symmetric_mode(body: Body, stiffness: Any, mass: Any) -> Array:
    """(n, 3), largest entry 1: the first in which both folds open."""
    x = np.asarray(body.mesh.points)[:, 0]
    _, modes = eigsh(stiffness, k=6, M=mass, sigma=0.0, v0=np.ones(len(body.free)))
    for mode in modes.T:
        shape = body.field(mode)
        opens = float((np.sign(x) * shape[:, 0]).sum())
        if abs(opens) > 0.5 * np.abs(shape[:, 0]).sum():
            return np.asarray(shape * np.sign(opens) / np.abs(shape).max())
    raise RuntimeError("none of the first six modes is symmetric")


def _run(flow: str, coupling: Any, steps: int) -> Motion:
    body, u, v = _start(flow)
    simulation = _simulation(body, flow, coupling, SPAN / steps, displacement=u, velocity=v)
    found = simulation.advance(steps)
    sections = np.unique(found["separation"])
    if sections.size != 1 or found["flow_stopped"].any():
        raise RuntimeError(f"the flow separates at sections {sections}; must be at one.")
    return Motion(np.asarray(simulation.displacement) - u, np.array(simulation.velocity))


def _method(coupling: str, level: Level) -> Callable[[], Motion]:
    flow = str(level["flow"])
    _start(flow)
    return lambda: _run(flow, COUPLINGS[coupling], int(level["steps"]))


@lru_cache(maxsize=2)
def _exact(flow: str, steps: int) -> Motion:
    return _run(flow, ITERATED, steps)


def _truth(level: Level) -> Truth:
    flow = str(level["flow"])
    return Truth(_exact(flow, int(level["exact"])), _run(flow, ITERATED, int(level["steps"])))


def _judge(level: Level, found: Motion, truth: Truth) -> dict[str, float]:
    exact, same = truth.exact, truth.same_step
    size_u, size_v = np.linalg.norm(exact.u), np.linalg.norm(exact.v)
    return {
        "displacement": float(np.linalg.norm(found.u - exact.u) / size_u),
        "velocity": float(np.linalg.norm(found.v - exact.v) / size_v),
        "coupling alone": float(np.linalg.norm(found.u - same.u) / size_u),
    }


def _levels(flows: Sequence[str], steps: Sequence[int]) -> tuple[Level, ...]:
    return tuple(
        {"flow": flow, "steps": count, "exact": FINER * max(steps)} for flow in flows for count in steps
    )


CASES = (
    Case(
        name="coupling",
        does="The folds of a coarse larynx swing for 4 ms in the air that flows between them.",
        reference="iterated coupling at an eighth of the shortest step",
        errors={
            "displacement": "at the end, over the motion",
            "velocity": "likewise",
            "coupling alone": "of the displacement, to the iterated coupling at the same step",
        },
        levels={
            "small": _levels(("viscous_slit",), (20, 40)),
            "full": _levels(("viscous_slit", "bernoulli"), (40, 80, 160, 320)),
        },
        methods=tuple(Method(name, partial(_method, name)) for name in COUPLINGS),
        truth=_truth,
        judge=_judge,
        problem=("flow",),
        claims=tuple(
            Claim(
                f"the iterated coupling is of order 2 with {flow}",
                of_order("iterated", "displacement", "steps", 1.7, flow=flow),
            )
            for flow in FLOWS
        ),
        threads=(1,),
    ),
)
