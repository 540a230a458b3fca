"""The measures of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plica.measures.contour import medial_surface
from plica.measures.cycles import Cycles, find_cycles
from plica.measures.glottal import area_measures, frequency_measures, over_cycles, quotient_measures
from plica.measures.measure import Measure, Measures, absent, whole
from plica.measures.record import Array, Floats
from plica.measures.run.contact import contact_measures
from plica.measures.run.folds import airway_faces, motion_measures, rest_width
from plica.measures.run.free import free_measures
from plica.measures.run.glottal import flow_measures, open_area, several_summits, strict_open_quotient
from plica.measures.run.run_data import RunData, reached
from plica.measures.run.solver import energy_measures, solver_measures
from plica.measures.run.sound import radiation_measures
from plica.measures.run.tract import tract_measures
from plica.measures.scene_text import scene_table, scene_tables
from plica.units import read_quantity

_HELD = 0.1  # of the supply's pressure, which the mean below the folds may lack without a word

__all__ = ["driving", "fold_length", "measure", "risen", "steady_cycles"]


def steady_cycles(run: RunData) -> Cycles:
    """The steady cycles of a run: of its glottal area, or without airflow of the probe that moves most.

    Parameters
    ----------
    run : RunData

    Returns
    -------
    Cycles
        Empty, with a note that gives the reason, if there are fewer than three.
    """
    time, waveforms = reached(run)
    if not time.size:
        return Cycles(np.empty(0), "no step was computed", "none")
    if "minimum_area" in waveforms:
        first = risen(waveforms)
        area = np.asarray(waveforms["minimum_area"], dtype=float)
        has_course = "course" in (scene_table(run.scene_text, "airflow") or {})
        if 0 < first == time.size - 1 and not has_course:
            return Cycles(np.empty(0), "the subglottal pressure still rises at the end of the record", "none")
        found = find_cycles(time[first:], area[first:], name="glottal area")
        if found.count or not (first and has_course):
            return found
        return find_cycles(time, area, name="glottal area")  # a caution says that the pressure moves
    probes = waveforms.get("probes")
    if probes is not None and probes.size:
        return free_measures(time, waveforms)[1]
    return Cycles(np.empty(0), "no airflow and no probes: nothing to find cycles in", "none")


def risen(waveforms: Mapping[str, Array]) -> int:
    """The first step from which what drives the air stays as it is; what is before is no voice's."""
    changes = np.flatnonzero(np.diff(driving(waveforms)))
    return int(changes[-1]) + 1 if changes.size else 0


def driving(waveforms: Mapping[str, Array]) -> Array:
    """What drives the air at each step, in any unit; empty where it does not change."""
    return np.asarray(waveforms.get("supply_rise", waveforms.get("subglottal_pressure", ())), dtype=float)


def measure(run: RunData, cycles: Cycles | None = None) -> Measures:
    """All measures of a run, in SI units.

    Parameters
    ----------
    run : RunData
        Finished, interrupted or failed; the computed steps are used.
    cycles : Cycles, optional
        Cycles of the glottal area to average over; default: the steady ones.

    Returns
    -------
    Measures
        By name. A part that the scene does not have gives no entries; a quantity that this run does not
        determine has the value None and a note with the reason.
    """
    time, waveforms = reached(run)
    if not time.size:
        return Measures([whole("steps", 0, "no step was computed")])
    found: list[Measure] = []
    cycles = run.cycles if cycles is None else cycles
    if "minimum_area" in waveforms:
        area = open_area(waveforms)
        found += frequency_measures(time, np.asarray(waveforms["minimum_area"], dtype=float), cycles)
        several = several_summits(area, time, cycles)
        found += [
            item if item.value is None else replace(item, cautions=(*item.cautions, *several))
            for item in (
                *quotient_measures(time, area, cycles),
                strict_open_quotient(time, area, cycles),
            )
        ]
        found += area_measures(time, area, cycles)
        found += flow_measures(time, np.asarray(waveforms["flow"], dtype=float), cycles)
        height = np.asarray(run.section_height, dtype=float)
        motion = motion_measures(time, waveforms, cycles, medial_surface(rest_width(run), height), height)
        found += [_unless_mirrored(item, run.scene_text) for item in motion]
        found += (given := _subglottal_pressure(run.scene_text, waveforms, time, cycles))
        supply = given[0].value if given else None
        heard = radiation_measures(time, waveforms, run.scene_text, cycles, supply)
        found += heard
        if run.vocal_tract is not None:
            found += tract_measures(run.vocal_tract, {item.name: item for item in heard}, cycles)
    elif "probes" in waveforms and waveforms["probes"].size:
        found += free_measures(time, waveforms)[0]
    if cycles.count and "strain_999" in waveforms:
        strain = np.asarray(waveforms["strain_999"], dtype=float)
        found.append(over_cycles("peak_strain", time, strain, cycles, np.max))
    if "contact_force_first" in waveforms:
        found += contact_measures(time, waveforms, cycles, fold_length(run))
    found += [*energy_measures(waveforms), *solver_measures(time, waveforms, len(run.mesh.cells))]
    return Measures(_doubted(item, run.scene_text) for item in found)


