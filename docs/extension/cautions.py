"""The page of all cautions, each with a scene that gives it, which a test runs."""

# ruff: noqa: E501  the lines of a page

from __future__ import annotations

import inspect
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "python"))

from caution_scenes import BLOCKS, GIVEN, LARYNX
from plica.measures.run.cautions import CHECKS
from plica.scene.body_cautions import CHECKS as BODY_CHECKS
from plica.scene.bounds import BOUNDS

INTRODUCTION = """\
# Cautions

A caution refuses nothing. It states an observation, with value and unit, and what to check or to do.
`plica run` prints those of the scene before it starts and all of them at the end; `plica measures` prints
them too. They are at the top of `report.html` and, as `[{"name", "seen", "advice"}]`, in `cautions.json`;
in Python they are `run.cautions`.

Each is shown with a small scene that gives only this caution (or also those named): one of the two
[at the end](#the-scenes), changed as shown. A test runs all of them, in half a minute.

## Of the scene

Quantities that no larynx has, often because of a missing unit; the caution suggests the unit that may have been
meant. Only scenes with an `[airflow]` are checked, and the size of a mesh file whose `unit` is left out. A quantity of
exactly zero is treated as absent.
"""

BODIES = """\
## Of the bodies

How bodies of tissue are held, and where they are: of scenes with an `[airflow]` or without. Cells that share nodes
are one body.
"""

RUN = """\
## Of the run
"""

SCENES = """\
## The scenes

Unchanged, neither gives a caution. `larynx`:
"""


def shown(name: str) -> str:
    """What is changed in which scene."""
    given = GIVEN[name]
    base = "larynx" if given.scene is LARYNX else "blocks"
    also = f", also `{'`, `'.join(given.also)}`" if given.also else ""
    return f"`{base}`{also} with:\n\n```toml\n{given.changes.replace('without ', '# left out: ')}\n```\n"


def text() -> str:
    """The page."""
    parts = [INTRODUCTION]
    for name, bound in BOUNDS.items():
        parts += [f"### `{name}`\n", f"{bound.whose} **{bound.span()}**. {bound.reason}\n", shown(name)]
    parts.append(BODIES)
    for body_check in BODY_CHECKS:
        parts += [
            f"### `{body_check.__name__}`\n",
            f"{inspect.getdoc(body_check)}\n",
            shown(body_check.__name__),
        ]
    parts.append(RUN)
    for check in CHECKS:
        parts += [f"### `{check.__name__}`\n", f"{inspect.getdoc(check)}\n", shown(check.__name__)]
    parts += [SCENES, f"```toml\n{LARYNX}```\n", "`blocks`:\n", f"```toml\n{BLOCKS}```\n"]
    return "\n".join(parts).rstrip() + "\n"
