"""Runs of a larynx side by side, beside the published figures; differences between steps and between meshes.

    python benchmarks/phonation.py runs/base runs/half_step runs/finer_mesh
    python benchmarks/phonation.py --scene examples/normal_phonation.toml -o runs/study \\
        --step "25 us" --mesh '{"around": 24, "body_rings": 3}'

The second form makes the runs first: the scene itself, then one for each other step and each other mesh
(mesh options as JSON, or the name of a preset); one that is there is continued or taken as it is. Runs
whose scenes differ in the step, the mesh or the number of the airflow's sections alone are compared; with
three levels the observed order follows, and the value extrapolated with it where the three are monotone.
The level of a mesh is unknowns^(-1/3). Spreads are standard deviations between cycles. A change is within a
limit, or misses it, only where twice its standard error does not reach across the limit; else it is
undecided. Successive cycles are not independent (those of a period-doubled orbit alternate), so the
standard error of a mean is that of the means of blocks of four cycles. Runs that ended at different times
are cut to the shortest one's with --common, so that the same stretch of each is measured; --from leaves out
the start.
"""

from __future__ import annotations

import argparse
import copy
import json
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import plica
from plica import _engine as engine
from plica.measures.cycles import Cycles
from plica.phonation.measures.measure import measure, steady_cycles
from plica.phonation.run.build import fixed_components
from plica.uncertainty.convergence import Level, observed_order

# Quantity: measure, factor, unit, digits; published; prototype as printed (P), with half the viscosity (B).
QUANTITIES: dict[str, tuple[str, float, str, int, str, str, str]] = {
    "fundamental frequency": ("fundamental_frequency", 1.0, "Hz", 2, "219", "284-290", "280-286"),
    "open quotient": ("open_quotient", 1.0, "", 4, "", "", ""),
    "open quotient (1 %)": ("open_quotient_1_percent", 1.0, "", 4, "0.87", "0.86-0.89", "0.75-0.77"),
    "peak flow": ("peak_flow", 1e6, "cm3/s", 1, "500-600", "507-511", "594-601"),
    "contact length fraction": ("contact_length_fraction", 1.0, "", 3, "0.40", "0.28-0.33", "0.57-0.61"),
    "impulse per collision": ("contact_impulse", 1e6, "uN s", 3, "", "", ""),
    "collision duration": ("contact_duration", 1e3, "ms", 3, "", "", ""),
    "mean contact force": ("contact_force_left_mean", 1e3, "mN", 2, "", "", ""),
    "peak strain": ("peak_strain", 1.0, "", 3, "", "", ""),
    "peak contact pressure": ("peak_contact_pressure", 1e-3, "kPa", 3, "1.17", "0.7-1.0", "1.2-1.5"),
    "converging while opening": ("converging_while_opening", 1.0, "", 2, "yes", "", ""),
    "diverging while closing": ("diverging_while_closing", 1.0, "", 2, "yes", "", ""),
}
# Quantity: largest change between two levels, relative or not.
LIMITS: dict[str, tuple[float, bool]] = {
    "fundamental frequency": (0.01, True),
    "open quotient": (0.01, False),
    "peak flow": (0.02, True),
    "impulse per collision": (0.05, True),
}


@dataclass(frozen=True)
class Case:
    """A run and what is looked at."""

    name: str
    run: plica.Run
    measures: dict[str, Any]
    unknowns: int
    mean_edge: float  # m, of the interface
    measured: float  # s, end of what was measured
    blocks: list[dict[str, Any]]  # measures of every four of the cycles

    def value(self, quantity: str) -> float | None:
        """In the quantity's unit; None where the run does not determine it."""
        key, factor, *_ = QUANTITIES[quantity]
        found = self.measures.get(key, {}).get("value")
        return None if found is None else factor * found

    def error(self, quantity: str) -> float:
        """Standard error of the mean, in the quantity's unit; infinite where nothing was averaged."""
        key, factor, *_ = QUANTITIES[quantity]
        means = [block[key].value for block in self.blocks if block[key].value is not None]
        return np.inf if len(means) < 3 else factor * float(np.std(means, ddof=1)) / np.sqrt(len(means))

    def text(self, quantity: str) -> str:
        value = self.value(quantity)
        if value is None:
            return "-"
        key, factor, _, digits, *_ = QUANTITIES[quantity]
        spread = self.measures[key]["spread"]
        return f"{value:.{digits}f}" + ("" if spread is None else f" +- {factor * spread:.{digits}f}")


