"""How often the 95 % intervals of what `plica video` measures hold the truth, measure by measure.

    python -m benchmarks.video.coverage                  the films that judge; about 4 min
    python -m benchmarks.video.coverage --chosen         those on which the intervals were made; kept nowhere

Films: the synthetic glottis, drawn by seed: size, voice, left against right, texture, noise of 1 to 10 grey
levels, blur of up to 1.1 px; shaded ones have the steep surface beside one fold in the shade of a lamp; of
voices without images the masks are exact. None of them is one that the intervals were made on.

Truth: written here from the definitions of the catalogue, on the exact edges, 40 samples a frame; cycles are
those that were found, with the true marks. Length: of the glottis that was drawn. Half width: half of
the interval over the magnitude of the truth, means over films; in the measure's own unit where that may be 0
(phase in rad).
A harmonics-to-noise ratio is cut off at 90 dB, beyond which it is not defined.
"""

from __future__ import annotations

import math
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.measures.cycles import Cycles
from plica.measures.measure import Measures
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.glottis.glottal_area import areas
from plica.video.glottis.midline import Midline
from plica.video.measures.waveforms import measures
from plica.video.settings import Settings

Floats = np.ndarray

FPS = 4000.0
FILMS = {"films": 40, "shaded films": 16, "without images": 24}
JUDGE, CHOSE = 7000, 1000  # first seeds
ENDS = (0.15, 0.85)  # of the height, between which the glottis is drawn
FINE, ROWS = 40, 400  # samples a frame, rows
ABSOLUTE = ("phase", "asymmetry", "growth", "index", "jitter", "shimmer", "perturbation", "gap")
PRECISE = 1e-9  # of 1, up to which an autocorrelation has a ratio in dB


@dataclass(frozen=True)
class Outcome:
    """Of one measure in one film: value found, interval, truth."""

    value: float
    interval: tuple[float, float]
    truth: float

    @property
    def held(self) -> bool:
        return self.interval[0] <= self.truth <= self.interval[1]

    @property
    def half_width(self) -> float:
        return (self.interval[1] - self.interval[0]) / 2


def drawn(kind: str, seed: int) -> Synthetic:
    """The film of a kind with this seed."""
    random = np.random.default_rng([seed, *kind.encode()])
    size = random.uniform(4, 9)
    unlike = random.uniform(0.7, 1.0)
    amplitude = (size, size * unlike) if random.random() < 0.5 else (size * unlike, size)
    opening = random.uniform(-0.2, 0.95) * size
    irregular = random.random() < 0.4
    return Synthetic(
        height=int(random.integers(112, 161)),
        width=int(random.integers(96, 129)),
        frames=int(random.integers(90, 131)),
        frequency=float(random.uniform(0.045, 0.062)),
        amplitude=amplitude,
        opening=(opening, opening * random.uniform(0.8, 1.2)),
        phase=(0.0, 0.0) if random.random() < 0.3 else (0.0, random.uniform(-0.7, 0.7)),
        lag=random.choice([0.0, random.uniform(-0.8, 0.8)]),
        jitter=random.uniform(0.005, 0.02) * irregular,
        shimmer=random.uniform(0.01, 0.05) * irregular,
        texture=random.uniform(10, 25),
        grain=random.uniform(2, 4),
        highlights=2,
        noise=random.uniform(1, 10),
        blur=random.uniform(0, 1.1),
        shade=random.uniform(1.0, 4.0) if kind == "shaded films" else 0.0,
        seed=seed,
    )


def found_of(kind: str, glottis: SyntheticGlottis) -> tuple[Measures, Cycles, Floats]:
    """What is measured, its cycles (s), and the seen lines' ends along the folds, shares of their length."""
    options = glottis.options
    if kind == "without images":
        top, bottom = (end * options.height for end in ENDS)
        line = Midline((glottis.midline, top), (glottis.midline, bottom))
        masks = (glottis.mask(t) for t in range(options.frames))
        return *measures(areas(masks, line), FPS, length=line.length), _middle(glottis, line)
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "film.npy", glottis.stack())
        settings = Settings(fps=FPS, correct_drift=False)
        path = Path(folder) / "film.npy", Path(folder) / "found"
        found = analyse(*path, settings, until="glottis", progress=False)
        return found.measures, found.cycles, _middle(glottis, found.midline)


