"""Measures of a run's glottal area and flow."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from plica.measures.catalogue import closed_share_1_percent
from plica.measures.cycles import Cycles
from plica.measures.glottal import few_samples, over_cycles
from plica.measures.measure import Measure, per_cycle
from plica.measures.quotients import open_quotient
from plica.measures.record import Array, Floats


def open_area(waveforms: Mapping[str, Array]) -> Floats:
    """Glottal area (k) m^2: the smallest section area, zero where negative or where contact stops flow."""
    area = np.maximum(np.asarray(waveforms["minimum_area"], dtype=float), 0.0)
    return np.where(np.asarray(waveforms["flow_stopped"]) != 0, 0.0, area)


def strict_open_quotient(time: Floats, area: Floats, cycles: Cycles) -> Measure:
    """The open quotient at the level used in the thesis."""
    values = [open_quotient(time, area, *ends, closed_share_1_percent) for ends in pairwise(cycles.starts)]
    return per_cycle("open_quotient_1_percent", cycles, np.array(values), cautions=few_samples(time, cycles))


def flow_measures(time: Floats, flow: Floats, cycles: Cycles) -> list[Measure]:
    """Peak, mean and minimum flow."""
    return [
        over_cycles("peak_flow", time, flow, cycles, np.max),
        over_cycles("mean_flow", time, flow, cycles, np.mean),
        over_cycles("minimum_flow", time, flow, cycles, np.min),
    ]
