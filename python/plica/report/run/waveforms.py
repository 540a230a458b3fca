"""Glottal area and flow, contact force and pressure, over time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from plica.measures.quotients import closed_intervals
from plica.measures.record import time_step
from plica.measures.run.contact import moving_average
from plica.measures.run.glottal import open_area
from plica.measures.thresholds import closed_share, pressure_window
from plica.measures.waveforms import STORED
from plica.report.drawing import Drawing, blue, draw, green, grey, label_ends, line, over_time, red
from plica.report.run.reading import Reading
from plica.report.wording import axis, row

_CYCLES = 5  # shown
closed_is = f"area at most {100 * closed_share:g} % of the cycle's largest"


def closed_times(reading: Reading, count: int) -> list[tuple[float, float]]:
    """Beginning and end (s) of each time during which the glottis is closed, by the open quotient, in the
    last `count` cycles; none without cycles."""
    area = open_area(reading.waveforms)
    return [
        interval
        for start, end in pairwise(reading.cycles.starts[-count - 1 :])
        for interval in closed_intervals(reading.time, area, start, end, closed_share)
    ]


def shade(axes: Axes, times: Sequence[tuple[float, float]]) -> None:
    """Shade these times (s) over the height of the axes."""
    for begin, end in times:
        axes.axvspan(1e3 * begin, 1e3 * end, color=grey, alpha=0.18, lw=0)


def glottal_waveforms(reading: Reading) -> Drawing:
    """Glottal area and flow in the last cycles."""
    part = reading.last_cycles(_CYCLES)
    time = 1e3 * reading.time[part]
    of_area, area = axis("glottal area", STORED["minimum_area"])
    of_flow, flow = axis("flow", STORED["flow"])
    closed = closed_times(reading, _CYCLES)

    def paint(figure: Figure) -> None:
        top, bottom = figure.subplots(2, 1, sharex=True)
        top.plot(time, of_area * open_area(reading.waveforms)[part], color=blue)
        bottom.plot(time, of_flow * reading.wave("flow")[part], color=red)
        over_time((top, area), (bottom, flow))
        for axes in (top, bottom):
            shade(axes, closed)
        if closed:
            named = [Patch(color=grey, alpha=0.18, lw=0, label=f"closed: {closed_is}")]
            top.legend(handles=named, loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2)

    caption = "The smallest section area and the flow through it."
    quotient = reading.measures.get("open_quotient")
    if closed:
        caption += f" Shaded: the glottis is closed ({closed_is})"
        if quotient is not None and quotient.value is not None:
            caption += f"; the rest of the cycle is the open quotient of {row(quotient).value}"
        caption += ". Folds that touch may leave a slit with some flow."
    elif reading.cycles.count:
        caption += f" In these cycles the glottis does not close (to an {closed_is})."
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

    averaged_too = reading.measures.get("peak_contact_pressure")
    without_limit = (
        "With these surfaces, which have mass, either pressure grows"
        if averaged_too is not None and averaged_too.no_limit
        else "The pressure of a single step grows"
    )

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
        f"pressure. {without_limit} as the step falls and has no limit; impulse and duration do not grow."
    )
    alt = "Contact force on the left and right fold over time, and the peak contact pressure below it."
    return draw("Contact", caption, alt, (9.2, 4.2), paint)
