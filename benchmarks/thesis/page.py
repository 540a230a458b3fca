"""docs/thesis.md: every figure with its sentence, and the table of trends, all numbers from the runs."""

from __future__ import annotations

import csv
import os
import textwrap
from pathlib import Path

from benchmarks.thesis import cases, plate
from benchmarks.thesis.asymmetry_plate import asymmetry
from benchmarks.thesis.contact_plates import (
    augmented_force,
    impact_stress,
    one_node,
    schemes,
    stress_by_pressure,
)
from benchmarks.thesis.cylinder_plates import forces, shapes
from benchmarks.thesis.enforcement_plates import overlap, paper_b_area, paper_b_force
from benchmarks.thesis.motion_plates import flow, glottal_shape, motion, surface_forces
from benchmarks.thesis.reading import Shelf
from benchmarks.thesis.trends import Trend, trends

PLATES = (
    motion,
    glottal_shape,
    flow,
    shapes,
    forces,
    surface_forces,
    stress_by_pressure,
    one_node,
    impact_stress,
    overlap,
    schemes,
    asymmetry,
    augmented_force,
    paper_b_force,
    paper_b_area,
)
HEAD = """\
Made by `python -m benchmarks.thesis`, engine {engine}; do not edit. Papers A and B are those of Granados
(2016). {mesh}

B is `examples/thesis_b.toml` (half the printed viscosity), P is `examples/thesis.toml` (as printed), both
with linear tetrahedra, {duration:g} s. The figures show B unless they say otherwise. Values are means over
the cycles of the last {last:g} ms ± standard error; the data of each figure are in
`benchmarks/thesis/data`. The set-up is near its threshold, and its results depend on step and mesh
([phonation.md](phonation.md)).

Contact area and stress are those of the right fold's triangles with a loaded vertex, overlap is the volume
of airway tetrahedra that are inside out. "LM" are multipliers that close the gap at the weighted position
of Eq. (25), "LM at n + 1" at the end of the step."""


REASONS = {  # beginning of a claim: why it may fail; shown where it does
    "f0 within": (
        "f0: linear tetrahedra on this mesh are too stiff, and the whole wall is held, which the thesis "
        "does not state ([phonation.md](phonation.md))."
    ),
    "open quotient (1 %) within": (
        "open quotient, flow, contact length: P hardly touches on this mesh, B closes over most of its "
        "length; the published values lie between."
    ),
    "f0 falls": "f0 by pressure: the published change is only 3 Hz.",
    "multipliers at the weighted": (
        "overlap: Eq. (25) as printed closes the gap at a weighted position and leaves 43 % of the last "
        "gap as overshoot; closed at the end of the step, only the tolerance is left."
    ),
    "multipliers' force": (
        "dependence on pressure: at 0.6 kPa B is near its threshold with multipliers, and their largest "
        "force is that of one step."
    ),
    "the trapezoidal": (
        "time schemes: the force of multipliers is rough with either scheme; with the penalty the "
        "published difference is seen."
    ),
    "largest compressive": (
        "compression: force and stress change from 0 to 20 to 40 % without order, by as much as separates "
        "one orbit from another; the mismatch itself moves the amplitudes by a few per cent."
    ),
}


def write(shelf: Shelf, docs: Path, data: Path) -> None:
    """The page, its pictures and their data; what lacks its runs is named and left out."""
    images = docs / "images"
    engine = (shelf.runs / "engine").read_text(encoding="utf-8")
    head = {"engine": engine, "mesh": mesh_text(shelf), "duration": cases.DURATION, "last": 1e3 * cases.LAST}
    found = trends(shelf)
    write_trends(found, data / "trends.csv")
    paragraphs = [filled(one) for one in HEAD.format(**head).split("\n\n")]
    text = ["# The thesis's figures, made anew", "", *(f"{one}\n" for one in paragraphs)]
    text += [trend_section(found, missing(shelf), os.path.relpath(data, docs))]
    for build in PLATES:
        made = build(shelf)
        if made is None:
            print(f"{build.__name__}: left out, its runs are not made or never touch")
            continue
        made.write_data(data)
        made.write_picture(images)
        text.append(section(made, os.path.relpath(images, docs), os.path.relpath(data, docs)))
        print(f"{made.name}: {made.text}")
    docs.mkdir(parents=True, exist_ok=True)
    (docs / "thesis.md").write_text("\n".join(text), encoding="utf-8")
    for trend in found:
        print(f"{trend.verdict.upper()}: {trend.claim}: {trend.found}")


def filled(text: str, below: str = "") -> str:
    """A paragraph as pages have it: its lines as long as may be, those after the first behind `below`."""
    return textwrap.fill(" ".join(text.split()), 120, break_on_hyphens=False, subsequent_indent=below)


def mesh_text(shelf: Shelf) -> str:
    record = shelf.get("B")
    if record is None:
        return ""
    unknowns = 3 * (len(record.points) - len(record.run.mesh.node_sets["wall"]))
    return f'Mesh: `larynx = "{shelf.mesh}"`, {len(record.run.mesh.cells)} tetrahedra, {unknowns} unknowns.'


def missing(shelf: Shelf) -> list[str]:
    """Runs of the table that are not there, or ended early."""
    found = []
    for case in cases.table(shelf.meshes):
        record = shelf.get(
            case.base,
            case.contact,
            case.pressure,
            mesh=case.mesh,
            scheme=case.scheme,
            asymmetry=case.asymmetry,
        )
        if record is None:
            found.append(case.name if cases.known(case) else f"{case.name} (no `[contact.{case.kind}]` yet)")
        elif record.run.status != "finished":
            found.append(f"{case.name} ({record.run.status} at {1e3 * float(record.run.time[-1]):.1f} ms)")
    return found


def section(made: plate.Plate, images: str, data: str) -> str:
    shows, text = (filled(words) for words in (f"*Thesis:* {made.shows}", f"*Here:* {made.text}"))
    lines = [f"## {made.title}", "", shows, "", text, ""]
    if made.paint is not None:
        lines += [f"![{made.title.partition(':')[0]}]({images}/thesis_{made.name}.png)", ""]
    else:
        lines += [f"Table: [{made.name}.csv]({data}/{made.name}.csv)", ""]
    return "\n".join(lines)


def trend_section(found: list[Trend], absent: list[str], data: str) -> str:
    counts = [f"{sum(t.verdict == v for t in found)} {v}" for v in ("pass", "fail", "undecided", "no value")]
    lines = [
        "## Trends",
        "",
        f"Of {len(found)} claims: {', '.join(counts)}.",
        "",
        filled(
            "A trend passes where its ends differ in the published sense by more than twice the standard "
            "error and no step goes against it by as much; it fails where a step does, and is undecided "
            "else. No value: the run is not made, its oscillation dies out or its folds never touch."
        ),
        "",
        f"Table: [trends.csv]({data}/trends.csv)",
        "",
    ]
    failed = [trend.claim for trend in found if trend.verdict == "fail"]
    why = [text for start, text in REASONS.items() if any(claim.startswith(start) for claim in failed)]
    if why:
        bullets = [filled(f"- {text}", "  ") for text in why]
        lines += ["Why claims fail, as far as known:", "", *bullets, ""]
    if absent:
        lines += [filled(f"Runs not made or not finished: {', '.join(absent)}."), ""]
    return "\n".join(lines)


def write_trends(found: list[Trend], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["claim", "published", "found", "verdict"])
        writer.writerows([trend.claim, trend.published, trend.found, trend.verdict] for trend in found)
