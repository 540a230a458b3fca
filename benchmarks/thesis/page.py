"""docs/thesis.md: every figure with its sentence, and the table of trends, all numbers from the runs."""

from __future__ import annotations

import csv
import os
import textwrap
from collections.abc import Sequence
from pathlib import Path

import cases
import plate
from asymmetry_plate import asymmetry
from contact_plates import augmented_force, impact_stress, one_node, schemes, stress_by_pressure
from cylinder_plates import forces, shapes
from enforcement_plates import overlap, paper_b_area, paper_b_force
from motion_plates import flow, glottal_shape, motion, surface_forces
from reading import Shelf
from trends import Trend, trends

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
HEAD = """# The thesis's figures, made anew

Made by `python benchmarks/thesis`; do not edit. Papers A and B are those of Granados (2016).
{mesh}

B is `examples/thesis_b.toml` (half the printed viscosity), P is `examples/thesis.toml` (as printed), both
with linear tetrahedra, {duration:g} s. The figures show B unless they say otherwise. Cycles are those of the
last {last:g} ms; values are means over cycles ± standard error. The data of each figure are in
`benchmarks/thesis/data`. What lies behind f0 and the size of the contact is in [phonation.md](phonation.md):
the set-up is near its threshold, and its results depend on step and mesh.

Definitions, as in the thesis: contact area is that of the right fold's interface triangles with a loaded
vertex, overlap the volume of airway tetrahedra that are inside out, contact stress the mediolateral force
over that area. "Forces neglected" is a penalty of 1e-15 of the thesis's. "LM" are Lagrange multipliers that
close the gap at the weighted position of Eq. (25), "LM at n + 1" at the end of the step.
"""


def write(shelf: Shelf, docs: Path, data: Path) -> None:
    """The page, its pictures and their data; what lacks its runs is named and left out."""
    images = docs / "images"
    text = [HEAD.format(mesh=mesh_text(shelf), duration=cases.DURATION, last=1e3 * cases.LAST)]
    for build in PLATES:
        made = build(shelf)
        if made is None:
            print(f"{build.__name__}: left out, its runs are not made or never touch")
            continue
        made.write_data(data)
        made.write_picture(images)
        text.append(section(made, os.path.relpath(images, docs)))
        print(f"{made.name}: {made.text}")
    found = trends(shelf)
    write_trends(found, data / "trends.csv")
    text.append(trend_section(found, missing(shelf)))
    docs.mkdir(parents=True, exist_ok=True)
    (docs / "thesis.md").write_text("\n".join(text), encoding="utf-8")
    for trend in found:
        print(f"{trend.verdict.upper()}: {trend.claim}: {trend.found}")


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


def row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def section(made: plate.Plate, images: str) -> str:
    shows, text = (textwrap.fill(words, 118) for words in (f"*Thesis:* {made.shows}", f"*Here:* {made.text}"))
    lines = [f"## {made.title}", "", shows, "", text, ""]
    if made.paint is not None:
        lines += [f"![{made.title}]({images}/thesis_{made.name}.png)", ""]
    if made.table:
        head, *rest = made.table
        lines += [row(head), row(["---"] * len(head)), *(row(cells) for cells in rest), ""]
    return "\n".join(lines)


def trend_section(found: list[Trend], absent: list[str]) -> str:
    counts = [f"{sum(t.verdict == v for t in found)} {v}" for v in ("pass", "fail", "undecided", "not made")]
    lines = [
        "## Trends",
        "",
        f"Of {len(found)} claims: {', '.join(counts)}.",
        "",
        "A trend passes where its ends differ in the published sense by more than twice the standard "
        "error and no step",
        "goes against it by as much; it fails where a step does, and is undecided else. Errors are "
        "those of independent",
        "cycles; a slow drift within the last 60 ms is not in them. Prototype: an independent program.",
        "",
        row(["claim", "published", "found", "verdict"]),
        row(["---"] * 4),
        *(row([trend.claim, trend.published, trend.found, f"**{trend.verdict}**"]) for trend in found),
        "",
    ]
    if absent:
        lines += [f"Runs not made or not finished: {', '.join(absent)}.", ""]
    return "\n".join(lines)


def write_trends(found: list[Trend], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["claim", "published", "found", "verdict"])
        writer.writerows([trend.claim, trend.published, trend.found, trend.verdict] for trend in found)