def _doubted(item: Measure, scene_text: str) -> Measure:
    """The measure with its reason among the cautions, if it does not converge in this run."""
    reason = item.quantity.no_limit
    if item.value is None or not reason:
        return item
    if item.quantity.no_limit_of == "surfaces with mass" and _massless(scene_text):
        return item
    return replace(item, no_limit=reason, cautions=(*item.cautions, reason))


def _unless_mirrored(item: Measure, scene_text: str) -> Measure:
    """The measure, without a value if it compares folds that are each other's image by symmetry."""
    if item.quantity.side not in ("ratio", "difference") or "symmetry" not in scene_tables(scene_text):
        return item
    return absent(item.name, "the scene's symmetry imposes it: one fold is the image of the other")


def _massless(scene_text: str) -> bool:
    """Whether the contact surfaces have no mass; where that is not known, they have."""
    return (scene_table(scene_text, "contact") or {}).get("surface_mass") == "redistributed"


def fold_length(run: RunData) -> float | None:
    """Anteroposterior length of the folds (m): of the section that is narrowest at rest, else of the airway.

    Parameters
    ----------
    run : RunData

    Returns
    -------
    float or None
        None if there is neither an airflow nor a surface named airway.
    """
    major = np.asarray(run.section_major, dtype=float)
    if major.size and len(run.time) and (width := rest_width(run)).size:
        return 2.0 * float(major[int(np.argmin(width))])
    surface = airway_faces(run)
    if surface is None:
        return None
    return float(np.ptp(np.asarray(run.mesh.points)[np.unique(surface), 1]))


def _subglottal_pressure(
    scene_text: str, waveforms: Mapping[str, Array], time: Floats, cycles: Cycles
) -> list[Measure]:
    airflow = scene_table(scene_text, "airflow") or {}
    try:
        value = read_quantity(airflow["subglottal_pressure"], "Pa")
    except (KeyError, ValueError):
        return []  # unknown for a run that was not made from a scene file
    if "course" in airflow:
        share = driving(waveforms) / (1.0 if "supply_rise" in waveforms else value)
        return [whole("subglottal_pressure", value * float(share[cycles.extent(time)].mean()))]
    supply = (scene_table(scene_text, "trachea") or {}).get("supply")
    if isinstance(supply, dict) and "flow" in supply:
        return []  # follows from the flow
    if "supply_rise" in waveforms:
        largest = value * float(np.max(waveforms["supply_rise"]))
    else:
        largest = float(np.max(waveforms.get("subglottal_pressure", value)))
    said = []
    if largest < (1 - 1e-9) * value:
        said.append(f"not reached: {largest:.4g} Pa at the end of the record, where it still rises")
    elif "trachea" in scene_tables(scene_text) and "subglottal_pressure" in waveforms:
        below = np.asarray(waveforms["subglottal_pressure"], dtype=float)
        mean = float(below[cycles.extent(time)].mean())
        if mean < (1 - _HELD) * value:
            said.append(
                f"of the supply: what arrives right below the folds is {mean:.4g} Pa in the mean, as the "
                "flow takes the rest at the trachea's end (trachea.supply) and along it"
            )
    return [whole("subglottal_pressure", value, cautions=said)]
