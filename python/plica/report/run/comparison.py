"""Comparison of two runs: simulations are deterministic, so differences have no interval."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from plica.errors import InvalidInput
from plica.measures.comparison import Change, changes
from plica.measures.measure import Measure, Measures
from plica.measures.run.run_data import MeasuredRun
from plica.measures.scene_text import scene_table
from plica.report.comparison import Sheet
from plica.report.drawing import Drawing
from plica.report.run.beside import flow_of_both, players_of_both, sound_of_both
from plica.report.run.page import sections
from plica.report.run.reading import read
from plica.report.run.sound import read_sound
from plica.report.wording import row

__all__ = ["RunComparison", "compare_runs", "sheet_of_runs"]


@dataclass(frozen=True)
class RunComparison:
    """Two finished runs and their directories."""

    runs: tuple[MeasuredRun, MeasuredRun]
    directories: tuple[Path, Path]

    @cached_property
    def changes(self) -> list[Change]:
        """The changes of all measures that both have."""
        before, after = (run.measures for run in self.runs)
        return changes(before, after)

    @cached_property
    def remarks(self) -> list[str]:
        """Remarks and cautions."""
        before, after = (directory.resolve() for directory in self.directories)
        found = ["Both are the same run, so every difference is 0."] if before == after else []
        for side, run in zip(("BEFORE", "AFTER"), self.runs, strict=True):
            found += [f"{side}: {caution}" for caution in run.cautions]
        return [*found, *flow_against_pressure(*(run.measures for run in self.runs))]


def compare_runs(runs: Sequence[MeasuredRun], directories: Sequence[Path]) -> RunComparison:
    """Compare two runs; raises InvalidInput if one is not finished."""
    for run, directory in zip(runs, directories, strict=True):
        if run.failure or run.time.size < run.steps_asked:
            raise InvalidInput(
                f"Compare: the run in {directory} has {run.time.size} of {run.steps_asked} steps; must be "
                f"finished. Continue it: plica run SCENE -o {directory} --resume."
            )
    return RunComparison((runs[0], runs[1]), (directories[0], directories[1]))


def sheet_of_runs(found: RunComparison) -> Sheet:
    """The page: each figure that both reports have, one after the other."""
    names = tuple(directory.resolve().name for directory in found.directories)
    arguments = [
        "plica",
        "compare",
        *(str(directory.resolve()) for directory in found.directories),
        "-o",
        "DIR",
    ]
    facts = [
        {
            "run": str(directory),
            "steps": f"{run.time.size}",
            "duration": f"{1e3 * run.time[-1]:.4g} ms",
            "tubes": _tubes(run),
        }
        for directory, run in zip(found.directories, found.runs, strict=True)
    ]
    readings = [read(run) for run in found.runs]
    heard = [read_sound(one) for one in readings]
    both = [one for one in heard if one is not None]
    flow = flow_of_both(readings)
    shown = [] if flow is None else [("Flow of both", [flow])]
    if len(both) == len(heard):
        shown.append(("Sound of both", [sound_of_both(both)]))
    of_both = [
        {drawing.title: drawing for _, drawings in sections(*one) for drawing in drawings}
        for one in zip(readings, heard, strict=True)
    ]
    shown += [
        (title, [_named("Before", "b", one), _named("After", "a", of_both[1][title])])
        for title, one in of_both[0].items()
        if title in of_both[1]
    ]
    command = shlex.join(arguments)
    return Sheet(
        (names[0], names[1]),
        (facts[0], facts[1]),
        found.remarks,
        found.changes,
        command,
        shown,
        players_of_both(both) if len(both) == len(heard) else (),
    )


def _tubes(run: MeasuredRun) -> str:
    """The tubes of a run, and the formants of its tract."""
    found = [name for name in ("trachea", "tract") if scene_table(run.scene_text, name) is not None]
    tract = run.vocal_tract
    if tract is None or isinstance(tract, str):
        return " and ".join(found) or "none"
    formants = ", ".join(f"{one.frequency:.0f}" for one in tract.formants()[:4])
    return f"{' and '.join(found)}; formants {formants or 'none'} Hz"


def flow_against_pressure(before: Measures, after: Measures) -> list[str]:
    """A remark if the flow falls while the subglottal pressure rises, by more than the scatter of cycles.

    Parameters
    ----------
    before, after : Measures
        Of two runs.
    """
    pressure = "subglottal_pressure"
    if not all(pressure in one and one[pressure].value for one in (before, after)):
        return []
    less, more = sorted((before, after), key=lambda one: one[pressure].value or 0.0)
    falls = [name for name in ("peak_flow", "mean_flow") if _falls(less[name], more[name])]
    if not falls or less[pressure].value == more[pressure].value:
        return []
    said = " and ".join(
        f"the {less[name].quantity.label.lower()} falls from {_shown(less[name])} to {_shown(more[name])}"
        for name in falls
    )
    return [
        f"{said[0].upper()}{said[1:]} while the subglottal pressure rises from {_shown(less[pressure])} to "
        f"{_shown(more[pressure])}. A voice that keeps its pattern has more flow at more pressure: look at "
        "the glottal area and the coronal sections of both."
    ]


def _falls(less: Measure, more: Measure) -> bool:
    if less.value is None or more.value is None:
        return False
    return more.value < less.value - max(less.spread or 0.0, more.spread or 0.0)


def _shown(item: Measure) -> str:
    shown = row(item)
    return f"{shown.value} {shown.unit}"


def _named(side: str, mark: str, drawing: Drawing) -> Drawing:
    """The drawing with its side in the caption and with SVG ids that differ from the other side's."""
    svg = re.sub(r'((?: id="|href="#|url\(#))', rf"\g<1>{mark}", drawing.svg)
    return replace(drawing, caption=f"{side}. {drawing.caption}", svg=svg)
