"""Common names of the keys, measures and waveforms of plica."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["SYNONYMS", "names_for"]

_STIFFNESS = ("tissue.NAME.E", "tissue.NAME.E_fibre", "tissue.NAME.mu_fibre", "tissue.NAME.mu_transverse")
_PRESSURE = ("airflow.subglottal_pressure",)

SYNONYMS: dict[str, tuple[str, ...]] = {
    "frequency": ("fundamental_frequency", "loads.frequency"),
    "pitch": ("fundamental_frequency",),
    "stiffness": (*_STIFFNESS, "contact.penalty.stiffness", "contact.augmented.stiffness"),
    "elasticity": _STIFFNESS,
    "modulus": _STIFFNESS,
    "young": _STIFFNESS[:2],
    "young's modulus": _STIFFNESS[:2],
    "shear modulus": _STIFFNESS[2:],
    "poisson": ("tissue.NAME.nu",),
    "poisson's ratio": ("tissue.NAME.nu",),
    "viscosity": ("tissue.NAME.viscosity", "airflow.model.viscous_slit.air_viscosity"),
    "damping": ("tissue.NAME.viscosity", "damping_ratio"),
    "thickness": ("mesh.options.layer_thickness",),
    "length": ("mesh.options.major", "glottal_length"),
    "gap": ("glottal_gap_index", "glottal_gap_relative", "deepest_gap"),
    "pressure": (*_PRESSURE, "section_pressure", "peak_contact_pressure"),
    "lung pressure": _PRESSURE,
    "loudness": _PRESSURE,
    "density": ("tissue.NAME.density", "airflow.air_density"),
    "collision": ("contact", "collisions", "contact_impulse", "peak_contact_pressure"),
    "impact": ("contact_impulse", "peak_contact_pressure"),
    "impact stress": ("peak_contact_pressure",),
    "mucosal wave": ("vertical_phase_difference",),
    "tension": ("tissue.NAME.E_fibre", "tissue.NAME.mu_fibre", "tissue.NAME.left", "tissue.NAME.right"),
    "paresis": ("tissue.NAME.left", "tissue.NAME.right"),
    "asymmetry": (
        "tissue.NAME.left",
        "tissue.NAME.right",
        "amplitude_asymmetry",
        "area_asymmetry",
        "left_right_phase",
    ),
    "phase": ("left_right_phase", "vertical_phase_difference", "phase", "loads.phase"),
    "perturbation": ("jitter", "shimmer"),
    "noise": ("harmonics_to_noise",),
    "area": ("glottal_area_max", "glottal_area_mean", "minimum_area", "area_total"),
    "glottal width": ("coronal_left", "coronal_right", "edge_left", "edge_right"),
    "airflow rate": ("flow", "mean_flow", "peak_flow"),
    "frame rate": ("output.every",),
    "duration": ("time.duration",),
}
"""Common name, in lower case, to the names that ``plica keys`` takes, best match first."""


def names_for(word: str, known: Iterable[tuple[str, str, str]]) -> tuple[str, ...]:
    """The names for a word: from the table, else those with this symbol, or with the word in name or label.

    known: name, symbol and label of all entries.
    """
    asked = " ".join(word.lower().replace("_", " ").replace("-", " ").split())
    if not asked:
        return ()
    if asked in SYNONYMS:
        return SYNONYMS[asked]
    entries = [
        (name, symbol.lower(), f"{name.replace('_', ' ')} {label}".lower()) for name, symbol, label in known
    ]
    return tuple(
        dict.fromkeys(
            [name for name, symbol, _ in entries if symbol == asked]
            or [name for name, _, text in entries if len(asked) > 2 and asked in text]
        )
    )
