"""Voices in a basis from another voice's full run: errors beside full runs of their own, and cost.

    python -m benchmarks.voice.reduced_voices -o runs/reduced --symmetry quarter --components 60 100 150
    python -m benchmarks.voice.reduced_voices -o runs/reduced --voices soft --components 100 150 --length 0.02

The basis is that of examples/normal_phonation.toml on the mesh `coarse`, whose displacements are stored;
VOICES are 0.2 s each. Runs are made in the folder where they are missing, full and reduced ones on the same
part of the tissue. Errors are over the steady cycles from --from on. CPU seconds are of one thread, a
second of voice, advanced from the newest checkpoint through --length: with all waveforms, and with flow and
glottal area alone; what is stored is left out. Parts are those of `Simulation.times()`, in wall time.
Records: `reduced_quarter` (`half`, `whole`) and, of the first voice, `reduced_quarter_parts`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import of_this_engine, record, script_parser
from benchmarks.voice.reduction import SAID, cost, errors, values
from plica.runs.basis_file import kept_basis
from plica.scene.mesh.build import build_mesh

PARTS = ("step", "residual", "load", "solve", "contact", "energies", "record")
COLUMNS = [
    "voice",
    "components",
    "coordinates",
    "f0",
    "open quotient",
    "peak flow",
    "impulse",
    "CPU s a second",
    "flow and area alone",
]
# Voice: subglottal pressure (Pa), stiffness of the cover in that of the example's.
VOICES = {"quiet": (700.0, 1.0), "loud": (900.0, 1.2), "soft": (750.0, 0.85)}


def scene_of(symmetry: str | None, voice: str | None = None) -> plica.Scene:
    """A voice in full; None: that of the basis, whose displacements are stored."""
    scene = plica.Scene.load(ROOT / "examples" / "normal_phonation.toml")
    scene = scene.replace({"mesh.larynx": "coarse", "symmetry": symmetry, "time.duration": 0.2})
    if voice is None:
        return scene.replace({"output": {"every": 2e-4, "start": 0.1}})
    pressure, stiffness = VOICES[voice]
    cover = scene.tissue["cover"]
    moduli = {name: stiffness * getattr(cover, name) for name in ("E", "E_fibre", "mu_fibre")}
    stiffer = {f"tissue.cover.{name}": value for name, value in moduli.items()}
    return scene.replace({"airflow.subglottal_pressure": pressure, "output": None} | stiffer)


class Study:
    """The runs of a folder, full and reduced, and where the time of the first voice's steps goes."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.folder = of_this_engine(options.output)
        self.tissue = options.symmetry or "whole"
        self.parts: list[list[str]] = []

    def made(self, name: str, scene: plica.Scene) -> plica.Run:
        directory = self.folder / f"{self.tissue}_{name}"
        print(directory, file=sys.stderr, flush=True)
        return plica.run(scene, directory, resume="if_there")

    def rows(self) -> Iterator[list[str]]:
        symmetry = self.options.symmetry
        basis = self.made("basis", scene_of(symmetry))
        for voice in self.options.voices:
            full = self.made(voice, scene_of(symmetry, voice))
            for components in self.options.components:
                yield self.row(voice, full, basis, components)

    def row(self, voice: str, full: plica.Run, basis: plica.Run, components: int) -> list[str]:
        truth = values(full, self.options.start)
        file = basis.directory.with_name(f"{basis.directory.name}_{components}.h5")
        if not file.exists():
            plica.reduce(basis, file, components=components)
        scene = full.scene.replace({"reduction": {"basis": str(file)}})
        run = self.made(f"{voice}_{components}", scene)
        vectors = kept_basis(run.directory, scene, build_mesh(scene.mesh, scene.source), resumed=True)
        seconds, parts = cost(run, vectors, self.options.length)
        least, _ = cost(run, vectors, self.options.length, ["flow", "minimum_area"])
        if voice == self.options.voices[0]:
            us = 1e6 * scene.time.step
            figures = (f"{us * parts[part]:.0f}" for part in PARTS)
            self.parts.append([str(components), *figures])
        pressure, stiffness = VOICES[voice]
        shown = (
            f"{truth['fundamental_frequency']:.1f} Hz, {truth['open_quotient']:.4f}, "
            f"{1e6 * truth['peak_flow']:.1f} ml/s, {1e6 * truth['contact_impulse']:.2f} uN s"
        )
        return [
            f"{pressure / 1000:g} kPa, cover {stiffness:g} ({shown})",
            str(components),
            str(vectors.shape[1]),
            *errors(values(run, self.options.start), truth),
            f"{seconds:.2f}",
            f"{least:.2f}",
        ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the runs")
    parser.add_argument("--voices", nargs="+", choices=VOICES, default=list(VOICES), help="these")
    parser.add_argument("--components", type=int, nargs="+", default=[60, 100, 150])
    parser.add_argument("--symmetry", choices=["half", "quarter"])
    parser.add_argument("--from", type=float, default=0.06, dest="start", help="s, where measuring starts")
    parser.add_argument("--length", type=float, default=0.05, help="s, that cost is measured over")
    study = Study(parser.parse_args())
    plica.set_threads(1)
    record(f"reduced_{study.tissue}", COLUMNS, study.rows(), SAID)
    columns = ["components", *(f"{part} (us)" for part in PARTS)]
    record(f"reduced_{study.tissue}_parts", columns, study.parts, "Wall time of a step.")


if __name__ == "__main__":
    main()
