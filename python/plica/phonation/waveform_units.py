"""Units of what is stored every step."""

from __future__ import annotations

__all__ = ["WAVEFORM_UNITS"]

WAVEFORM_UNITS = {
    "time": "s",
    "iterations": "1",
    "kinetic_energy": "J",
    "elastic_energy": "J",
    "load_work": "J",
    "viscous_loss": "J",
    "numerical_loss": "J",
    "ledger_error": "J",
    "inverted_tissue": "1",
    "probes": "m",
    "flow": "m^3/s",
    "minimum_area": "m^2",
    "separation": "1",
    "flow_stopped": "1",
    "coupling_sweeps": "1",
    "coupling_residual": "1",
    "coupling_frozen": "1",
    "coupling_converged": "1",
    "section_area": "m^2",
    "section_pressure": "Pa",
    "coronal_right": "m",
    "coronal_left": "m",
    "contact_force_first": "N",
    "contact_force_second": "N",
    "contact_rows": "1",
    "contact_passes": "1",
    "contact_area": "m^2",
    "contact_length": "m",
    "peak_contact_pressure": "Pa",
    "deepest_gap": "m",
    "overlap_volume": "m^3",
    "edge_overlap_volume": "m^3",
    "largest_multiplier": "N",
    "contact_work": "J",
}
