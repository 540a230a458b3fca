"""The page of scene keys, waveforms and measures, from the docstrings of the parts and the catalogue."""

# ruff: noqa: E501  the lines of a page

from __future__ import annotations

from collections.abc import Iterable

from plica.measures.catalogue import CATALOGUE
from plica.measures.waveforms import RECORDED, STORED, Waveform
from plica.scene.composition import COMBINATIONS
from plica.scene.reference import Table, scene_tables

INTRODUCTION = """\
# Scene keys, waveforms and measures

A scene is a TOML file, or a `plica.Scene` with parts and fields of the same names. A quantity is a number in the
unit of its row, or a text with any unit of that dimension: `step = 5e-5` is `step = "50 us"`. "Required" applies
within a table: a table may be left out as a whole. Keys of the scene itself that are not tables, such as
`gravity`, are written above the first table. `plica mesh SCENE` prints the names of layers,
surfaces and node sets; examples are in [examples](../examples).

A table with one of several kinds is written as the table of that kind or, if the kind needs no key, as its
name: `coupling = "lagged"`, `scheme = { hht = { alpha = -0.1 } }`, `[contact.multipliers]`.
"""

IN_WORDS = {"required", "one of these", "left out", "none", "see below", "the preset's"}

TIMES = """\
A run stores these every step (`plica.Run`, `results.h5`); those of airflow and contact only if the scene has them.

Times: `flow`, `minimum_area`, `separation`, `section_area`, `section_pressure` and `flow_stopped`, and all of
trachea and tract (pressures at the folds, flows, the tubes' energies), belong to t_{n+1+alpha}, the instant at which the time scheme balances forces (alpha of the HHT scheme, 0 for Newmark); with
lagged coupling to t_n. All others belong to the end of the step t_{n+1}, which is the value of `time`.
"""

FRAMES = """\
`plica video` stores these for every frame (`Analysis.waveforms`, `waveforms.csv`). Units apply to a recording with
known frame rate and pixel size; otherwise px, px^2 and frames. Left and right are those of the image.
"""

MEASURES = """\
`plica measures`, `measures.json` and the reports have the mean and the spread over three or more cycles (scatter: their standard deviation, no accuracy), or over
their collisions; or one value of the whole record; or no value and a note with the reason. The cycles of a run are the
steady ones, those of a recording all complete ones (`cycles_found`); in a recording a value also has a 95 % `interval`
(bootstrap over the cycles), which determines the digits shown. Cautions state what speaks against a value. Measures of
both kinds have the same definition in a run and in a recording, except the folds' amplitudes. `measures.json` is in the
unit, tables and reports in the unit "shown in"; a recording whose frame rate or pixel size is not known has
frames and px, 1/frame and px^2. Left and right are those of the patient, in a recording those of the image.
"""


def section(table: Table) -> str:
    """Heading, sentence and table of one part."""
    lines = [f"## {heading(table)}", "", table.description, ""]
    if not table.keys:
        return "\n".join(lines if "keys as in" in table.description else [*lines, "It has no keys.", ""])
    lines += ["| key | unit | default | meaning |", "|---|---|---|---|"]
    for key in table.keys:
        default = key.default if key.default in IN_WORDS else f"`{key.default}`"
        meaning = key.meaning.replace("|", "\\|")
        lines.append(f"| `{key.name}` | {key.unit} | {default} | {meaning} |")
    return "\n".join([*lines, ""])


def heading(table: Table) -> str:
    where = f"`[{table.path}]`" if table.path else "The scene"
    return f"{where} with `{table.kind}`" if table.kind else where


def waveforms(title: str, introduction: str, entries: Iterable[Waveform]) -> str:
    rows = [f"| `{entry.name}` | {entry.unit} | {entry.meaning} |" for entry in entries]
    return "\n".join(
        [f"## {title}", "", introduction, "| name | unit | meaning |", "|---|---|---|", *rows, ""]
    )


def combinations() -> str:
    kinds = {"physics": "by its nature", "construction": "not built"}
    lines = ["## What cannot be combined", "", "`plica keys combinations` prints these.", ""]
    for one in COMBINATIONS:
        lines.append(f"- **{one.reason[0].upper()}{one.reason[1:-1]}** ({kinds[one.kind]}):")
        for group in one.groups:
            options, others = (
                ", ".join(f"`{name}`" for name in names) for names in (group.options, group.others)
            )
            lines.append(f"  - {options}: {group.must} with {others}.{group.hint}")
    return "\n".join([*lines, ""])


def measures() -> str:
    """The catalogue, by group."""
    of = {"run": "run", "video": "recording", "both": "both"}
    lines = [
        "## Measures",
        "",
        MEASURES,
        "| name | unit | shown in | of | meaning |",
        "|---|---|---|---|---|",
    ]
    for entry in CATALOGUE.values():
        shown = entry.people()[1].replace("1", "")
        lines.append(f"| `{entry.name}` | {entry.unit} | {shown} | {of[entry.source]} | {entry.described}. |")
    return "\n".join([*lines, ""])


def text() -> str:
    """The page."""
    sections = [section(table) for table in scene_tables()]
    of_runs = waveforms("Waveforms of a run", TIMES, STORED.values())
    of_recordings = waveforms("Waveforms of a recording", FRAMES, RECORDED.values())
    return (
        "\n".join([INTRODUCTION, *sections, combinations(), of_runs, of_recordings, measures()]).rstrip()
        + "\n"
    )
