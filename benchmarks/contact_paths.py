"""Time per colliding step of the three contact solvers at equal error, and of a free step beside them.

For each scene file the folds are thrown at each other (an opening pattern of negative size); --run takes the
last checkpoint of a run of that scene instead, advanced to its next collision. The states before each step of
the collision are kept. All solvers then take the same steps, each from its kept state, in turn in one
process, the order reversed from round to round. The free step is the last before the collision, by the
condensed
solver. The first round stands apart ("first"): in it the condensed solver computes the columns of the
compliance that it finds later, as a run does in its first collision. Other figures are medians over the later
rounds; a ratio is the median of the ratios within a round, the spread the range over the median.

The errors are those of the contact forces (over their norm), of the motion (over that of the step) and of the
deepest gap (in mean edges) against the condensed solver with solves at 1e-13, each the largest over the
steps. "Break-even" is after how many colliding steps the columns have paid, against the saddle point.
"""

from __future__ import annotations

import argparse
import csv
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np
from step_cost import CLOSING, SEARCHED
from voice_measures import mean_interface_edge

import plica
from plica.phonation.run import checkpoint

SOLVERS = ("condensed", "saddle", "gmres")
PARTS = ("solve", "contact", "detection")


def scene_of(path: str, solver: str, *, thrown: bool, **krylov: float) -> plica.Scene:
    """The scene of the file with this contact solver, thrown or as the file starts it."""
    data = plica.Scene.load(path).resolved()
    if "multipliers" not in data["contact"]:
        raise plica.SceneError(f"{path}: contact; must be multipliers, whose solvers these are.")
    data["contact"]["multipliers"]["solver"] = solver
    if thrown:
        data["initial"] = {"opening_velocity": CLOSING}
    data["solver"] = data.get("solver", {}) | krylov
    return plica.Scene.model_validate(data)


def collision(simulation: Any, steps: int, longest: int) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """A state before a free step, and those before so many steps with contact rows in a row or nearly so."""
    free, colliding = simulation.state(), []
    for _ in range(longest):
        before = simulation.state()
        if simulation.advance(1)["contact_rows"][-1] > 0:
            colliding.append(before)
        elif not colliding:
            free = before
        if len(colliding) == steps:
            return free, colliding
    raise RuntimeError(f"{len(colliding)} of {longest} steps were colliding; must be {steps} or more.")


def one_step(simulation: Any, state: dict[str, Any]) -> dict[str, Any]:
    """Times (s) and findings of the step from this state."""
    simulation.restore(state)
    before = simulation.times()
    start = time.perf_counter()
    waveforms = simulation.advance(1)
    total = time.perf_counter() - start
    after = simulation.times()
    moved = np.asarray(simulation.displacement) - np.asarray(state["displacement"]).reshape(-1, 3)
    return {
        "total": total,
        **{part: after[part] - before[part] for part in PARTS},
        "rows": int(waveforms["contact_rows"][-1]),
        "passes": int(waveforms["contact_passes"][-1]),
        "iterations": int(waveforms["iterations"][-1]),
        "gap": float(waveforms["deepest_gap"][-1]),
        "moved": moved,
        "force": np.asarray(simulation.contact_force),
    }


