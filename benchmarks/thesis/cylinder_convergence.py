"""The impact of two cylinders (cylinders.py) on three meshes by three steps: total force, its convergence.

    python benchmarks/thesis/cylinder_convergence.py

Prints Markdown tables and draws docs/images/cylinders.png. With the combination that `plica bench impact`
recommends, and as the thesis does it: HHT(-0.3) and contact nodes that have mass.
"""

from __future__ import annotations

import argparse
import io
import itertools
from dataclasses import dataclass
from pathlib import Path

import cylinders
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from plica import _engine as engine
from plica.bench.body import SCHEMES
from plica.report.drawing import blue, green, grey, red, style

ACROSS = (4, 8, 16)  # elements
STEPS = (40e-6, 20e-6, 10e-6)  # s
WAYS = {"recommended": ("trapezoidal", "redistributed"), "thesis": ("HHT(-0.3)", "kept")}
PICTURE = Path(__file__).resolve().parents[2] / "docs" / "images" / "cylinders.png"


@dataclass(frozen=True)
class History:
    """Total force of one computation, and its energy."""

    step: float  # s
    unknowns: int
    time: np.ndarray  # s
    left: np.ndarray  # N, along x
    right: np.ndarray
    energy: np.ndarray  # of that at the start

    def highest_mean(self, over: float) -> float:
        """MN, of all means over that time (s)."""
        count = round(over / self.step)
        return float(np.convolve(self.right, np.ones(count) / count, "same").max() * 1e-6)

    def quantities(self) -> dict[str, float]:
        touching, total = np.flatnonzero(self.right > 0), self.right.sum()
        return {
            "peak (MN)": self.right.max() * 1e-6,
            "peak of 0.3 ms means (MN)": self.highest_mean(0.3e-3),
            "peak of 1 ms means (MN)": self.highest_mean(1e-3),
            "impulse, of twice the momentum": total * self.step / cylinders.momentum(),
            "first to last touch (ms)": (touching[-1] - touching[0] + 1) * self.step * 1e3,
            # that of a constant force with the same impulse and the same integral of its square
            "duration (ms)": total**2 / (self.right**2).sum() * self.step * 1e3,
        }


def history(across: int, step: float, scheme: str, mass: str) -> History:
    # few steps for so many nodes that touch: columns of the inverse would not pay
    contact = engine.Multipliers(solver="saddle")
    pair = cylinders.pair(across, step, SCHEMES[scheme], mass, contact)
    waves = pair.simulation.advance(round(cylinders.DURATION / step))
    return History(
        step,
        pair.mesh.points.size,
        waves["time"],
        -waves["contact_force_first"][:, 0],
        waves["contact_force_second"][:, 0],
        (waves["kinetic_energy"] + waves["elastic_energy"]) / pair.simulation.state()["initial"],
    )


def stored(across: int, step: float, scheme: str, mass: str, runs: Path) -> History:
    """That history, computed unless `runs` has it."""
    path = runs / f"cylinders_{across}_{1e6 * step:g}us_{scheme}_{mass}.npz"
    if path.exists():
        with np.load(path) as kept:
            return History(**{name: kept[name][()] for name in kept.files})
    made = history(across, step, scheme, mass)
    runs.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, **vars(made))
    return made


def order(values: list[float]) -> str:
    """From three levels, each half the one before; none where the differences do not fall alike."""
    first, second = values[0] - values[1], values[1] - values[2]
    return f"{np.log2(first / second):.2f}" if first * second > 0 else "-"


def draw(found: dict[tuple[str, int, float], History], path: Path) -> None:
    with mpl.rc_context({**style, "figure.facecolor": "white", "axes.facecolor": "white", "font.size": 8.5}):
        figure = Figure(figsize=(7.4, 2.8), layout="constrained")
        both, meshes = figure.subplots(1, 2, sharey=True)
        last = found["recommended", ACROSS[-1], STEPS[-1]]
        both.plot(1e3 * last.time, 1e-6 * last.left, color=blue, label="on the left one")
        both.plot(1e3 * last.time, 1e-6 * last.right, ":", color=red, label="on the right one")
        for across, colour in zip(ACROSS, (green, red, blue), strict=True):
            one = found["recommended", across, STEPS[-1]]
            meshes.plot(1e3 * one.time, 1e-6 * one.right, color=colour, lw=0.9, label=f"{across} across")
        for axes in (both, meshes):
            axes.axhline(1e-6 * np.pi * cylinders.RADIUS**2 * cylinders.bar_pressure(), color=grey, lw=0.6)
            axes.set_xlabel("time (ms)")
            axes.legend(loc="lower center", fontsize=7)
        both.set_ylabel("force (MN)")
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=110)
    Image.open(buffer).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=Path, default=Path("runs/thesis"), help="where computations are kept")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    options = parser.parse_args()
    found: dict[tuple[str, int, float], History] = {}
    quantities: dict[tuple[str, int, float], dict[str, float]] = {}
    for level in itertools.product(WAYS, ACROSS, STEPS):
        way, across, step = level
        one = found[level] = stored(across, step, *WAYS[way], options.runs)
        if not quantities:
            names = list(one.quantities())
            head = ["as", "elements across", "step (us)", "unknowns", *names, "left - right, of the peak"]
            print(
                "| " + " | ".join([*head, "energy max", "energy end"]) + " |\n|" + " --- |" * (len(head) + 2)
            )
        quantities[level] = one.quantities()
        cells = " | ".join(f"{value:.4g}" for value in quantities[level].values())
        apart = np.abs(one.left - one.right).max() / one.right.max()
        print(
            f"| {way} | {across} | {1e6 * step:.0f} | {one.unknowns} | {cells} | {apart:.0e} | "
            f"{one.energy.max():.3f} | {one.energy[-1]:.3f} |",
            flush=True,
        )
    print("\n| as | order in | " + " | ".join(names) + " |\n|" + " --- |" * (2 + len(names)))
    for way in WAYS:
        for name, levels in (
            (f"the edge, at {1e6 * STEPS[-1]:.0f} us", [(way, across, STEPS[-1]) for across in ACROSS]),
            (f"the step, {ACROSS[-1]} across", [(way, ACROSS[-1], step) for step in STEPS]),
        ):
            cells = " | ".join(order([quantities[level][name] for level in levels]) for name in names)
            print(f"| {way} | {name} | {cells} |")
    draw(found, options.picture)


if __name__ == "__main__":
    main()
