"""What a step costs, by part, by contact solver and by coupling; what an absent part saves; peak memory.

For each scene file the folds, the whole of them, are thrown at each other (an opening pattern of negative
size), so that a few free steps and a collision lie within two milliseconds. Every case repeats the same
steps from the same two states: the one so many steps before the first contact, and the one before the steps
with the most contact rows. All cases take turns in one process, one block of steps each. The first round
stands apart ("first"): in it the solvers compute the columns of the compliance that the later ones find in
their cache, as a run does in its first collision. Other figures are medians over the later rounds; a ratio
is the median of the ratios to the first case within a round, the spread the range over the median. Peak
memory is that of a process of its own per case, over what it holds before it builds the scene. The error is
that of the displacements' change over the block against the same case with solves at 1e-12.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show

# The process that starts the others must stay small: on Linux a child's peak begins with its parent's.
if TYPE_CHECKING:
    import plica

CONTACTS: dict[str, dict[str, Any]] = {
    "condensed": {"multipliers": {"solver": "condensed"}},
    "gmres": {"multipliers": {"solver": "gmres"}},
    "penalty": {"penalty": {"stiffness": 100.0}},
    "volume penalty": {"volume_penalty": {"kappa": 1e8}},
}
COUPLINGS = ("iterated", "lagged")
CASES = [f"{contact}, {coupling}" for coupling in COUPLINGS for contact in CONTACTS]
ABSENT = ["no contact, iterated", "condensed, no airflow", "no contact, no airflow"]
PARTS = ("residual", "load", "solve", "detection", "contact", "energies", "record")
CLOSING = -0.7  # m/s
SEARCHED = 40  # steps, for the ones with the most contact rows
SETTLED = 4  # steps after which a start has the past that its solves begin from


def scene_of(path: str, case: str, **solver: float) -> plica.Scene:
    """The scene of the file with the contact and the coupling of the case, and the folds closing."""
    import plica

    data = plica.Scene.load(path).resolved()
    data.pop("symmetry", None)
    contact, coupling = case.split(", ")
    if contact == "no contact":
        del data["contact"]
    else:
        position = data["contact"].get("multipliers", {}).get("position", "end_of_step")
        kept = {key: value for key, value in data["contact"].items() if key not in plica.Contact.kinds}
        data["contact"] = kept | json.loads(json.dumps(CONTACTS[contact]))
        if "multipliers" in data["contact"]:
            data["contact"]["multipliers"]["position"] = position
    if coupling == "no airflow":
        del data["airflow"]
    else:
        data["airflow"]["coupling"] = coupling
    data["initial"] = {"opening_velocity": CLOSING}
    data["solver"] = data.get("solver", {}) | solver
    data["output"] = {"every": data["time"]["step"]}
    return plica.Scene.model_validate(data)


def peak_bytes() -> int:
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def memory(path: str, case: str, steps: int) -> dict[str, float]:
    """Peak memory (bytes) of building the scene and so many steps, over that of the imported package."""
    import plica

    before = peak_bytes()
    simulation = plica.build_simulation(scene_of(path, case))
    built = peak_bytes()
    # what a case that fails has needed until then is its peak, too
    with contextlib.suppress(plica.SolveFailed):
        simulation.advance(steps)
    return {"before": before, "built": built - before, "peak": peak_bytes() - before}


def timed(simulation: Any, state: dict[str, Any], steps: int) -> tuple[dict[str, float], dict[str, Any]]:
    """Seconds a step by part, and the waveforms."""
    simulation.restore(state)
    before = simulation.times()
    start = time.perf_counter()
    waveforms = simulation.advance(steps)
    total = time.perf_counter() - start
    after = simulation.times()
    parts = {part: (after[part] - before[part]) / steps for part in PARTS}
    return parts | {"total": total / steps}, waveforms


def moved(simulation: Any, state: dict[str, Any]) -> Any:
    """Change of the displacements since the state, (3 n,) m."""
    import numpy as np

    return np.asarray(simulation.displacement).ravel() - np.asarray(state["displacement"]).ravel()


def compare(path: str, options: argparse.Namespace) -> dict[str, Any]:
    """All cases of a scene in turn."""
    import numpy as np

    import plica
    from benchmarks.voice.measures import mean_interface_edge

    plica.set_threads(options.threads)
    first = CASES[0]
    simulations = {case: plica.build_simulation(scene_of(path, case)) for case in (*CASES, *ABSENT)}
    leader = simulations[first]
    passed, rows = [leader.state()], []
    while leader.step_count < SEARCHED:
        rows.append(int(leader.advance(1)["contact_rows"][-1]))
        passed.append(leader.state())
    blocks = np.lib.stride_tricks.sliding_window_view(rows, options.steps)
    colliding = int(np.argmax(blocks.min(axis=1) * 1000 + blocks.sum(axis=1)))
    if blocks[colliding].min() == 0:
        raise RuntimeError(f"{path}: the folds are not in contact for {options.steps} of {SEARCHED} steps")
    free = int(np.flatnonzero(rows)[0]) - options.steps
    if free < SETTLED:
        raise RuntimeError(f"{path}: the folds touch after {free} steps; must be {SETTLED} or more")
    # a state belongs to a scene with the same parts: what lacks one comes there by its own steps
    states: dict[str, dict[str, Any]] = {"free": dict.fromkeys(CASES, passed[free])}
    states["colliding"] = dict.fromkeys(CASES, passed[colliding])
    for case in ABSENT:
        simulations[case].advance(free)
        states["free"][case] = simulations[case].state()
    without_airflow = ABSENT[1]
    simulations[without_airflow].advance(colliding - free)
    states["colliding"][without_airflow] = simulations[without_airflow].state()

    table: list[dict[str, Any]] = []
    mean_edge = mean_interface_edge(plica.build_mesh(scene_of(path, first).mesh))
    failures: dict[str, str] = {}
    for phase, cases in (("free", (*CASES, *ABSENT)), ("colliding", (*CASES, without_airflow))):
        rounds: dict[str, list[dict[str, float]]] = {case: [] for case in cases}
        waveforms: dict[str, dict[str, Any]] = {}
        changes: dict[str, Any] = {}
        failed: dict[str, str] = {}
        for _ in range(1 + options.blocks):
            for case in cases:
                if case in failed:
                    continue
                try:
                    seconds, waveforms[case] = timed(simulations[case], states[phase][case], options.steps)
                except plica.SolveFailed as error:
                    failed[case] = str(error)
                    continue
                rounds[case].append(seconds)
                changes[case] = moved(simulations[case], states[phase][case])
        failures |= {f"{case}, {phase}": reason for case, reason in failed.items()}
        for case in cases:
            if case in failed:
                continue
            exact = plica.build_simulation(scene_of(path, case, tolerance=1e-12))
            timed(exact, states[phase][case], options.steps)
            change = moved(exact, states[phase][case])
            error = np.linalg.norm(changes[case] - change) / np.linalg.norm(change)
            totals, reference = (
                np.array([entry["total"] for entry in rounds[name][1:]]) for name in (case, first)
            )
            found = waveforms[case]
            sweeps = np.mean(found["coupling_sweeps"]) if "coupling_sweeps" in found else 1.0
            medians = {
                part: 1e3 * float(np.median([entry[part] for entry in rounds[case][1:]])) for part in PARTS
            }
            table.append(
                {
                    "case": case,
                    "steps": phase,
                    "ms": 1e3 * float(np.median(totals)),
                    "spread": float((totals.max() - totals.min()) / np.median(totals)),
                    "ratio": float(np.median(totals / reference)),
                    "first": 1e3 * rounds[case][0]["total"],
                    **medians,
                    "sweeps": float(sweeps),
                    "iterations": float(np.mean(found["iterations"])),
                    "rows": float(np.mean(found.get("contact_rows", 0))),
                    "gap": float(np.min(found.get("deepest_gap", 0)) / mean_edge),
                    "error": float(error),
                }
            )
    return {
        "scene": Path(path).name,
        "info": {
            name: value for name, value in leader.info().items() if isinstance(value, (int, float, str))
        },
        "table": table,
        "failures": failures,
        "set_up": _set_up(path, first, options),
        "output": _output(path, first, options),
        "reached": colliding,
        "block": options.steps,
    }


def _set_up(path: str, case: str, options: argparse.Namespace) -> dict[str, float]:
    """Seconds: mesh, pattern, each matrix (with its copy to compressed rows), the whole simulation."""
    import numpy as np

    import plica
    from plica import _engine
    from plica.runs.materials import materials_of

    scene = scene_of(path, case)
    taken: dict[str, list[float]] = {}
    for _ in range(options.blocks):
        made: dict[str, Any] = {}
        for name, work in {
            "mesh": lambda: plica.build_mesh(scene.mesh),
            "pattern": lambda made=made: _engine.Assembly(made["mesh"], *materials_of(scene, made["mesh"])),
            "mass": lambda made=made: made["pattern"].mass(),
            "stiffness": lambda made=made: made["pattern"].stiffness(),
            "viscosity": lambda made=made: made["pattern"].viscosity(),
            "simulation": lambda made=made: plica.build_simulation(scene, made["mesh"]),
        }.items():
            start = time.perf_counter()
            made[name] = work()
            taken.setdefault(name, []).append(time.perf_counter() - start)
    return {name: float(np.median(values)) for name, values in taken.items()}


def _output(path: str, case: str, options: argparse.Namespace) -> dict[str, float]:
    """Seconds to store the waveforms of a block of steps, the fields of one frame, and a checkpoint."""
    import numpy as np

    import plica
    from plica.runs import checkpoint
    from plica.runs.store import ResultFile

    scene = scene_of(path, case)
    mesh = plica.build_mesh(scene.mesh)
    simulation = plica.build_simulation(scene, mesh)
    taken: dict[str, list[float]] = {"steps": [], "frame": [], "checkpoint": []}
    with tempfile.TemporaryDirectory() as folder:
        sample = simulation.advance(options.steps)
        with ResultFile.create(Path(folder) / "results.h5", scene, simulation, mesh) as results:
            for k in range(options.blocks):
                start = time.perf_counter()
                results.write_steps(k * options.steps, sample)
                results.commit(k * options.steps, 0, 0.0)
                stored = time.perf_counter()
                results.write_frame(k, simulation)
                framed = time.perf_counter()
                held = checkpoint.Checkpoint(k, "", simulation.state(), {})
                checkpoint.write(Path(folder), held, checkpoint.SLOTS[k % 2])
                taken["steps"].append(stored - start)
                taken["frame"].append(framed - stored)
                taken["checkpoint"].append(time.perf_counter() - framed)
    return {name: float(np.median(values)) for name, values in taken.items()}


def show_scene(result: dict[str, Any], peaks: dict[str, dict[str, float]]) -> None:
    """The Markdown tables of a scene."""
    info, output = result["info"], result["output"]
    print(f"\n## {result['scene']}\n")
    print(
        f"{info['cells']} tetrahedra of order {info['order']}, {info['nodes']} nodes, "
        f"{info['unknowns']} unknowns, {1e-6 * info['matrix_bytes']:.1f} MB of A."
    )
    made = ", ".join(f"{name} {1e3 * seconds:.0f}" for name, seconds in result["set_up"].items())
    print(f"\nSet-up (ms): {made}.")
    stored = {name: 1e3 * seconds for name, seconds in output.items()}
    print(
        f"\nOutput (ms): waveforms of {result['block']} steps {stored['steps']:.2f}, "
        f"a frame {stored['frame']:.2f}, a checkpoint {stored['checkpoint']:.1f}."
    )
    for phase in ("free", "colliding"):
        print()
        columns = [f"{phase} steps", "ms/step", "spread", "ratio", "first", *PARTS, "sweeps", "iterations"]
        rows = [_cells(row, peaks) for row in result["table"] if row["steps"] == phase]
        show([*columns, "rows", "deepest gap/edge", "error", "peak MB"], rows)
    for case, reason in result["failures"].items():
        print(f"\n{case}: failed. {reason}", flush=True)


def _cells(row: dict[str, Any], peaks: dict[str, dict[str, Any]]) -> list[str]:
    return [
        row["case"],
        f"{row['ms']:.1f}",
        f"{100 * row['spread']:.0f} %",
        f"{row['ratio']:.2f}",
        f"{row['first']:.0f}",
        *(f"{row[part]:.1f}" for part in (*PARTS, "sweeps", "iterations")),
        f"{row['rows']:.0f}",
        f"{row['gap']:.0e}",
        f"{row['error']:.0e}",
        f"{1e-6 * peaks[row['case']]['peak']:.0f}",
    ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument(
        "scenes", nargs="*", default=["examples/thesis.toml", "examples/normal_phonation.toml"]
    )
    parser.add_argument("--blocks", type=int, default=5, help="rounds in which all cases take turns")
    parser.add_argument("--steps", type=int, default=3, help="of a block")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--csv", type=Path, default=Path("step_cost.csv"))
    parser.add_argument("--case", help=argparse.SUPPRESS)  # in a child: the memory of this case
    parser.add_argument("--compare", action="store_true", help=argparse.SUPPRESS)  # in a child: the times
    options = parser.parse_args()
    if options.compare:
        print(json.dumps(compare(options.scenes[0], options)))
        return
    if options.case:
        print(json.dumps(memory(options.scenes[0], options.case, options.steps)))
        return

    def child(scene: str, *arguments: str) -> dict[str, Any]:
        command = [sys.executable, "-m", "benchmarks.dynamics.step_cost", scene]
        command += ["--threads", str(options.threads), *arguments]
        found: dict[str, Any] = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
        return found

    with options.csv.open("w", newline="") as file:
        writer = None
        for scene in options.scenes:
            blocks = ("--blocks", str(options.blocks), "--steps", str(options.steps))
            result = child(scene, "--compare", *blocks)
            last = str(result["reached"] + options.steps)
            peaks = {case: child(scene, "--case", case, "--steps", last) for case in (*CASES, *ABSENT)}
            show_scene(result, peaks)
            for row in result["table"]:
                entry = {"scene": result["scene"], **row, **peaks[row["case"]]}
                if writer is None:
                    writer = csv.DictWriter(file, list(entry))
                    writer.writeheader()
                writer.writerow(entry)
            file.flush()


if __name__ == "__main__":
    main()
