"""What is stored every step: units and meanings."""

from __future__ import annotations

__all__ = ["SINCE_THE_START", "WAVEFORM_MEANINGS", "WAVEFORM_UNITS"]

_WAVEFORMS = {
    "time": ("s", "End of the step, t_{n+1}."),
    "iterations": ("1", "Of conjugate gradients, over all solves of the step."),
    "kinetic_energy": ("J", "Of the tissue."),
    "elastic_energy": ("J", "Of the tissue."),
    "load_work": ("J", "Work of airflow, loads and gravity since t = 0."),
    "viscous_loss": ("J", "Energy the tissue's viscosity took since t = 0."),
    "numerical_loss": ("J", "Energy the time scheme took since t = 0."),
    "ledger_error": ("J", "What is missing in the balance of the energies, works and losses."),
    "inverted_tissue": (
        "1",
        "Tissue cells inside out or folded over; with any, stresses there mean nothing.",
    ),
    "probes": ("m", "Displacement of each probe's node, (steps, probes, 3)."),
    "flow": ("m^3/s", "Volume flow through the glottis."),
    "minimum_area": ("m^2", "Least section area: the glottal area."),
    "separation": ("1", "Section of least area, from 0, where the jet leaves the wall."),
    "flow_stopped": ("1", "1 where contact stops the flow."),
    "coupling_sweeps": ("1", "Evaluations of the airflow in the step."),
    "coupling_residual": (
        "1",
        "Largest pressure change of the last sweep, in subglottal pressures; NaN without iteration.",
    ),
    "coupling_frozen": ("1", "1 where separation and stop of the flow were held for the last sweeps."),
    "coupling_converged": ("1", "0 where the sweeps ended above the tolerance."),
    "section_area": ("m^2", "Of each section of the airway, upward, (steps, sections)."),
    "section_pressure": ("Pa", "In each section, (steps, sections)."),
    "coronal_right": ("m", "Point of the right fold in the mid-coronal plane at each section."),
    "coronal_left": ("m", "Point of the left fold in the mid-coronal plane at each section."),
    "contact_force_first": ("N", "Sum of the contact forces on the first surface, (steps, 3)."),
    "contact_force_second": ("N", "Sum of the contact forces on the second surface, (steps, 3)."),
    "contact_rows": ("1", "Closed contact constraints."),
    "contact_passes": ("1", "Rebuildings of the contact rows in the step."),
    "contact_gap_error": ("m", "Largest gap error left at the end of the step."),
    "contact_slide": (
        "1",
        "How far closed nodes have slid along the other surface of a matched airway, at most, in mean edges.",
    ),
    "contact_converged": ("1", "0 where augmentations ran out with a gap error above the tolerance."),
    "contact_area": ("m^2", "Of the loaded nodes, mean of both sides."),
    "contact_length": ("m", "Anteroposterior; a loaded node stands for half the way to its neighbours."),
    "peak_contact_pressure": ("Pa", "Largest nodal force over the node's area, friction left out."),
    "deepest_gap": ("m", "Worst gap at a node; negative is overlap."),
    "overlap_volume": (
        "m^3",
        "Of inverted air tetrahedra with a node inside; little worth after sliding in a matched airway.",
    ),
    "edge_overlap_volume": (
        "m^3",
        "Of inverted air tetrahedra between crossed edges, which no contact row sees; likewise.",
    ),
    "largest_multiplier": ("N", "Largest pull of a contact force; <= 0 where none is tensile."),
    "contact_work": ("J", "Work of the contact forces since t = 0, friction's included."),
    "friction_loss": ("J", "Minus the work of friction in the step."),
}
WAVEFORM_UNITS = {name: unit for name, (unit, _) in _WAVEFORMS.items()}
WAVEFORM_MEANINGS = {name: meaning for name, (_, meaning) in _WAVEFORMS.items()}
SINCE_THE_START = frozenset(name for name, meaning in WAVEFORM_MEANINGS.items() if "since t = 0" in meaning)
"""Those that add up from t = 0 on."""
