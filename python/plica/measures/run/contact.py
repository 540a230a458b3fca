"""Measures of the collisions between the folds.

A collision lasts while the contact force on the left (first) fold exceeds a share (see the catalogue) of the
peak of a steady cycle, the median over the cycles with contact, so that a violent onset does not hide later
collisions; without such cycles, of the largest value. Short losses of contact are bridged: folds that close
in parts, one after the other, make one collision.
Without cycles all of the run is measured. If it vibrates with pulses that are no periods, only its last third
is, as the onset is no part of that vibration, and nothing per collision: losses of contact within one cannot
be told from those between two.
Forces belong to whole steps: an impulse is the sum of force times step, a duration is a number of steps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, average, per_cycle, whole
from plica.measures.record import Array, Floats, time_step
from plica.measures.thresholds import bridged_of_record, bridged_share, contact_share, pressure_window


def collisions(time: Floats, force: Floats, level: float, gap: float) -> list[slice]:
    """Samples of each complete collision.

    Parameters
    ----------
    time : (k) s
    force : (k) N, magnitude
    level : float
        N, >= 0; contact is where the force is above it.
    gap : float
        s; losses of contact up to this long are bridged.

    Returns
    -------
    list of slice
        Without collisions that are incomplete at the start or the end of the record.
    """
    touching = np.flatnonzero(force > level)
    if not touching.size:
        return []
    breaks = np.flatnonzero(np.diff(time[touching]) > gap + 1.5 * time_step(time))
    first = touching[np.concatenate(([0], breaks + 1))]
    last = touching[np.concatenate((breaks, [touching.size - 1]))]
    found = [slice(int(a), int(b) + 1) for a, b in zip(first, last, strict=True)]
    return [part for part in found if part.start > 0 and part.stop < time.size]


def moving_average(values: Floats, count: int) -> Floats:
    """Mean over `count` consecutive samples ending at each sample; earlier samples count as zero."""
    total = np.concatenate((np.zeros(count), np.cumsum(values)))
    return (total[count:] - total[:-count]) / count


def contact_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, fold_length: float | None
) -> list[Measure]:
    """Forces, impulses, durations, areas, pressures and the accuracy of the contact.

    Parameters
    ----------
    time, waveforms
        Of the computed steps.
    cycles : Cycles
        Steady cycles, possibly none.
    fold_length : float or None
        m, anteroposterior length of the folds; None if unknown.
    """
    left = np.asarray(waveforms["contact_force_first"], dtype=float)
    right = np.asarray(waveforms["contact_force_second"], dtype=float)
    size = np.linalg.norm(left, axis=1)
    if not size.size or not size.max() > 0:
        return _without_collision(waveforms, fold_length)
    record, part = float(time[-1] - time[0]), _window(time, cycles)
    loss = bridged_share * float(cycles.periods.mean()) if cycles.count else bridged_of_record * record
    peaks = np.array([size[part].max() for part in cycles.samples(time)]) if cycles.count else np.empty(0)
    peak = np.median(peaks[peaks > 0]) if peaks.any() else size[part].max()
    found = collisions(time, size, contact_share * float(peak), loss)
    each = [
        whole("collisions", len(found)),
        *_collision_measures(time, left, right, _measured(found, time, cycles), cycles),
    ]
    if cycles.verdict == "ambiguous":
        each = [absent(name, cycles.note) for name in ("collisions", *_EACH)]
    balance = float(np.linalg.norm(left + right, axis=1).max() / size.max())
    return [
        *each,
        *_extent_measures(time, waveforms, cycles, fold_length),
        *_pressure_measures(time, waveforms, cycles),
        whole("contact_force_balance", balance),
        *_enforcement_measures(waveforms),
    ]


def _window(time: Floats, cycles: Cycles) -> slice:
    """Samples that are measured: the cycles; without any the whole run, or its last third if it vibrates."""
    return cycles.extent(time) if cycles.count or cycles.verdict == "ambiguous" else slice(0, time.size)


def _measured(found: list[slice], time: Floats, cycles: Cycles) -> list[slice]:
    """The collisions whose middle is in the part that is measured."""
    begin, end = cycles.starts[[0, -1]] if cycles.count else (-np.inf, np.inf)
    middle = [0.5 * (time[part.start] + time[part.stop - 1]) for part in found]
    return [part for part, t in zip(found, middle, strict=True) if begin <= t < end]


def _said(time: Floats, cycles: Cycles) -> list[str]:
    """The note of the cycles, and without any over which part of the run a value is."""
    if cycles.count:
        return [cycles.note] if cycles.note else []
    part = _window(time, cycles)
    extent = f"{1e3 * time[part.start]:.4g} to {1e3 * time[part.stop - 1]:.4g} ms"
    which = "the whole run" if part.start == 0 else "the last third of the run"
    return [f"over {which}, {extent}; {cycles.note}"]


_EACH = (
    "contact_impulse",
    "contact_duration",
    "contact_force_left_peak",
    "contact_force_left_mean",
    "contact_force_right_peak",
    "contact_force_right_mean",
)


def _collision_measures(
    time: Floats, left: Floats, right: Floats, chosen: list[slice], cycles: Cycles
) -> list[Measure]:
    if not chosen:
        return [absent(name, "no complete collision in the steady cycles") for name in _EACH]
    step = time_step(time)
    durations = np.array([(part.stop - part.start) * step for part in chosen])
    impulses = np.array([np.linalg.norm(left[part].sum(axis=0)) * step for part in chosen])
    values = {"contact_impulse": impulses, "contact_duration": durations}
    for side, force in (("left", left), ("right", right)):
        size = np.linalg.norm(force, axis=1)
        peaks = np.array([size[part].max() for part in chosen])
        means = np.array([np.linalg.norm(force[part].mean(axis=0)) for part in chosen])
        values |= {f"contact_force_{side}_peak": peaks, f"contact_force_{side}_mean": means}
    return [average(name, values[name], cautions=_said(time, cycles)) for name in _EACH]


def _per_cycle_peak(name: str, time: Floats, values: Floats, cycles: Cycles, note: str = "") -> Measure:
    if not cycles.count:
        return whole(name, float(values[_window(time, cycles)].max()), note, _said(time, cycles))
    return per_cycle(name, cycles, np.array([values[part].max() for part in cycles.samples(time)]), note)


def _extent_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, fold_length: float | None
) -> list[Measure]:
    length = np.asarray(waveforms["contact_length"], dtype=float)
    area = np.asarray(waveforms["contact_area"], dtype=float)
    found = [
        _per_cycle_peak("contact_area_max", time, area, cycles),
        _per_cycle_peak("contact_length_max", time, length, cycles),
    ]
    if fold_length:
        note = f"fold length at rest {1e3 * fold_length:.4g} mm"
        found.append(_per_cycle_peak("contact_length_fraction", time, length / fold_length, cycles, note))
    return found


def _pressure_measures(time: Floats, waveforms: Mapping[str, Array], cycles: Cycles) -> list[Measure]:
    pressure = np.asarray(waveforms["largest_contact_pressure"], dtype=float)
    step = time_step(time)
    count = max(round(pressure_window / step), 1)
    averaged = moving_average(pressure, count)
    return [
        _per_cycle_peak("peak_contact_pressure", time, averaged, cycles, _averaging(count * step)),
        _per_cycle_peak("peak_contact_pressure_step", time, pressure, cycles, _averaging(step)),
    ]


def _averaging(time: float) -> str:
    return f"averaging time {1e3 * time:.3g} ms"


def _enforcement_measures(waveforms: Mapping[str, Array]) -> list[Measure]:
    table: tuple[tuple[str, str, Callable[[Floats], float]], ...] = (
        ("deepest_gap", "deepest_gap", np.min),
        ("largest_multiplier", "largest_multiplier", np.max),
        ("overlap_volume_max", "overlap_volume", np.max),
        ("edge_overlap_volume_max", "edge_overlap_volume", np.max),
        ("mean_contact_passes", "contact_passes", np.mean),
    )
    return [
        whole(name, reduce(np.asarray(waveforms[key], dtype=float)))
        for name, key, reduce in table
        if key in waveforms
    ]


def _without_collision(waveforms: Mapping[str, Array], fold_length: float | None) -> list[Measure]:
    reason = "the folds never touch"
    nothing = (*_EACH, "contact_force_balance", "peak_contact_pressure", "peak_contact_pressure_step")
    zero = ["contact_area_max", "contact_length_max"] + ["contact_length_fraction"] * bool(fold_length)
    return [
        whole("collisions", 0),
        *(absent(name, reason) for name in nothing),
        *(whole(name, 0, reason) for name in zero),
        *_enforcement_measures(waveforms),
    ]
