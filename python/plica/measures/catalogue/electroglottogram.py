"""What an electroglottogram tells."""

from __future__ import annotations

from functools import partial
from math import inf

from plica.measures.catalogue.phrases import OVER_AREA
from plica.measures.catalogue.quantity import SHARE, Quantity
from plica.measures.quotients import leak_level
from plica.measures.thresholds import closed_share

__all__ = ["ROWS"]

_egg = partial(Quantity, group="Electroglottogram", source="video", recorded_from="signal", signal="egg")

ROWS = (
    _egg(
        "egg_frequency",
        "Fundamental frequency of the EGG",
        "Hz",
        "cycles from closing peak to closing peak of the electroglottogram's slope, per time",
        bounds=(0.0, inf),
    ),
    _egg(
        "egg_frequency_difference",
        "Frequency of the EGG against the area's",
        "1",
        f"electroglottogram less glottal area {OVER_AREA}",
    ),
    _egg(
        "egg_jitter",
        "Jitter of the EGG (local)",
        "1",
        "mean difference of neighbouring periods over the mean period (Praat), from closing peak to closing "
        "peak",
        bounds=(0.0, inf),
    ),
    _egg(
        "egg_contact_quotient_level",
        "Contact quotient, dEGG peak to 3/7",
        "1",
        "from the closing peak of the electroglottogram's slope to where the signal falls through 3/7 of the "
        "cycle's range, over the period (Howard, J. Voice 9, 1995); the interval has the scatter of cycles "
        "alone",
        symbol="CQ_3/7",
        bounds=SHARE,
    ),
    _egg(
        "egg_contact_quotient_peaks",
        "Contact quotient, dEGG peaks",
        "1",
        "from the closing to the opening peak of the electroglottogram's slope, over the period (Henrich et "
        "al., J. Acoust. Soc. Am. 115, 2004), where both are single; the interval has the scatter of "
        "cycles alone",
        symbol="CQ_dEGG",
        bounds=SHARE,
    ),
    _egg(
        "egg_closing_lag",
        "Closing peak of the EGG behind the area's closing",
        "s",
        f"from where the area falls to {100 * closed_share:g} % of the cycle's largest (without closure to "
        f"{100 * leak_level:g} % of its range) to the nearest closing peak; no interval, as the error of the "
        "start of the signal is not known",
    ),
)
