"""Paper A, Figs. 9, 10 and 12, Table IV; Paper B, Fig. 2: how the contact force goes through a collision."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from benchmarks.thesis.cases import PRESSURES
from benchmarks.thesis.judging import Value, rises
from benchmarks.thesis.plate import Plate
from benchmarks.thesis.reading import Record, Shelf
from benchmarks.thesis.wording import number, verdict_text
from plica.report.drawing import blue, green, grey, purple, red

PUBLISHED_STRESS = (0.54, 1.17, 1.21)  # kPa, Table IV
AROUND = 0.5e-3  # s shown before and after a collision


def collision(record: Record, margin: float = AROUND) -> slice:
    """Frames of the typical cycle's collision and a margin; all of them without contact."""
    part = record.typical
    if part is None:
        return slice(0, record.frames)
    touching = part.start + np.flatnonzero(record.force[part] > 0.01 * record.force[part].max())
    more = round(margin / record.run.scene.time.step)
    return slice(max(int(touching[0]) - more, 0), min(int(touching[-1]) + more + 1, record.frames))


def since(record: Record, part: slice, margin: float = AROUND) -> np.ndarray:
    """ms since the typical collision's first contact."""
    return np.asarray(1e3 * (record.time[part] - record.time[part.start] - margin))


def columns(curves: dict[str, tuple[np.ndarray, ...]]) -> list[list[object]]:
    """Curves as rows: name, time and values."""
    return [[name, *row] for name, curve in curves.items() for row in zip(*curve, strict=True)]


def overlap_of(record: Record) -> float:
    """µm, by which the node of the edge passes its opposite at most."""
    return 1e6 * max(float((record.place("edge left") - record.place("edge"))[:, 0].max()), 0.0)


def one_node(shelf: Shelf) -> Plate | None:
    records = {"multipliers": shelf.get("B"), "penalty 1e7": shelf.get("B", "1e7")}
    exact = shelf.get("B", "multipliers")
    curves = {}
    overlap = {} if exact is None else {"n + 1": overlap_of(exact)}
    for name, record in records.items():
        if record is None or record.typical is None:
            return None
        part = collision(record, 1e-3)
        x, opposite = record.place("edge")[:, 0], record.place("edge left")[:, 0]
        speed = np.gradient(x, record.run.scene.time.step)
        force = record.node_force("edge")
        overlap[name] = overlap_of(record)
        wave = (
            since(record, part, 1e-3),
            1e2 * x[part],
            1e2 * opposite[part],
            1e2 * speed[part],
            force[part],
        )
        curves[name] = wave

    def paint(figure: Figure) -> None:
        panels = figure.subplots(3, 1, sharex=True)
        for (name, (time, x, opposite, speed, force)), colour, line in zip(
            curves.items(), (blue, red), ("-", ":"), strict=True
        ):
            panels[0].plot(time, x, line, color=colour, label=name)
            panels[0].plot(time, opposite, line, color=colour, alpha=0.6)
            panels[1].plot(time, speed, line, color=colour)
            panels[2].plot(time, 1e4 * force, line, color=colour)
        for axes, label in zip(panels, ("x (cm)", "velocity (cm/s)", "force (10⁻⁴ N)"), strict=True):
            axes.set_ylabel(label)
        panels[0].legend(loc="upper center", ncols=2)
        panels[-1].set_xlabel("time since first contact (ms)")

    rough = {name: record.roughness for name, record in records.items() if record is not None}
    text = (
        f"The node passes its opposite by {overlap['penalty 1e7']:.0f} µm with the penalty and by "
        f"{overlap['multipliers']:.0f} µm with multipliers at the weighted position of Eq. (25) "
        f"({overlap.get('n + 1', np.nan):.2g} µm at n + 1). That the nodal force of multipliers is the "
        f"rougher one is {verdict_text(rises([rough['penalty 1e7'], rough['multipliers']]))}."
    )
    return Plate(
        "fig09",
        "Figure 9: position, velocity and contact force of a node",
        "The penalty (kappa = 1e7) lets the folds overlap visibly, multipliers do not; their force jumps.",
        text,
        ["run", "time (ms)", "x (cm)", "x of the opposite (cm)", "velocity (cm/s)", "force (N)"],
        columns(curves),
        (6.4, 4.4),
        paint,
    )


