"""Text output of an estimate: plan, source, table, and CSV file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from plica.measures.catalogue import CATALOGUE
from plica.measures.scale import shown_unit
from plica.measures.uncertainty import VERDICTS, Refinement, Uncertain, Uncertainty
from plica.runs.results import Run
from plica.storage.table import write_table
from plica.uncertainty.comparison import Computed
from plica.uncertainty.plan import Plan, transient
from plica.uncertainty.start import Start
from plica.units import clock, two_digits

__all__ = ["planned", "sentence", "uncertainty_table", "write_csv"]


def planned(plan: Plan, run: Run, start: Start | None) -> str:
    """The levels with their cost, before they are computed."""
    total = sum(level.seconds for level in plan.levels)
    where = (
        "from the start of the scene"
        if start is None
        else f"from the steady vibration at {1e3 * start.time:.4g} ms, without the first {transient} cycles"
    )
    lines = [
        f"plica: {len(plan.levels)} level{'s' * (len(plan.levels) != 1)} {where}: about {clock(total)}, "
        f"{total / max(run.seconds, 1e-9):.2g} times the time of the run",
        *(f"plica:   {level.text()}" for level in plan.levels),
        *(f"plica:   {remark}" for remark in plan.remarks),
    ]
    return "\n".join(lines)


def sentence(levels: Sequence[Computed], run: Run, start: Start | None) -> str:
    """The source of the uncertainties, as one sentence."""
    if not levels:
        return "No level could be computed: the numerical error is unknown."
    cells = len(run.mesh.cells)
    named = [
        f"1/{one.level.factor:g} of the step"
        if one.level.kind == "step"
        else f"a mesh of {len(one.run.mesh.cells) / cells:.2g} times the cells"
        for one in levels
    ]
    named = [*named[:-2], " and ".join(named[-2:])]
    where = (
        "each from the start of the scene"
        if start is None
        else f"each from the steady vibration at {1e3 * start.time:.4g} ms without the first {transient} "
        "cycles"
    )
    return f"By comparison with {', '.join(named)}, {where} (docs/uncertainty.md)."


def uncertainty_table(found: Uncertainty) -> str:
    """Measures with uncertainties in common units; one line per waveform; source and remarks."""
    head = f"{'':<40} {'value':<12} {'numerical':<10} {'unit':<8} {'step':<28} {'mesh':<28} statistical"
    lines = [head]
    for item in found.measures.values():
        factor, unit = _shown_unit(item)
        numerical = "?" if item.numerical is None else f"{factor * item.numerical:.2g}"
        statistical = "" if item.statistical is None else f"{factor * item.statistical:.2g}"
        value = _rounded(factor * item.value, factor * (item.numerical or 0.0))
        lines.append(
            f"{item.name:<40} {value:<12} {numerical:<10} {'' if unit == '1' else unit:<8} "
            f"{_part(item.step, factor):<28} {_part(item.mesh, factor):<28} {statistical}".rstrip()
        )
    lines += [
        *_waveform_lines(found.waveforms),
        "",
        *_verdict_lines(found.measures.values()),
        found.source,
        *(f"! {remark}" for remark in found.remarks),
        *(
            f"! {item.name}: {CATALOGUE[item.name].no_limit}"
            for item in found.measures.values()
            if item.doubts and CATALOGUE[item.name].no_limit
        ),
    ]
    return "\n".join(lines)


def _verdict_lines(items: Iterable[Uncertain]) -> list[str]:
    """What each verdict in the table means."""
    shown = {part.verdict for item in items for part in (item.step, item.mesh) if part is not None}
    lines = [f"{verdict:<16} {meaning}" for verdict, meaning in VERDICTS.items() if verdict in shown]
    return (
        ["By step and by mesh; a level is the scene with another step or mesh:", *lines, ""] if lines else []
    )


def _waveform_lines(waveforms: Mapping[str, Uncertain]) -> list[str]:
    """The error of each waveform, and its largest value with its instant."""
    names = dict.fromkeys(key.rpartition(".")[0] for key in waveforms)
    if not names:
        return []
    lines = [
        "",
        f"{'waveform, at fixed times':<40} {'off by':<12} {'largest value (numerical)':<32} at (numerical)",
    ]
    for name in names:
        off = waveforms[f"{name}.relative_error"].numerical
        error = "?" if off is None else f"{two_digits(100 * off)} %"
        peak, instant = (_with_error(waveforms[f"{name}.{what}"]) for what in ("peak", "peak_time"))
        lines.append(f"{name:<40} {error:<12} {peak:<32} {instant}")
    return lines


def _with_error(item: Uncertain) -> str:
    factor, unit = _shown_unit(item)
    numerical = "?" if item.numerical is None else f"{factor * item.numerical:.2g}"
    value = _rounded(factor * item.value, factor * (item.numerical or 0.0))
    return f"{value} ({numerical}) {'' if unit == '1' else unit}".rstrip()


def _shown_unit(item: Uncertain) -> tuple[float, str]:
    return CATALOGUE[item.name].people() if item.name in CATALOGUE else shown_unit(item.unit, "")


def _part(part: Refinement | None, factor: float) -> str:
    if part is None:
        return "not estimated"
    order = f" {part.order:.1f}" if part.order is not None and part.verdict.endswith("order") else ""
    return f"{factor * part.uncertainty:.2g} ({part.verdict}{order})"


def _rounded(value: float, half: float) -> str:
    """Rounded to the uncertainty's second digit, at most six digits."""
    if value == 0 or not half > 0:
        return f"{value:.6g}"
    digits = math.floor(math.log10(abs(value)) + 1e-12) - math.floor(math.log10(half)) + 2
    return f"{float(f'{value:.{min(max(digits, 1), 6)}g}'):g}"


def write_csv(found: Uncertainty, path: Path) -> None:
    """Write one row per quantity, in SI: value, uncertainties, orders and verdicts; empty if there is
    none."""
    rows = list(_rows(found))
    names = rows[0] if rows else ()
    write_table(path, {name: np.array([row[name] for row in rows], dtype=object) for name in names})


def _rows(found: Uncertainty) -> Iterator[Mapping[str, object]]:
    for item in (*found.measures.values(), *found.waveforms.values()):
        row: dict[str, object] = {
            "name": item.name,
            "unit": item.unit,
            "value": item.value,
            "numerical": _or_nan(item.numerical),
        }
        for kind, part in (("step", item.step), ("mesh", item.mesh)):
            row[kind] = _or_nan(None if part is None else part.uncertainty)
            row[f"{kind}_verdict"] = "not estimated" if part is None else part.verdict
            row[f"{kind}_order"] = _or_nan(None if part is None else part.order)
            row[f"{kind}_extrapolated"] = _or_nan(None if part is None else part.extrapolated)
        row |= {
            "statistical": _or_nan(item.statistical),
            "spread": _or_nan(item.spread),
            "cycles": item.cycles,
        }
        yield row


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value
