"""Measures of a run's glottal area and flow."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.glottal import few_samples, over_cycles
from plica.measures.measure import Measure, per_period
from plica.measures.pulses import summits
from plica.measures.quotients import open_quotient
from plica.measures.record import Array, Floats
from plica.measures.thresholds import closed_share_1_percent

summit_share = 0.1  # of a pulse's range, by which a summit stands out


def open_area(waveforms: Mapping[str, Array]) -> Floats:
    """Glottal area (k) m^2: the smallest section area, zero where negative or where contact stops flow."""
    area = np.maximum(np.asarray(waveforms["minimum_area"], dtype=float), 0.0)
    return np.where(np.asarray(waveforms["flow_stopped"]) != 0, 0.0, area)


def strict_open_quotient(time: Floats, area: Floats, cycles: Cycles) -> Measure:
    """The open quotient at the level used in the thesis."""
    values = [open_quotient(time, area, *ends, closed_share_1_percent) for ends in pairwise(cycles.starts)]
    return per_period("open_quotient_1_percent", cycles, np.array(values), cautions=few_samples(time, cycles))


def several_summits(area: Floats, time: Floats, cycles: Cycles) -> list[str]:
    """A caution if pulses have more than one summit.

    A summit stands out by a tenth of its cycle's range, as pulses do of the record's (plica.measures.pulses);
    half of the cycles must have several, so that a single disturbance says nothing.
    """
    parts = [area[part] for part in cycles.samples(time)]
    counts = [summits(part, summit_share * float(np.ptp(part))) for part in parts]
    several = sum(count > 1 for count in counts)
    if not parts or 2 * several < len(parts):
        return []
    return [
        f"{several} of {len(parts)} pulses have several summits (by over {100 * summit_share:g} % of the "
        "pulse): another pattern of vibration than that of a modal voice"
    ]


def flow_measures(time: Floats, flow: Floats, cycles: Cycles) -> list[Measure]:
    """Peak, mean and minimum flow."""
    return [
        over_cycles("peak_flow", time, flow, cycles, np.max),
        over_cycles("mean_flow", time, flow, cycles, np.mean),
        over_cycles("minimum_flow", time, flow, cycles, np.min),
    ]