def _middle(glottis: SyntheticGlottis, line: Midline) -> Floats:
    """Rows of the middle tenth of the line that was found: where a fold is measured is no error of it."""
    (_, top), (_, bottom) = line.upper, line.lower
    return top + np.linspace(0.45, 0.55, 21) * (bottom - top)


def truth_of(glottis: SyntheticGlottis, cycles: Cycles, rows: Floats) -> dict[str, float]:
    """The true measures, over the cycles that were found."""
    options = glottis.options
    time = np.arange(0, options.frames - 1 + 0.5 / FINE, 1 / FINE)  # frames
    height = options.height * (ENDS[1] - ENDS[0])
    y = options.height * ENDS[0] + (np.arange(ROWS) + 0.5) / ROWS * height
    side_area = np.array([[glottis.edge(k, y, t).mean() * height for t in time] for k in (0, 1)])
    edge = np.array([[glottis.edge(k, rows, t).mean() for t in time] for k in (0, 1)])
    area = side_area.sum(axis=0)
    marks = _marks(time, area, cycles.starts * FPS)
    parts = [slice(*np.searchsorted(time, ends)) for ends in pairwise(marks)]
    periods = np.diff(marks)
    tops, lows = (np.array([reduce(area[part]) for part in parts]) for reduce in (np.max, np.min))
    swings = [[np.ptp(one[part]) / 2 for part in parts] for one in (*edge, *side_area)]
    left, right, left_area, right_area = np.array(swings)
    of_cycles = [_quotients(time, area, part, period) for part, period in zip(parts, periods, strict=True)]
    size = tops - lows
    found = {name: float(np.mean([one[name] for one in of_cycles])) for name in of_cycles[0]}
    return found | {
        "fundamental_frequency": FPS * periods.size / (marks[-1] - marks[0]),
        "period": periods.mean() / FPS,
        "amplitude_growth": np.polyfit(np.arange(size.size), size, 1)[0] / size.mean(),
        "jitter": _local(periods),
        "shimmer": _local(size),
        "period_perturbation_quotient": _five(periods),
        "amplitude_perturbation_quotient": _five(size),
        "harmonics_to_noise": _harmonics_to_noise(area[parts[0].start : parts[-1].stop], periods.mean()),
        "amplitude_left": left.mean(),
        "amplitude_right": right.mean(),
        "amplitude_left_relative": left.mean() / height,
        "amplitude_right_relative": right.mean() / height,
        "amplitude_ratio": (right / left).mean(),
        "amplitude_asymmetry": ((right - left) / (right + left)).mean(),
        "area_asymmetry": ((right_area - left_area) / (right_area + left_area)).mean(),
        "left_right_phase": _phase(time, edge, marks),
        "glottal_area_max": tops.mean(),
        "glottal_area_mean": float(np.mean([area[part].mean() for part in parts])),
        "glottal_area_max_relative": tops.mean() / height**2,
        "glottal_gap_index": (lows / tops).mean(),
        "glottal_gap_relative": lows.mean() / height**2,
    }


def _marks(time: Floats, area: Floats, near: Floats) -> Floats:
    """Frames: the mean of the instants at which the pulse nearest each of these rises through 20, 30 and 40 %
    of its height over the least area before it."""
    period = float(np.median(np.diff(near)))
    found = []
    for mark in near:
        after = (time >= mark - 0.1 * period) & (time < mark + 0.75 * period)
        peak = int(np.flatnonzero(after)[np.argmax(area[after])])
        before = (time >= time[peak] - 0.8 * period) & (time < time[peak])
        foot = area[before].min()
        levels = foot + np.array([0.2, 0.3, 0.4]) * (area[peak] - foot)
        below = [np.flatnonzero((area <= level) & (time < time[peak]))[-1] for level in levels]
        rises = [
            time[k] + (level - area[k]) / (area[k + 1] - area[k]) / FINE
            for k, level in zip(below, levels, strict=True)
        ]
        found.append(np.mean(rises))
    return np.array(found)


