"""Catalogue of all measures: name, unit, definition and thresholds.

Runs, recordings, reports, command tables and docs/scene.md use it: names, definitions and units are defined
only here.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import partial
from math import inf
from typing import Literal

from plica.errors import UnknownName
from plica.measures.quotients import leak_level
from plica.measures.scale import SI, Scale, shown_unit

__all__ = ["CATALOGUE", "Quantity", "RecordedFrom", "Side", "Source", "catalogue_entry", "names"]

Source = Literal["run", "video", "both"]
RecordedFrom = Literal["", "record", "marks", "area", "edges", "midline", "motion", "signal"]
Side = Literal["", "left", "right", "ratio", "difference"]

closed_share = 0.05  # of a cycle's largest area, up to which the glottis is closed
closed_share_1_percent = 0.01  # the same for open_quotient_1_percent and for opening and closing samples
contact_share = 0.01  # of a steady cycle's peak force, above which the folds are in contact
medial_angle = 0.436  # rad, 25 degrees: between M5's glottis (to 20 a side) and inferior faces (32 and more)
bridged_share = 0.25  # of the period: losses of contact up to this long belong to a collision
bridged_of_record = 0.05  # the same for runs without cycles, as a share of the record
open_levels = (0.2, 0.5)  # levels of further open quotients, in the range of a cycle's area
pressure_window = 0.2e-3  # s, averaging time of the peak contact pressure


@dataclass(frozen=True)
class Quantity:
    """One entry of the catalogue.

    Attributes
    ----------
    name : str
        Name in the API and in measures.json.
    label : str
        Name in reports and tables.
    unit : str
        SI, "1" for a pure number; in a recording without a scale it is `Scale.unit` of this.
    meaning : str
        The definition with its level, averaging time and sign; empty if the label is sufficient.
    group : str
        Heading in reports.
    source : {"run", "video", "both"}
        Kind of record that has it.
    symbol : str
        Common abbreviation.
    shown : str
        Unit in reports, if it is not the usual one for `unit`.
    no_limit : str
        Why it does not converge as the step falls, and what to use instead; empty if it does. Such a measure
        is no headline, and has this as a caution.
    no_limit_of : {"every run", "surfaces with mass"}
        The runs of which that is true.
    diagnostic : bool
        Whether it is of the accuracy of the solution or its effort, not of the voice; no headline either.
    recorded_from : {"", "record", "marks", "area", "edges", "midline", "motion", "signal"}
        What of a recording tells it: the record as such, not the voice; the marks at which cycles begin, the
        glottal area, the folds' edges, the midline, the tissue's motion, a signal beside the picture; empty
        for what only runs have.
    side : {"", "left", "right", "ratio", "difference"}
        The fold it is of, or how it compares both: a ratio is 1 and a difference 0 where they move alike.
    extreme : bool
        Whether the largest or least sample of a cycle alone tells it.
    perturbation : {"", "amplitude", "decibels"}
        Of what adds to the differences of cycles, by squares: a mean difference, or a ratio to them in dB.
    angle : bool
        Whether it is known up to 2 pi.
    of_ends : bool
        Whether the first and the last cycle tell it, so that errors fall with the number of cycles.
    bounds : (float, float)
        Between which its definition leaves it.
    """

    name: str
    label: str
    unit: str
    meaning: str = ""
    _: KW_ONLY
    group: str
    source: Source
    symbol: str = ""
    shown: str = ""
    no_limit: str = ""
    no_limit_of: Literal["every run", "surfaces with mass"] = "every run"
    diagnostic: bool = False
    recorded_from: RecordedFrom = ""
    side: Side = ""
    extreme: bool = False
    perturbation: Literal["", "amplitude", "decibels"] = ""
    angle: bool = False
    of_ends: bool = False
    bounds: tuple[float, float] = (-inf, inf)

    @property
    def described(self) -> str:
        """Label, definition, and why it has no limit, as text without a full stop."""
        limit = f". Caution: {self.no_limit}" if self.no_limit else ""
        return f"{self.label}: {self.meaning}".rstrip(": ") + limit

    def people(self, scale: Scale = SI) -> tuple[float, str]:
        """Factor to the unit used in reports, and that unit, for a record with this scale."""
        unit = scale.unit(self.unit)
        return shown_unit(unit, self.shown if unit == self.unit else "")


_OPEN = (
    "share of the cycle in which the glottis is not closed; closed is an area of at most {:g} % of the "
    "cycle's largest and, with Bernoulli's flow, one that contact stops"
)
_SIDE = (
    "half the peak-to-peak mediolateral displacement of the {} fold's edge in a cycle: in a run of "
    "the mid-coronal point that moves most, also while it touches or is hidden (up to half as much again "
    "as an edge has been seen), in a recording the mean of the visible edge over the middle tenth of the "
    "midline"
)
_SHARE = (0.0, 1.0)
_OVER_AREA = "over the latter, in the time that both have; no interval: chance is in the note"
_FOLDS: tuple[Side, Side] = ("left", "right")
_WITHOUT = "or, if there are no cycles, in the whole run (in its last third where pulses are no periods)"
_COLLISION = "over the collisions of the steady cycles or, if there are none, of the whole run"
_LARGEST = f"largest in each cycle {_WITHOUT}"
_HARMONICS = (
    "level of harmonic {} over that of harmonic {} of each cycle, under a Hann window of two periods about it"
)
_RAW = "not corrected for formants"
_ASYMMETRY = "(right - left) / (right + left)"
_STEP_PRESSURE = "largest nodal pressure of each step"

_vibration = partial(Quantity, group="Vibration", source="both")
_run_vibration = partial(Quantity, group="Vibration", source="run")
_video_vibration = partial(Quantity, group="Vibration", source="video")
_motion = partial(Quantity, group="Motion of the tissue", source="video")
_glottis = partial(Quantity, group="Glottis", source="both")
_video_glottis = partial(Quantity, group="Glottis", source="video")
_perturbation = partial(Quantity, group="Perturbation", source="video")
_airflow = partial(Quantity, group="Airflow", source="run")
_run_sound = partial(Quantity, group="Sound", source="run")
_tract = partial(Quantity, group="Vocal tract", source="run")
_sound = partial(Quantity, group="Sound", source="both", recorded_from="signal")
_video_sound = partial(Quantity, group="Sound", source="video", recorded_from="signal")
_egg = partial(Quantity, group="Electroglottogram", source="video", recorded_from="signal")
_contact = partial(Quantity, group="Contact", source="run")
_energy = partial(Quantity, group="Energy", source="run")
_accuracy = partial(Quantity, group="Accuracy of the solution", source="run", diagnostic=True)
_solver = partial(Quantity, group="Solver", source="run", diagnostic=True)

_QUANTITIES = (
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
        "steady voice at most 1 %, and 5 % over all. Of a run that is changing, by the line through the "
        "logarithms of the last half of all its cycles",
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
        bounds=_SHARE,
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
        bounds=_SHARE,
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
            bounds=_SHARE,
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
        bounds=_SHARE,
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
    _perturbation(
        "jitter",
        "Jitter (local)",
        "1",
        "mean difference of neighbouring periods over the mean period (Praat), from mark to mark; a mark is "
        "where the area rises through 20 to 40 % of its pulse's height",
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
    _vibration(
        "amplitude_left",
        "Amplitude, left fold",
        "m",
        _SIDE.format("left"),
        recorded_from="edges",
        side="left",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _vibration(
        "amplitude_right",
        "Amplitude, right fold",
        "m",
        _SIDE.format("right"),
        recorded_from="edges",
        side="right",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _vibration(
        "amplitude_ratio",
        "Amplitude ratio",
        "1",
        "of the folds' displacements, right over left",
        recorded_from="edges",
        side="ratio",
        bounds=(0.0, inf),
    ),
    _vibration(
        "amplitude_asymmetry",
        "Amplitude asymmetry",
        "1",
        f"of the folds' displacements, {_ASYMMETRY}",
        recorded_from="edges",
        side="difference",
        bounds=(-1.0, 1.0),
    ),
    _video_vibration(
        "area_asymmetry",
        "Area asymmetry",
        "1",
        f"of the ranges of the glottal areas on either side of the midline, {_ASYMMETRY}",
        recorded_from="area",
        side="difference",
        bounds=(-1.0, 1.0),
    ),
    _vibration(
        "left_right_phase",
        "Left-right phase",
        "rad",
        "between the crests of the folds' edges, the farther three quarters of their ways while apart; "
        "positive where the right lags",
        recorded_from="edges",
        side="difference",
        angle=True,
    ),
    _run_vibration(
        "peak_strain",
        "Peak strain",
        "1",
        "of a cycle: the strain that 0.1 % of the volume exceeds; the caution large_strain says by how "
        "much linear tissue is off",
    ),
    *(
        _motion(
            f"mucosal_wave_speed_{side}",
            f"Mucosal wave speed, {side} fold",
            "m/s",
            "medial-lateral phase velocity of the fundamental on the upper surface as the picture shows it: "
            "angular frequency over the slope of the outward motion's phase away from the midline, where the "
            "motion is over 30 % of its largest, from 8 px beyond the edge on, mean over bands of the fold's "
            "middle (Titze, Jiang, Hsiao, Ann. Otol. Rhinol. Laryngol. 102, 1993); the interval is by bands, "
            "and has what smooth flow makes of the slope",
            recorded_from="motion",
            side=side,
        )
        for side in _FOLDS
    ),
    _motion(
        "strain_amplitude_across",
        "Strain amplitude across the midline",
        "1",
        "of the fundamental, 2-D projection, over a gauge of 8 px: what 5 % of the folds' visible surface "
        "exceed; du/dx with x across the midline. Smooth flow makes it too small, by a third at worst in "
        "films of known waves",
        recorded_from="motion",
    ),
    _motion(
        "strain_rate_amplitude_across",
        "Strain rate amplitude across the midline",
        "1/s",
        "the same times the angular frequency",
        recorded_from="motion",
    ),
    _run_vibration(
        "vertical_phase_difference",
        "Vertical phase difference",
        "rad",
        "at the fundamental, of the glottal width at the inferior and superior edge of the medial "
        "surface; positive where the superior edge lags. The medial surface is where the mid-coronal contour "
        "at rest is within 25 degrees of vertical, about the narrowest place",
        angle=True,
    ),
    _run_vibration(
        "converging_while_opening",
        "Converging while opening",
        "1",
        f"share of the opening samples above {100 * closed_share_1_percent:g} % of the cycle's largest area "
        "with the lower edge wider",
    ),
    _run_vibration(
        "diverging_while_closing",
        "Diverging while closing",
        "1",
        f"share of the closing samples above {100 * closed_share_1_percent:g} % of the cycle's largest area "
        "with the upper edge wider",
    ),
    _glottis(
        "glottal_area_max",
        "Largest glottal area",
        "m^2",
        "in each cycle or, if there are none, in a recording or the last third of a run",
        recorded_from="area",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _glottis(
        "glottal_area_mean",
        "Mean glottal area",
        "m^2",
        "of each cycle or, if there are none, of a recording or the last third of a run",
        recorded_from="area",
        bounds=(0.0, inf),
    ),
    _video_glottis(
        "glottal_gap_index",
        "Glottal gap index",
        "1",
        "least over largest area of each cycle (Kunduk, J. Voice 24, 2010)",
        symbol="GGI",
        recorded_from="area",
        bounds=_SHARE,
    ),
    _video_glottis(
        "glottal_gap_relative",
        "Relative glottal gap",
        "1",
        "least area of each cycle over the square of the glottal length (Omori, J. Voice 10, 1996)",
        recorded_from="area",
        bounds=(0.0, inf),
    ),
    _video_glottis("glottal_length", "Glottal length", "m", "of the midline", recorded_from="midline"),
    _video_glottis(
        "glottal_area_max_relative",
        "Largest glottal area over the square of the glottal length",
        "1",
        recorded_from="area",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _video_glottis(
        "amplitude_left_relative",
        "Amplitude over the glottal length, left fold",
        "1",
        recorded_from="edges",
        side="left",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _video_glottis(
        "amplitude_right_relative",
        "Amplitude over the glottal length, right fold",
        "1",
        recorded_from="edges",
        side="right",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _airflow("subglottal_pressure", "Subglottal pressure", "Pa", "of the scene"),
    _airflow(
        "peak_flow",
        "Peak flow",
        "m^3/s",
        "in each cycle or, if there are none, in the last third of the record",
    ),
    _airflow(
        "mean_flow",
        "Mean flow",
        "m^3/s",
        "of each cycle or, if there are none, of the last third of the record",
    ),
    _airflow(
        "minimum_flow",
        "Least flow",
        "m^3/s",
        "in each cycle or, if there are none, in the last third of the record",
    ),
    _airflow(
        "maximum_flow_declination_rate",
        "Maximum flow declination rate",
        "m^3/s^2",
        "steepest fall of the glottal flow in each cycle, over 50 us or a longer step",
        symbol="MFDR",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _airflow(
        "normalised_amplitude_quotient",
        "Normalised amplitude quotient",
        "1",
        "peak-to-peak flow of a cycle over the product of period and steepest fall (Alku, J. Acoust. "
        "Soc. Am. 112, 2002)",
        symbol="NAQ",
        bounds=(0.0, inf),
    ),
    _airflow("flow_h1_h2", "H1-H2 of the glottal flow", "dB", _HARMONICS.format(1, 2), symbol="H1-H2"),
    _airflow("flow_h2_h4", "H2-H4 of the glottal flow", "dB", _HARMONICS.format(2, 4), symbol="H2-H4"),
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
        f"sound less glottal area {_OVER_AREA}",
    ),
    _run_sound(
        "sound_pressure_level",
        "Sound pressure level at 0.3 m",
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
    _sound("sound_h1_h2", "H1-H2 of the sound", "dB", f"{_HARMONICS.format(1, 2)}, {_RAW}"),
    _sound("sound_h2_h4", "H2-H4 of the sound", "dB", f"{_HARMONICS.format(2, 4)}, {_RAW}"),
    _sound(
        "sound_cepstral_peak_prominence",
        "Cepstral peak prominence of the sound",
        "dB",
        "height of the cepstrum's peak at the period above the line through the cepstrum from 1 ms "
        "to half the "
        "record, of the spectrum up to 5 kHz, Hamming window over all cycles (Hillenbrand, J. Speech "
        "Hear. Res. 37, 1994)",
    ),
    _sound(
        "sound_harmonics_to_noise",
        "Harmonics-to-noise ratio of the sound",
        "dB",
        "10 log10(r / (1 - r)), r the normalised autocorrelation of all cycles at the period "
        "(Boersma, Proc. Inst. "
        "Phon. Sci. Amsterdam 17, 1993); cycles that differ count as noise, and a run has no other",
    ),
    _sound(
        "sound_jitter",
        "Jitter of the sound (local)",
        "1",
        "mean difference of neighbouring periods over the mean period (Praat); a period of a run is from "
        "where the glottal flow rises through 20 to 40 % of its pulse to the next such instant, of a "
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
        f"electroglottogram less glottal area {_OVER_AREA}",
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
        bounds=_SHARE,
    ),
    _egg(
        "egg_contact_quotient_peaks",
        "Contact quotient, dEGG peaks",
        "1",
        "from the closing to the opening peak of the electroglottogram's slope, over the period (Henrich et "
        "al., J. Acoust. Soc. Am. 115, 2004), where both are single; the interval has the scatter of "
        "cycles alone",
        symbol="CQ_dEGG",
        bounds=_SHARE,
    ),
    _egg(
        "egg_closing_lag",
        "Closing peak of the EGG behind the area's closing",
        "s",
        f"from where the area falls to {100 * closed_share:g} % of the cycle's largest (without closure to "
        f"{100 * leak_level:g} % of its range) to the nearest closing peak; no interval, as the error of the "
        "start of the signal is not known",
    ),
    _contact(
        "collisions",
        "Collisions",
        "1",
        "complete ones in the whole run; "
        f"in contact above {100 * contact_share:g} % of the peak force, losses of contact below "
        f"{bridged_share:g} of the period (of the record {bridged_of_record:g} without cycles) bridged",
    ),
    _contact("contact_impulse", "Impulse per collision", "N s", f"on the left fold, {_COLLISION}"),
    _contact("contact_duration", "Duration of a collision", "s", _COLLISION),
    _contact(
        "contact_force_left_peak",
        "Peak force, left fold",
        "N",
        f"of a single step, {_COLLISION}",
        side="left",
    ),
    _contact(
        "contact_force_right_peak",
        "Peak force, right fold",
        "N",
        f"of a single step, {_COLLISION}",
        side="right",
    ),
    _contact(
        "contact_force_left_mean",
        "Mean force, left fold",
        "N",
        f"impulse over duration, {_COLLISION}",
        side="left",
    ),
    _contact(
        "contact_force_right_mean",
        "Mean force, right fold",
        "N",
        f"impulse over duration, {_COLLISION}",
        side="right",
    ),
    _contact(
        "contact_area_max",
        "Largest contact area",
        "m^2",
        f"of the loaded nodes (by over 1e-3 of the largest force), mean of both sides; {_LARGEST}",
    ),
    _contact(
        "contact_length_max",
        "Largest contact length",
        "m",
        "anteroposterior, of the deformed fold; a loaded node stands for half the way to its neighbours; "
        f"{_LARGEST}",
    ),
    _contact(
        "contact_length_fraction",
        "Contact length over fold length",
        "1",
        "length in contact of the deformed fold over the length of the fold at rest, so that it may pass "
        f"1; {_LARGEST}",
    ),
    _contact(
        "peak_contact_pressure",
        f"Peak contact pressure, mean over {1e3 * pressure_window:g} ms",
        "Pa",
        f"moving mean over {1e3 * pressure_window:g} ms of the {_STEP_PRESSURE} (an upper bound of any one "
        f"node's mean); {_LARGEST}",
        no_limit="surfaces with mass: it grows as the step falls and has no limit; use the impulse, the "
        'duration and the mean force, or contact.surface_mass = "redistributed", with which it converges',
        no_limit_of="surfaces with mass",
    ),
    _contact(
        "peak_contact_pressure_step",
        "Peak contact pressure of a single step",
        "Pa",
        f"{_STEP_PRESSURE}; {_LARGEST}",
        no_limit="pressure of single steps: it grows as the step falls and is no physical figure; use the "
        "impulse, the duration and the mean force",
    ),
    _energy("kinetic_energy", "Kinetic energy", "J", "at the end of the run"),
    _energy("elastic_energy", "Elastic energy", "J", "at the end of the run"),
    _energy("load_work", "Work of the loads", "J", "at the end of the run, the airflow's included"),
    _energy("flow_work", "Work of the airflow", "J", "on the tissue, at the end of the run"),
    _energy("viscous_loss", "Viscous loss", "J", "at the end of the run"),
    _energy("contact_work", "Work of the contact", "J", "at the end of the run"),
    _energy("friction_loss", "Friction loss", "J", "minus the work of friction, over the run"),
    _energy(
        "air_supplied_energy",
        "Energy supplied to the air",
        "J",
        "by the pressure difference along the glottis, over the run",
    ),
    _energy("air_viscous_energy", "Air's viscous loss", "J", "of the energy supplied, over the run"),
    _energy("air_inertial_energy", "Work that accelerates the air", "J", "in the glottis, over the run"),
    _accuracy(
        "contact_force_balance",
        "Imbalance of the forces",
        "1",
        "largest magnitude of the sum of both forces over the largest force",
    ),
    _accuracy(
        "deepest_gap", "Deepest gap", "m", "of the whole run, at a node; negative is overlap", shown="um"
    ),
    _accuracy("overlap_volume_max", "Largest overlap", "m^3", "of the whole run, confirmed at nodes"),
    _accuracy(
        "edge_overlap_volume_max",
        "Largest overlap, edge to edge",
        "m^3",
        "of the whole run, between crossed edges, where no node meets the facing surface",
    ),
    _accuracy(
        "largest_multiplier",
        "Largest pull of a contact force",
        "N",
        "of the whole run, at one node; contact can only push, so that a pull (> 0) is an error",
        shown="uN",
    ),
    _accuracy("numerical_loss", "Numerical loss", "J", "at the end of the run"),
    _accuracy(
        "energy_balance_error",
        "Energy balance error",
        "1",
        "largest of what does not balance, over the largest energy of the run",
    ),
    _solver("steps", "Steps", "1", "computed"),
    _solver("time_step", "Time step", "s", shown="us"),
    _solver("duration", "Time simulated", "s"),
    _solver("mean_iterations", "Iterations per step", "1", "mean over all steps"),
    _solver("largest_iterations", "Iterations per step, at most", "1"),
    _solver(
        "mean_coupling_sweeps",
        "Coupling sweeps per step",
        "1",
        "mean over all steps: how often the air pressure was computed from the position of the folds",
    ),
    _solver(
        "coupling_frozen_fraction",
        "Steps with held flow separation",
        "1",
        "share of all steps: where the jet separates, and whether contact stops the flow, were held in the "
        "last sweeps, as they went to and fro",
    ),
    _solver(
        "coupling_converged_fraction",
        "Steps with a converged coupling",
        "1",
        "share of all steps: air pressure and position of the folds agree",
    ),
    _solver(
        "mean_contact_passes",
        "Contact passes per step",
        "1",
        "mean over all steps: how often it was found anew which nodes touch the facing surface",
    ),
    _solver("inverted_tissue_max", "Inverted tissue cells, at most", "1"),
)

CATALOGUE = {entry.name: entry for entry in _QUANTITIES}
"""All quantities by name, in the order of reports."""


def names(**properties: str | bool) -> frozenset[str]:
    """Of all quantities with these properties: ``names(recorded_from="edges", side="left")``."""
    wanted = properties.items()
    return frozenset(
        name
        for name, entry in CATALOGUE.items()
        if all(getattr(entry, key) == value for key, value in wanted)
    )


def catalogue_entry(name: str) -> Quantity:
    """The entry of that name; raises UnknownName if there is none."""
    if name not in CATALOGUE:
        raise UnknownName("Measures", name, CATALOGUE)
    return CATALOGUE[name]
