"""How cycles differ from their neighbours, by the glottal area."""

from __future__ import annotations

from functools import partial
from math import inf

from plica.measures.catalogue.phrases import MARK
from plica.measures.catalogue.quantity import Quantity

__all__ = ["ROWS"]

_perturbation = partial(Quantity, group="Perturbation", source="video")

ROWS = (
    _perturbation(
        "jitter",
        "Jitter (local)",
        "1",
        "mean difference of neighbouring periods over the mean period (Praat), from mark to mark; a mark is "
        f"where the area rises through {MARK} of its pulse's height",
        recorded_from="marks",
        perturbation="amplitude",
        bounds=(0.0, inf),
    ),
    _perturbation(
        "period_perturbation_quotient",
        "Period perturbation quotient (five points)",
        "1",
        "mean difference of a period from the mean of the five about it, over the mean period (Praat's ppq5)",
        symbol="PPQ",
        recorded_from="marks",
        perturbation="amplitude",
        bounds=(0.0, inf),
    ),
    _perturbation(
        "shimmer",
        "Shimmer (local)",
        "1",
        "mean difference of neighbouring heights over the mean height (Praat), a height being a cycle's "
        "largest less its least area",
        recorded_from="area",
        perturbation="amplitude",
        bounds=(0.0, inf),
    ),
    _perturbation(
        "amplitude_perturbation_quotient",
        "Amplitude perturbation quotient (five points)",
        "1",
        "mean difference of a height from the mean of the five about it, over the mean height (Praat's apq5)",
        symbol="APQ",
        recorded_from="area",
        perturbation="amplitude",
        bounds=(0.0, inf),
    ),
    _perturbation(
        "harmonics_to_noise",
        "Harmonics-to-noise ratio of the area",
        "dB",
        "10 log10(r / (1 - r)), r the normalised autocorrelation at the period (Boersma, Proc. Inst. Phon. "
        "Sci. Amsterdam 17, 1993); cycles that differ count as noise",
        symbol="HNR",
        recorded_from="area",
        perturbation="decibels",
    ),
    _perturbation(
        "cepstral_peak_prominence",
        "Cepstral peak prominence of the area",
        "dB",
        "height of the cepstrum's peak at the period above the line through the cepstrum, Hamming window, "
        "quefrencies from four frames to half the record (Hillenbrand, J. Speech Hear. Res. 37, 1994)",
        symbol="CPP",
        recorded_from="area",
        perturbation="decibels",
    ),
)
