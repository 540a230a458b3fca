"""The study of a voice: its runs, and their records beside the thesis's figures, by step, mesh and sections.

    python -m benchmarks.voice.phonation -o runs                    all parts
    python -m benchmarks.voice.phonation -o runs --only voice       one part

Runs are made in the folder where they are missing and go on where they were stopped; a record is written as
soon as its runs are there. Parts, each a variation of examples/normal_phonation.toml but the last:

voice    the presets of meshes; half and a quarter of the step; sections of the airflow; surfaces without mass
cells    the size of the cells at the folds, its growth, the lines around the airway
tissue   how strained linear tissue is, by subglottal pressure
start    how the pressure rises and what opening velocity the folds have, and the start and the voice then
thesis   examples/thesis.toml (P) and thesis_b.toml (B), on the thesis's mesh and a coarser one

All but the start's and the thesis's are measured from START on. Spreads, errors and limits: measures.py.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import of_this_engine, record, script_parser
from benchmarks.tissue.larynx_modes import symmetric_modes
from benchmarks.voice.measures import (
    F0,
    FLOW,
    IMPULSE,
    OPEN,
    STRAIN,
    Voice,
    change_columns,
    changes,
    measured,
    side_by_side,
)
from plica.measures.run.measure import steady_cycles

EXAMPLES = ROOT / "examples"
START = 0.06  # s, where the voice has settled
SLOWER = 0.15  # s, where quieter ones have
SHORT = 0.12  # s, as long as a look at cells takes
MASSLESS = {"contact.surface_mass": "redistributed"}
CELLS = (  # size at the folds (mm), growth, lines
    (1.0, 0.3, 20),
    (1.0, 0.3, 32),
    (0.7, 0.45, 20),
    (0.55, 0.6, 20),
    (0.55, 0.2, 20),
    (0.55, 0.2, 32),
    (0.4, 0.2, 20),
    (0.35, 0.5, 20),
    (0.35, 0.8, 20),
    (0.35, 0.8, 12),
    (0.25, 0.8, 12),
    (0.35, 0.4, 16),
)
MESHES = ("coarse", "demo", "fine", "finest")
PRESSURES = (400, 300, 200)  # Pa
RISES = (0.0, 5.4, 8.0, 11.0, 16.0, 22.0)  # ms, of the pressure
AT_REST = (0.0, 5.4, 22.0)  # those also without an opening velocity
STARTS = [(rise, opened) for rise in RISES for opened in ((True, False) if rise in AT_REST else (True,))]


def start_name(rise: float, opened: bool) -> str:
    """Of the run with a rise of the pressure (ms), with the example's opening velocity or without."""
    return f"rise_{rise:g}_ms{'' if opened else '_at_rest'}"


# Run: changes of the example.
RUNS: dict[str, dict[str, Any]] = {
    **{name: {"mesh.larynx": name} for name in MESHES},
    "half_step": {"time.step": 25e-6},
    "quarter_step": {"time.step": 12.5e-6},
    **{f"sections_{count}": {"airflow.area.cut.sections": count} for count in (50, 100, 400)},
    "massless": MASSLESS,
    "massless_half_step": MASSLESS | {"time.step": 25e-6},
    "massless_quarter_step": MASSLESS | {"time.step": 12.5e-6},
    **{f"massless_{mesh}": MASSLESS | {"mesh.larynx": mesh} for mesh in ("fine", "finest")},
    **{
        f"cells_{size}_{growth}_{lines}": {
            "mesh.options": {"size": 1e-3 * size, "growth": growth, "around": lines},
            "time.duration": SHORT,
        }
        for size, growth, lines in CELLS
    },
    **{
        f"coarse_{pressure}_pa": {"mesh.larynx": "coarse", "airflow.subglottal_pressure": float(pressure)}
        for pressure in PRESSURES
    },
    **{
        start_name(rise, opened): {"airflow.rise": 1e-3 * rise, "time.duration": 0.16}
        | ({} if opened else {"initial": None})
        for rise, opened in STARTS
    },
}
# Run: example, mesh.
THESIS = {
    f"{case}_{mesh.removeprefix('thesis_')}": (example, mesh)
    for case, example in (("P", "thesis"), ("B", "thesis_b"))
    for mesh in ("thesis_medium", "thesis")
}


