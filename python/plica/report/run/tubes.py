"""Pressures and flows at both ends of the glottis, of a run between a trachea and a vocal tract."""

from __future__ import annotations

from matplotlib.figure import Figure

from plica.measures.waveforms import STORED
from plica.report.drawing import Drawing, blue, draw, green, label_ends, over_time, red
from plica.report.run.reading import Reading
from plica.report.run.waveforms import closed_times, shade
from plica.report.wording import axis

__all__ = ["air_at_the_glottis"]

_CYCLES = 5  # shown


def air_at_the_glottis(reading: Reading) -> Drawing:
    """Pressures below and above the folds, and flows through them and at the lips, in the last cycles."""
    part = reading.last_cycles(_CYCLES)
    time = 1e3 * reading.time[part]
    pressures = [
        (name, label, colour)
        for name, label, colour in (
            ("subglottal_pressure", "below", blue),
            ("supraglottal_pressure", "above", red),
        )
        if reading.has(name)
    ]
    flows = [
        (name, label, colour)
        for name, label, colour in (("flow", "glottis", blue), ("lip_flow", "lips", green))
        if reading.has(name)
    ]
    of_pressure, pressure = axis("pressure", STORED["subglottal_pressure"])
    of_flow, flow = axis("flow", STORED["flow"])
    closed = closed_times(reading, _CYCLES)

    def paint(figure: Figure) -> None:
        top, bottom = figure.subplots(2, 1, sharex=True)
        for axes, factor, shown in ((top, of_pressure, pressures), (bottom, of_flow, flows)):
            for name, _, colour in shown:
                axes.plot(time, factor * reading.wave(name)[part], color=colour)
            label_ends(axes, [(label, colour) for _, label, colour in shown])
            shade(axes, closed)
        over_time((top, pressure), (bottom, flow))

    ends = " and out of the lips" if reading.has("lip_flow") else ""
    caption = f"Pressure at the folds, which the flow changes, and the flow through the glottis{ends}."
    if closed:
        caption += " Shaded: the glottis is closed."
    alt = f"Two panels over time: pressure at the folds; flow through the glottis{ends}."
    return draw("Air below and above the folds, last cycles", caption, alt, (9.2, 4.0), paint)
