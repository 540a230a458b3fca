"""Paper A, Fig. 13: a stiffer right fold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from benchmarks.thesis.cases import MISMATCHES
from benchmarks.thesis.judging import Value, rises
from benchmarks.thesis.plate import Plate
from benchmarks.thesis.reading import Record, Shelf
from benchmarks.thesis.wording import number, verdict_text
from plica.report.drawing import blue, grey, red


@dataclass(frozen=True)
class Fold:
    """One fold at one mismatch."""

    force: Value | None  # mN, mean over a collision
    compression: Value | None  # kPa, in the middle half
    anywhere: Value | None  # kPa
    place: Value | None  # x of node 6157 or its opposite where they are closest, over that at rest


def measured(record: Record) -> dict[str, Fold]:
    gap = record.place("6157")[:, 0] - record.place("6157 left")[:, 0]
    folds = {}
    for side, probe in (("left", "6157 left"), ("right", "6157")):
        x = record.place(probe)[:, 0] / record.points[record.node(probe), 0]
        closest = [part.start + int(np.argmin(gap[part])) for part in record.parts]
        middle, anywhere = (record.compression[name] for name in (f"{side} middle", side))
        folds[side] = Fold(
            record.value(f"contact_force_{side}_mean", 1e3),
            *(
                Value.of(1e-3 * stress[part.start // 2 : part.stop // 2].max() for part in record.parts)
                for stress in (middle, anywhere)
            ),
            Value.of(x[closest]),
        )
    return folds


def amplitude_ratio(record: Record | None) -> Value | None:
    """Right over left, of node 6157 and its opposite."""
    if record is None:
        return None
    right, left = record.place("6157")[:, 0], record.place("6157 left")[:, 0]
    return Value.of(float(np.ptp(right[part]) / np.ptp(left[part])) for part in record.parts)


def anteroposterior(record: Record) -> float:
    """N, largest component along y of the total contact force."""
    return float(np.abs(record.wave("contact_force_second")[:, 1]).max())


def asymmetry(shelf: Shelf) -> Plate | None:
    found = {percent: shelf.get("B", asymmetry=percent) for percent in MISMATCHES}
    free = {percent: shelf.get("B", "neglected", asymmetry=percent) for percent in MISMATCHES}
    if any(record is None for record in found.values()):
        return None
    records = {percent: record for percent, record in found.items() if record is not None}
    folds = {percent: measured(record) for percent, record in records.items()}
    ratios = {percent: amplitude_ratio(record) for percent, record in records.items()}
    bare = {percent: amplitude_ratio(record) for percent, record in free.items()}

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1, 3)
        for k, side in enumerate(("left", "right")):
            places = np.arange(len(records)) + 0.4 * k - 0.2
            colour = (red, blue)[k]
            for axes, name in zip(panels[:2], ("force", "compression"), strict=True):
                values = [getattr(folds[percent][side], name) for percent in records]
                means = [0.0 if value is None else value.mean for value in values]
                errors = [
                    0.0 if value is None or not np.isfinite(value.error) else value.error for value in values
                ]
                axes.bar(places, means, 0.36, yerr=errors, color=colour, label=side, error_kw={"lw": 0.8})
        for values, line, name in ((ratios, "o-", "with contact forces"), (bare, "o--", "neglected")):
            known = {percent: value for percent, value in values.items() if value is not None}
            panels[2].plot(
                [MISMATCHES.index(p) for p in known],
                [v.mean for v in known.values()],
                line,
                color=grey,
                label=name,
                ms=4,
            )
        names = ("mean contact force (mN)", "compression, middle half (kPa)", "amplitude, right / left")
        for axes, name in zip(panels, names, strict=True):
            axes.set(title=name, xticks=range(len(records)), xticklabels=[f"{p} %" for p in records])
        panels[0].legend(fontsize=7)
        panels[2].legend(fontsize=7)

    grows = {
        side: verdict_text(rises([folds[p][side].compression for p in records])) for side in ("left", "right")
    }
    apart = max(float(record.measures["contact_force_balance"].value or 0) for record in records.values())
    along, most = max(anteroposterior(record) for record in records.values()), max(records)
    text = (
        f"Forces on both folds differ by {apart:.0e} of the largest. Growth of the largest compression in "
        f"the middle half with the mismatch: left fold {grows['left']}, right one {grows['right']}. "
        f"Amplitude right over left at {most} %: {number(ratios[most], 3)}; without contact forces "
        f"{number(bare[most], 3)}. The largest "
        f"anteroposterior force is {along:.0e} N."
    )
    rows = [
        [percent, side, *(x for value in values for x in parts(value))]
        for percent in records
        for side, fold in folds[percent].items()
        for values in [
            (fold.force, fold.compression, fold.anywhere, fold.place, ratios[percent], bare[percent])
        ]
    ]
    names = (
        "force (mN)",
        "compression in the middle half (kPa)",
        "compression anywhere (kPa)",
        "x at closest / x at rest",
        "amplitude ratio",
        "the same, no forces",
    )
    return Plate(
        "fig13",
        "Figure 13: tension mismatch of 0, 20 and 40 %",
        "Equal contact forces on both folds; compression and amplitude ratio grow with the mismatch; "
        "anteroposterior forces of 1e-6 N.",
        text,
        ["mismatch (%)", "fold", *(text for name in names for text in (name, f"error of {name}"))],
        rows,
        (7.6, 2.6),
        paint,
    )


def parts(value: Value | None) -> list[float]:
    return [np.nan, np.nan] if value is None else [value.mean, value.error]
