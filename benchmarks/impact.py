"""Bars that strike an obstacle or each other, in 3D: the engine against closed forms (R1, R2, R3).

R1  periodic bar on a rigid obstacle (Dabaghi et al., arXiv 1601.00778): contact for 1 < t < 2 with force 1/2.
R2  bouncing bar under gravity (Doyen, Ern, Piperno 2011): impact for 1 < t < 5/3 with pressure rho c g t.
R3  two equal bars that meet at 1 m/s: pressure rho c v / 2 for 2 L / c.

Every bar is one hexahedron (six tetrahedra) across, nu = 0, on lateral rollers. Columns: whether the nodes of
the contact surfaces keep their mass; then, as ratios to the exact value where there is one, duration from the
first to the last step in contact, impulse over duration, median of the pressure while in contact, peak
pressure, duty (share of the duration spent in contact; below 1 the contact chatters), deepest penetration in
edges, energy at the end and its maximum over that at the start, the ledger's error over the largest energy
with solves at 1e-13 and at 1e-8, and the time of a step.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from body import SCHEMES, Body, advanced

from plica import _engine as engine


@dataclass(frozen=True)
class Bar:
    """A bar's material and the step that goes with it."""

    E: float  # Pa
    density: float  # kg/m^3
    length: float  # m
    elements: int
    courant: float  # step in units of dx / c

    @property
    def speed(self) -> float:
        return float(np.sqrt(self.E / self.density))

    @property
    def edge(self) -> float:
        return self.length / self.elements

    @property
    def step(self) -> float:
        return self.courant * self.edge / self.speed


@dataclass(frozen=True)
class Problem:
    """A bar problem and its exact first impact."""

    bar: Bar
    duration: float  # s simulated
    impact: tuple[float, float]  # s, exact begin and end of the first impact
    pressure: Callable[[np.ndarray], np.ndarray]  # Pa, exact, at times
    build: Callable[[Bar, Any, dict[str, Any], float], Any]


def rollers(nodes: int, rigid: np.ndarray | None = None) -> np.ndarray:
    fixed = np.zeros((nodes, 3), bool)
    fixed[:, 1:] = True
    if rigid is not None:
        fixed[rigid] = True
    return fixed


def simulation(
    bar: Bar,
    mesh: Any,
    fixed: np.ndarray,
    airway: Any,
    scheme: Any,
    contact: dict[str, Any],
    tolerance: float,
    **initial: Any,
) -> Any:
    material = engine.Material(engine.Isotropic(bar.E, 0.0), density=bar.density, viscosity=0.0)
    return Body(mesh, material, fixed).simulation(
        scheme=scheme,
        step=bar.step,
        solver_tolerance=tolerance,
        max_iterations=20000,
        contact=engine.Contact(airway=airway, **contact),
        **initial,
    )


