"""Quantities compared between levels: measures with their statistical error, and waveforms at fixed times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica.measures.catalogue import CATALOGUE
from plica.measures.cycles import Cycles
from plica.measures.instants import highest
from plica.measures.measure import Measure
from plica.measures.run.measure import measure
from plica.measures.run.run_data import RunData
from plica.scene.scene import Scene

__all__ = ["Sample", "Sampled", "Wave", "near", "sampled", "waves"]

Floats = NDArray[np.float64]

_BLOCK = 2  # least number of cycles: neighbours are correlated, and alternate in a period-doubled vibration
_FEWEST_BLOCKS = 4
_WAVES = ("probes", "minimum_area", "flow", "contact_force_first", "kinetic_energy", "elastic_energy")
_AT_THE_LOAD = ("minimum_area", "flow")  # belong to t_{n+1+alpha}
_EXCLUDED = frozenset(
    (
        "subglottal_pressure",
        "amplitude_growth",
        "sound_jitter",
        "sound_shimmer",
        "sound_harmonics_to_noise",
        "sound_cepstral_peak_prominence",
    )
)
"""An input, and what is zero or without bounds in the limit, or depends on the number of cycles; diagnostics
of the solution are left out too."""


@dataclass(frozen=True)
class Sample:
    """A measure with the 95 % statistical error of its mean.

    Attributes
    ----------
    measure : Measure
    scatter : float or None
        0 without averaging over steady cycles; None: too few of them have the quantity to tell.
    """

    measure: Measure
    scatter: float | None

    @property
    def value(self) -> float:
        """In SI units."""
        assert self.measure.value is not None
        return self.measure.value


@dataclass(frozen=True)
class Sampled:
    """Cycles of a level, and its measures with a value."""

    cycles: Cycles
    samples: dict[str, Sample]


def sampled(run: RunData, *, of_cycles: bool) -> Sampled:
    """The measures of a level that converge under refinement.

    Parameters
    ----------
    run : RunData
    of_cycles : bool
        Only averages over cycles, for levels that start in different states.
    """
    cycles = run.cycles
    found = measure(run, cycles)
    scatter = _scatter(run, cycles, found) if cycles.settled else None
    samples = {}
    for name, item in found.items():
        left_out = name in _EXCLUDED or CATALOGUE[name].diagnostic or (of_cycles and not item.cycles)
        if item.value is not None and not left_out:
            samples[name] = Sample(item, 0.0 if scatter is None or not item.cycles else scatter.get(name))
    return Sampled(cycles, samples)


def _scatter(run: RunData, cycles: Cycles, means: Mapping[str, Measure]) -> dict[str, float]:
    """Student's interval of the means of blocks of cycles (batch means), or of single cycles if there are
    few; nothing of a quantity that fewer than two of them have."""
    from scipy import special

    size = max(_BLOCK, cycles.pattern)
    size = size if cycles.count >= size * _FEWEST_BLOCKS else 1
    count = cycles.count // size
    ends = [cycles.starts[cycles.count - size * (k + 1) : cycles.count - size * k + 1] for k in range(count)]
    blocks = [measure(run, Cycles(starts, verdict=cycles.verdict)) for starts in ends]
    found = {}
    for name in blocks[0] if blocks else ():
        mean, unit = means[name].value, means[name].unit
        if mean is None:
            continue
        values = np.array([near(v, mean, unit) for block in blocks if (v := block[name].value) is not None])
        if values.size > 1:
            half = special.stdtrit(values.size - 1, 0.975) * values.std(ddof=1) / np.sqrt(values.size)
            found[name] = float(half)
    return found


def near(value: float, to: float, unit: str) -> float:
    """An angle shifted to within half a turn of another; other values unchanged."""
    if unit != "rad":
        return value
    return to + float((value - to + np.pi) % (2 * np.pi) - np.pi)


@dataclass(frozen=True)
class Wave:
    """A waveform at fixed times, its largest magnitude and its instant.

    Attributes
    ----------
    unit : str
    values : (k)
        All components, concatenated.
    peak, instant : float
    """

    unit: str
    values: Floats
    peak: float
    instant: float


def waves(run: RunData, units: dict[str, str], scene: Scene, times: Floats) -> Iterator[tuple[str, Wave]]:
    """The main waveforms of a run, interpolated at times (s), each with its own instants."""
    from scipy.interpolate import CubicSpline

    own = np.asarray(run.time, dtype=float)
    scheme = scene.time.scheme.hht
    lagged = scene.airflow is not None and scene.airflow.coupling.lagged is not None
    alpha = -1.0 if lagged else scheme.alpha if scheme is not None else 0.0
    for name in _WAVES:
        if name not in run.waveforms or not np.size(run.waveforms[name]):
            continue
        values = np.asarray(run.waveforms[name], dtype=float).reshape(own.size, -1)
        instants = own + alpha * scene.time.step * (name in _AT_THE_LOAD)
        size = np.linalg.norm(values, axis=1)
        at, peak = highest(instants, size, int(np.argmax(size)))
        taken = CubicSpline(instants, values)(times)
        yield name, Wave(units[name], np.asarray(taken, dtype=float).ravel(), peak, at)
