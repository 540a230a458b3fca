"""Voices side by side: what is measured of the settled part of runs, and how it changes from run to run.

Spreads are standard deviations between cycles. Successive cycles are not independent (those of a
period-doubled orbit alternate), so the standard error of a mean is that of the means of blocks of four
cycles. A change is within a limit, or misses it, only where twice its standard error does not reach across
the limit; else it is undecided.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

import plica
from plica import _engine as engine
from plica.measures.cycles import Cycles
from plica.measures.run.measure import measure
from plica.runs.build import fixed_components
from plica.uncertainty.convergence import Level, observed_order


@dataclass(frozen=True)
class Quantity:
    """A measure as it is shown, the thesis's figure, and the largest change between two levels."""

    measure: str
    name: str
    unit: str = ""
    factor: float = 1.0
    digits: int = 2
    published: str = ""
    limit: float | None = None
    relative: bool = True  # changes in percent

    @property
    def head(self) -> str:
        return f"{self.name} ({self.unit})" if self.unit else self.name

    @property
    def allowed(self) -> str:
        if self.limit is None:
            return ""
        return f"{100 * self.limit:g} %" if self.relative else f"{self.limit:g}"


F0 = Quantity("fundamental_frequency", "fundamental frequency", "Hz", published="219", limit=0.01)
OPEN = Quantity("open_quotient", "open quotient", digits=4, limit=0.01, relative=False)
FLOW = Quantity("peak_flow", "peak flow", "cm3/s", 1e6, 1, "500-600", 0.02)
IMPULSE = Quantity("contact_impulse", "impulse per collision", "uN s", 1e6, 3, limit=0.05)
STRAIN = Quantity("peak_strain", "peak strain", digits=3)
QUANTITIES = (
    F0,
    OPEN,
    Quantity("open_quotient_1_percent", "open quotient (1 %)", digits=4, published="0.87", relative=False),
    FLOW,
    Quantity("contact_length_fraction", "contact length fraction", digits=3, published="0.40"),
    IMPULSE,
    Quantity("contact_duration", "collision duration", "ms", 1e3, 3),
    Quantity("contact_force_left_mean", "mean contact force", "mN", 1e3),
    STRAIN,
    Quantity("peak_contact_pressure", "peak contact pressure", "kPa", 1e-3, 3, "1.17"),
    Quantity("converging_while_opening", "converging while opening", published="yes"),
    Quantity("diverging_while_closing", "diverging while closing", published="yes"),
)


def mean_interface_edge(mesh: Any) -> float:
    """Mean edge (m) of the surface named airway, six-node faces as four flat triangles."""
    corners = np.asarray(engine.flat_triangles(mesh.surfaces["airway"]))
    sides = np.concatenate((corners[:, :2], corners[:, 1:], corners[:, ::2]))
    ends = np.asarray(mesh.points)[np.unique(np.sort(sides, axis=1), axis=0)]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())


class Voice:
    """What is measured of a run between two times (s)."""

    def __init__(self, name: str, run: plica.Run, start: float, until: float | None = None) -> None:
        part = run.between(start, until)
        starts = part.cycles.starts
        self.name, self.run, self.time, self.waveforms = name, run, part.time, part.waveforms
        self.measures = part.measures
        self.blocks = [measure(part, Cycles(starts[k : k + 5])) for k in range(0, starts.size - 4, 4)]
        self.unknowns = int((~fixed_components(run.scene, run.mesh)).sum())

    @property
    def sections(self) -> int:
        return int(self.run.scene.airflow.area.cut.sections)

    @property
    def remarks(self) -> str:
        """What is unusual about its cycles, and what stopped it."""
        found = self.measures["fundamental_frequency"].note if self.measures else "nothing was computed"
        return "; ".join(filter(None, (found, self.run.failure)))

    def plain(self, name: str) -> float | None:
        return self.measures[name].value if name in self.measures else None

    def value(self, quantity: Quantity) -> float | None:
        """In the quantity's unit; None where the run does not determine it."""
        found = self.plain(quantity.measure)
        return None if found is None else quantity.factor * found

    def error(self, quantity: Quantity) -> float:
        """Standard error of the mean, in the quantity's unit; infinite where there are too few cycles."""
        found = [block[quantity.measure].value for block in self.blocks if quantity.measure in block]
        means = [value for value in found if value is not None]
        if len(means) < 3:
            return np.inf
        return quantity.factor * float(np.std(means, ddof=1) / np.sqrt(len(means)))

    def text(self, quantity: Quantity) -> str:
        value = self.value(quantity)
        if value is None:
            return "-"
        spread = self.measures[quantity.measure].spread
        more = "" if spread is None else f" +- {quantity.factor * spread:.{quantity.digits}f}"
        return f"{value:.{quantity.digits}f}{more}"


