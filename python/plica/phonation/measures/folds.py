"""Measures of the motion of the two folds in the mid-coronal plane.

Half-widths are x of the right fold's point and -x of the left one's, so that both grow as the glottis opens.
The glottal canal is the range of sections about the narrowest one whose width at rest is at most 1.5 times
the least; its lowest section is the lower edge and its highest the upper edge.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plica.measures.catalogue import closed_share_1_percent
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, per_cycle, per_cycle_angle
from plica.measures.record import Array, Floats
from plica.measures.sides import lags, side_measures
from plica.phonation.measures.glottal import open_area
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


def motion_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, canal: slice
) -> list[Measure]:
    """Amplitudes of both folds, their ratio and asymmetry, the phase between them and between the edges."""
    right, left = half_widths(waveforms)
    steady = cycles.extent(time)
    section = int(np.argmax(np.ptp(right[steady], axis=0) + np.ptp(left[steady], axis=0)))
    where = f"section {section}"
    found = side_measures(time, left[:, section], right[:, section], cycles, (where, where))
    return found + _canal_measures(time, waveforms, cycles, canal)


def _canal_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, canal: slice
) -> list[Measure]:
    names = ("vertical_phase_difference", "converging_while_opening", "diverging_while_closing")
    if not cycles.count:
        return [absent(name, cycles.note) for name in names]
    if canal.stop - canal.start < 2:
        return [absent(name, "the glottal canal has a single section") for name in names]
    right, left = half_widths(waveforms)
    lower, upper = (right + left)[:, canal.start], (right + left)[:, canal.stop - 1]
    area = open_area(waveforms)
    rate = np.gradient(area, time)
    opening, closing = [], []
    for part in cycles.samples(time):
        opened = area[part] > closed_share_1_percent * area[part].max()
        slope = lower[part] - upper[part]
        opening.append(_share(slope > 0, opened & (rate[part] > 0)))
        closing.append(_share(slope < 0, opened & (rate[part] < 0)))
    edges = f"sections {canal.start} and {canal.stop - 1}"
    return [
        per_cycle_angle("vertical_phase_difference", cycles, lags(time, lower, upper, cycles), edges),
        per_cycle("converging_while_opening", cycles, np.array(opening), edges),
        per_cycle("diverging_while_closing", cycles, np.array(closing), edges),
    ]


def _share(fact: Array, among: Array) -> float:
    return float(fact[among].mean()) if among.any() else float("nan")