def mean_interface_edge(mesh: Any) -> float:
    """Mean edge (m) of the surface named airway, six-node faces as four flat triangles."""
    corners = np.asarray(engine.flat_triangles(mesh.surfaces["airway"]))
    sides = np.concatenate((corners[:, :2], corners[:, 1:], corners[:, ::2]))
    ends = np.asarray(mesh.points)[np.unique(np.sort(sides, axis=1), axis=0)]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())


class Cut:
    """A run between two times (s) as one that begins at the first: what is measured of it."""

    def __init__(self, run: plica.Run, start: float, until: float) -> None:
        self._run = run
        first, last = np.searchsorted(run.time, [start, until * (1 + 1e-9)], side="right")
        self.time = run.time[first:last] - start
        self.waveforms = {name: values[first:last] for name, values in run.waveforms.items()}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._run, name)


def load(name: str, run: plica.Run, start: float, until: float) -> Case:
    free = ~fixed_components(run.scene, run.mesh)
    cut = Cut(run, start, until)
    measures = {key: item.as_json() for key, item in measure(cut).items()}
    edge = mean_interface_edge(run.mesh)
    starts = steady_cycles(cut).starts
    blocks = [measure(cut, Cycles(starts[k : k + 5])) for k in range(0, starts.size - 4, 4)]
    return Case(name, run, measures, int(free.sum()), edge, start + float(cut.time[-1]), blocks)


def make(options: argparse.Namespace) -> list[tuple[str, Path]]:
    """The runs of a scene, at its own step and mesh and at the others asked for."""
    base = plica.Scene.load(options.scene).resolved()
    base["output"] = {key: value for key, value in base.get("output", {}).items() if key == "every"}
    variants = {"base": base}
    for step in options.step:
        scene = copy.deepcopy(base)
        scene["time"]["step"] = step
        variants[f"step {step}"] = scene
    for number, mesh in enumerate(options.mesh, start=1):
        scene = copy.deepcopy(base)
        if mesh.lstrip().startswith("{"):
            scene["mesh"]["options"] |= json.loads(mesh)
        else:
            scene["mesh"] = {"larynx": mesh, "order": base["mesh"]["order"]}
        variants[f"mesh {number}"] = scene
    made = []
    for name, data in variants.items():
        directory = options.output / name.replace(" ", "_")
        plica.run(plica.Scene.model_validate(data), directory, resume=directory.exists())
        made.append((name, directory))
    return made


def row(*cells: str) -> None:
    print("| " + " | ".join(cells) + " |")


def show_runs(cases: list[Case]) -> None:
    head = ["", *(case.name for case in cases), "published", "prototype P", "prototype B"]
    row(*head)
    row(*["---"] * len(head))
    blank = [""] * 3
    cells = [np.asarray(case.run.mesh.cells) for case in cases]
    orders = ["quadratic" if array.shape[1] == 10 else "linear" for array in cells]
    row("tetrahedra", *(f"{len(a)}, {order}" for a, order in zip(cells, orders, strict=True)), *blank)
    row("unknowns", *(str(case.unknowns) for case in cases), *blank)
    row("step (us)", *(f"{1e6 * case.run.scene.time.step:g}" for case in cases), "50", "50", "50")
    row("sections", *(str(sections(case)) for case in cases), *blank)
    row("measured until (ms)", *(f"{1e3 * case.measured:.1f}" for case in cases), *blank)
    row("state of the run", *(case.run.status for case in cases), *blank)
    frequencies = [case.measures.get("fundamental_frequency", {}) for case in cases]
    row("cycles", *(str(found.get("cycles", 0)) for found in frequencies), *blank)
    for quantity, (_, _, unit, _, *reference) in QUANTITIES.items():
        name = f"{quantity} ({unit})" if unit else quantity
        row(name, *(case.text(quantity) for case in cases), *reference)

    def plain(name: str, key: str, scale: Any = lambda case: 1.0, form: str = ".1e") -> None:
        found = [case.measures.get(key, {}).get("value") for case in cases]
        texts = [
            "-" if value is None else f"{value / scale(case):{form}}"
            for case, value in zip(cases, found, strict=True)
        ]
        row(name, *texts, *blank)

    plain("deepest gap / mean interface edge", "deepest_gap", lambda case: case.mean_edge)
    plain("largest multiplier (N)", "largest_multiplier")
    plain("force balance", "contact_force_balance")
    plain("ledger / largest energy", "ledger_error")
    plain("share of steps with a frozen coupling", "coupling_frozen_fraction")
    plain("inverted tissue cells", "inverted_tissue_max", form=".0f")
    row("wall time (s)", *(f"{case.run.seconds:.0f}" for case in cases), *blank)
    for case, found in zip(cases, frequencies, strict=True):
        if found.get("note"):
            print(f"\n{case.name}: {found['note']}.")
        if case.run.failure:
            print(f"\n{case.name} failed: {case.run.failure}")


