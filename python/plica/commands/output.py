"""What commands print: errors, cautions, the table of measures."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from plica.measures.catalogue import names
from plica.measures.measure import Measure
from plica.measures.thresholds import closed_share
from plica.report.wording import digits_of, shown_spread
from plica.units import two_digits

__all__ = ["MAIN_MEASURES", "measures_table", "print_cautions", "print_error"]

MAIN_MEASURES = (
    "fundamental_frequency",
    "open_quotient",
    "speed_quotient",
    "peak_flow",
    "mean_flow",
    "glottal_area_max",
    "amplitude_left",
    "amplitude_right",
    "contact_impulse",
    "contact_duration",
    "contact_force_left_mean",
    "peak_contact_pressure",
    "contact_length_fraction",
    "energy_balance_error",
)


_DIFFERENCES = names(recorded_from="edges", side="difference")
_digits_unbounded = 4  # of a value whose numerical uncertainty is not known, as on pages
_largest_count = 10**9  # that is written in full
_ROUND_OFF = 1e-6  # rad, and of the amplitudes; a symmetric run is symmetric to 1e-12


def measures_table(measures: Mapping[str, Measure], *, short: bool = False) -> str:
    """The measures in common units, each followed by its cautions; `short`: only the main ones.

    Cautions are not repeated; a measure without a value refers to the first one with the same reason, or is
    omitted from the short table.
    """
    main = (*MAIN_MEASURES, *_unlike(measures)) if short else ()
    chosen = [name for name in main if name in measures and not measures[name].no_limit]
    lines: list[str] = []
    shown: set[str] = set()
    reasons: dict[str, str] = {}
    for name in chosen or measures:
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
        if not short and item.note and item.note not in shown:
            lines.append(f"    {item.note}")
            shown.add(item.note)
        lines += [f"    ! {text}" for text in new]
        shown.update(item.cautions)
    return "\n".join([*lines, *_meaning([measures[name] for name in chosen or measures])])


def _unlike(measures: Mapping[str, Measure]) -> list[str]:
    """What compares the folds' edges, where they move differently: by more than round-off."""
    found = [name for name in measures if name in _DIFFERENCES]
    return found if any(abs(measures[name].value or 0.0) > _ROUND_OFF for name in found) else []


def _meaning(items: Sequence[Measure]) -> list[str]:
    """What the numbers beside the values are."""
    lines = []
    if any(item.name == "open_quotient" and item.value is not None for item in items):
        lines.append(
            f"open_quotient: closed is an area of at most {100 * closed_share:g} % of the cycle's largest"
        )
    if any(item.interval is not None for item in items):
        lines.append(
            "[from, to]: 95 % interval of the value, by bootstrap over cycles, with what pictures leave open"
        )
    if any(item.spread is not None for item in items):
        lines.append("scatter: standard deviation between cycles; it is no accuracy")
    sources = dict.fromkeys(item.bound.source for item in items if item.bound is not None)
    lines += [f"numerical: bound on the error of step and mesh ({source})" for source in sources]
    if sources:
        lines.append("neither has the error of the model")
    elif any(item.spread is not None for item in items) and not any(item.interval for item in items):
        lines.append("the numerical uncertainty is not known: plica uncertainty DIR estimates it")
    return ["", *lines] if lines else []


def _without(text: str, shown: set[str]) -> str:
    """The text without a final part that was shown before."""
    ends = (f"; {reason}" for reason in sorted(shown) if text.endswith(f"; {reason}"))
    return text.removesuffix(next(ends, ""))


def _line(item: Measure) -> str:
    factor, unit = item.quantity.people(item.scale)
    unit = "" if unit == "1" else unit
    cycles = f"({item.cycles} cycles)" if item.cycles else ""
    if item.spread is not None:
        spread = shown_spread(item)
        cycles = f"scatter of {item.cycles} cycles {two_digits(spread * factor)}"
    if item.interval is not None:
        low, high = (float(f"{factor * end:.3g}") for end in item.interval)
        cycles = f"[{low:g}, {high:g}] {cycles}"
    digits = digits_of(item.value or 0.0, item.interval)
    if item.interval is None and item.bound is None:
        digits = _digits_unbounded  # scatter is no accuracy, however small it is
    if item.interval is None and item.spread and item.value:  # two digits of the spread, as it is shown
        scattered = digits_of(item.value, (item.value - item.spread, item.value + item.spread)) + 1
        digits = min(scattered, digits)
    numerical = ""
    if item.bound is not None:
        doubts = f" ({'; '.join(item.bound.doubts)})" if item.bound.doubts else ""
        numerical = f"numerical {two_digits(factor * item.bound.uncertainty)}{doubts}"
    value = (item.value or 0.0) * factor
    counted = item.spread is None and value == round(value) and abs(value) < _largest_count
    text = f"{round(value)}" if counted else f"{float(f'{value:.{digits}g}'):.6g}"
    return f"{item.name:<40} {text:<12} {unit:<8} {cycles:<28} {numerical}".rstrip()


def print_error(text: str, code: int) -> int:
    """Print each line of a text on standard error; returns the exit code."""
    for line in text.splitlines():
        print(f"plica: {line}", file=sys.stderr)
    return code


def print_cautions(cautions: Sequence[object]) -> int:
    """Print cautions on standard error; returns 0."""
    return print_error("\n".join(f"Caution: {caution}" for caution in cautions), 0)