def measured(voices: Sequence[Voice]) -> Iterator[list[str]]:
    """A row of each quantity, a column of each voice."""
    for quantity in QUANTITIES:
        yield [quantity.head, *(voice.text(quantity) for voice in voices)]


def side_by_side(voices: Sequence[Voice]) -> Iterator[list[str]]:
    """Meshes, steps and sections; the quantities; what the solvers say; the thesis's figures last."""

    def row(name: str, text: Callable[[Voice], str], published: str = "") -> list[str]:
        return [name, *map(text, voices), published]

    def plain(name: str, key: str, form: str = ".1e", scale: Callable[[Voice], float] = lambda _: 1.0) -> Any:
        def text(voice: Voice) -> str:
            value = voice.plain(key)
            return "-" if value is None else f"{value / scale(voice):{form}}"

        return row(name, text)

    yield row("tetrahedra", cells_of)
    yield row("unknowns", lambda voice: str(voice.unknowns))
    yield row("step (us)", lambda voice: f"{1e6 * voice.run.scene.time.step:g}", "50")
    if all(voice.run.scene.airflow.area.cut for voice in voices):
        yield row("sections", lambda voice: str(voice.sections))
    yield row("cycles", lambda voice: str(voice.measures["fundamental_frequency"].cycles))
    for quantity in QUANTITIES:
        yield row(quantity.head, lambda voice, of=quantity: voice.text(of), quantity.published)
    edge = {voice.name: mean_interface_edge(voice.run.mesh) for voice in voices}
    yield plain("deepest gap / mean interface edge", "deepest_gap", scale=lambda voice: edge[voice.name])
    yield plain("largest pull of a contact force (N)", "largest_multiplier")
    yield plain("force balance", "contact_force_balance")
    yield plain("energy balance error / largest energy", "energy_balance_error")
    yield plain("share of steps with held flow separation", "coupling_frozen_fraction")
    yield plain("inverted tissue cells", "inverted_tissue_max", ".0f")


def cells_of(voice: Voice) -> str:
    cells = np.asarray(voice.run.mesh.cells)
    return f"{len(cells)}, {'quadratic' if cells.shape[1] == 10 else 'linear'}"


def change_columns(voices: Sequence[Voice]) -> list[str]:
    pairs = [f"{a.name} to {b.name}" for a, b in pairwise(voices)]
    return ["", *pairs, "limit", "order", "extrapolated"]


def changes(voices: Sequence[Voice], level: Callable[[Voice], float]) -> Iterator[list[str]]:
    """From voice to voice, the finest last, of whose value percents are; the order of the last three."""
    for quantity in QUANTITIES:
        found = [voice.value(quantity) for voice in voices]
        values = [value for value in found if value is not None]
        if len(values) < len(voices):
            yield [quantity.head, *["-"] * (len(voices) - 1), quantity.allowed, "", ""]
            continue
        size = abs(values[-1]) if quantity.relative else 1.0
        cells = []
        for (first, second), (a, b) in zip(pairwise(voices), pairwise(values), strict=True):
            doubt = 2 * np.hypot(first.error(quantity), second.error(quantity)) / size
            cells.append(_change((b - a) / size, doubt, quantity))
        yield [quantity.head, *cells, quantity.allowed, *_limit(values, list(map(level, voices)), quantity)]


def _change(change: float, doubt: float, quantity: Quantity) -> str:
    if quantity.relative:
        text = f"{100 * change:+.2f} % +- {100 * doubt:.2f}"
    else:
        text = f"{change:+.{quantity.digits}f} +- {doubt:.{quantity.digits}f}"
    if quantity.limit is None:
        return text
    if abs(change) + doubt <= quantity.limit:
        return text + " (within)"
    return text + (" (missed)" if abs(change) - doubt > quantity.limit else " (undecided)")


def _limit(values: list[float], sizes: list[float], quantity: Quantity) -> tuple[str, str]:
    """The observed order, and what the values go to with it, by the last three."""
    if len(values) < 3:
        return "", ""
    p = observed_order(*map(Level, sizes[-3:], values[-3:]))
    if p is None:
        return "not monotone", ""
    if p <= 0:
        return f"{p:.2f}", ""
    rest = (values[-1] - values[-2]) * sizes[-1] ** p / (sizes[-2] ** p - sizes[-1] ** p)
    return f"{p:.2f}", f"{values[-1] + rest:.{quantity.digits}f} {quantity.unit}".strip()