def scene_of(name: str) -> plica.Scene:
    """No fields are stored; 0.3 s, but where the run says otherwise or is the thesis's."""
    if name in THESIS:
        example, mesh = THESIS[name]
        return plica.Scene.load(EXAMPLES / f"{example}.toml").replace({"mesh.larynx": mesh, "output": None})
    example = plica.Scene.load(EXAMPLES / "normal_phonation.toml")
    return example.replace({"time.duration": 0.3, "output": None} | RUNS[name])


class Study:
    """The runs of a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def voice(self, name: str, start: float = START, until: float | None = None) -> Voice:
        """A run, made where it is missing; one that fails is measured as far as it came."""
        directory = self.folder / name
        print(f"{directory}", file=sys.stderr, flush=True)
        try:
            run = plica.run(scene_of(name), directory, resume="if_there")
        except plica.SolveFailed as error:
            print(f"{name} failed: {error}", file=sys.stderr, flush=True)
            run = plica.Run.load(directory)
        return Voice(name.replace("_", " "), run, start, until)

    def voices(self, *names: str, start: float = START) -> list[Voice]:
        return [self.voice(name, start) for name in names]


def table_note(voices: Sequence[Voice], start: float = START) -> str:
    remarks = [f"{voice.name}: {voice.remarks}." for voice in voices if voice.remarks]
    end = max(float(voice.run.time[-1]) for voice in voices)
    return " ".join([f"From {1e3 * start:g} to {1e3 * end:.0f} ms.", *remarks])


def keep_changes(name: str, voices: Sequence[Voice], level: Callable[[Voice], float]) -> None:
    record(name, change_columns(voices), changes(voices, level), table_note(voices))


def keep_side_by_side(name: str, voices: Sequence[Voice], start: float = START) -> None:
    columns = ["", *(voice.name for voice in voices), "published"]
    record(name, columns, side_by_side(voices), table_note(voices, start))


def step(voice: Voice) -> float:
    return float(voice.run.scene.time.step)


def modes(voice: Voice) -> str:
    """The lowest symmetric ones, of the mass that the voice moves with."""
    scene = voice.run.scene
    _, found = symmetric_modes(scene.mesh, surface_mass=scene.contact.surface_mass)
    return ", ".join(f"{frequency:.1f}" for frequency in found)


def voice_part(study: Study) -> None:
    meshes, steps = study.voices(*MESHES), study.voices("half_step", "quarter_step")
    demo = meshes[1]
    keep_side_by_side("phonation", [*meshes, *steps])
    keep_changes("phonation_step", [demo, *steps], step)
    keep_changes("phonation_mesh", meshes, lambda voice: voice.unknowns ** (-1 / 3))
    fewer, more = study.voices("sections_50", "sections_100"), study.voice("sections_400")
    keep_changes("phonation_sections", [*fewer, demo, more], lambda voice: 1 / voice.sections)
    massless, fine, finest = study.voices("massless", "massless_fine", "massless_finest")
    pairs = [demo, massless, meshes[2], fine, meshes[3], finest]
    rows = [*measured(pairs), ["f1, f2, f3 of free vibration (Hz)", *map(modes, pairs)]]
    record("phonation_massless", ["", *(voice.name for voice in pairs)], rows, table_note(pairs))
    steps = study.voices("massless_half_step", "massless_quarter_step")
    keep_changes("phonation_massless_step", [massless, *steps], step)


def cells_part(study: Study) -> None:
    quantities = (F0, OPEN, FLOW, IMPULSE)
    columns = ["size at the folds, growth, lines", "unknowns", *(quantity.head for quantity in quantities)]

    def rows() -> Iterator[list[str]]:
        tried = {f"{s:g} mm, {g:g}, {n}": f"cells_{s}_{g}_{n}" for s, g, n in CELLS}
        for shown, name in (tried | {f"`{mesh}`": mesh for mesh in MESHES}).items():
            voice = study.voice(name, until=SHORT)
            yield [shown, str(voice.unknowns), *(voice.text(quantity) for quantity in quantities)]

    record("phonation_cells", columns, rows(), f"From {1e3 * START:g} to {1e3 * SHORT:g} ms.")


def tissue_part(study: Study) -> None:
    quantities = (F0, OPEN, FLOW, STRAIN)
    columns = ["pressure, `coarse`", *(q.head for q in quantities), "linear tissue off by", "in the start"]
    shown = {"0.8 kPa": "coarse"} | {f"{p / 1000:g} kPa": f"coarse_{p}_pa" for p in PRESSURES}

    def rows() -> Iterator[list[str]]:
        for name, run in shown.items():
            voice = study.voice(run, SLOWER)
            cells = [voice.text(quantity) for quantity in quantities]
            yield [name, *cells, off_by(voice), off_by(voice.run)]

    record("phonation_tissue", columns, rows(), f"From {1e3 * SLOWER:g} to 300 ms.")


def off_by(run: Voice | plica.Run) -> str:
    """|E - eps| over |grad u| where it is largest, as the report's caution says it."""
    return f"{100 * np.sqrt(np.max(run.waveforms['strain_neglected']) / 2):.0f} %"


