"""The trends of Papers A and B, each as pass, fail or undecided with its figures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.thesis.asymmetry_plate import amplitude_ratio, anteroposterior, measured
from benchmarks.thesis.cases import MISMATCHES, PENALTIES, PRESSURES
from benchmarks.thesis.contact_plates import early
from benchmarks.thesis.enforcement_plates import reduction
from benchmarks.thesis.judging import Value, Verdict, all_of, between, falls, rises
from benchmarks.thesis.reading import Record, Shelf
from benchmarks.thesis.wording import listed, number, rounded

Reader = Callable[[Record], Value | None]


@dataclass(frozen=True)
class Trend:
    """One published claim and what was found."""

    claim: str
    published: str
    found: str
    verdict: Verdict


def read(records: list[Record | None], reader: Reader) -> list[Value | None]:
    return [None if record is None else reader(record) for record in records]


def area(record: Record) -> Value | None:
    return record.peak(record.area, 1e6)


def force(record: Record) -> Value | None:
    return record.peak(record.force, 1e3)


def stress(record: Record) -> Value | None:
    return record.peak(record.stress, 1e-3)


def volume(record: Record) -> Value | None:
    return record.peak(record.volume, 1e9)


def measure(name: str, factor: float = 1.0) -> Reader:
    return lambda record: record.value(name, factor)


def of_penalty(shelf: Shelf, base: str, pressure: float) -> Iterator[Trend]:
    """Falling penalty parameter, and multipliers as its limit."""
    where = f"{base}, {pressure:g} kPa"
    names = ["multipliers", *PENALTIES]
    records = [shelf.get(base, contact, pressure) for contact in ("weighted", *PENALTIES)]
    if all(record is None for record in records[1:]):
        return
    claims: list[tuple[str, str, Reader, Callable[..., Verdict], int, str, bool]] = [
        ("contact area grows as the penalty falls", "grows", area, rises, 1, "mm²", True),
        ("largest total force grows as the penalty falls", "grows", force, rises, -3, "mN", False),
        ("overlap volume grows as the penalty falls", "grows", volume, rises, -2, "mm³", True),
        (
            "open quotient (1 %) falls with the penalty",
            "0.87 (multipliers), 0.85, 0.76, 0.70",
            measure("open_quotient_1_percent"),
            falls,
            3,
            "",
            True,
        ),
    ]
    for claim, published, reader, rule, digits, unit, exact in claims:
        values = read(records, reader)
        compared = values if exact else values[1:]
        yield Trend(f"{claim} ({where})", published, listed(names, values, digits, unit), rule(compared))


def of_overlap(shelf: Shelf, base: str, pressure: float) -> Iterator[Trend]:
    """By what factor multipliers reduce the overlap."""
    free = shelf.get(base, "neglected", pressure)
    if free is None:
        return
    for contact, name, prototype in (
        ("weighted", "at the weighted position of Eq. (25)", "11 to 20"),
        ("multipliers", "at the end of the step", {"P": "1030", "B": "130"}[base]),
    ):
        record = shelf.get(base, contact, pressure)
        if record is None:
            continue
        factor = reduction(record, free)
        text = f"{number(volume(free), -3)} mm³ without forces, {number(volume(record), -2)} mm³"
        text += ": no overlap at all" if factor is None else f": {rounded(factor.mean)} times less"
        verdict: Verdict = (
            "pass" if factor is None else between(Value(factor.mean, factor.error), 1e3, np.inf)
        )
        claim = (
            f"multipliers {name} overlap at least 1000 times less than no forces ({base}, {pressure:g} kPa)"
        )
        yield Trend(claim, f"about 1e3 (prototype {prototype})", text, verdict)
    out = shelf.get(base, "none", pressure)
    if out is not None:
        values = read([out, free], volume)
        text = listed(["left out", "forces neglected"], values, 3, "mm³")
        same: Verdict = "no value" if None in values else "pass"
        if same == "pass" and "pass" in (rises(values), falls(values)):
            same = "fail"
        yield Trend(
            f"a scene without contact overlaps as one with its forces neglected ({base})", "", text, same
        )


def of_pressure(shelf: Shelf, base: str, mesh: str) -> Iterator[Trend]:
    """Subglottal pressure, on one mesh."""
    records = [shelf.get(base, "weighted", pressure, mesh=mesh) for pressure in PRESSURES]
    if any(record is None for record in records):
        return
    names = [f"{pressure:g} kPa" for pressure in PRESSURES]
    claims: list[tuple[str, str, Reader, Callable[..., Verdict], int, str]] = [
        (
            "f0 falls with pressure",
            "222, 219 Hz at 0.6, 0.8 kPa",
            measure("fundamental_frequency"),
            falls,
            1,
            "Hz",
        ),
        (
            "open quotient (1 %) falls with pressure",
            "0.89, 0.87 at 0.6, 0.8 kPa",
            measure("open_quotient_1_percent"),
            falls,
            3,
            "",
        ),
        (
            "peak flow grows with pressure",
            "500 to 600 cm³/s at 0.8 kPa",
            measure("peak_flow", 1e6),
            rises,
            0,
            "cm³/s",
        ),
        ("contact stress (one step) grows with pressure", "0.54, 1.17, 1.21 kPa", stress, rises, 2, "kPa"),
        (
            "contact pressure (0.2 ms) grows with pressure",
            "",
            measure("peak_contact_pressure", 1e-3),
            rises,
            2,
            "kPa",
        ),
    ]
    for claim, published, reader, rule, digits, unit in claims:
        values = read(records, reader)
        yield Trend(f"{claim} ({base}, {mesh})", published, listed(names, values, digits, unit), rule(values))


def of_robustness(shelf: Shelf) -> Iterator[Trend]:
    """Force and area from 0.6 to 0.8 kPa by method."""
    for name, reader, digits, unit in (("force", force, 2, "mN"), ("area", area, 1, "mm²")):
        changes: list[tuple[str, float]] = []
        texts, verdicts = [], []
        for contact in ("weighted", *PENALTIES):
            values = read([shelf.get("B", contact, pressure) for pressure in (0.6, 0.8)], reader)
            if None in values:
                return
            texts.append(f"{contact} {number(values[0], digits)} to {number(values[1], digits)} {unit}")
            verdicts.append(rises(values))
            low, high = (v.mean for v in values if v is not None)
            changes.append((contact, high / low if low else np.inf))
        if name == "force":
            yield Trend(
                "less pressure, less contact force, however enforced (B)",
                "yes",
                "; ".join(texts),
                all_of(verdicts),
            )
        least = min(changes, key=lambda change: change[1])[0]
        ratios = ", ".join(f"{contact} {ratio:.2f}" for contact, ratio in changes)
        claim = f"multipliers' {name} depends least on pressure (B, 0.8 over 0.6 kPa)"
        yield Trend(claim, "yes", ratios, "pass" if least == "weighted" else "fail")


def of_scheme(shelf: Shelf) -> Iterator[Trend]:
    """HHT against the trapezoidal rule."""
    for contact, other, where in (
        ("weighted", "weighted", "multipliers"),
        ("multipliers", "weighted", "multipliers, both at n + 1"),  # without alpha the positions are one
        ("1e7", "1e7", "penalty 1e7"),
    ):
        pair = [shelf.get("B", contact), shelf.get("B", other, scheme="newmark")]
        if any(record is None for record in pair):
            continue
        names = ["HHT", "trapezoidal"]
        rough = read(pair, lambda record: record.roughness)
        wide = read(pair, measure("amplitude_right", 1e3))
        yield Trend(
            f"the trapezoidal nodal force is rougher ({where})", "yes", listed(names, rough, 3), rises(rough)
        )
        yield Trend(
            f"the trapezoidal amplitude is larger ({where})", "yes", listed(names, wide, 3, "mm"), rises(wide)
        )
        states = [record.run.status for record in pair if record is not None]
        ended: Verdict = "pass" if states == ["finished"] * 2 else "fail"
        yield Trend(f"both are stable at 50 µs ({where})", "yes", " and ".join(states), ended)


def of_method(shelf: Shelf) -> Iterator[Trend]:
    """Smoothness by method."""
    wanted = ("1e7", "weighted")
    pair = [shelf.get("B", contact) for contact in wanted]
    names = ["penalty 1e7", "multipliers"]
    rough = read(pair, lambda record: record.roughness)
    yield Trend(
        "multipliers' nodal force is rougher than the penalty's (B)",
        "yes",
        listed(names, rough, 3),
        rises(rough),
    )
    places = read(pair[::-1], early)
    yield Trend(
        "the stress of multipliers peaks earlier in the collision (B)",
        "a sudden peak at first impact",
        listed(names[::-1], places, 2),
        rises(places),
    )
    augmented = read([shelf.get("B", "augmented 4"), shelf.get("B")], lambda record: record.roughness)
    yield Trend(
        "four augmentations make the nodal force smoother than multipliers (B)",
        "yes",
        listed(["augmented 4", "multipliers"], augmented, 3),
        rises(augmented),
    )


def of_asymmetry(shelf: Shelf) -> Iterator[Trend]:
    """0, 20 and 40 % tension mismatch."""
    records = [shelf.get("B", asymmetry=percent) for percent in MISMATCHES]
    if any(record is None for record in records):
        return
    known = [record for record in records if record is not None]
    names = [f"{percent} %" for percent in MISMATCHES]
    apart = [record.measures["contact_force_balance"].value for record in known]
    equal: Verdict = "pass" if all(a is not None and a < 1e-9 for a in apart) else "fail"
    text = f"their sum is at most {max(a for a in apart if a is not None):.0e} of the largest"
    yield Trend("equal total forces on both folds at every mismatch (B)", "equal", text, equal)
    along = [anteroposterior(record) for record in known]
    text = ", ".join(f"{name} {1e6 * a:.1f}" for name, a in zip(names, along, strict=True)) + " µN at most"
    small: Verdict = "pass" if max(along) < 1e-5 else "fail"
    yield Trend("anteroposterior contact force of order 1e-6 N (B)", "1e-6 N", text, small)
    ratios = [amplitude_ratio(record) for record in known]
    away = [None if ratio is None else Value(abs(ratio.mean - 1), ratio.error) for ratio in ratios]
    found = listed(names, ratios, 3)
    yield Trend("amplitude ratio, right over left, moves away from 1 (B)", "grows", found, rises(away))
    folds = [measured(record) for record in known]
    for side in ("left", "right"):
        for where, values in (
            ("the middle half of", [fold[side].compression for fold in folds]),
            ("all of", [fold[side].anywhere for fold in folds]),
        ):
            claim = f"largest compressive stress in {where} the {side} fold grows with the mismatch (B)"
            yield Trend(claim, "grows", listed(names, values, 2, "kPa"), rises(values))


def of_voice(shelf: Shelf) -> Iterator[Trend]:
    """Single published figures."""
    for base in ("P", "B"):
        record = shelf.get(base)
        if record is None:
            continue
        wanted: list[tuple[str, str, Reader, float, float, int, str]] = [
            ("f0 within 10 % of 219 Hz", "219 Hz", measure("fundamental_frequency"), 197, 241, 1, "Hz"),
            ("peak flow within 500 to 600 cm³/s", "500-600", measure("peak_flow", 1e6), 500, 600, 0, "cm³/s"),
            (
                "open quotient (1 %) within 0.05 of 0.87",
                "0.87",
                measure("open_quotient_1_percent"),
                0.82,
                0.92,
                3,
                "",
            ),
            (
                "contact length within 0.1 of 0.40",
                "0.40",
                measure("contact_length_fraction"),
                0.3,
                0.5,
                2,
                "",
            ),
            ("converging while opening", "yes", measure("converging_while_opening"), 0.5, 1.01, 2, ""),
            ("diverging while closing", "yes", measure("diverging_while_closing"), 0.5, 1.01, 2, ""),
        ]
        for claim, published, reader, low, high, digits, unit in wanted:
            value = reader(record)
            text = f"{number(value, digits)} {unit}".rstrip()
            yield Trend(f"{claim} ({base}, {shelf.mesh})", published, text, between(value, low, high))


def trends(shelf: Shelf) -> list[Trend]:
    found: list[Trend] = [*of_voice(shelf)]
    for base, pressure in (("B", 0.8), ("B", 0.6), ("P", 0.8)):
        found += [*of_penalty(shelf, base, pressure), *of_overlap(shelf, base, pressure)]
    for base in ("B", "P"):
        for mesh in shelf.meshes:
            found += of_pressure(shelf, base, mesh)
    for part in (of_robustness, of_method, of_scheme, of_asymmetry):
        found += part(shelf)
    return found
