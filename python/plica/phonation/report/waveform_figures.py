"""Glottal area and flow, contact force and pressure, over time."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plica.measures.catalogue import closed_share, pressure_window
from plica.measures.record import time_step
from plica.measures.waveforms import STORED
from plica.phonation.measures.contact import moving_average
from plica.phonation.measures.glottal import open_area
from plica.phonation.report.reading import Reading
from plica.report.drawing import Drawing, blue, draw, green, grey, label_ends, line, over_time, red
from plica.report.wording import axis


def shade(axes: Axes, reading: Reading, part: slice) -> None:
    """Shade the time during which the glottis is closed, as in the open quotient: its area is at most 5 % of
    the largest shown. A flow through a slit is never zero.
    """
    area = open_area(reading.waveforms)[part]
    closed = area <= closed_share * area.max()
    low, high = axes.get_ylim()
    time = 1e3 * reading.time[part]
    axes.fill_between(time, low, high, where=closed.tolist(), step="mid", color=grey, alpha=0.18, lw=0)
    axes.set_ylim(low, high)


def glottal_waveforms(reading: Reading) -> Drawing:
    """Glottal area and flow in the last cycles."""
    part = reading.last_cycles(5)
    time = 1e3 * reading.time[part]
    of_area, area = axis("glottal area", STORED["minimum_area"])
    of_flow, flow = axis("flow", STORED["flow"])

    def paint(figure: Figure) -> None:
        top, bottom = figure.subplots(2, 1, sharex=True)
        top.plot(time, of_area * open_area(reading.waveforms)[part], color=blue)
        bottom.plot(time, of_flow * reading.wave("flow")[part], color=red)
        over_time((top, area), (bottom, flow))
        for axes in (top, bottom):
            shade(axes, reading, part)

    caption = (
        f"The smallest section area and the flow through it. Shaded: closed, that is an area of at most "
        f"{100 * closed_share:g} % of the largest shown."
    )
    alt = "Two curves over time: glottal area and flow."
    return draw("Glottal area and flow, last cycles", caption, alt, (9.2, 4.0), paint)


def whole_run(reading: Reading) -> Drawing:
    """Glottal area from the first to the last step, with the steady part marked."""
    factor, area = axis("glottal area", STORED["minimum_area"])

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        line(axes, 1e3 * reading.time, factor * open_area(reading.waveforms), color=blue, lw=0.9)
        over_time((axes, area))
        if reading.cycles.count:
            ends = 1e3 * reading.cycles.starts[[0, -1]]
            axes.axvspan(*ends, color=green, alpha=0.13, lw=0)

    used = f" Green: the {reading.cycles.count} cycles that the measures use." if reading.cycles.count else ""
    caption = "Glottal area over the whole run." + used
    return draw("Whole run", caption, "Glottal area over the whole run.", (9.2, 2.3), paint)


def contact_forces(reading: Reading) -> Drawing:
    """Mediolateral contact force on both folds and the largest nodal pressure."""
    part = reading.last_cycles(5)
    time = 1e3 * reading.time[part]
    of_force, force = axis("sideways force", STORED["contact_force_first"])
    of_force *= reading.midline()[1]  # positive to the right, also where x grows to the left
    left, right = (of_force * reading.wave(f"contact_force_{side}")[part, 0] for side in ("first", "second"))
    of_pressure, highest = axis("largest pressure", STORED["largest_contact_pressure"])
    pressure = of_pressure * reading.wave("largest_contact_pressure")
    step = time_step(reading.time)
    count = max(round(pressure_window / step), 1)

    def paint(figure: Figure) -> None:
        top, bottom = figure.subplots(2, 1, sharex=True)
        top.plot(time, left, color=blue)
        top.plot(time, right, color=red)
        label_ends(top, (("left fold", blue), ("right fold", red)))
        bottom.plot(time, pressure[part], color=grey, lw=0.9)
        bottom.plot(time, moving_average(pressure, count)[part], color=green)
        averaged = f"mean over {1e3 * count * step:.2g} ms"
        label_ends(bottom, (("single step", grey), (averaged, green)))
        over_time((top, force), (bottom, highest))

    caption = (
        "Total contact force on each fold, positive to the patient's right, and the largest nodal contact "
        "pressure. The pressure of a single step grows as the step falls; impulse and duration do not."
    )
    alt = "Contact force on the left and right fold over time, and the peak contact pressure below it."
    return draw("Contact", caption, alt, (9.2, 4.2), paint)