def impact_stress(shelf: Shelf) -> Plate | None:
    records = {"multipliers": shelf.get("B"), "penalty 1e7": shelf.get("B", "1e7")}
    curves, rise, peaks = {}, {}, {}
    for name, record in records.items():
        if record is None or record.typical is None:
            return None
        part = collision(record)
        curves[name] = (since(record, part), 1e-3 * record.stress[part])
        rise[name], peaks[name] = early(record), record.peak(record.stress, 1e-3)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for (name, curve), colour, line in zip(curves.items(), (blue, red), ("-", ":"), strict=True):
            axes.plot(*curve, line, color=colour, label=name)
        axes.set(xlabel="time since first contact (ms)", ylabel="stress (kPa)")
        axes.legend(loc="upper right")

    text = (
        f"The stress of multipliers peaks {number(rise['multipliers'], 2)} of the collision after its "
        f"start, that of the penalty {number(rise['penalty 1e7'], 2)}; the peaks are "
        f"{number(peaks['multipliers'], 2)} and {number(peaks['penalty 1e7'], 2)} kPa. The earlier peak is "
        f"{verdict_text(rises([rise['multipliers'], rise['penalty 1e7']]))}, its greater height "
        f"{verdict_text(rises([peaks['penalty 1e7'], peaks['multipliers']]))}. A peak of one step is no "
        "property of the folds: [it grows as the step falls](phonation.md)."
    )
    return Plate(
        "fig10",
        "Figure 10: mediolateral contact stress through a collision",
        "Multipliers: a sudden peak, then a gradual fall and a small rise at the end. Penalty: low and "
        "smooth.",
        text,
        ["run", "time (ms)", "stress (kPa)"],
        columns(curves),
        (5.2, 2.4),
        paint,
    )


def early(record: Record) -> Value | None:
    """Where in a collision the stress is largest: 0 at first contact, 1 at the last."""
    found = []
    for part in record.parts:
        touching = np.flatnonzero(record.force[part] > 0.01 * record.force[part].max())
        if touching.size > 3 and record.force[part].max() > 0:
            place = np.argmax(record.stress[part]) - touching[0]
            found.append(float(np.clip(place / (touching[-1] - touching[0]), 0, 1)))
    return Value.of(found)


def regression(pressures: np.ndarray, stresses: np.ndarray) -> tuple[float, float]:
    """Slope and coefficient of determination of the straight line through the points."""
    slope, start = np.polyfit(pressures, stresses, 1)
    left = ((stresses - slope * pressures - start) ** 2).sum()
    return float(slope), float(1 - left / ((stresses - stresses.mean()) ** 2).sum())


def stress_by_pressure(shelf: Shelf) -> Plate | None:
    head = ["", *(f"{pressure:g} kPa" for pressure in PRESSURES), "slope", "R²"]
    printed = regression(np.array(PRESSURES), np.array(PUBLISHED_STRESS))
    rows: list[list[object]] = [["published (kPa)", *PUBLISHED_STRESS, *printed]]
    for base in ("B", "P"):
        found = [shelf.get(base, pressure=pressure) for pressure in PRESSURES]
        if any(record is None for record in found):
            continue
        for name, values in (
            ("force over area, one step", [r.peak(r.stress, 1e-3) for r in found if r]),
            ("nodal pressure, mean of 0.2 ms", [r.value("peak_contact_pressure", 1e-3) for r in found if r]),
        ):
            means = np.array([np.nan if value is None else value.mean for value in values])
            line = regression(np.array(PRESSURES), means) if np.isfinite(means).all() else (np.nan, np.nan)
            rows.append([f"{base}, {name} (kPa)", *means, *line])
    if len(rows) == 1:
        return None
    grow = all(np.all(np.diff(np.array(row[1:4], dtype=float)) > 0) for row in rows[1:])
    text = (
        f"{'As published, each of our stresses grows' if grow else 'Not all of our stresses grow'} with "
        "the pressure. The printed regression (1.72, 0.989) is not that of the three printed points."
    )
    return Plate(
        "table4",
        "Table IV: peak mediolateral contact stress by subglottal pressure",
        "The stress grows with the pressure, within 0.4 to 1.5 kPa.",
        text,
        head,
        rows,
    )


