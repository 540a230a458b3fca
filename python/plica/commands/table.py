"""Table of measures for the terminal."""

from __future__ import annotations

from collections.abc import Mapping

from plica.measures.measure import Measure
from plica.report.wording import digits_of

__all__ = ["MAIN_MEASURES", "measures_table"]

MAIN_MEASURES = (
    "fundamental_frequency",
    "open_quotient",
    "speed_quotient",
    "peak_flow",
    "mean_flow",
    "glottal_area_max",
    "amplitude_left",
    "amplitude_right",
    "peak_contact_pressure",
    "contact_impulse",
    "contact_duration",
    "contact_length_fraction",
    "ledger_error",
)


def measures_table(measures: Mapping[str, Measure], *, short: bool = False) -> str:
    """The measures in common units, each followed by its cautions; `short`: only the main ones.

    Cautions are not repeated; a measure without a value refers to the first one with the same reason, or is
    omitted from the short table.
    """
    names = [name for name in MAIN_MEASURES if name in measures] if short else []
    lines: list[str] = []
    shown: set[str] = set()
    reasons: dict[str, str] = {}
    for name in names or measures:
        item = measures[name]
        if item.value is None:
            if short and item.note in shown:
                continue
            first = reasons.setdefault(item.note, name) if item.note else name
            note = item.note if first == name else f"see {first}"
            lines.append(f"{name:<40} -            {note}".rstrip())
            shown.add(item.note)
            continue
        new = [_without(text, shown) for text in item.cautions if text not in shown]
        mark = "!" if item.cautions else ""
        lines.append(f"{_line(item)} {mark}".rstrip())
        lines += [f"    ! {text}" for text in new]
        shown.update(item.cautions)
    return "\n".join(lines)


def _without(text: str, shown: set[str]) -> str:
    """The text without a final part that was shown before."""
    ends = (f"; {reason}" for reason in sorted(shown) if text.endswith(f"; {reason}"))
    return text.removesuffix(next(ends, ""))


def _line(item: Measure) -> str:
    factor, unit = item.quantity.people(item.scale)
    unit = "" if unit == "1" else unit
    spread = f"+- {item.spread * factor:.2g}" if item.spread is not None else ""
    cycles = f"({item.cycles} cycles)" if item.cycles else ""
    if item.interval is not None:
        low, high = (float(f"{factor * end:.3g}") for end in item.interval)
        cycles = f"[{low:g}, {high:g}] {cycles}"
    digits = digits_of(item.value or 0.0, item.interval)
    if item.interval is None and item.spread and item.value:  # two digits of the spread, as it is shown
        digits = min(digits_of(item.value, (item.value - item.spread, item.value + item.spread)) + 1, 6)
    value = float(f"{(item.value or 0.0) * factor:.{digits}g}")
    return f"{item.name:<40} {value:<12.6g} {unit:<8} {spread:<11} {cycles:<12}"
