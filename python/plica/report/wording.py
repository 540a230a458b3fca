"""Names and units in which people read the measures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plica.measures.measure import Measure

# SI unit: (factor, unit for people).
people: dict[str, tuple[float, str]] = {
    "m^3/s": (1e6, "cm³/s"),
    "m^3": (1e9, "mm³"),
    "m^2": (1e6, "mm²"),
    "m": (1e3, "mm"),
    "s": (1e3, "ms"),
    "Pa": (1e-3, "kPa"),
    "N": (1e3, "mN"),
    "N s": (1e6, "µN s"),
    "J": (1e6, "µJ"),
    "rad": (180 / math.pi, "°"),
    "1": (1.0, ""),
}
special: dict[str, tuple[float, str]] = {
    "deepest_gap": (1e6, "µm"),
    "time_step": (1e6, "µs"),
    "largest_multiplier": (1e6, "µN"),
}

groups: dict[str, dict[str, str]] = {
    "Vibration": {
        "fundamental_frequency": "Fundamental frequency",
        "fundamental_frequency_autocorrelation": "… by autocorrelation",
        "period": "Period",
        "amplitude_growth": "Growth per cycle",
        "damping_ratio": "Damping ratio",
        "probe_amplitude": "Amplitude of the probe",
        "open_quotient": "Open quotient",
        "speed_quotient": "Speed quotient",
        "closing_quotient": "Closing quotient",
        "amplitude_left": "Amplitude, left fold",
        "amplitude_right": "Amplitude, right fold",
        "amplitude_ratio": "Amplitude ratio",
        "amplitude_asymmetry": "Amplitude asymmetry",
        "left_right_phase": "Left–right phase",
        "vertical_phase_difference": "Vertical phase difference",
        "converging_while_opening": "Converging while opening",
        "diverging_while_closing": "Diverging while closing",
    },
    "Airflow": {
        "subglottal_pressure": "Subglottal pressure",
        "peak_flow": "Peak flow",
        "mean_flow": "Mean flow",
        "minimum_flow": "Least flow",
        "glottal_area_max": "Largest glottal area",
        "glottal_area_mean": "Mean glottal area",
    },
    "Contact": {
        "collisions": "Collisions",
        "contact_impulse": "Impulse per collision",
        "contact_duration": "Duration of a collision",
        "contact_force_left_peak": "Peak force, left fold",
        "contact_force_right_peak": "Peak force, right fold",
        "contact_force_left_mean": "Mean force, left fold",
        "contact_force_right_mean": "Mean force, right fold",
        "contact_force_balance": "Imbalance of the forces",
        "contact_area_max": "Largest contact area",
        "contact_length_max": "Largest contact length",
        "contact_length_fraction": "… of the fold length",
        "peak_contact_pressure": "Peak contact pressure",
        "peak_contact_pressure_step": "… of a single step",
        "deepest_gap": "Deepest gap",
        "overlap_volume_max": "Largest overlap",
        "edge_overlap_volume_max": "Largest overlap, edge to edge",
        "largest_multiplier": "Largest multiplier",
    },
    "Energy": {
        "kinetic_energy": "Kinetic energy",
        "elastic_energy": "Elastic energy",
        "load_work": "Work of the loads",
        "viscous_loss": "Viscous loss",
        "numerical_loss": "Numerical loss",
        "contact_work": "Work of the contact",
        "ledger_error": "Ledger error",
    },
    "Solver": {
        "steps": "Steps",
        "time_step": "Time step",
        "duration": "Time simulated",
        "mean_iterations": "Iterations per step",
        "largest_iterations": "… at most",
        "mean_coupling_sweeps": "Coupling sweeps per step",
        "coupling_frozen_fraction": "Steps with a frozen coupling",
        "coupling_converged_fraction": "Steps with a converged coupling",
        "mean_contact_passes": "Contact passes per step",
        "inverted_tissue_max": "Inverted tissue cells, at most",
    },
}
headline = (
    "fundamental_frequency",
    "open_quotient",
    "peak_flow",
    "contact_impulse",
    "contact_length_fraction",
    "damping_ratio",
)


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    name: str
    label: str
    value: str
    unit: str
    spread: str
    cycles: str
    note: str


def number(value: float, digits: int = 4) -> str:
    """A number of so many significant digits, with a true minus and powers of ten where they are shorter."""
    if not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)) + 1e-12)
    if value == round(value) and abs(value) < 1e7:
        text = f"{round(value)}"
    elif -4 <= exponent < 6:
        text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
    else:
        mantissa, power = f"{value:.{min(digits, 3) - 1}e}".split("e")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa} × 10{raised}"
    return text.replace("-", "−")


def row(name: str, label: str, item: Measure) -> Row:
    """A measure in the unit in which people read it."""
    factor, unit = special.get(name) or people.get(item.unit, (1.0, item.unit))
    value = "–" if item.value is None else number(factor * item.value)
    spread = "" if item.spread is None else number(factor * item.spread, 2)
    if item.spread is not None and item.value and abs(item.spread) < 1e-9 * abs(item.value):
        spread = "0"  # round-off
    cycles = str(item.cycles) if item.cycles else ""
    return Row(name, label, value, unit if item.value is not None else "", spread, cycles, item.note)


def tables(measures: Mapping[str, Measure]) -> list[tuple[str, list[Row]]]:
    """The measures that this run has, by group."""
    named = {name for labels in groups.values() for name in labels}
    found = [
        (title, [row(name, label, measures[name]) for name, label in labels.items() if name in measures])
        for title, labels in groups.items()
    ]
    others = [row(name, name.replace("_", " "), item) for name, item in measures.items() if name not in named]
    return [(title, rows) for title, rows in [*found, ("Other", others)] if rows]


def headlines(measures: Mapping[str, Measure]) -> Sequence[Row]:
    """The few figures at the head of the page."""
    labels = {name: label for group in groups.values() for name, label in group.items()}
    labels["contact_length_fraction"] = "Contact length, share of fold"
    return [row(name, labels[name], measures[name]) for name in headline if name in measures]