def schemes(shelf: Shelf) -> Plate | None:
    wanted = {
        "multipliers, HHT": ("weighted", "hht", blue, "-"),
        "multipliers, trapezoidal": ("weighted", "newmark", green, "-"),
        "penalty 1e7, HHT": ("1e7", "hht", red, "-"),
        "penalty 1e7, trapezoidal": ("1e7", "newmark", purple, "-"),
    }
    records = {name: shelf.get("B", contact, scheme=scheme) for name, (contact, scheme, *_) in wanted.items()}
    curves = {}
    for name, record in records.items():
        if record is None or record.typical is None:
            return None
        part = collision(record)
        curves[name] = (since(record, part), record.node_force("edge")[part])

    def paint(figure: Figure) -> None:
        for axes, kind in zip(figure.subplots(1, 2, sharex=True), ("multipliers", "penalty"), strict=True):
            for name, (time, force) in curves.items():
                if name.startswith(kind):
                    axes.plot(
                        time, 1e4 * force, wanted[name][3], color=wanted[name][2], label=name.split(", ")[1]
                    )
            axes.set(xlabel="time since first contact (ms)", title=kind)
            axes.legend(loc="upper right")
        figure.axes[0].set_ylabel("force (10⁻⁴ N)")

    verdicts = []
    for kind in ("multipliers", "penalty 1e7"):
        pair = [records[f"{kind}, {scheme}"] for scheme in ("HHT", "trapezoidal")]
        rougher = rises([r and r.roughness for r in pair])
        larger = rises([r and r.value("amplitude_right") for r in pair])
        verdicts.append(
            f"{kind}: rougher force {verdict_text(rougher)}, larger amplitude {verdict_text(larger)}"
        )
    steady = all(r is not None and r.run.status == "finished" for r in records.values())
    stable = "All four are stable at 50 µs as published." if steady else "Not all are stable at 50 µs."
    text = f"By the trapezoidal rule, {'; '.join(verdicts)}. {stable}"
    return Plate(
        "fig12",
        "Figure 12: force at a node by time scheme",
        "The undamped Newmark scheme makes the force rougher and, with the penalty, larger.",
        text,
        ["run", "time (ms)", "force (N)"],
        columns(curves),
        (7.2, 2.5),
        paint,
    )


def augmented_force(shelf: Shelf) -> Plate | None:
    wanted = {"multipliers": "weighted", "penalty 1e7": "1e7", "augmented, 4": "augmented 4"}
    colours = {"multipliers": (blue, "-"), "penalty 1e7": (red, ":"), "augmented, 4": (green, "--")}
    curves, rough = {}, []
    for name, contact in wanted.items():
        record = shelf.get("B", contact)
        if record is not None and record.typical is not None:
            part = collision(record)
            curves[name] = (since(record, part), record.node_force("edge")[part])
            rough.append(f"{name} {number(record.roughness, 2)}")
    if not curves:
        return None
    absent = (
        "" if "augmented, 4" in curves else " The augmented run is not made: the engine does not know it yet."
    )

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for name, (time, force) in curves.items():
            axes.plot(time, 1e4 * force, colours[name][1], color=colours[name][0], label=name)
        axes.axhline(0, color=grey, lw=0.6)
        axes.set(xlabel="time since first contact (ms)", ylabel="force (10⁻⁴ N)")
        axes.legend(loc="upper right")

    return Plate(
        "paperb_fig2",
        "Paper B, Figure 2: force at a node by method",
        "Four augmentations make the force smoother than plain multipliers.",
        f"Total variation of the nodal forces, one rise and fall being 1: {', '.join(rough)}.{absent}",
        ["run", "time (ms)", "force (N)"],
        columns(curves),
        (5.2, 2.4),
        paint,
    )
