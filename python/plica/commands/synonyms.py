"""Common names of the keys, measures and waveforms of plica."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["NOT_MODELLED", "SYNONYMS", "names_for", "not_modelled"]

_STIFFNESS = ("tissue.NAME.E", "tissue.NAME.E_fibre", "tissue.NAME.mu_fibre", "tissue.NAME.mu_transverse")
_PRESSURE = ("airflow.subglottal_pressure",)
_MUSCLES = ("posture.muscles", "posture.elongation", "posture.active_stress")
_LESION = ("mesh.folds.lesions", "mesh.folds.lesions.stiffness", "mesh.folds.lesions.protrusion")
_ASIDE = ("mesh.folds.left_gap", "mesh.folds.right_gap", "tissue.NAME.left", "tissue.NAME.right")
_SOUND = ("sound_pressure_level", "glottal_efficiency", "sound_h1_h2", "sound_cepstral_peak_prominence")

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
    "thickness": ("mesh.folds.thickness", "mesh.folds.cover", "mesh.options.layer_thickness"),
    "length": ("mesh.folds.length", "mesh.options.major", "glottal_length"),
    "gap": ("mesh.folds.gap", "glottal_gap_index", "glottal_gap_relative", "deepest_gap"),
    "pressure": (*_PRESSURE, "section_pressure", "peak_contact_pressure"),
    "lung pressure": _PRESSURE,
    **dict.fromkeys(("cm h2o", "cmh2o", "hpa", "mmhg"), _PRESSURE),
    "threshold pressure": _PRESSURE,
    "phonation threshold pressure": _PRESSURE,
    "density": ("tissue.NAME.density", "airflow.air_density"),
    "collision": ("contact", "collisions", "contact_impulse", "peak_contact_pressure"),
    "impact": ("contact_impulse", "peak_contact_pressure"),
    "impact stress": ("peak_contact_pressure",),
    "mucosal wave": ("vertical_phase_difference",),
    "tension": ("tissue.NAME.E_fibre", "tissue.NAME.mu_fibre", "tissue.NAME.left", "tissue.NAME.right"),
    **dict.fromkeys(("paresis", "paralysis", "lateral fold"), _ASIDE),
    **dict.fromkeys(("lesion", "polyp", "nodule", "nodules", "cyst", "scar", "oedema", "edema"), _LESION),
    **dict.fromkeys(("chink", "posterior gap", "posterior chink"), ("mesh.folds.posterior_chink",)),
    "asymmetry": (
        "tissue.NAME.left",
        "tissue.NAME.right",
        "amplitude_asymmetry",
        "area_asymmetry",
        "left_right_phase",
    ),
    "phase": ("left_right_phase", "vertical_phase_difference", "phase", "loads.phase"),
    "perturbation": ("jitter", "shimmer", "sound_jitter", "sound_shimmer"),
    "noise": ("harmonics_to_noise", "sound_harmonics_to_noise"),
    **dict.fromkeys(("sound", "sound pressure", "acoustics", "microphone"), _SOUND),
    "loudness": (*_SOUND[:1], *_PRESSURE),
    "spectral tilt": (
        "flow_h1_h2",
        "flow_h2_h4",
        "sound_h1_h2",
        "sound_h2_h4",
        "sound_h1_h2_corrected",
        "sound_h2_h4_corrected",
    ),
    "h1 h2": ("flow_h1_h2", "sound_h1_h2"),
    "cpp": ("sound_cepstral_peak_prominence", "cepstral_peak_prominence"),
    "hnr": ("sound_harmonics_to_noise", "harmonics_to_noise"),
    "efficiency": ("glottal_efficiency",),
    "area": ("glottal_area_max", "glottal_area_mean", "minimum_area", "area_total"),
    "glottal width": ("coronal_left", "coronal_right", "edge_left", "edge_right"),
    "airflow rate": ("flow", "mean_flow", "peak_flow"),
    "glottal flow": ("flow", "mean_flow", "peak_flow"),
    "flow declination": ("maximum_flow_declination_rate", "normalised_amplitude_quotient"),
    "frame rate": ("output.every",),
    **dict.fromkeys(("one fold", "hemilarynx", "midplane"), ("mesh.mirror", "symmetry")),
    "duration": ("time.duration",),
    **dict.fromkeys(
        ("vocal tract", "supraglottal tract", "formant", "formants", "resonance"), ("tract", "formant_1")
    ),
    "vowel": ("tract.vowel.name", "tract"),
    "subglottal tract": ("trachea",),
    "lungs": (*_PRESSURE, "trachea.supply"),
    "supraglottal pressure": ("supraglottal_pressure", "tract"),
    "posturing": ("posture.elongation", "posture.muscles"),
    "stretch": ("posture.elongation", "tissue.NAME.stiffening", "tissue.NAME.matrix_stiffening"),
    **dict.fromkeys(("muscle", "muscle activation", "activation"), _MUSCLES),
    "ct": ("posture.muscles.cricothyroid",),
    "ta": ("posture.muscles.thyroarytenoid", "posture.active_stress"),
    **dict.fromkeys(("lca", "lateral cricoarytenoid"), ("posture.muscles.lateral_cricoarytenoid",)),
    **dict.fromkeys(
        ("large strain", "nonlinear", "hyperelastic", "geometric nonlinearity"), ("strain", "nonlinear_loss")
    ),
    **dict.fromkeys(("radiation", "lip radiation"), ("radiated_energy", "lip_flow", "tract.end")),
}
"""Common name, in lower case, to the names that ``plica keys`` takes, best match first."""


_ADDUCTION = (
    "arytenoids do not turn and muscles do not move in a run: the gap and the length of the folds are given",
    ("mesh.folds.gap", "mesh.folds.medial_angle", "posture.elongation"),
)
_JET = (
    "the air is one-dimensional: there is no turbulence, no vortex, and no resolved jet",
    ("airflow.model", "flow", "separation"),
)
_SURFACE = (
    "no liquid layer and no adhesion are modelled: surfaces only push",
    ("contact", "contact.friction"),
)
_FOLDS = (
    "only the true vocal folds are modelled; another shape can be given as a mesh file",
    ("mesh.file", "mesh.options.sections"),
)
NOT_MODELLED: dict[str, tuple[str, tuple[str, ...]]] = {
    **dict.fromkeys(
        (
            "adduction",
            "medialization",
            "thyroplasty",
            "abduction",
            "arytenoid",
            "arytenoids",
            "pca",
            "ia",
            "strap muscles",
        ),
        _ADDUCTION,
    ),
    **dict.fromkeys(("turbulence", "vortex", "vortices", "jet", "jet noise", "navier stokes", "cfd"), _JET),
    **dict.fromkeys(("mucus", "adhesion", "liquid layer", "surface liquid", "hydration"), _SURFACE),
    **dict.fromkeys(("ventricular folds", "false folds", "epiglottis", "ventricle"), _FOLDS),
}
"""Words of the field, in lower case, that plica does not model: the sentence that says so, and the names that
``plica keys`` takes of what is nearest to it."""


def not_modelled(word: str) -> str:
    """What to say of a word whose matter is not modelled, or an empty string."""
    asked = _asked(word)
    if asked not in NOT_MODELLED:
        return ""
    sentence, names = NOT_MODELLED[asked]
    return f'"{word}" is not modelled: {sentence}. What there is (plica keys NAME): {", ".join(names)}.'


def _asked(word: str) -> str:
    return " ".join(word.lower().replace("_", " ").replace("-", " ").split())


def names_for(word: str, known: Iterable[tuple[str, str, str]]) -> tuple[str, ...]:
    """The names for a word: from the table, else those with this symbol, or with the word in name or label.

    known: name, symbol and label of all entries.
    """
    asked = _asked(word)
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
