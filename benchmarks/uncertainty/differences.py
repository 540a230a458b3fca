"""How often the 95 % interval of a difference between two recordings (`plica compare`) holds the true change.

    python -m benchmarks.uncertainty.differences

Pairs of drawn waveforms: 40 cycles of 20 frames each, pulses sin^1.5 over 0.6 of the period on either side,
the right one 0.3 rad later. From cycle to cycle, independently: jitter 1 %, shimmer 2 %, the pulse's share
0.01, the phase 0.05 rad; a gap of 2 % that never closes, and noise of 1 % of the largest value in every
frame. Where nothing changes the truth is 0; where the jitter rises from 1 to 3 % it is the difference of the
means over other recordings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.measures.comparison import Change, changes
from plica.measures.measure import Measures
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures.waveforms import measures

CYCLES, FRAMES, FPS = 40, 20, 4000.0
BEGINS, WIDTH, PHASE = 0.15, 0.6, 0.3  # of the period, of the period, rad
SHIMMER, WIDTHS, PHASES, NOISE, GAP = 0.02, 0.01, 0.05, 0.01, 0.02
AREA, EDGE, LENGTH = 4e6, 600.0, 8000.0  # px^2 and px of a side, px: so fine that pixels add nothing
CHANGED = 0.03  # jitter, of 0.01


def drawn(seed: int, jitter: float) -> Measures:
    """What is measured of one recording."""
    random = np.random.default_rng([seed, round(1e3 * jitter)])
    periods = FRAMES * (1 + jitter * random.standard_normal(CYCLES))
    heights = 1 + SHIMMER * random.standard_normal(CYCLES)
    widths = WIDTH + WIDTHS * random.standard_normal(CYCLES)
    lags = (PHASE + PHASES * random.standard_normal(CYCLES)) / (2 * np.pi)
    edges = np.concatenate([[0.0], np.cumsum(periods)])
    time = np.arange(int(edges[-1])) + random.uniform(0.1, 0.9)
    time = time[time < edges[-1]]
    cycle = np.searchsorted(edges, time, side="right") - 1
    share = (time - edges[cycle]) / periods[cycle] - BEGINS

    def side(late: np.ndarray | float) -> np.ndarray:
        within = np.clip((share - late) / widths[cycle], 0, 1)
        return heights[cycle] * np.sin(np.pi * within) ** 1.5

    def noisy(size: float, pulse: np.ndarray) -> np.ndarray:
        return size * (GAP + pulse + NOISE * random.standard_normal(pulse.size))

    left, right = side(0.0), side(lags[cycle])
    area = GlottalArea(noisy(AREA, left), noisy(AREA, right), noisy(EDGE, left), noisy(EDGE, right))
    return measures(area, FPS, length=LENGTH)[0]


def held(pairs: list[list[Change]], truth: Callable[[str], float]) -> dict[str, str]:
    """Per cent of the intervals that hold the truth, by the label of the measure."""
    found: dict[str, list[bool]] = {}
    for change in (one for pair in pairs for one in pair if one.interval is not None):
        low, high = change.interval
        found.setdefault(change.before.quantity.label, []).append(low <= truth(change.name) <= high)
    return {label: f"{100 * np.mean(each):.1f}" for label, each in found.items()}


def rows(count: int) -> Iterator[list[str]]:
    """A row for each measure: no change in so many pairs, a change in half as many."""
    same = [drawn(seed, 0.01) for seed in range(2 * count)]
    other = [drawn(seed, CHANGED) for seed in range(count // 2 + count)]
    steady = held([changes(*same[2 * k : 2 * k + 2]) for k in range(count)], lambda name: 0.0)

    def mean(name: str, recordings: list[Measures]) -> float:
        return float(np.mean([one[name].value for one in recordings]))

    def true(name: str) -> float:
        return mean(name, other[count // 2 :]) - mean(name, same[count:])

    moved = held([changes(same[k], other[k]) for k in range(count // 2)], true)
    for label, share in steady.items():
        yield [label, share, moved[label]]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--pairs", type=int, default=300, help="without a change; with one half as many")
    count = parser.parse_args().pairs
    columns = ["measure", f"no change, {count} pairs (%)", f"jitter from 1 to 3 %, {count // 2} pairs (%)"]
    record("differences", columns, rows(count))


if __name__ == "__main__":
    main()
