"""How steeply the glottal flow falls.

The fall in 50 us, or in a step where that is longer, over that time: the slope at an instant would be that of
single steps, and where a closing fold stops the flow it has no limit. With f the peak-to-peak flow of a cycle
and d its steepest fall, f / (d T) is the normalised amplitude quotient (Alku, Backstrom and Vilkman, J.
Acoust. Soc. Am. 112, 2002); f / d is the time in which the flow would fall by all of f.
"""

from __future__ import annotations

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, per_cycle, per_period
from plica.measures.record import Floats, time_step
from plica.measures.thresholds import fall_window

__all__ = ["declination_measures", "steepest_falls"]

_SHORT = 4.0  # windows: a shorter fall is not resolved


def steepest_falls(time: Floats, flow: Floats, cycles: Cycles) -> Floats:
    """(c) m^3/s^2, the largest fall of the flow (k) in each cycle (see the module docstring)."""
    width = max(fall_window, time_step(time))
    later = np.interp(time + width, time, flow, right=np.nan)
    fall = (flow - later) / width
    return np.array([_largest(fall[part]) for part in cycles.samples(time)])


def _largest(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def declination_measures(time: Floats, flow: Floats, cycles: Cycles, cautions: list[str]) -> list[Measure]:
    """Maximum flow declination rate and normalised amplitude quotient of the glottal flow."""
    rate, quotient = "maximum_flow_declination_rate", "normalised_amplitude_quotient"
    if not cycles.count:
        return [absent(name, cycles.note) for name in (rate, quotient)]
    falls = steepest_falls(time, flow, cycles)
    size = np.array([float(np.ptp(flow[part])) for part in cycles.samples(time)])
    lasts = np.divide(size, falls, out=np.full(falls.size, np.nan), where=falls > 0)
    cautions = [*cautions, *_unresolved(lasts, max(fall_window, time_step(time)))]
    return [
        per_cycle(rate, cycles, falls, cautions=cautions),
        per_period(quotient, cycles, lasts / cycles.periods, cautions=cautions),
    ]


def _unresolved(lasts: Floats, width: float) -> list[str]:
    """A caution where the flow falls within few of the times over which its fall is taken."""
    known = lasts[np.isfinite(lasts)]
    if not known.size or float(np.median(known)) >= _SHORT * width:
        return []
    lasting = 1e6 * float(np.median(known))
    return [
        f"the flow falls within {lasting:.3g} us, {_SHORT:g} times the {1e6 * width:.3g} us over which its "
        "fall is taken, or less: the fall may be steeper"
    ]
