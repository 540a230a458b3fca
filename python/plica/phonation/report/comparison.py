"""Two runs beside each other: a simulation does not scatter, so differences have no interval."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from plica.errors import InvalidInput
from plica.measures.comparison import Change, changes
from plica.phonation.measures.cautions import cautions
from plica.phonation.measures.measure import measure
from plica.phonation.measures.run_data import RunData
from plica.phonation.report.page import sections
from plica.phonation.report.reading import read
from plica.report.comparison import Sheet
from plica.report.drawing import Drawing

__all__ = ["RunComparison", "compare_runs"]


@dataclass(frozen=True)
class RunComparison:
    """Two runs that came to their end, and their directories."""

    runs: tuple[RunData, RunData]
    directories: tuple[Path, Path]

    @cached_property
    def changes(self) -> list[Change]:
        """Every measure that both have."""
        before, after = (measure(run) for run in self.runs)
        return changes(before, after)

    @cached_property
    def remarks(self) -> list[str]:
        """What is to be minded, a sentence each."""
        before, after = (directory.resolve() for directory in self.directories)
        found = ["Both are the same run: every difference is 0, and says nothing."] if before == after else []
        for side, run in zip(("BEFORE", "AFTER"), self.runs, strict=True):
            found += [f"{side}: {caution}" for caution in cautions(run)]
        return found

    def sheet(self) -> Sheet:
        """The page: each figure that both reports have, one after the other."""
        names = tuple(directory.resolve().name for directory in self.directories)
        words = [
            "plica",
            "compare",
            *(str(directory.resolve()) for directory in self.directories),
            "-o",
            "DIR",
        ]
        facts = [
            {"run": str(directory), "steps": f"{run.time.size}", "duration": f"{1e3 * run.time[-1]:.4g} ms"}
            for directory, run in zip(self.directories, self.runs, strict=True)
        ]
        of_both = [{one.title: one for one in _drawings(run)} for run in self.runs]
        shown = [
            (title, [_named("Before", "b", one), _named("After", "a", of_both[1][title])])
            for title, one in of_both[0].items()
            if title in of_both[1]
        ]
        command = shlex.join(words)
        return Sheet((names[0], names[1]), (facts[0], facts[1]), self.remarks, self.changes, command, shown)


def compare_runs(runs: Sequence[RunData], directories: Sequence[Path]) -> RunComparison:
    """Two runs beside each other; InvalidInput where one has not come to its end."""
    for run, directory in zip(runs, directories, strict=True):
        if run.failure or run.time.size < run.steps_asked:
            raise InvalidInput(
                f"Compare: the run in {directory} came to {run.time.size} of {run.steps_asked} steps; must "
                f"be finished. Go on with it: plica run SCENE -o {directory} --resume."
            )
    return RunComparison((runs[0], runs[1]), (directories[0], directories[1]))


def _drawings(run: RunData) -> list[Drawing]:
    return [drawing for _, drawings in sections(read(run)) for drawing in drawings]


def _named(side: str, mark: str, drawing: Drawing) -> Drawing:
    """With the side in its caption, and names within the picture that are not those of the other side's."""
    svg = re.sub(r'((?: id="|href="#|url\(#))', rf"\g<1>{mark}", drawing.svg)
    return replace(drawing, caption=f"{side}. {drawing.caption}", svg=svg)