def on_obstacle(bar: Bar, gap: float) -> tuple[Any, np.ndarray, Any]:
    """The bar on [gap, gap + L] and a fully fixed cube below it."""
    w, n = bar.edge, bar.elements
    body = engine.block_mesh(corner=(gap, 0, 0), size=(bar.length, w, w), divisions=(n, 1, 1))
    obstacle = engine.block_mesh(corner=(-w, 0, 0), size=(w, w, w), divisions=(1, 1, 1))
    mesh = engine.combine(obstacle, body, "a.", "b.")
    airway = engine.matched_airway(mesh.points, mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"], (1, 0, 0))
    rigid = np.arange(len(mesh.points)) < len(obstacle.points)
    return mesh, rigid, airway


def periodic_bar(bar: Bar, scheme: Any, contact: dict[str, Any], tolerance: float) -> Any:
    mesh, rigid, airway = on_obstacle(bar, 0.0)
    fixed = rollers(len(mesh.points), rigid)
    fixed[mesh.points[:, 0] > bar.length * (1 - 1e-9)] = True
    displacement = np.zeros((len(mesh.points), 3))
    displacement[~rigid, 0] = (1 - mesh.points[~rigid, 0]) / 2
    return simulation(bar, mesh, fixed, airway, scheme, contact, tolerance, displacement=displacement)


def bouncing_bar(bar: Bar, scheme: Any, contact: dict[str, Any], tolerance: float) -> Any:
    mesh, rigid, airway = on_obstacle(bar, 5.0)
    fixed = rollers(len(mesh.points), rigid)
    return simulation(bar, mesh, fixed, airway, scheme, contact, tolerance, gravity=(-10.0, 0.0, 0.0))


def two_bars(bar: Bar, scheme: Any, contact: dict[str, Any], tolerance: float) -> Any:
    w, n = bar.edge, bar.elements
    left = engine.block_mesh(corner=(-bar.length, 0, 0), size=(bar.length, w, w), divisions=(n, 1, 1))
    right = engine.block_mesh(corner=(0, 0, 0), size=(bar.length, w, w), divisions=(n, 1, 1))
    mesh = engine.combine(left, right, "a.", "b.")
    airway = engine.matched_airway(mesh.points, mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"], (1, 0, 0))
    velocity = np.zeros((len(mesh.points), 3))
    velocity[:, 0] = np.where(np.arange(len(mesh.points)) < len(left.points), 0.5, -0.5)
    return simulation(
        bar, mesh, rollers(len(mesh.points)), airway, scheme, contact, tolerance, velocity=velocity
    )


def problems(elements: int) -> dict[str, Problem]:
    r1 = Bar(1.0, 1.0, 1.0, elements, 0.5)
    r2 = Bar(900.0, 1.0, 10.0, elements, 1.0)
    r3 = Bar(20e3, 1040.0, 0.01, elements, 1.0)
    plateau = r3.density * r3.speed / 2
    return {
        "R1": Problem(r1, 3.0, (1.0, 2.0), lambda t: np.full(t.shape, 0.5), periodic_bar),
        "R2": Problem(r2, 2.5, (1.0, 5 / 3), lambda t: 300.0 * t, bouncing_bar),
        "R3": Problem(
            r3,
            2.6 * r3.length / r3.speed,
            (0.0, 2 * r3.length / r3.speed),
            lambda t: np.full(t.shape, plateau),
            two_bars,
        ),
    }


MASSES = ("kept", "redistributed")  # of the contact nodes


def enforcements(bar: Bar) -> dict[str, Any]:
    """Multipliers three ways; penalties of 10 E / dx (Pa/m) in all."""
    stiffness = 10 * bar.E / bar.edge
    area = bar.edge**2
    return {
        "multipliers": engine.Multipliers(),
        "multipliers, GMRES": engine.Multipliers(solver="gmres"),
        "multipliers, Eq. (25)": engine.Multipliers(position="weighted"),
        "augmented": engine.Augmented(),
        "Nitsche": engine.Nitsche(),
        "penalty": engine.Penalty(stiffness=stiffness * area / 4),  # four nodes
        "volume penalty": engine.VolumePenalty(
            kappa=6 * stiffness
        ),  # two of three tetrahedra push, kappa V / 4 each
    }


def run(
    problem: Problem, scheme: Any, contact: dict[str, Any], tolerance: float, duration: float | None = None
) -> dict[str, float]:
    bar = problem.bar
    sim = problem.build(bar, scheme, contact, tolerance)
    steps = round((duration or problem.duration) / bar.step)
    start = time.perf_counter()
    result = advanced(sim, steps)
    seconds = time.perf_counter() - start
    t = result["time"]
    pressure = np.abs(result["contact_force_first"][:, 0]) / bar.edge**2
    energy = result["kinetic_energy"] + result["elastic_energy"]
    begin, end = problem.impact
    exact = problem.pressure(t)
    window = (t > begin - 0.4 * (end - begin)) & (t < end + 0.4 * (end - begin))
    on = window & (pressure > 0)
    first, last = t[on][0], t[on][-1]
    length = last - first + bar.step
    mean = problem.pressure(np.linspace(begin, end, 10001)).mean()
    forces = result["contact_force_first"] + result["contact_force_second"]
    scale = energy.max()
    # R2's energy is all gravity's at the start, m g h0, and its work is recorded as that of a load.
    total, reference = energy - result["load_work"], sim.state()["initial"]
    if reference == 0.0:
        reference = bar.density * bar.edge**2 * bar.length * 10.0 * 5.0
        total = total + reference
    return {
        "duration": length / (end - begin),
        "impulse/duration": pressure[on].sum() * bar.step / length / mean,
        "plateau": float(np.median(pressure[on] / exact[on])),
        "peak": float((pressure[on] / exact[on]).max()),
        "duty": on.sum() * bar.step / length,
        "penetration": -result["deepest_gap"].min() / bar.edge,
        "energy end": total[-1] / reference,
        "energy max": total.max() / reference,
        "ledger": np.abs(result["ledger_error"]).max() / scale,
        "force sum": np.abs(forces).max() / np.abs(result["contact_force_first"]).max(),
        "largest multiplier": result["largest_multiplier"].max(),
        "passes": int(result["contact_passes"].max()),
        "ms/step": 1e3 * seconds / steps,
    }


COLUMNS = [
    "duration",
    "impulse/duration",
    "plateau",
    "peak",
    "duty",
    "penetration",
    "energy end",
    "energy max",
]


def text(value: float) -> str:
    return f"{value:.3f}" if 1e-3 <= abs(value) < 1e4 else f"{value:.1e}"


def convergence() -> None:
    """The three limits of the recommended schemes on finer bars, solves at 1e-8."""
    columns = ["duration", "impulse/duration", "plateau", "peak", "penetration"]
    print("\n| | contact | scheme | elements | " + " | ".join(columns) + " |")
    print("|" + " --- |" * (4 + len(columns)))
    for name in ("R1", "R2", "R3"):
        for label in ("multipliers", "penalty"):
            for scheme in ("HHT(-0.3)", "HHT(-1/3)"):
                for elements in (50, 100, 200, 400):
                    problem = problems(elements)[name]
                    contact = {"enforcement": enforcements(problem.bar)[label]}
                    r = run(problem, SCHEMES[scheme], contact, 1e-8)
                    print(
                        f"| {name} | {label} | {scheme} | {elements} | "
                        + " | ".join(text(r[c]) for c in columns)
                        + " |",
                        flush=True,
                    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--problems", default="R1,R2,R3", help="the scheme tables to make")
    parser.add_argument("--elements", type=int, default=100, help="along a bar")
    parser.add_argument(
        "--periods", type=int, default=0, help="also R1 over so many periods, multipliers and penalty"
    )
    parser.add_argument("--convergence", action="store_true", help="also finer bars, the recommended schemes")
    parser.add_argument("--csv", type=Path, default=Path("impact.csv"))
    options = parser.parse_args()
    rows = []
    for name in filter(None, options.problems.split(",")):
        problem = problems(options.elements)[name]
        print(
            f"\n| {name} | "
            + " | ".join(["scheme", "mass", *COLUMNS, "ledger 1e-13", "1e-8", "ms/step"])
            + " |"
        )
        print("|" + " --- |" * (len(COLUMNS) + 6))
        for label, scheme_name, mass in itertools.product(enforcements(problem.bar), SCHEMES, MASSES):
            contact = {"enforcement": enforcements(problem.bar)[label], "surface_mass": mass}
            try:
                tight = run(problem, SCHEMES[scheme_name], contact, 1e-13)
                default = run(problem, SCHEMES[scheme_name], contact, 1e-8)
            except (RuntimeError, IndexError) as failure:
                print(f"| {label} | {scheme_name} | {mass} | {failure} |", flush=True)
                continue
            rows.append(
                {
                    "problem": name,
                    "contact": label,
                    "scheme": scheme_name,
                    "mass": mass,
                    **tight,
                    "ledger default": default["ledger"],
                    "ms/step default": default["ms/step"],
                }
            )
            cells = [
                label,
                scheme_name,
                mass,
                *(text(tight[c]) for c in COLUMNS),
                f"{tight['ledger']:.0e}",
                f"{default['ledger']:.0e}",
                f"{default['ms/step']:.2f}",
            ]
            print("| " + " | ".join(cells) + " |", flush=True)
    if options.periods:
        problem = problems(options.elements)["R1"]
        print(
            f"\n| R1, {options.periods} periods | scheme | mass | energy end | energy max "
            "| peak force | penetration |"
        )
        print("|" + " --- |" * 7)
        for label, scheme_name, mass in itertools.product(("multipliers", "penalty"), SCHEMES, MASSES):
            contact = {"enforcement": enforcements(problem.bar)[label], "surface_mass": mass}
            try:
                r = run(problem, SCHEMES[scheme_name], contact, 1e-10, 3.0 * options.periods)
            except RuntimeError as failure:
                print(f"| {label} | {scheme_name} | {mass} | {failure} |", flush=True)
                continue
            print(
                f"| {label} | {scheme_name} | {mass} | {text(r['energy end'])} | {text(r['energy max'])} | "
                f"{text(r['peak'] / 2)} | {text(r['penetration'] / options.elements)} |",
                flush=True,
            )
    if options.convergence:
        convergence()
    if rows:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
