"""Measures of the motion of the two folds in the mid-coronal plane.

Half-widths are x of the right fold's point and -x of the left one's, so that both grow as the glottis opens.
The glottal canal is the range of sections about the narrowest one whose width at rest is at most 1.5 times
the least; its lowest section is the lower edge and its highest the upper edge.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, per_cycle
from plica.measures.record import Array, Floats
from plica.phonation.measures.glottal import open_area, open_level
from plica.phonation.measures.run_data import RunData

canal_width = 1.5  # largest width of the glottal canal at rest, relative to the least


def half_widths(waveforms: Mapping[str, Array]) -> tuple[Floats, Floats]:
    """Half-widths (k, s) m of the right and of the left fold."""
    right = np.asarray(waveforms["coronal_right"], dtype=float)[:, :, 0]
    left = -np.asarray(waveforms["coronal_left"], dtype=float)[:, :, 0]
    return right, left


def rest_width(run: RunData) -> Floats:
    """Width (s) m of the airway at y = 0 and the heights of the sections, in the reference position.

    Cut from the surface named airway; without one, the width at the first record.
    """
    surface = run.mesh.surfaces.get("airway")
    if surface is None:
        right, left = half_widths(run.waveforms)
        return np.asarray(right[0] + left[0], dtype=float)
    points, corners = np.asarray(run.mesh.points, dtype=float), np.asarray(surface)[:, :3]
    edges = np.concatenate((corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]))
    y = points[edges, 1]
    edges = edges[(y.min(axis=1) <= 0) & (y.max(axis=1) >= 0) & (np.ptp(y, axis=1) > 0)]
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    cut = a - (a[:, 1] / (b[:, 1] - a[:, 1]))[:, None] * (b - a)
    width = np.zeros(len(run.section_height))
    for side in (cut[cut[:, 0] > 0], cut[cut[:, 0] < 0]):
        ascending = side[np.argsort(side[:, 2])]
        width += np.interp(run.section_height, ascending[:, 2], np.abs(ascending[:, 0]))
    return width


def glottal_canal(width: Floats) -> slice:
    """Range of sections that form the glottal canal, from the widths at rest (see the module's head)."""
    narrow = width <= canal_width * width.min()
    low = high = int(np.argmin(width))
    while low > 0 and narrow[low - 1]:
        low -= 1
    while high + 1 < width.size and narrow[high + 1]:
        high += 1
    return slice(low, high + 1)


def fourier(time: Floats, signal: Floats, start: float, end: float) -> complex:
    """Coefficient of the fundamental of one cycle, (2 / T) int (s - mean) exp(-i 2 pi (t - start) / T) dt.

    The signal is interpolated linearly to 128 instants of the cycle, ends included once.
    """
    instants = start + (end - start) * np.arange(128) / 128
    values = np.interp(instants, time, signal)
    turns = np.exp(-2j * np.pi * np.arange(128) / 128)
    return complex(2.0 * np.mean((values - values.mean()) * turns))


def motion_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, canal: slice
) -> dict[str, Measure]:
    """Amplitudes of both folds, their ratio and asymmetry, the phase between them and between the edges."""
    units = {
        "amplitude_left": "m",
        "amplitude_right": "m",
        "amplitude_ratio": "1",
        "amplitude_asymmetry": "1",
        "left_right_phase": "rad",
        "vertical_phase_difference": "rad",
        "converging_while_opening": "1",
        "diverging_while_closing": "1",
    }
    if not cycles.count:
        return {name: absent(unit, cycles.note) for name, unit in units.items()}
    right, left = half_widths(waveforms)
    parts = cycles.samples(time)
    ends = list(pairwise(cycles.starts))
    steady = cycles.extent(time)
    section = int(np.argmax(np.ptp(right[steady], axis=0) + np.ptp(left[steady], axis=0)))
    right_amplitude = np.array([0.5 * np.ptp(right[part, section]) for part in parts])
    left_amplitude = np.array([0.5 * np.ptp(left[part, section]) for part in parts])
    x, y = right[:, section], left[:, section]
    phase = [_angle(fourier(time, x, *pair), fourier(time, y, *pair)) for pair in ends]
    where = f"half the peak-to-peak mediolateral motion, mid-coronal, section {section} (moves most)"
    total = right_amplitude + left_amplitude
    found = {
        "amplitude_left": per_cycle(cycles, left_amplitude, "m", where),
        "amplitude_right": per_cycle(cycles, right_amplitude, "m", where),
        "amplitude_ratio": per_cycle(cycles, _ratio(right_amplitude, left_amplitude), "1", "right over left"),
        "amplitude_asymmetry": per_cycle(
            cycles, _ratio(right_amplitude - left_amplitude, total), "1", "(right - left) / (right + left)"
        ),
        "left_right_phase": per_cycle(
            cycles, np.array(phase), "rad", "at the fundamental; positive where the right fold is ahead"
        ),
    }
    return found | _canal_measures(time, waveforms, cycles, canal)


def _canal_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, canal: slice
) -> dict[str, Measure]:
    if canal.stop - canal.start < 2:
        reason = "the glottal canal has a single section"
        return {
            "vertical_phase_difference": absent("rad", reason),
            "converging_while_opening": absent("1", reason),
            "diverging_while_closing": absent("1", reason),
        }
    right, left = half_widths(waveforms)
    lower, upper = (right + left)[:, canal.start], (right + left)[:, canal.stop - 1]
    lag = [
        _angle(fourier(time, lower, *pair), fourier(time, upper, *pair)) for pair in pairwise(cycles.starts)
    ]
    area = open_area(waveforms)
    rate = np.gradient(area, time)
    opening, closing = [], []
    for part in cycles.samples(time):
        opened = area[part] > open_level * area[part].max()
        slope = lower[part] - upper[part]
        opening.append(_share(slope > 0, opened & (rate[part] > 0)))
        closing.append(_share(slope < 0, opened & (rate[part] < 0)))
    edges = f"sections {canal.start} and {canal.stop - 1}"
    return {
        "vertical_phase_difference": per_cycle(
            cycles,
            np.array(lag),
            "rad",
            f"lag of the upper behind the lower edge ({edges}), at the fundamental",
        ),
        "converging_while_opening": per_cycle(
            cycles, np.array(opening), "1", f"share of opening samples with the lower edge wider ({edges})"
        ),
        "diverging_while_closing": per_cycle(
            cycles, np.array(closing), "1", f"share of closing samples with the upper edge wider ({edges})"
        ),
    }


def _angle(ahead: complex, behind: complex) -> float:
    """Phase of the first minus that of the second, in (-pi, pi]; NaN where one of them does not move."""
    if min(abs(ahead), abs(behind)) <= 1e-6 * max(abs(ahead), abs(behind)) or ahead == 0:
        return float("nan")
    return float(np.angle(ahead * np.conj(behind)))


def _ratio(top: Floats, bottom: Floats) -> Floats:
    ratio: Floats = np.divide(top, bottom, out=np.full(top.shape, np.nan), where=bottom > 0)
    return ratio


def _share(fact: Array, among: Array) -> float:
    return float(fact[among].mean()) if among.any() else float("nan")
