"""The impact of two cylinders (cylinders.py) on three meshes by three steps: total force, its convergence.

    python -m benchmarks.thesis.cylinder_convergence

Makes two records and draws docs/images/cylinders.png. With the combination that `python -m benchmarks impact`
recommends, and as the thesis does it: HHT(-0.3) and contact nodes that have mass.
"""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from benchmarks.harness.study import record, script_parser
from benchmarks.thesis import cylinders
from plica import _engine as engine
from plica.report.drawing import blue, green, grey, red, style
from plica.verify.bodies.body import SCHEMES

ACROSS = (4, 8, 16)  # elements
STEPS = (40e-6, 20e-6, 10e-6)  # s
WAYS = {"recommended": ("trapezoidal", "redistributed"), "thesis": ("HHT(-0.3)", "kept")}
NAMES = (
    *("peak (MN)", "peak of 0.3 ms means (MN)", "peak of 1 ms means (MN)", "impulse, of twice the momentum"),
    *("first to last touch (ms)", "duration (ms)"),
)
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
        values = (
            self.right.max() * 1e-6,
            self.highest_mean(0.3e-3),
            self.highest_mean(1e-3),
            total * self.step / cylinders.momentum(),
            (touching[-1] - touching[0] + 1) * self.step * 1e3,
            # that of a constant force with the same impulse and the same integral of its square
            total**2 / (self.right**2).sum() * self.step * 1e3,
        )
        return dict(zip(NAMES, values, strict=True))


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
    parser = script_parser(__doc__)
    parser.add_argument("--runs", type=Path, default=Path("runs/thesis"), help="where computations are kept")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    options = parser.parse_args()
    found: dict[tuple[str, int, float], History] = {}
    head = ["as", "elements across", "step (us)", "unknowns", *NAMES, "left - right, of the peak"]
    record("cylinders", [*head, "energy max", "energy end"], rows(options.runs, found))
    record("cylinders_order", ["as", "order in", *NAMES], orders(found))
    draw(found, options.picture)


def rows(runs: Path, found: dict[tuple[str, int, float], History]) -> Iterator[list[object]]:
    """A row for each level, whose history is put into `found`."""
    for way, across, step in itertools.product(WAYS, ACROSS, STEPS):
        one = found[way, across, step] = stored(across, step, *WAYS[way], runs)
        apart = np.abs(one.left - one.right).max() / one.right.max()
        cells = [f"{value:.4g}" for value in one.quantities().values()]
        energy = [f"{value:.3f}" for value in (one.energy.max(), one.energy[-1])]
        yield [way, across, f"{1e6 * step:.0f}", one.unknowns, *cells, f"{apart:.0e}", *energy]


def orders(found: dict[tuple[str, int, float], History]) -> Iterator[list[str]]:
    """Of each quantity, in the edge and in the step."""
    values = {level: one.quantities() for level, one in found.items()}
    for way in WAYS:
        for name, levels in (
            (f"the edge, at {1e6 * STEPS[-1]:.0f} us", [(way, across, STEPS[-1]) for across in ACROSS]),
            (f"the step, {ACROSS[-1]} across", [(way, ACROSS[-1], step) for step in STEPS]),
        ):
            yield [way, name, *(order([values[level][what] for level in levels]) for what in NAMES)]


if __name__ == "__main__":
    main()
