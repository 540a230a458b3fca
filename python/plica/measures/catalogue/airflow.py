"""Pressure and flow in the glottis, and the flow as a source of sound."""

from __future__ import annotations

from functools import partial
from math import inf

from plica.measures.catalogue.phrases import HARMONICS
from plica.measures.catalogue.quantity import Quantity
from plica.measures.thresholds import fall_window

__all__ = ["ROWS"]

_airflow = partial(Quantity, group="Airflow", source="run")
_source = partial(Quantity, group="Airflow", source="run", signal="flow")

ROWS = (
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
    _source(
        "maximum_flow_declination_rate",
        "Maximum flow declination rate",
        "m^3/s^2",
        f"steepest fall of the glottal flow in each cycle, over {1e6 * fall_window:g} us or a longer step",
        symbol="MFDR",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _source(
        "normalised_amplitude_quotient",
        "Normalised amplitude quotient",
        "1",
        "peak-to-peak flow of a cycle over the product of period and steepest fall (Alku, J. Acoust. "
        "Soc. Am. 112, 2002)",
        symbol="NAQ",
        bounds=(0.0, inf),
    ),
    _source("flow_h1_h2", "H1-H2 of the glottal flow", "dB", HARMONICS.format(1, 2), symbol="H1-H2"),
    _source("flow_h2_h4", "H2-H4 of the glottal flow", "dB", HARMONICS.format(2, 4), symbol="H2-H4"),
)
