"""Cells of tissue that were inside out: how many, where and when, and what of a run is then no result."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from plica.measures.caution import Caution
from plica.measures.record import Array
from plica.measures.run.measure import risen
from plica.measures.run.run_data import RunData, reached
from plica.units import two_digits

__all__ = ["inverted_cells", "linear_error"]

_NO_MEANING = "Strain and stress of an inverted cell have no meaning, nor has the pressure of contact on it"
_ANY_CELL = 0.5
"""The error of linear tissue, half of |grad u|, from which on more of the tissue may be inverted than the
0.1 % that its percentile leaves out: where |grad u| < 1 none is (docs/theory/tissue.md, "Large strains")."""


def inverted_cells(run: RunData) -> Caution | None:
    """Tissue cells were inside out or folded over at any time. In the cycles measured (the whole run if there
    are none) their strain, stress and contact pressure have no meaning; from an error of the linear tissue
    model of 50 % on they may be more than 0.1 % of the tissue's volume, and nothing of the run is a result.
    """
    time, waveforms = reached(run)
    inverted = np.asarray(waveforms.get("inverted_tissue", np.zeros(time.size)))
    if not inverted.any():
        return None
    cycles = run.cycles
    part = cycles.extent(time) if cycles.count else slice(0, time.size)
    within = inverted[part]
    counted = part if within.any() else slice(0, time.size)
    worst = counted.start + int(inverted[counted].argmax())
    count = int(inverted[worst])
    seen = (
        f"{count} of {len(run.mesh.cells)} cells {'was' if count == 1 else 'were'} inverted at "
        f"{1e3 * time[worst]:.3g} ms{_layers(run, waveforms, worst)}"
    )
    measured = (
        f"the {cycles.count} cycles measured" if cycles.count else "the run, in which no cycles were measured"
    )
    if within.any():
        share = two_digits(100 * float(np.mean(within > 0)))
        seen += f", the most within {measured}; in {share} % of that time some were"
        return Caution("inverted_cells", f"{seen}.", _advice_within(waveforms, part))
    seen += f", the most of the run; none in {measured}"
    advice = f"{_NO_MEANING}, but no measure of the cycles is of one."
    if "deepest_gap" in waveforms:
        advice += " Contact may have failed at them: see that deepest_gap is near zero in the cycles."
    return Caution("inverted_cells", f"{seen}.", f"{advice}{_slower_start(waveforms)}")


def _layers(run: RunData, waveforms: Mapping[str, Array], step: int) -> str:
    """`` (3 in the cover, 1 in the body)``; nothing of a run that has not recorded it."""
    if "inverted_by_layer" not in waveforms:
        return ""
    counts = np.asarray(waveforms["inverted_by_layer"])[step]
    order = [k for k in np.argsort(-counts, kind="stable") if counts[k]]
    return f" ({', '.join(f'{counts[k]} in the {run.mesh.layer_names[k]}' for k in order)})"


def linear_error(neglected: float) -> float:
    """[-] Of the linear tissue model, |E - eps| over |grad u|, by the neglected part of Green and Lagrange's
    strain, the waveform `strain_neglected` (docs/theory/tissue.md)."""
    return math.sqrt(neglected / 2)


def _advice_within(waveforms: Mapping[str, Array], part: slice) -> str:
    cause = "subglottal pressure" if "minimum_area" in waveforms else "initial velocity or load"
    until = f"Use a lower {cause}, or stiffer tissue, until none is inverted."
    if "nonlinear_loss" in waveforms:  # at finite strain
        rest = (
            "Tissue at finite strain is not inside out where its force is summed, but at a node, between "
            "such points: the mesh is too coarse there."
        )
        return f"{_NO_MEANING}: use none of these. {rest} {until}"
    neglected = np.asarray(waveforms.get("strain_neglected", np.zeros(part.stop)), dtype=float)[part]
    error = linear_error(float(neglected.max()))
    off = f"linear tissue, which is off by {two_digits(100 * error)} % where it is strained most"
    if error >= _ANY_CELL:
        rest = f"Of {off}, more than 0.1 % of the volume may be inverted: nothing of this run is a result."
    else:
        rest = (
            f"Less than 0.1 % of the tissue's volume is strained so much: motion and flow are those of {off}."
        )
    return f"{_NO_MEANING}: use none of these. {rest} {until}"


def _slower_start(waveforms: Mapping[str, Array]) -> str:
    if "minimum_area" not in waveforms or risen(waveforms):
        return ""
    return " A pressure that rises within a period of the slowest mode (airflow.rise) strains the start less."
