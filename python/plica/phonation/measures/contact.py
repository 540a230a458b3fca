"""Measures of the collisions between the folds.

A collision lasts as long as the contact force on the left (first) fold exceeds 1 % of a steady cycle's peak,
the median over the cycles with contact, so that a violent start does not hide what follows; without such
cycles, of its largest value. Losses of contact shorter than a quarter of the period are part of it: where
the folds close in parts, one after the other, that is one collision. Without cycles those
shorter than 5 % of the record are.
Forces belong to whole steps: an impulse is the sum of force times step, a duration is a number of steps.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, average, per_cycle, whole
from plica.measures.record import Array, Floats, time_step

force_level = 0.01  # of a steady cycle's peak force: contact
bridged = 0.25  # of the period: losses of contact within a collision
bridged_of_record = 0.05  # the same without cycles, of the record
pressure_window = 0.2e-3  # s, averaging time of the peak contact pressure


def collisions(time: Floats, force: Floats, level: float, gap: float) -> list[slice]:
    """Samples of each complete collision.

    Parameters
    ----------
    time : (k) s
    force : (k) N, magnitude
    level : float
        N, >= 0, contact is above it.
    gap : float
        s, losses of contact up to this long are bridged.

    Returns
    -------
    list of slice
        Without a collision that is still going on at the end of the record, or was at its beginning.
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
) -> dict[str, Measure]:
    """Forces, impulses, durations, areas, pressures and the quality of the enforcement.

    Parameters
    ----------
    time, waveforms
        Of the steps that were computed.
    cycles : Cycles
        Steady cycles, possibly none.
    fold_length : float or None
        m, anteroposterior length of the folds; None where the scene does not tell.
    """
    left = np.asarray(waveforms["contact_force_first"], dtype=float)
    right = np.asarray(waveforms["contact_force_second"], dtype=float)
    size = np.linalg.norm(left, axis=1)
    if not size.size or not size.max() > 0:
        return _without_collision(waveforms, fold_length)
    record = float(time[-1] - time[0])
    loss = bridged * float(cycles.periods.mean()) if cycles.count else bridged_of_record * record
    peaks = np.array([size[part].max() for part in cycles.samples(time)]) if cycles.count else np.empty(0)
    peak = np.median(peaks[peaks > 0]) if peaks.any() else size.max()
    found = collisions(time, size, force_level * float(peak), loss)
    chosen = _steady(found, time, cycles)
    return (
        _collision_measures(time, left, right, chosen, len(found))
        | _extent_measures(time, waveforms, cycles, fold_length)
        | _pressure_measures(time, waveforms, cycles)
        | {
            "contact_force_balance": whole(
                float(np.linalg.norm(left + right, axis=1).max() / size.max()),
                "1",
                "largest magnitude of the sum of both forces over the largest force",
            )
        }
        | _enforcement_measures(waveforms)
    )


def _steady(found: list[slice], time: Floats, cycles: Cycles) -> list[slice]:
    if not cycles.count:
        return found
    middle = [0.5 * (time[part.start] + time[part.stop - 1]) for part in found]
    return [part for part, t in zip(found, middle, strict=True) if cycles.starts[0] <= t < cycles.starts[-1]]


def _collision_measures(
    time: Floats, left: Floats, right: Floats, chosen: list[slice], count: int
) -> dict[str, Measure]:
    found = {"collisions": whole(count, "1", "complete collisions in the whole run")}
    step = time_step(time)
    note = (
        "over the collisions of the steady cycles, without cycles of the run; in contact above 1 % of the "
        "peak force, losses of contact below a quarter of the period (5 % of the run) bridged"
    )
    if not chosen:
        reason = "no complete collision in the steady cycles"
        units = {"contact_impulse": "N s", "contact_duration": "s"}
        for side in ("left", "right"):
            units |= {f"contact_force_{side}_peak": "N", f"contact_force_{side}_mean": "N"}
        return found | {name: absent(unit, reason) for name, unit in units.items()}
    durations = np.array([(part.stop - part.start) * step for part in chosen])
    impulses = np.array([np.linalg.norm(left[part].sum(axis=0)) * step for part in chosen])
    found["contact_impulse"] = average(impulses, "N s", f"on the left fold; {note}")
    found["contact_duration"] = average(durations, "s", note)
    for side, force in (("left", left), ("right", right)):
        size = np.linalg.norm(force, axis=1)
        peaks = np.array([size[part].max() for part in chosen])
        means = np.array([np.linalg.norm(force[part].mean(axis=0)) for part in chosen])
        found[f"contact_force_{side}_peak"] = average(peaks, "N", f"single step; {note}")
        found[f"contact_force_{side}_mean"] = average(means, "N", f"impulse over duration; {note}")
    return found


