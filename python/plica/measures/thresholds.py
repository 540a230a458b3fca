"""The levels, shares and times by which measures are defined; definitions in the catalogue name them."""

from __future__ import annotations

__all__ = [
    "bridged_of_record",
    "bridged_share",
    "cepstral_band",
    "closed_share",
    "closed_share_1_percent",
    "contact_share",
    "fall_window",
    "first_quefrency",
    "mark_shares",
    "medial_angle",
    "open_levels",
    "pressure_window",
    "strain_gauge",
    "usual_distance",
    "wave_percentile",
    "wave_share",
]

closed_share = 0.05  # of a cycle's largest area, up to which the glottis is closed
closed_share_1_percent = 0.01  # the same for open_quotient_1_percent and for opening and closing samples
open_levels = (0.2, 0.5)  # levels of further open quotients, in the range of a cycle's area
mark_shares = (0.2, 0.3, 0.4)  # of a pulse's height, around which its cycle starts
medial_angle = 0.436  # rad, 25 degrees: between M5's glottis (to 20 a side) and inferior faces (32 and more)
strain_gauge = 8.0  # px, over which strain is taken
wave_percentile = 95  # of the folds' visible surface, by strain or motion: what few pixels exceed
wave_share = 0.3  # of the largest amplitude in a band: farther out is no wave to be seen
contact_share = 0.01  # of a steady cycle's peak force, above which the folds are in contact
bridged_share = 0.25  # of the period: losses of contact up to this long belong to a collision
bridged_of_record = 0.05  # the same for runs without cycles, as a share of the record
pressure_window = 0.2e-3  # s, averaging time of the peak contact pressure
fall_window = 50e-6  # s, over which the fall of the glottal flow is taken
usual_distance = 0.3  # m, from the lips: of microphones and of published levels
cepstral_band = 5000.0  # Hz, up to which the spectrum of a cepstrum counts
first_quefrency = 1e-3  # s, from which the line through a cepstrum of a sound is fitted
