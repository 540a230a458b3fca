"""Cycles of the vibration: frequency, growth, and how long the glottis is open."""

from __future__ import annotations

from functools import partial
from math import inf

from plica.measures.catalogue.quantity import SHARE, Quantity
from plica.measures.quotients import leak_level
from plica.measures.stationary import of_amplitude
from plica.measures.thresholds import closed_share, closed_share_1_percent, open_levels

__all__ = ["ROWS"]

_OPEN = (
    "share of the cycle in which the glottis is not closed; closed is an area of at most {:g} % of the "
    "cycle's largest and, with Bernoulli's flow, one that contact stops"
)

_vibration = partial(Quantity, group="Vibration", source="both")
_run_vibration = partial(Quantity, group="Vibration", source="run")
_video_vibration = partial(Quantity, group="Vibration", source="video")

ROWS = (
    _vibration(
        "fundamental_frequency",
        "Fundamental frequency",
        "Hz",
        "cycles over their time: of a run the steady ones, of a recording all; none where the "
        "autocorrelation finds another frequency, or where a run's vibration decays",
        symbol="f0",
        recorded_from="marks",
        of_ends=True,
    ),
    _vibration(
        "fundamental_frequency_autocorrelation",
        "Fundamental frequency by autocorrelation",
        "Hz",
        "first high peak of the autocorrelation",
        recorded_from="area",
    ),
    _vibration("period", "Period", "s", symbol="T", recorded_from="marks", of_ends=True),
    _vibration(
        "amplitude_growth",
        "Growth per cycle",
        "1",
        "relative change of the peak-to-peak amplitude from cycle to cycle, by the line through all; in a "
        f"steady voice at most {100 * of_amplitude.rate:g} %, and {100 * of_amplitude.scatter:g} % over "
        "all. Of a run that is changing, by the line through the logarithms of the last half of "
        "all its cycles",
        recorded_from="area",
        of_ends=True,
    ),
    _run_vibration(
        "damping_ratio",
        "Damping ratio",
        "1",
        "from the decay of the peak-to-peak amplitude; negative: it grows",
        symbol="zeta",
    ),
    _run_vibration(
        "probe_amplitude",
        "Amplitude of the probe",
        "m",
        "half the peak-to-peak motion of the probe that moves most, in the direction in which it does",
    ),
    _vibration(
        "open_quotient",
        f"Open quotient, area above {100 * closed_share:g} % of its largest",
        "1",
        _OPEN.format(100 * closed_share),
        symbol="OQ",
        recorded_from="area",
        bounds=SHARE,
    ),
    _run_vibration(
        "open_quotient_1_percent",
        f"Open quotient, area above {100 * closed_share_1_percent:g} % of its largest",
        "1",
        f"{_OPEN.format(100 * closed_share_1_percent)}: folds that leave a slit are open by this level, and "
        f"closed by that of {100 * closed_share:g} %, which figures shade",
    ),
    _vibration(
        "speed_quotient",
        "Speed quotient",
        "1",
        f"opening over closing time, above {100 * closed_share:g} % of the cycle's largest area; without "
        f"closure above {100 * leak_level:g} % of the way from the least to the largest area",
        symbol="SQ",
        recorded_from="area",
        bounds=(0.0, inf),
    ),
    _vibration(
        "closing_quotient",
        "Closing quotient",
        "1",
        "closing time over period, as in the speed quotient",
        symbol="ClQ",
        recorded_from="area",
        bounds=SHARE,
    ),
    _video_vibration(
        "cycles_found",
        "Cycles found",
        "1",
        "complete ones in the recording, from mark to mark of the area",
        recorded_from="record",
    ),
    _video_vibration(
        "cycles_used",
        "Cycles used",
        "1",
        "those of them over which measures are taken: all whose "
        "frames are all known, or where these are too few, all",
        recorded_from="record",
    ),
    *(
        _video_vibration(
            f"open_quotient_{100 * level:g}_percent",
            f"Open quotient, area above {100 * level:g} % of its range",
            "1",
            f"share of the cycle with the glottal area above {100 * level:g} % of the way from the cycle's "
            "least to its largest",
            recorded_from="area",
            bounds=SHARE,
        )
        for level in open_levels
    ),
    _video_vibration(
        "closed_quotient",
        f"Closed quotient, area at most {100 * closed_share:g} % of its largest",
        "1",
        "one less the open quotient of the cycle",
        symbol="CQ",
        recorded_from="area",
        bounds=SHARE,
    ),
    _video_vibration(
        "speed_index",
        "Speed index",
        "1",
        "(opening - closing) / (opening + closing) time, those of the speed quotient (Hirano, Clinical "
        "Examination of Voice, 1981)",
        symbol="SI",
        recorded_from="area",
        bounds=(-1.0, 1.0),
    ),
    _video_vibration(
        "rate_quotient",
        "Rate quotient",
        "1",
        "(closed + opening) over closing time: what of the period is not closing, over closing (Kitzing, "
        "Folia Phoniatr. 34, 1982)",
        symbol="RQ",
        recorded_from="area",
        bounds=(0.0, inf),
    ),
)
