"""The report of a sweep."""

from __future__ import annotations

import inspect
from pathlib import Path

from plica.errors import InvalidInput
from plica.measures.run.cautions import CHECKS
from plica.measures.scale import shown_unit
from plica.report.drawing import Drawing
from plica.report.page import render
from plica.report.wording import number, typeset
from plica.scene.body_cautions import CHECKS as BODY_CHECKS
from plica.scene.bounds import BOUNDS
from plica.storage.files import write_text
from plica.sweep.pictures import indices_picture, measures_picture
from plica.sweep.results import Sweep
from plica.sweep.sensitivity import ANALYSED, Indices, indices, write_indices

__all__ = ["write_report"]

_SHOWN = 50  # cases without a result, in full
_DESIGNS = {
    "grid": "all combinations",
    "list": "a list of cases",
    "latin_hypercube": "Latin hypercube",
    "sobol": "Sobol indices (Saltelli's design)",
    "morris": "Morris's elementary effects",
}
_KINDS = {
    "run": "Sweep of a scene",
    "recording": "Sweep of recordings",
    "identification": "Sweep of the tissue that recordings are asked for",
}


def write_report(sweep: Sweep, measures: tuple[str, ...] = ()) -> Path:
    """Write ``report.html`` and, of a whole design that has them, ``sensitivity.csv``; returns the page.

    measures: shown; default: the main ones.
    """
    shown = tuple(name for name in measures or sweep.main_measures)
    found, remarks = _indices(sweep, shown)
    if found:
        write_indices(found, sweep.directory / "sensitivity.csv")
    else:
        (sweep.directory / "sensitivity.csv").unlink(missing_ok=True)  # of other measures
    drawings: list[Drawing] = [measures_picture(sweep, shown)] if shown else []
    drawings += [indices_picture(found)] if found else []
    lost = sweep.without_result
    seconds = sweep.columns["seconds"][sweep.columns["seconds"] > 0]
    text = render(
        "sweep/report.html.j2",
        title=sweep.directory.resolve().name,
        running=f"Sweep {sweep.directory.resolve().name}",
        counts={name: count for name, count in sweep.counts.items() if count},
        cases=len(sweep),
        kind=_KINDS[sweep.record.get("kind", "run")],
        design=_DESIGNS[sweep.record["design"]],
        samples=sweep.record["samples"],
        seed=sweep.record["seed"],
        varied=[_varied(sweep, k) for k in range(len(sweep.keys))],
        drawings=drawings,
        remarks=remarks,
        lost=lost[:_SHOWN],
        more=max(len(lost) - _SHOWN, 0),
        cautions=[(name, count, meaning_of(name)) for name, count in sweep.caution_counts.items()],
        mean_seconds=number(float(seconds.mean()), 3) if seconds.size else "",
        version=sweep.record["plica_version"],
    )
    return write_text(text, sweep.directory / "report.html")


def meaning_of(caution: str) -> str:
    """What a caution of this name says of any scene or run; empty of one that is not in docs/cautions.md."""
    if bound := BOUNDS.get(caution):
        return f"{bound.whose} {bound.span()}."
    for check in (*BODY_CHECKS, *CHECKS):
        if check.__name__ == caution:
            return (inspect.getdoc(check) or "").replace("``", "")
    return ""


def _indices(sweep: Sweep, measures: tuple[str, ...]) -> tuple[list[Indices], list[str]]:
    """The indices that there are, and why there are no others."""
    found, remarks = [], []
    if sweep.record["design"] in ANALYSED:
        for name in measures:
            try:
                found.append(indices(sweep, name))
            except InvalidInput as error:
                remarks.append(str(error).removeprefix(f"{sweep.directory}: "))
    return found, remarks


def _varied(sweep: Sweep, k: int) -> tuple[str, str, str, str, int]:
    """Key, ends of its range in the plan, unit, number of different values. Of values that are given the ends
    are the least and the largest, of words the first and the last."""
    key, values = sweep.keys[k], sweep.values[:, k]
    if key in sweep.words:
        words = sweep.words[key]
        return key, words[0], words[-1], "", len(words)
    factor, unit = shown_unit(sweep.units[key])
    ranges = dict(
        zip([one for one in sweep.keys if one not in sweep.words], sweep.record["ranges"], strict=False)
    )
    low, high = (number(factor * float(end), 4) for end in ranges.get(key, (values.min(), values.max())))
    return key, low, high, typeset(unit or "1"), len(set(values))