def round_of(simulation: Any, states: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [one_step(simulation, state) for state in states]


def mean(steps: list[dict[str, Any]], name: str) -> float:
    return statistics.fmean(step[name] for step in steps)


def errors(found: list[dict[str, Any]], exact: list[dict[str, Any]], mean_edge: float) -> dict[str, float]:
    def largest(name: str) -> float:
        return max(
            float(np.linalg.norm(a[name] - b[name]) / np.linalg.norm(b[name]))
            for a, b in zip(found, exact, strict=True)
        )

    gap = max(abs(a["gap"] - b["gap"]) for a, b in zip(found, exact, strict=True)) / mean_edge
    return {"force error": largest("force"), "motion error": largest("moved"), "gap error": gap}


def compare(path: str, options: argparse.Namespace) -> dict[str, Any]:
    thrown = options.run is None
    simulations = {
        solver: plica.build_simulation(scene_of(path, solver, thrown=thrown)) for solver in options.solvers
    }
    mean_edge = mean_interface_edge(plica.build_mesh(plica.Scene.load(path).mesh))
    exact = plica.build_simulation(scene_of(path, "condensed", thrown=thrown, tolerance=1e-13))
    if not thrown:
        held = checkpoint.newest(options.run)
        if held is None:
            raise RuntimeError(f"{options.run}: no checkpoint; make a run of {path} there.")
        exact.restore(held.state)
    free, states = collision(exact, options.steps, SEARCHED if thrown else 1000)
    reference = round_of(exact, states)

    rounds: dict[str, list[list[dict[str, Any]]]] = {solver: [] for solver in options.solvers}
    free_rounds: list[float] = []
    failed: dict[str, str] = {}
    for k in range(1 + options.blocks):
        free_rounds.append(mean([one_step(simulations["condensed"], free) for _ in states], "total"))
        for solver in options.solvers if k % 2 == 0 else reversed(options.solvers):
            if solver in failed:
                continue
            try:
                rounds[solver].append(round_of(simulations[solver], states))
            except plica.SolveFailed as error:
                failed[solver] = str(error)

    def totals(solver: str) -> np.ndarray[Any, Any]:
        return np.array([mean(steps, "total") for steps in rounds[solver]])

    free_totals = np.array(free_rounds)
    table = []
    for solver in (solver for solver in options.solvers if solver not in failed):
        times, last = totals(solver)[1:], rounds[solver][-1]
        slowest = totals("gmres")[1:] if "gmres" in rounds and "gmres" not in failed else np.nan * times
        table.append(
            {
                "solver": solver,
                "ms": 1e3 * float(np.median(times)),
                "spread": float(np.ptp(times) / np.median(times)),
                "over free": float(np.median(times / free_totals[1:])),
                "gmres over": float(np.median(slowest / times)),
                "first": 1e3 * float(totals(solver)[0]),
                **{
                    part: 1e3 * float(np.median([mean(steps, part) for steps in rounds[solver][1:]]))
                    for part in PARTS
                },
                "rows": mean(last, "rows"),
                "passes": mean(last, "passes"),
                "CG": mean(last, "iterations"),
                **errors(last, reference, mean_edge),
            }
        )
    info = simulations["condensed"].info()
    return {
        "scene": Path(path).name,
        "unknowns": info["unknowns"],
        "order": info["order"],
        "steps": len(states),
        "auto": plica.build_simulation(scene_of(path, "auto", thrown=thrown)).info()["contact_solver"],
        "free": 1e3 * float(np.median(free_totals[1:])),
        "table": table,
        "failed": failed,
    }


def show(result: dict[str, Any]) -> None:
    print(
        f"\n## {result['scene']}\n\n{result['unknowns']} unknowns, order {result['order']}; "
        f"{result['steps']} colliding steps; a free step {result['free']:.1f} ms; "
        f'"auto" is {result["auto"]}.\n'
    )
    print(
        "| solver | ms/step | spread | of a free step | gmres / it | first | solve | contact | detection "
        "| rows | passes | CG | force error | motion error | gap error |"
    )
    print("|" + " --- |" * 15)
    for row in result["table"]:
        print(
            f"| {row['solver']} | {row['ms']:.1f} | {100 * row['spread']:.0f} % | {row['over free']:.2f} "
            f"| {row['gmres over']:.1f} | {row['first']:.0f} | "
            + " | ".join(f"{row[part]:.1f}" for part in PARTS)
            + f" | {row['rows']:.1f} | {row['passes']:.1f} | {row['CG']:.0f} | {row['force error']:.0e} "
            f"| {row['motion error']:.0e} | {row['gap error']:.0e} |"
        )
    for solver, reason in result["failed"].items():
        print(f"\n{solver}: failed. {reason}")
    by_name = {row["solver"]: row for row in result["table"]}
    if {"condensed", "saddle"} <= by_name.keys():
        columns = (by_name["condensed"]["first"] - by_name["condensed"]["ms"]) * result["steps"]
        saved = by_name["saddle"]["ms"] - by_name["condensed"]["ms"]
        paid = f"{1e-3 * columns:.1f} s; break-even after {columns / saved:.0f} steps"
        print(f"\nColumns of this collision: {paid}.")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "scenes", nargs="*", default=["examples/thesis_b.toml", "examples/normal_phonation.toml"]
    )
    parser.add_argument("--run", type=Path, help="folder of a run of the one scene, for its checkpoint")
    parser.add_argument("--solvers", nargs="+", choices=SOLVERS, default=SOLVERS)
    parser.add_argument("--blocks", type=int, default=5, help="rounds in which all solvers take turns")
    parser.add_argument("--steps", type=int, default=4, help="colliding steps of a round")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--csv", type=Path, default=Path("contact_paths.csv"))
    options = parser.parse_args()
    if options.run and len(options.scenes) != 1:
        parser.error("--run goes with one scene, that of the run")
    plica.set_threads(options.threads)
    with options.csv.open("w", newline="") as file:
        writer = None
        for scene in options.scenes:
            result = compare(scene, options)
            show(result)
            for row in result["table"]:
                entry = {key: result[key] for key in ("scene", "unknowns", "order", "steps", "free")} | row
                if writer is None:
                    writer = csv.DictWriter(file, list(entry))
                    writer.writeheader()
                writer.writerow(entry)
            file.flush()


if __name__ == "__main__":
    main()