KINDS = {"step": ("time", "step"), "mesh": ("mesh",), "sections": ("airflow", "area", "cut", "sections")}


def families(cases: list[Case], kind: str) -> Iterable[list[Case]]:
    """Runs whose scenes are equal but for one entry."""
    found: dict[str, list[Case]] = {}
    *tables, key = KINDS[kind]
    for case in cases:
        rest = copy.deepcopy(case.run.scene.resolved())
        rest.pop("output", None)
        rest["time"].pop("duration")
        table = rest
        for name in tables:
            table = table[name]
        table.pop(key)
        found.setdefault(json.dumps(rest, sort_keys=True), []).append(case)
    return [family for family in found.values() if len(family) > 1]


def level(case: Case, kind: str) -> float:
    if kind == "mesh":
        return case.unknowns ** (-1 / 3)
    return case.run.scene.time.step if kind == "step" else 1 / sections(case)


def sections(case: Case) -> int:
    return int(case.run.scene.airflow.area.cut.sections)


def verdict(change: float, doubt: float, limit: float | None) -> str:
    if limit is None:
        return ""
    if change + doubt <= limit:
        return " (within)"
    return " (missed)" if change - doubt > limit else " (undecided)"


def show_differences(family: list[Case], kind: str) -> None:
    family = sorted(family, key=lambda case: -level(case, kind))
    print(f"\nBy the {kind}, from {family[0].name} to {family[-1].name}:\n")
    if len({round(case.measured, 4) for case in family}) > 1:
        print("These runs are of different length: differences may be those of a transient.\n")
    pairs = list(pairwise(family))
    head = ["", *(f"{a.name} to {b.name}" for a, b in pairs), "limit", "order", "extrapolated"]
    row(*head)
    row(*["---"] * len(head))
    for quantity, (_, _, unit, digits, *_) in QUANTITIES.items():
        values = [case.value(quantity) for case in family]
        if any(value is None for value in values):
            continue
        limit, relative = LIMITS.get(quantity, (None, not quantity.startswith("open quotient")))
        known = [value for value in values if value is not None]
        cells = []
        for (first, second), (a, b) in zip(pairs, pairwise(known), strict=True):
            size = abs(a) if relative and a else 1.0
            change, doubt = (b - a) / size, 2 * np.hypot(first.error(quantity), second.error(quantity)) / size
            text = f"{100 * change:+.2f} % +- {100 * doubt:.2f}"
            if not (relative and a):
                text = f"{change:+.{digits}f} +- {doubt:.{digits}f}"
            cells.append(text + verdict(abs(change), doubt, limit))
        order, exact = "", ""
        if len(known) >= 3:
            h = [level(case, kind) for case in family[-3:]]
            p = observed_order(*map(Level, h, known[-3:]))
            order = "not monotone" if p is None else f"{p:.2f}"
            if p is not None and p > 0:
                rest = (known[-1] - known[-2]) * h[-1] ** p / (h[-2] ** p - h[-1] ** p)
                exact = f"{known[-1] + rest:.{digits}f} {unit}".strip()
        allowed = "" if limit is None else f"{100 * limit:g} %" if relative else f"{limit:g}"
        row(f"{quantity} ({unit})" if unit else quantity, *cells, allowed, order, exact)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="*", metavar="[NAME=]DIR", help="directories of runs")
    parser.add_argument("--scene", type=Path, help="make runs of this scene")
    parser.add_argument("-o", "--output", type=Path, help="where to make them")
    parser.add_argument("--step", action="append", default=[], help="another step, e.g. '25 us'")
    parser.add_argument("--mesh", action="append", default=[], help="other mesh options (JSON), or a preset")
    parser.add_argument("--common", action="store_true", help="cut all runs to the shortest one's time")
    parser.add_argument("--from", type=float, default=0.0, dest="start", help="s, where measuring starts")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    if (options.scene is None) != (options.output is None):
        parser.error("--scene and --output go together")
    plica.set_threads(options.threads)
    named: list[tuple[str, Path]] = []
    for argument in options.runs:
        name, _, directory = argument.rpartition("=")
        named.append((name or Path(directory).name, Path(directory)))
    if options.scene is not None:
        named += make(options)
    if not named:
        parser.error("name directories of runs, or a scene")
    runs = [(name, plica.Run.load(directory)) for name, directory in named]
    until = min(float(run.time[-1]) for _, run in runs) if options.common else np.inf
    cases = [load(name, run, options.start, until) for name, run in runs]
    show_runs(cases)
    for kind in KINDS:
        for family in families(cases, kind):
            show_differences(family, kind)


if __name__ == "__main__":
    main()
