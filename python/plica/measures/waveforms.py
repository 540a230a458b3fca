"""What is stored of every step of a run and of every frame of a recording: units and meanings.

The measures' catalogue says what is made of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

__all__ = ["RECORDED", "SINCE_THE_START", "STORED", "Waveform"]


@dataclass(frozen=True)
class Waveform:
    """One entry.

    Attributes
    ----------
    name : str
    unit : str
        SI, "1" for a pure number, "" for words; of a recording without a scale, `Scale.unit` of this.
    meaning : str
    source : {"run", "video"}
    shown : str
        The unit that people read, where it is not the usual one of `unit`.
    """

    name: str
    unit: str
    meaning: str
    source: Literal["run", "video"]
    shown: str = ""


_run = partial(Waveform, source="run")
_video = partial(Waveform, source="video")

_WAVEFORMS = (
    _run("time", "s", "End of the step, t_{n+1}."),
    _run("iterations", "1", "Of conjugate gradients, over all solves of the step."),
    _run("kinetic_energy", "J", "Of the tissue."),
    _run("elastic_energy", "J", "Of the tissue."),
    _run("load_work", "J", "Work of airflow, loads and gravity since t = 0."),
    _run("viscous_loss", "J", "Energy the tissue's viscosity took since t = 0."),
    _run("numerical_loss", "J", "Energy the time scheme took since t = 0."),
    _run("ledger_error", "J", "What is missing in the balance of the energies, works and losses."),
    _run(
        "inverted_tissue",
        "1",
        "Tissue cells inside out or folded over; with any, stresses there mean nothing.",
    ),
    _run("probes", "m", "Displacement of each probe's node, (steps, probes, 3).", shown="um"),
    _run("flow", "m^3/s", "Volume flow through the glottis."),
    _run("minimum_area", "m^2", "Least section area: the glottal area."),
    _run("separation", "1", "Section of least area, from 0, where the jet leaves the wall."),
    _run("flow_stopped", "1", "1 where contact stops the flow."),
    _run("coupling_sweeps", "1", "Evaluations of the airflow in the step."),
    _run(
        "coupling_residual",
        "1",
        "Largest pressure change of the last sweep, in subglottal pressures; NaN without iteration.",
    ),
    _run("coupling_frozen", "1", "1 where separation and stop of the flow were held for the last sweeps."),
    _run("coupling_converged", "1", "0 where the sweeps ended above the tolerance."),
    _run("section_area", "m^2", "Of each section of the airway, upward, (steps, sections)."),
    _run("section_pressure", "Pa", "In each section, (steps, sections)."),
    _run("coronal_right", "m", "Point of the right fold in the mid-coronal plane at each section."),
    _run("coronal_left", "m", "Point of the left fold in the mid-coronal plane at each section."),
    _run("contact_force_first", "N", "Sum of the contact forces on the first surface, (steps, 3)."),
    _run("contact_force_second", "N", "Sum of the contact forces on the second surface, (steps, 3)."),
    _run("contact_rows", "1", "Closed contact constraints."),
    _run("contact_passes", "1", "Rebuildings of the contact rows in the step."),
    _run("contact_gap_error", "m", "Largest gap error left at the end of the step."),
    _run(
        "contact_slide",
        "1",
        "How far closed nodes have slid along the other surface of a matched airway, at most, in mean edges.",
    ),
    _run("contact_converged", "1", "0 where augmentations ran out with a gap error above the tolerance."),
    _run("contact_area", "m^2", "Of the loaded nodes, mean of both sides."),
    _run(
        "contact_length",
        "m",
        "Anteroposterior, of the deformed fold; a loaded node stands for half the way to its neighbours.",
    ),
    _run(
        "largest_contact_pressure",
        "Pa",
        "Largest nodal pressure of the step: a node's force over its area, friction left out.",
    ),
    _run("deepest_gap", "m", "Worst gap at a node; negative is overlap."),
    _run(
        "overlap_volume",
        "m^3",
        "Of inverted air tetrahedra with a node inside; little worth after sliding in a matched airway.",
    ),
    _run(
        "edge_overlap_volume",
        "m^3",
        "Of inverted air tetrahedra between crossed edges, which no contact row sees; likewise.",
    ),
    _run("largest_multiplier", "N", "Largest pull of a contact force; <= 0 where none is tensile."),
    _run("contact_work", "J", "Work of the contact forces since t = 0, friction's included."),
    _run("friction_loss", "J", "Minus the work of friction in the step."),
    _video("time", "s", "Of the frame."),
    _video("area_total", "m^2", "Glottal area."),
    _video("area_left", "m^2", "Glottal area left of the midline, in the image."),
    _video("area_right", "m^2", "Glottal area right of the midline, in the image."),
    _video(
        "area_least",
        "m^2",
        "Glottal area, had the outline been drawn at 0.4 of the way from the glottis' dark to the tissue.",
    ),
    _video("area_largest", "m^2", "Glottal area, had the outline been drawn at 0.6 of that way."),
    _video(
        "edge_left",
        "m",
        "Mean distance of the left fold's edge from the midline, over the middle tenth of its length.",
    ),
    _video("edge_right", "m", "Mean distance of the right fold's edge from the midline, likewise."),
    _video("phase", "", "Closed, opening, open or closing; nothing outside the cycles."),
    _video("flags", "", "What speaks against the frame."),
    _video("drift_right", "px", "Motion of the picture to the right against the first frame."),
    _video("drift_down", "px", "Motion of the picture downward."),
    _video("drift_turn", "rad", "Rotation of the picture, clockwise."),
    _video(
        "residual",
        "grey levels",
        "Root mean square of what is left of the brightness difference after the motion, on tissue.",
    ),
    _video("warp_error", "grey levels", "The same over the whole frame, after Granados."),
    _video(
        "mismatch",
        "px",
        "Median on the folds of the distance from the start after going to the next frame and back.",
    ),
    _video("mode_coefficients", "px", "Of each principal mode, (frames, modes); positive: the folds part."),
    _video(
        "mode_round_trip", "px", "What going to the next frame and back misses in each mode, (frames, modes)."
    ),
)

STORED = {entry.name: entry for entry in _WAVEFORMS if entry.source == "run"}
"""Of every step of a run."""
SINCE_THE_START = frozenset(name for name, entry in STORED.items() if "since t = 0" in entry.meaning)
"""Those that add up from t = 0 on."""
RECORDED = {entry.name: entry for entry in _WAVEFORMS if entry.source == "video"}
"""Of every frame of a recording."""
