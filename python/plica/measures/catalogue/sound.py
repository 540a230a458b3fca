"""Sound, and the vocal tract's resonances."""

from __future__ import annotations

from functools import partial
from math import inf

from plica.measures.catalogue.phrases import HARMONICS, MARK, OVER_AREA
from plica.measures.catalogue.quantity import Quantity
from plica.measures.thresholds import cepstral_band, first_quefrency, usual_distance

__all__ = ["ROWS"]

_RAW = "not corrected for formants"

_run_sound = partial(Quantity, group="Sound", source="run", signal="sound")
_tract = partial(Quantity, group="Vocal tract", source="run")
_sound = partial(Quantity, group="Sound", source="both", recorded_from="signal", signal="sound")
_video_sound = partial(Quantity, group="Sound", source="video", recorded_from="signal", signal="sound")

ROWS = (
    _video_sound(
        "sound_frequency",
        "Fundamental frequency of the sound",
        "Hz",
        "cycles of the sound per time, each the lag at which it is most like the next",
        bounds=(0.0, inf),
    ),
    _video_sound(
        "sound_frequency_difference",
        "Frequency of the sound against the area's",
        "1",
        f"sound less glottal area {OVER_AREA}",
    ),
    _run_sound(
        "sound_pressure_level",
        f"Sound pressure level at {usual_distance:g} m",
        "dB",
        "re 20 uPa, root mean square of each cycle or, if there are none, of the last third of the run; of a "
        "small source in free air with the flow at the lips or, without a tract, at the glottis; before the "
        "wall in which a tract's open end stands it would be 6 dB more",
        symbol="SPL",
    ),
    _run_sound(
        "glottal_efficiency",
        "Glottal efficiency",
        "1",
        "radiated power, 4 pi r^2 / (rho c) times the mean square of the sound pressure at r, over "
        "the product of mean subglottal pressure and mean flow, in each cycle; of a source in free air, half "
        "of the radiated_energy that leaves a tract's open end, which stands in a wall",
        bounds=(0.0, inf),
    ),
    _sound("sound_h1_h2", "H1-H2 of the sound", "dB", f"{HARMONICS.format(1, 2)}, {_RAW}"),
    _sound("sound_h2_h4", "H2-H4 of the sound", "dB", f"{HARMONICS.format(2, 4)}, {_RAW}"),
    _sound(
        "sound_cepstral_peak_prominence",
        "Cepstral peak prominence of the sound",
        "dB",
        "height of the cepstrum's peak at the period above the line through the cepstrum from "
        f"{1e3 * first_quefrency:g} ms to half the record, of the spectrum up to {1e-3 * cepstral_band:g} "
        "kHz, Hamming window over all cycles (Hillenbrand, J. Speech Hear. Res. 37, 1994)",
    ),
    _sound(
        "sound_harmonics_to_noise",
        "Harmonics-to-noise ratio of the sound",
        "dB",
        "10 log10(r / (1 - r)), r the normalised autocorrelation of all cycles at the period "
        "(Boersma, Proc. Inst. Phon. Sci. Amsterdam 17, 1993); cycles that differ count as "
        "noise, and a run has no other",
    ),
    _sound(
        "sound_jitter",
        "Jitter of the sound (local)",
        "1",
        "mean difference of neighbouring periods over the mean period (Praat); a period of a run is from "
        f"where the glottal flow rises through {MARK} of its pulse to the next such instant, of a "
        "recording the lag at which its sound is most like what follows",
        bounds=(0.0, inf),
    ),
    _sound(
        "sound_shimmer",
        "Shimmer of the sound (local)",
        "1",
        "mean difference of neighbouring amplitudes over the mean one (Praat), an amplitude being "
        "the root mean square of a cycle, as a peak depends on the band",
        bounds=(0.0, inf),
    ),
    *(
        entry
        for k in (1, 2, 3, 4)
        for entry in (
            _tract(
                f"formant_{k}",
                f"Formant {k}",
                "Hz",
                "resonance of the run's vocal tract over a closed glottis, of the model, not of the sound",
                symbol=f"F{k}",
            ),
            _tract(
                f"formant_{k}_bandwidth",
                f"Bandwidth of formant {k}",
                "Hz",
                "between the points of half the power, of the tract alone: an open glottis adds to it",
                symbol=f"B{k}",
            ),
        )
    ),
    *(
        _tract(
            f"sound_h{one}_h{other}_corrected",
            f"H{one}-H{other} of the sound without the tract",
            "dB",
            "that of the sound less what the run's tract adds at the mean frequency of the cycles (flow at "
            "the lips over that into the tract, of the model): that of the rate of change of the flow that "
            "enters the tract, the glottal one and the air that the folds displace",
            symbol=f"H{one}*-H{other}*",
        )
        for one, other in ((1, 2), (2, 4))
    ),
)