def start_part(study: Study) -> None:
    """The start, which is all before the steady cycles, and the cycles."""
    quantities = (F0, OPEN, FLOW)
    columns = ["`rise`", "`opening_velocity`", "steady from", "strain, start", "linear tissue off by, start"]
    columns += ["inverted cells, start", "strain, cycles", "off by, cycles", "inverted cells, cycles"]
    columns += [quantity.head for quantity in quantities]
    voices = {given: study.voice(start_name(*given), start=0.0) for given in STARTS}

    def rows() -> Iterator[list[str]]:
        for (rise, opened), voice in voices.items():
            cycles, time = steady_cycles(voice.run), voice.run.time
            part = cycles.extent(time) if cycles.settled else slice(time.size, time.size)
            steady = (
                f"{1e3 * cycles.starts[0]:.0f} ms" if cycles.settled else f"not by {1e3 * time[-1]:.0f} ms"
            )
            velocity = f"{voice.run.scene.initial.opening_velocity:g} m/s" if opened else "-"
            parts = [slice(0, part.start), part]
            strained = [cell for one in parts for cell in worst(voice.run, one)]
            shown = [voice.text(quantity) if cycles.settled else "-" for quantity in quantities]
            yield [f"{rise:g} ms" if rise else "0", velocity, steady, *strained, *shown]

    record("phonation_start", columns, rows(), against_scatter(voices[0.0, True], voices[5.4, True]))


def worst(run: plica.Run, part: slice) -> list[str]:
    """Largest strain, error of linear tissue and inverted cells of a part of a run; dashes without steps."""
    if part.start == part.stop:
        return ["-"] * 3
    strain, neglected, inverted = (
        float(np.max(run.waveforms[name][part]))
        for name in ("strain_999", "strain_neglected", "inverted_tissue")
    )
    return [f"{100 * strain:.0f} %", f"{100 * np.sqrt(neglected / 2):.0f} %", f"{inverted:.0f}"]


def against_scatter(sudden: Voice, risen: Voice) -> str:
    """How far the measures of the cycles of two voices are apart, in scatters between cycles."""
    apart = {
        name: abs(other.value - item.value) / max(item.spread, other.spread)
        for name, item in sudden.measures.items()
        if item.spread and (other := risen.measures[name]).spread and other.cycles
    }
    most = max(apart, key=apart.__getitem__)
    return (
        f"With the example's rise and with none, {len(apart)} measures of the cycles differ by at most "
        f"{apart[most]:.2f} of their scatter between cycles ({most})."
    )


def thesis_part(study: Study) -> None:
    keep_side_by_side("phonation_thesis", study.voices(*THESIS, start=0.0), 0.0)


PARTS = {
    "voice": voice_part,
    "cells": cells_part,
    "tissue": tissue_part,
    "start": start_part,
    "thesis": thesis_part,
}


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the runs")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="these parts")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    plica.set_threads(options.threads)
    study = Study(of_this_engine(options.output))
    for part in options.only:
        PARTS[part](study)


if __name__ == "__main__":
    main()
