"""Measures of the motion of the two folds in the mid-coronal plane.

Half-widths are the distances of the points of the right and of the left fold from the midline, which is
computed from the folds, wherever the mesh is. Both increase as the glottis opens.
The glottal canal, which figures show, is the range of sections around the narrowest one whose width at rest
is at most 1.5 times the smallest.
The medial surface is that of `plica.measures.contour`, in whole sections.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plica.measures.contour import coronal_contours
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, absent, per_cycle_angle, per_period
from plica.measures.record import Array, Floats
from plica.measures.run.glottal import open_area
from plica.measures.run.run_data import RunData
from plica.measures.scene_text import airway_name
from plica.measures.sides import lags, side_measures
from plica.measures.thresholds import closed_share_1_percent

canal_width = 1.5  # largest width of the glottal canal at rest, relative to the least


def midline(waveforms: Mapping[str, Array]) -> tuple[float, float]:
    """x (m) halfway between the folds in the first step, and 1 if x increases to the right, else -1."""
    right, left = (
        np.asarray(waveforms[f"coronal_{side}"], dtype=float)[0, :, 0] for side in ("right", "left")
    )
    return 0.5 * float(np.mean(right + left)), 1.0 if np.sum(right - left) >= 0 else -1.0


def half_widths(
    waveforms: Mapping[str, Array], sections: slice | list[int] = slice(None)
) -> tuple[Floats, Floats]:
    """Half-widths (k, s) m of the right and of the left fold, at all sections or at these."""
    middle, toward_right = midline(waveforms)
    right, left = (
        np.asarray(waveforms[f"coronal_{side}"], dtype=float)[:, sections, 0] for side in ("right", "left")
    )
    return toward_right * (right - middle), toward_right * (middle - left)


def airway_faces(run: RunData) -> Array | None:
    """Faces (f, 3 or 6) of the surface that the airflow is in, or of the one named airway; None without."""
    return run.mesh.surfaces.get(airway_name(run.scene_text))


def rest_width(run: RunData) -> Floats:
    """Width (s) m of the airway in its mid-coronal plane at the sections, in the reference position.

    Cut from the airflow's surface, halfway between its smallest and largest y; the fold at larger x is
    the one whose faces point to smaller x. Without that surface, the width in the first step.
    """
    surface = airway_faces(run)
    if surface is None:
        right, left = half_widths(run.waveforms)
        return np.asarray(right[0] + left[0], dtype=float)
    height = run.section_height
    larger, smaller = (
        np.interp(height, line[:, 0], line[:, 1])
        for line in coronal_contours(np.asarray(run.mesh.points, dtype=float), np.asarray(surface))
    )
    return np.asarray(larger - smaller)


def glottal_canal(width: Floats) -> slice:
    """Range of sections that form the glottal canal, from the widths at rest (see the module docstring)."""
    narrow = width <= canal_width * width.min()
    low = high = int(np.argmin(width))
    while low > 0 and narrow[low - 1]:
        low -= 1
    while high + 1 < width.size and narrow[high + 1]:
        high += 1
    return slice(low, high + 1)


def motion_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, medial: slice, height: Floats
) -> list[Measure]:
    """Amplitudes of both folds, their ratio and asymmetry, and phases between folds and between edges.

    Parameters
    ----------
    time, waveforms, cycles
        Of the computed steps.
    medial : slice
        Sections of the medial surface.
    height : (s) m
        Of the sections.
    """
    steady = cycles.extent(time)
    paths = (np.array(waveforms[f"coronal_{side}"][steady, :, 0]) for side in ("right", "left"))
    section = int(np.argmax(sum(np.ptp(path, axis=0) for path in paths)))
    right, left = (width[:, 0] for width in half_widths(waveforms, [section]))
    where = place(section, medial, height)
    found = side_measures(time, left, right, cycles, (where, where))
    return found + _medial_measures(time, waveforms, cycles, medial, height)


def place(section: int, medial: slice, height: Floats) -> str:
    """Where a section is, as text: its height, and where that is on the medial surface.

    Parameters
    ----------
    section : int
    medial : slice
        Sections of the medial surface.
    height : (s) m
        Of the sections.
    """
    z, low, high = (1e3 * float(height[k]) for k in (section, medial.start, medial.stop - 1))
    at = f"at z = {z:.3g} mm"
    if z > high:
        return f"{at}, {z - high:.2g} mm above the superior edge of the medial surface"
    if z < low:
        return f"{at}, {low - z:.2g} mm below the inferior edge of the medial surface"
    return f"{at}, on the medial surface"


def vertical_phase(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, medial: slice, height: Floats
) -> Measure:
    """How far the superior edge of the medial surface lags the inferior one; parameters as of
    :func:`motion_measures`."""
    name = "vertical_phase_difference"
    reason = _not_medial(cycles, medial)
    if reason:
        return absent(name, reason)
    lower, upper = _edges(waveforms, medial)
    return per_cycle_angle(name, cycles, lags(time, lower, upper, cycles), _edge_heights(medial, height))


def _not_medial(cycles: Cycles, medial: slice) -> str:
    """Why there is nothing to measure of the medial surface; empty if there is."""
    if not cycles.count:
        return cycles.note
    if medial.stop - medial.start < 2:
        return "no medial surface: the folds' contour at rest is not vertical at the narrowest section"
    return ""


def _edges(waveforms: Mapping[str, Array], medial: slice) -> tuple[Floats, Floats]:
    """Width (k) m of the airway at the inferior and at the superior edge."""
    width = np.add(*half_widths(waveforms, [medial.start, medial.stop - 1]))
    return width[:, 0], width[:, 1]


def _edge_heights(medial: slice, height: Floats) -> str:
    bottom, top = (1e3 * float(height[k]) for k in (medial.start, medial.stop - 1))
    return f"inferior edge at z = {bottom:.3g} mm, superior edge at {top:.3g} mm"


def _medial_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles, medial: slice, height: Floats
) -> list[Measure]:
    phase = vertical_phase(time, waveforms, cycles, medial, height)
    phase = replace(phase, cautions=(*phase.cautions, *inferior_lag(phase)))
    names, reason = ("converging_while_opening", "diverging_while_closing"), _not_medial(cycles, medial)
    if reason:
        return [phase, *(absent(name, reason) for name in names)]
    lower, upper = _edges(waveforms, medial)
    area = open_area(waveforms)
    rate = np.gradient(area, time)
    opening, closing = [], []
    for part in cycles.samples(time):
        opened = area[part] > closed_share_1_percent * area[part].max()
        slope = lower[part] - upper[part]
        opening.append(_share(slope > 0, opened & (rate[part] > 0)))
        closing.append(_share(slope < 0, opened & (rate[part] < 0)))
    edges = _edge_heights(medial, height)
    return [
        phase,
        *(
            per_period(name, cycles, np.array(shares), edges)
            for name, shares in zip(names, (opening, closing), strict=True)
        ),
    ]


def inferior_lag(phase: Measure) -> list[str]:
    """A caution if the inferior edge of the medial surface lags, by more than the scatter of the cycles.

    Parameters
    ----------
    phase : Measure
        vertical_phase_difference.
    """
    if phase.value is None or not phase.value < -(phase.spread or 0.0):
        return []
    return [
        f"the inferior edge lags the superior one by {np.degrees(-phase.value):.3g} degrees: in a modal "
        "voice it leads, so that this is another pattern of vibration"
    ]


def _share(fact: Array, among: Array) -> float:
    return float(fact[among].mean()) if among.any() else float("nan")