def _per_cycle_peak(time: Floats, values: Floats, cycles: Cycles, unit: str, note: str = "") -> Measure:
    if not cycles.count:
        text = "; ".join(part for part in (note, "largest of the whole run") if part)
        return whole(float(values.max()), unit, text)
    return per_cycle(cycles, np.array([values[part].max() for part in cycles.samples(time)]), unit, note)


def _extent_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, fold_length: float | None
) -> dict[str, Measure]:
    length = np.asarray(waveforms["contact_length"], dtype=float)
    area = np.asarray(waveforms["contact_area"], dtype=float)
    found = {
        "contact_area_max": _per_cycle_peak(time, area, cycles, "m^2"),
        "contact_length_max": _per_cycle_peak(time, length, cycles, "m", "anteroposterior"),
    }
    if fold_length:
        note = f"of the fold length {1e3 * fold_length:.4g} mm"
        found["contact_length_fraction"] = _per_cycle_peak(time, length / fold_length, cycles, "1", note)
    return found


def _pressure_measures(time: Floats, waveforms: Mapping[str, Array], cycles: Cycles) -> dict[str, Measure]:
    pressure = np.asarray(waveforms["peak_contact_pressure"], dtype=float)
    step = time_step(time)
    count = max(round(pressure_window / step), 1)
    note = (
        f"averaging time {1e3 * count * step:.3g} ms: moving mean of the largest nodal pressure of each step "
        "(an upper bound of any one node's mean); grows as the step falls where the surfaces have mass, "
        'converges without (contact.surface_mass = "redistributed")'
    )
    return {
        "peak_contact_pressure": _per_cycle_peak(time, moving_average(pressure, count), cycles, "Pa", note),
        "peak_contact_pressure_step": _per_cycle_peak(
            time,
            pressure,
            cycles,
            "Pa",
            f"averaging time one step, {1e3 * step:.3g} ms: grows as the step falls, not a physical figure",
        ),
    }


def _enforcement_measures(waveforms: Mapping[str, Array]) -> dict[str, Measure]:
    table = (
        ("deepest_gap", "deepest_gap", np.min, "m", "of the whole run, at a node; negative is overlap"),
        (
            "largest_multiplier",
            "largest_multiplier",
            np.max,
            "N",
            "of the whole run; positive would be tensile",
        ),
        ("overlap_volume_max", "overlap_volume", np.max, "m^3", "of the whole run, confirmed at nodes"),
        (
            "edge_overlap_volume_max",
            "edge_overlap_volume",
            np.max,
            "m^3",
            "of the whole run; edge to edge, without a row",
        ),
        ("mean_contact_passes", "contact_passes", np.mean, "1", "over all steps"),
    )
    found = {}
    for name, key, function, unit, note in table:
        if key in waveforms:
            value = function(np.asarray(waveforms[key], dtype=float))
            found[name] = whole(float(value), unit, note)
    return found


def _without_collision(waveforms: Mapping[str, Array], fold_length: float | None) -> dict[str, Measure]:
    reason = "the folds never touch"
    units = {
        "contact_impulse": "N s",
        "contact_duration": "s",
        "contact_force_left_peak": "N",
        "contact_force_left_mean": "N",
        "contact_force_right_peak": "N",
        "contact_force_right_mean": "N",
        "contact_force_balance": "1",
        "peak_contact_pressure": "Pa",
        "peak_contact_pressure_step": "Pa",
    }
    found = {"collisions": whole(0, "1", "complete collisions in the whole run")}
    found |= {name: absent(unit, reason) for name, unit in units.items()}
    found |= {"contact_area_max": whole(0, "m^2", reason), "contact_length_max": whole(0, "m", reason)}
    if fold_length:
        found["contact_length_fraction"] = whole(0, "1", reason)
    return found | _enforcement_measures(waveforms)
