"""Paper A, Fig. 11; Paper B, Figs. 3 and 4: what overlap does to contact area, force and open quotient."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from benchmarks.thesis.cases import AUGMENTED
from benchmarks.thesis.judging import Value, rises
from benchmarks.thesis.plate import Plate
from benchmarks.thesis.reading import Record, Shelf
from benchmarks.thesis.wording import number
from plica.report.drawing import blue, green, grey, red

MARKS = {
    "weighted": ("o", "LM"),
    "multipliers": ("D", "LM at n + 1"),
    "1e7": ("v", "κ 1e7"),
    "1e6": ("s", "κ 1e6"),
    "1e5": ("^", "κ 1e5"),
    "augmented 1": ("<", "A1"),
    "augmented 2": ("<", "A2"),
    "augmented 4": ("<", "A4"),
    "augmented": (">", "A, converged"),
}
NAMED = ("weighted", "1e7", "1e5", "augmented 4")  # in the text; the data have all


@dataclass(frozen=True)
class Point:
    """One way to enforce contact at one pressure."""

    base: str
    contact: str
    pressure: float
    volume: Value | None  # mm^3
    ratio: Value | None  # to that with the contact forces neglected
    area: Value | None  # mm^2
    force: Value | None  # mN
    open_quotient: Value | None


def point(shelf: Shelf, base: str, contact: str, pressure: float) -> Point | None:
    record, free = shelf.get(base, contact, pressure), shelf.get(base, "neglected", pressure)
    if record is None:
        return None
    volume = record.peak(record.volume, 1e9)
    bare = None if free is None else free.peak(free.volume, 1e9)
    ratio = volume.over(bare) if volume and bare and bare.mean > 0 and volume.mean > 0 else None
    return Point(
        base,
        contact,
        pressure,
        volume,
        ratio,
        record.peak(record.area, 1e6),
        record.peak(record.force, 1e3),
        record.value("open_quotient_1_percent"),
    )


def points(shelf: Shelf, contacts: tuple[str, ...]) -> list[Point]:
    wanted = [("B", 0.8), ("B", 0.6), ("P", 0.8)]
    found = [point(shelf, base, contact, p) for base, p in wanted for contact in (*contacts, "neglected")]
    return [one for one in found if one is not None]


def rows(found: list[Point]) -> list[list[object]]:
    def both(value: Value | None) -> list[float]:
        return [np.nan, np.nan] if value is None else [value.mean, value.error]

    return [
        [one.base, one.contact, one.pressure]
        + [
            x
            for value in (one.volume, one.ratio, one.area, one.force, one.open_quotient)
            for x in both(value)
        ]
        for one in found
    ]


HEADER = ["base", "contact", "pressure (kPa)"] + [
    text
    for name in ("volume (mm3)", "volume ratio", "area (mm2)", "force (mN)", "open quotient (1 %)")
    for text in (name, f"error of {name}")
]


def scatter(figure: Figure, found: list[Point], names: tuple[str, ...], labels: tuple[str, ...]) -> None:
    for axes, name, label in zip(np.atleast_1d(figure.subplots(1, len(names))), names, labels, strict=True):
        for one in found:
            value, mark = getattr(one, name), MARKS.get(one.contact)
            if one.base != "B" or value is None or one.ratio is None or mark is None:
                continue
            kind = one.contact.split()[0]
            colour = {"weighted": blue, "multipliers": blue, "augmented": green}.get(kind, red)
            full = colour if one.pressure == 0.8 else "white"
            error = value.error if np.isfinite(value.error) else 0.0
            title = mark[1] if one.pressure == 0.8 and axes is figure.axes[0] else None
            axes.errorbar(
                one.ratio.mean,
                value.mean,
                error,
                fmt=mark[0],
                color=colour,
                mfc=full,
                ms=6,
                lw=0.8,
                label=title,
            )
        axes.set(xscale="log", xlabel="overlap volume / that without forces", ylabel=label)
        axes.set_ylim(0, 1.1 * axes.get_ylim()[1])
        axes.grid(color=grey, alpha=0.2, lw=0.5)
    figure.axes[0].legend(loc="best", fontsize=7)


def trend_text(found: list[Point], name: str, digits: int, unit: str) -> str:
    texts = []
    for pressure in (0.8, 0.6):
        chosen = [
            one for one in found if one.base == "B" and one.pressure == pressure and one.contact in NAMED
        ]
        listed = ", ".join(f"{MARKS[one.contact][1]} {number(getattr(one, name), digits)}" for one in chosen)
        if listed:
            texts.append(f"{pressure:g} kPa: {listed}")
    return f"{'; '.join(texts)} {unit}."


def comparison(found: list[Point]) -> str:
    """Whether area and force follow the overlap, from multipliers to the softest penalty, at 0.8 kPa."""
    chosen = {one.contact: one for one in found if one.base == "B" and one.pressure == 0.8}
    names = ("weighted", "1e7", "1e6", "1e5")
    if any(name not in chosen for name in names):
        return ""
    area, force = (rises([getattr(chosen[name], what) for name in names]) for what in ("area", "force"))
    texts = [
        {
            "pass": "The area grows with the overlap as published",
            "fail": "The area does not grow with the overlap",
        }.get(area, "Whether the area grows with the overlap is undecided")
    ]
    texts.append(
        {"pass": "the force too.", "undecided": "whether the force does is undecided."}.get(
            force,
            "but the force falls: the overlap of a soft penalty is bounded by that without forces, so its "
            "force vanishes with kappa, while multipliers stop the folds within single steps.",
        )
    )
    return ", ".join(texts)


def overlap(shelf: Shelf) -> Plate | None:
    found = points(shelf, ("weighted", "multipliers", "1e7", "1e6", "1e5"))
    if not any(one.ratio for one in found):
        return None

    def paint(figure: Figure) -> None:
        scatter(figure, found, ("area", "force"), ("largest contact area (mm²)", "largest force (mN)"))

    return Plate(
        "fig11",
        "Figure 11: contact area and force over the overlap",
        "Both grow as kappa falls and the folds overlap more; less pressure, less force.",
        comparison(found),
        HEADER,
        rows(found),
        (7.4, 3.0),
        paint,
    )


def _of_paper_b(
    shelf: Shelf, name: str, file: str, title: str, shows: str, digits: int, unit: str
) -> Plate | None:
    found = points(shelf, ("weighted", "1e7", "1e6", "1e5", *AUGMENTED))
    if not any(one.ratio for one in found):
        return None
    known = any(one.contact in AUGMENTED for one in found)
    absent = "" if known else " The augmented runs are not made: the engine does not know them yet."

    def paint(figure: Figure) -> None:
        scatter(figure, found, (name,), (f"largest {name} ({unit})",))

    return Plate(
        file,
        title,
        shows,
        trend_text(found, name, digits, unit) + absent,
        HEADER,
        rows(found),
        (4.4, 3.0),
        paint,
    )


def paper_b_force(shelf: Shelf) -> Plate | None:
    return _of_paper_b(
        shelf,
        "force",
        "paperb_fig3",
        "Paper B, Figure 3: total contact force over the overlap",
        "Force depends strongly on kappa, little on pressure with multipliers (the errata: its sizes are "
        "too large; right in Paper A, Fig. 11b).",
        2,
        "mN",
    )


def paper_b_area(shelf: Shelf) -> Plate | None:
    return _of_paper_b(
        shelf,
        "area",
        "paperb_fig4",
        "Paper B, Figure 4: contact area over the overlap",
        "Area grows with the overlap; multipliers hardly depend on the pressure.",
        1,
        "mm²",
    )


def reduction(record: Record | None, free: Record | None) -> Value | None:
    """By what factor a run's overlap is smaller than without contact forces; None where it has none."""
    if record is None or free is None:
        return None
    least, most = record.peak(record.volume), free.peak(free.volume)
    if least is None or most is None or least.mean <= 0:
        return None
    return most.over(least)
