"""Random voices: tissue and pressure drawn within what is plausible, run to the end or to what stops them.

    python -m benchmarks.extremes.draw                     # 118 scenes
    python -m benchmarks.extremes.draw --seed 2 --symmetry none --scenes 0 1 2 3

Each is `examples/normal_phonation.toml` on the mesh `coarse` for 160 ms, with factors of the preset
`thesis_corrected`: moduli of body and ligament 0.1 to 1.5, of the cover 0.4 to 6, one a layer, and all
viscosities 0.2 to 1.5, log-uniform, under 500 to 1300 Pa. A scene runs in a process of its own, on one
thread, at low priority, for at most --limit. Of one that ends: `voiced`, with cycles from 80 ms on that do
not decay, or `silent`. Record: `draw_1` of seed 1 and so on; none of some scenes alone, or with other
options.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import warnings
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import astuple, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import plica
from benchmarks.harness.record import ROOT, this_environment
from benchmarks.harness.study import keep, script_parser
from benchmarks.harness.table import show

__all__ = ["COLUMNS", "Drawn", "drawn", "outcome", "scene_of"]

COUNT = 118
VOICE_FROM = 0.08  # s
SOFTER = {"body": (0.1, 1.5), "ligament": (0.1, 1.5), "cover": (0.4, 6.0)}
VISCOSITY, PRESSURE = (0.2, 1.5), (500.0, 1300.0)  # -, Pa
MODULI = ("E", "E_fibre", "mu_fibre")
COLUMNS = [
    "scene",
    "body",
    "ligament",
    "cover",
    "viscosity",
    "pressure (Pa)",
    "ended",
    "at (ms)",
    "f0 (Hz)",
    "cells folded at most",
    "steps with contact",
    "of these by facing nodes",
    "processor (s)",
    "said",
]


@dataclass(frozen=True)
class Drawn:
    """Factors of the tissue `thesis_corrected`, and the subglottal pressure (Pa)."""

    body: float
    ligament: float
    cover: float
    viscosity: float
    pressure: float


def drawn(seed: int, count: int = COUNT) -> list[Drawn]:
    """The scenes of a seed; more of them begin with the same ones."""
    random = np.random.default_rng(seed)

    def factor(low: float, high: float) -> float:
        return float(low * (high / low) ** random.random())

    return [
        Drawn(
            body=factor(*SOFTER["body"]),
            ligament=factor(*SOFTER["ligament"]),
            cover=factor(*SOFTER["cover"]),
            viscosity=factor(*VISCOSITY),
            pressure=float(random.uniform(*PRESSURE)),
        )
        for _ in range(count)
    ]


def scene_of(
    voice: Drawn,
    symmetry: str | None = "quarter",
    duration: float = 0.16,
    step: float = 5e-5,
    larynx: str = "coarse",
) -> plica.Scene:
    """The scene of a draw."""
    scene = plica.Scene.load(ROOT / "examples" / "normal_phonation.toml")
    scene = scene.replace(
        {
            "mesh.larynx": larynx,
            "tissue": "thesis_corrected",
            "symmetry": symmetry,
            "airflow.subglottal_pressure": voice.pressure,
            "time.duration": duration,
            "time.step": step,
            "output": None,
        }
    )
    changes = {}
    for layer in SOFTER:
        tissue = scene.tissue[layer]
        for name in MODULI:
            changes[f"tissue.{layer}.{name}"] = getattr(voice, layer) * getattr(tissue, name)
        changes[f"tissue.{layer}.viscosity"] = voice.viscosity * tissue.viscosity
    return scene.replace(changes)


def outcome(scene: plica.Scene) -> dict[str, Any]:
    """How a run of the scene ends, from `ended` to `said` of the columns."""
    said = ""
    with TemporaryDirectory() as folder:
        directory = Path(folder) / "run"
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                run = plica.run(scene, directory, progress=False)
        except plica.SolveFailed as error:
            said = " ".join(str(error).split())
            run = plica.Run.load(directory)
        found = {
            "ended": "failed",
            "at": 1e3 * float(run.time[-1]),
            "f0": None,
            "folded": int(np.max(run["inverted_tissue"])),
            "touching": int(np.count_nonzero(run["contact_rows"])),
            "facing": int(np.count_nonzero(run["contact_facing"])) if "contact_facing" in run else None,
        }
        if not said:
            part = run.between(min(VOICE_FROM, scene.time.duration / 2), None)
            voiced = part.cycles.count and part.cycles.verdict not in ("decaying", "ended")
            found["ended"] = "voiced" if voiced else "silent"
            found["f0"] = part.measures["fundamental_frequency"].value if voiced else None
            said = ", ".join(caution.name for caution in run.cautions)
    used = resource.getrusage(resource.RUSAGE_SELF)
    return found | {"seconds": used.ru_utime + used.ru_stime, "said": said}


def in_a_process(number: int, options: argparse.Namespace) -> dict[str, Any]:
    """`outcome` of a scene by its number, made by another process."""
    command = [sys.executable, "-m", "benchmarks.extremes.draw", "--one", str(number)]
    for name in ("seed", "symmetry", "duration", "step", "larynx"):
        command += [f"--{name}", str(getattr(options, name))]
    nothing = dict.fromkeys(("at", "f0", "folded", "touching", "facing", "seconds"))
    try:
        made = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=options.limit)
    except subprocess.TimeoutExpired:
        return {"ended": "too long", **nothing, "said": f"no end in {options.limit:g} s"}
    if made.returncode:
        return {"ended": "crash", **nothing, "said": (made.stderr.strip().splitlines() or [""])[-1]}
    return json.loads(made.stdout)  # type: ignore[no-any-return]


def rows(numbers: list[int], options: argparse.Namespace) -> Iterator[list[object]]:
    """Of each scene, in their order."""
    scenes = drawn(options.seed, max(numbers) + 1)
    with ThreadPoolExecutor(options.workers) as workers:
        for number, found in zip(
            numbers, workers.map(lambda number: in_a_process(number, options), numbers), strict=True
        ):
            *factors, pressure = astuple(scenes[number])
            ended, at, f0, folded, touching, facing, seconds, said = found.values()
            yield [
                number,
                *(f"{factor:.3f}" for factor in factors),
                f"{pressure:.0f}",
                ended,
                None if at is None else f"{at:.2f}",
                None if f0 is None else f"{f0:.1f}",
                folded,
                touching,
                facing,
                None if seconds is None else f"{seconds:.0f}",
                said,
            ]


def summary(made: list[list[object]]) -> str:
    """How many ended how."""
    ends = Counter(str(row[COLUMNS.index("ended")]) for row in made)
    folded, facing = (
        sum(bool(row[COLUMNS.index(name)]) for row in made)
        for name in ("cells folded at most", "of these by facing nodes")
    )
    parts = [f"{count} {end}" for end, count in ends.most_common()]
    return (
        f"Of {len(made)} scenes {', '.join(parts)}; in {folded} cells folded, in {facing} nodes were held "
        "apart from those that they face at rest."
    )


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenes", type=int, nargs="+", metavar="NUMBER", help="these alone; default: all")
    parser.add_argument("--symmetry", choices=["none", "half", "quarter"], default="quarter")
    parser.add_argument("--larynx", default="coarse", help="default: coarse")
    parser.add_argument("--duration", type=float, default=0.16, metavar="S")
    parser.add_argument("--step", type=float, default=5e-5, metavar="S")
    parser.add_argument("--workers", type=int, default=2, metavar="N", help="processes; default: 2")
    parser.add_argument("--limit", type=float, default=1800.0, metavar="S", help="of a scene; default: 1800")
    parser.add_argument("--one", type=int, metavar="NUMBER", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one is not None:
        os.nice(5)
        plica.set_threads(1)
        voice = drawn(options.seed, options.one + 1)[-1]
        symmetry = None if options.symmetry == "none" else options.symmetry
        print(json.dumps(outcome(scene_of(voice, symmetry, options.duration, options.step, options.larynx))))
        return
    usual = all(getattr(options, name) == parser.get_default(name) for name in ("duration", "step", "larynx"))
    environment = this_environment({})
    made = show(COLUMNS, rows(options.scenes or list(range(COUNT)), options))
    print("\n" + summary(made))
    if usual and options.scenes is None and options.symmetry == "quarter":
        keep(f"draw_{options.seed}", COLUMNS, made, summary(made), environment)


if __name__ == "__main__":
    main()
