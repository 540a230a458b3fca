"""Each tutorial runs as it is written, ends with a picture, and costs less than a minute of a processor."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from repository import ROOT

TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("[0-9]*.py"))
BUDGET = (
    60.0  # s of processors, of the tutorial and of all that it starts; the slowest takes 50 s on an idle one
)
_RUN = """
import resource, runpy, sys
import matplotlib.pyplot as plt
runpy.run_path(sys.argv[1], run_name="__main__")
used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(len(plt.get_fignums()), sum(one.ru_utime + one.ru_stime for one in used))
"""


def test_there_are_tutorials() -> None:
    assert [int(path.name[:2]) for path in TUTORIALS] == list(range(1, 12))


@pytest.mark.slow
@pytest.mark.parametrize("tutorial", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_within_its_budget_and_ends_with_a_picture(tutorial: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _RUN, str(tutorial)],
        cwd=tutorial.parent,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    pictures, seconds = done.stdout.splitlines()[-1].split()
    assert int(pictures) >= 1
    assert float(seconds) < BUDGET