def _quotients(time: Floats, area: Floats, part: slice, period: float) -> dict[str, float]:
    """Of the cycle of these samples and this period (frames)."""
    inside = area[part]
    peak = part.start + int(inside.argmax())
    around = int(period * FINE)
    before, after = area[max(peak - around, 0) : peak][::-1], area[peak : peak + around]
    foot, level = max(before.min(), after.min()), 0.05 * area[peak]
    if foot > level:
        level = foot + 0.1 * (area[peak] - foot)
    opening, closing = (float(np.argmax(one <= level)) / FINE for one in (before, after))
    speed, shut = opening / closing, closing / period
    low, high = inside.min(), inside.max()
    opened = float(np.mean(inside > 0.05 * high))
    return {
        "open_quotient": opened,
        "closed_quotient": 1 - opened,
        "open_quotient_20_percent": float(np.mean(inside > low + 0.2 * (high - low))),
        "open_quotient_50_percent": float(np.mean(inside > low + 0.5 * (high - low))),
        "speed_quotient": speed,
        "speed_index": (opening - closing) / (opening + closing),
        "closing_quotient": shut,
        "rate_quotient": 1 / shut - 1,
    }


def _local(values: Floats) -> float:
    return float(np.abs(np.diff(values)).mean() / values.mean())


def _five(values: Floats) -> float:
    if values.size < 5:
        return math.nan
    off = [values[k] - values[k - 2 : k + 3].mean() for k in range(2, values.size - 2)]
    return float(np.abs(off).mean() / values.mean())


def _phase(time: Floats, edge: Floats, marks: Floats) -> float:
    """rad, of the fundamentals by Fourier's integral over each cycle; positive where the right lags."""
    turns = []
    for begin, end in pairwise(marks):
        part = slice(*np.searchsorted(time, (begin, end)))
        wave = np.exp(2j * np.pi * (time[part] - begin) / (end - begin))
        left, right = ((one[part] - one[part].mean()) @ wave for one in edge)
        turns.append(right * np.conj(left) / abs(right * left))
    return float(np.angle(np.mean(turns)))


def _harmonics_to_noise(area: Floats, period: float) -> float:
    """dB, of the largest correlation of the area with itself a lag within 5 % of the period later."""
    centred, best = area - area.mean(), -1.0
    for lag in range(int(0.95 * period * FINE), int(1.05 * period * FINE) + 2):
        one, other = centred[:-lag], centred[lag:]
        best = max(best, float(one @ other / math.sqrt((one @ one) * (other @ other))))
    r = min(best, 1 - PRECISE)
    return 10 * math.log10(r / (1 - r)) if r > 0 else math.nan


def outcomes(kind: str, seed: int) -> dict[str, Outcome]:
    """By measure, of those that have an interval and a truth."""
    glottis = SyntheticGlottis(drawn(kind, seed))
    found, cycles, rows = found_of(kind, glottis)
    if not cycles.count:
        return {}
    truth = truth_of(glottis, cycles, rows)
    return {
        name: Outcome(float(item.value), item.interval, float(truth[name]))
        for name, item in found.items()
        if item.value is not None and item.interval is not None and np.isfinite(truth.get(name, np.nan))
    }


def rows(first: int) -> Iterator[list[object]]:
    """A row a measure, then all measures."""
    by_kind: dict[str, dict[str, list[Outcome]]] = {}
    for kind, count in FILMS.items():
        by_kind[kind] = defaultdict(list)
        for seed in range(first, first + count):
            for name, one in outcomes(kind, seed).items():
                by_kind[kind][name].append(one)
    for name in by_kind["films"]:
        relative = not any(part in name for part in ABSOLUTE)
        cells: list[object] = [name.replace("_", " ")]
        for of_kind in by_kind.values():
            cells += _cells(of_kind[name], relative)
        yield cells
    cells = ["all"]
    for of_kind in by_kind.values():
        cells += _cells([one for some in of_kind.values() for one in some], None)
    yield cells


def _cells(found: list[Outcome], relative: bool | None) -> list[object]:
    """How many hold the truth, in %; the mean half width, none of measures that differ."""
    if not found:
        return ["", ""]
    held = sum(one.held for one in found)
    share = f"{held} of {len(found)}" if relative is not None else f"{100 * held / len(found):.1f} %"
    if relative is None:
        return [share, ""]
    half = float(np.mean([one.half_width for one in found]))
    half /= float(np.mean([abs(one.truth) for one in found])) if relative else 1.0
    return [share, f"{100 * half:.2g} %" if relative else f"{half:.2g}"]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--chosen", action="store_true", help="those on which the intervals were made")
    options = parser.parse_args()
    columns = ["measure", *(head for kind in FILMS for head in (f"{kind}: held", "half width"))]
    if options.chosen:
        from benchmarks.harness.table import show

        show(columns, rows(CHOSE))
    else:
        record("video_coverage", columns, rows(JUDGE))


if __name__ == "__main__":
    main()
