"""Measures and waveforms as text: labels and units of the catalogue, and number formats."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from plica.measures.catalogue import CATALOGUE
from plica.measures.caution import Caution
from plica.measures.measure import Measure
from plica.measures.scale import SI, Scale, shown_unit
from plica.measures.waveforms import Waveform

headline = (
    "fundamental_frequency",
    "open_quotient",
    "peak_flow",
    "contact_impulse",
    "contact_length_fraction",
    "damping_ratio",
)


@dataclass(frozen=True)
class Row:
    """One line of the table; the note has that of the record, and the definition if there is a value."""

    name: str
    label: str
    value: str
    unit: str
    spread: str
    interval: str
    cycles: str
    cautions: tuple[str, ...]
    note: str
    numerical: str = ""
    doubts: tuple[str, ...] = ()


def typeset(unit: str) -> str:
    """A unit of the catalogue with superscripts and Greek letters; empty for a pure number."""
    if unit == "1":
        return ""
    if unit == "deg":
        return "°"
    raised = unit.replace("^2", "²").replace("^3", "³")
    return f"µ{raised[1:]}" if raised.startswith("u") else raised


def axis(label: str, entry: Waveform, scale: Scale = SI) -> tuple[float, str]:
    """Factor and label with unit of an axis for a waveform."""
    factor, unit = shown_unit(scale.unit(entry.unit), entry.shown)
    return factor, f"{label} ({typeset(unit)})"


def number(value: float, digits: int = 4) -> str:
    """A number with this many significant digits, or all it has if these are fewer, with a typographic minus,
    and powers of ten if shorter."""
    if not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)) + 1e-12)
    if value == round(value) and abs(value) < 1e7:
        text = f"{round(value)}"
    elif -4 <= exponent < 6:
        text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
        if "." in text and float(text) == value:  # 0.8 kPa is given, not measured to four digits
            text = text.rstrip("0")
    else:
        mantissa, power = f"{value:.{min(digits, 3) - 1}e}".split("e")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa} × 10{raised}"
    return text.replace("-", "−")


def digits_of(value: float, interval: tuple[float, float] | None, most: int = 6) -> int:
    """Significant digits of a value by its interval: the last is that of the half-width's first digit, or
    further on, where rounding there would leave the interval."""
    if interval is None or value == 0:
        return most
    low, high = interval
    half = 0.5 * (high - low)
    if not half > 1e-12 * abs(value):
        return most
    last = math.floor(math.log10(half))
    digits = min(max(math.floor(math.log10(abs(value)) + 1e-12) - last + 1, 1), most)
    while digits < most and low <= value <= high and not low <= float(f"{value:.{digits - 1}e}") <= high:
        digits += 1
    return digits


def row(item: Measure) -> Row:
    """A measure in its common unit, with its numerical uncertainty if there is one."""
    factor, unit = item.quantity.people(item.scale)
    digits = 4 if item.value is None else min(digits_of(item.value, item.interval), 4)
    half = None if item.bound is None else item.bound.uncertainty
    if item.value is not None and half:
        digits = min(digits_of(item.value, (item.value - half, item.value + half)) + 1, 6)
    value = "–" if item.value is None else number(factor * item.value, digits)
    spread = "" if item.spread is None else number(factor * shown_spread(item), 2)
    return Row(
        name=item.name,
        label=item.quantity.label,
        value=value,
        unit=typeset(unit) if item.value is not None else "",
        spread=spread,
        interval=_interval(item, factor, digits),
        cycles=str(item.cycles) if item.cycles else "",
        cautions=item.cautions,
        note="; ".join(filter(None, (item.note, item.quantity.meaning if item.value is not None else ""))),
        numerical="" if half is None else number(factor * half, 2),
        doubts=() if item.bound is None else item.bound.doubts,
    )


def shown_spread(item: Measure) -> float:
    """The scatter of a measure that has one; 0 for round-off."""
    spread = item.spread or 0.0
    return 0.0 if item.value and abs(spread) < 1e-9 * abs(item.value) else spread


def _decade(value: float) -> int:
    return math.floor(math.log10(abs(value)) + 1e-12) if value else 0


def _interval(item: Measure, factor: float, digits: int) -> str:
    """ "0.61 to 0.64", rounded to the value's last digit, or empty."""
    if item.interval is None or item.value is None:
        return ""
    ends = []
    last = _decade(item.value) - digits
    for end in item.interval:
        ends.append(number(factor * end, max(_decade(end) - last, 1)))
    return " to ".join(ends)


def numbered(texts: Sequence[str], notes: list[str]) -> tuple[int, ...]:
    """The numbers, from 1, of these texts in `notes`, to which new ones are added."""
    notes.extend(text for text in dict.fromkeys(texts) if text not in notes)
    return tuple(notes.index(text) + 1 for text in texts)


def numbered_after(texts: Sequence[str], cautions: Sequence[Caution], notes: list[str]) -> tuple[int, ...]:
    """As :func:`numbered`, counted on from the cautions of the page: a text that one of them says has its
    number, and is no note."""
    found: dict[int, None] = {}
    for text in texts:
        said = (k for k, caution in enumerate(cautions, 1) if text.casefold() in caution.seen.casefold())
        number = next(said, 0) or len(cautions) + numbered([text], notes)[0]
        found[number] = None
    return tuple(found)


def tables(measures: Mapping[str, Measure]) -> list[tuple[str, list[Row]]]:
    """The measures by group, in the order of the catalogue; a reason for a missing value is given once, and
    other measures refer to that."""
    groups: dict[str, list[Row]] = {}
    first_labels: dict[str, str] = {}
    for name, entry in CATALOGUE.items():
        if name not in measures:
            continue
        made, item = row(measures[name]), measures[name]
        if (
            item.value is None
            and item.note
            and (first := first_labels.setdefault(item.note, made.label)) != made.label
        ):
            made = replace(made, note=made.note.replace(item.note, f"see {first}", 1))
        groups.setdefault(entry.group, []).append(made)
    return list(groups.items())


def headlines(measures: Mapping[str, Measure]) -> Sequence[Row]:
    """The main measures at the top of the page; of these, those that have a value and converge."""
    found = [measures[name] for name in headline if name in measures]
    return [row(item) for item in found if item.value is not None and not item.no_limit]
