"""Voices of larynges with a lesion, beside a healthy one: what it does to sound, phase and contact.

    python -m benchmarks.voice.lesions --picture lesions.png   # the examples' own mesh and step
    python -m benchmarks.voice.lesions --accuracy "half the step" --voices healthy polyp paralysis chink
    python -m benchmarks.voice.lesions --accuracy "mesh demo" --voices healthy polyp paralysis chink

The scenes are examples/polyp.toml, paralysis.toml and chink.toml; "healthy" is the same voice on the same
mesh without what they have, "gap of the polyp" has that alone; in "stiffer" and "slacker" more of it
differs. Means over the steady cycles from `--from` on. Records: `lesions`, `lesions_step`, `lesions_demo`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser
from plica.report.glottis import narrowest

Floats = NDArray[np.floating[Any]]
SHOWN = 0.02  # s, of the picture

COLUMNS = [
    "voice",
    "varied",
    "f0 (Hz)",
    "open quotient",
    "peak flow (ml/s)",
    "least flow (ml/s)",
    "least area (mm^2)",
    "right lags left (degrees)",
    "amplitude left/right (mm)",
    "peak contact pressure (kPa)",
    "contact impulse (uN s)",
    "contact length (%)",
    "SPL at 0.3 m (dB)",
    "H1-H2 of the flow (dB)",
    "HNR (dB)",
    "CPP (dB)",
    "peak strain",
    "periods' scatter (%)",
]
SLACKER = {
    f"tissue.{layer}.left": {"E": E, "E_fibre": along, "mu_fibre": along / 4}
    for layer, E, along in (("body", 3.5e3, 11e3), ("ligament", 2.8e3, 17e3), ("cover", 2.8e3, 8.5e3))
}
LESIONS = ("polyp", "paralysis", "chink")
ACCURACY: Mapping[str, Mapping[str, Any]] = {
    "half the step": {"time.step": "50 us"},
    "mesh demo": {"mesh.larynx": "demo"},
}


def scenes() -> dict[str, plica.Scene]:
    """The healthy voice, that with the polyp's gap alone, and the three."""
    found = {name: plica.Scene.load(ROOT / "examples" / f"{name}.toml") for name in LESIONS}
    healthy = found["chink"].replace({"mesh.folds.posterior_chink": None, "symmetry": "quarter"})
    gap = found["polyp"].replace({"mesh.folds.lesions": [], "symmetry": "quarter"})
    slacker = found["paralysis"].replace({"mesh.folds.left_gap": "0.25 mm", **SLACKER})
    stiffer = found["polyp"].replace({"mesh.folds.lesions[0].stiffness": 1.5})
    worse = {"polyp, stiffer": stiffer, "paralysis, slacker": slacker}
    return {"healthy": healthy, "gap of the polyp": gap, **found, **worse}


@dataclass(frozen=True)
class Panel:
    """What the picture has of one voice, in mm, ms and ml/s."""

    name: str
    above: tuple[Floats, Floats, Floats]  # at rest: y, and x of the left and the right fold
    time: Floats
    edges: tuple[Floats, Floats]  # x of the left and the right one, where the middle plane is narrowest
    flow: Floats


def panel(name: str, scene: plica.Scene, run: Any) -> Panel:
    """The end of a run."""
    mesh = plica.scene_mesh(scene)
    above = narrowest(1e3 * np.asarray(mesh.points), np.asarray(mesh.surfaces["airway"]))
    late = run["time"] >= run["time"][-1] - SHOWN
    left, right = (1e3 * run[f"coronal_{side}"][late][..., 0] for side in ("left", "right"))
    width, rows = right - left, np.arange(len(left))
    at = width.argmin(axis=1)
    time = 1e3 * (run["time"][late] - run["time"][late][0])
    return Panel(name, above, time, (left[rows, at], right[rows, at]), 1e6 * run["flow"][late])


def draw(panels: list[Panel], path: Path) -> None:
    """The glottis at rest from above, the narrowest place of the middle plane over time, and the flow."""
    figure = Figure(figsize=(2.6 * len(panels), 7), layout="constrained")
    grid = figure.subplots(3, len(panels), squeeze=False, sharey="row")
    for k, one in enumerate(panels):
        above, edges, flow = grid[:, k]
        y, left, right = one.above
        above.fill_betweenx(y, left, right, color="black")
        above.set(title=one.name, xlim=(-1, 1), xlabel="left      x (mm)      right")
        edges.plot(one.time, one.edges[0], label="left")
        edges.plot(one.time, one.edges[1], label="right")
        flow.plot(one.time, one.flow, color="black")
        flow.set(xlabel="time (ms)")
    for axes, text in zip(
        grid[:, 0], ("back      y (mm)      front", "edges (mm)", "flow (ml/s)"), strict=True
    ):
        axes.set_ylabel(text)
    grid[1, 0].legend()
    figure.savefig(path, dpi=100)


def row(name: str, varied: str, scene: plica.Scene, start: float, panels: list[Panel] | None) -> list[object]:
    """What a run of the scene gives, from a time on (s); adds its panel of the picture, if there is one."""
    with TemporaryDirectory() as folder:
        try:
            run = plica.run(scene, Path(folder) / "run").between(start, None)
        except plica.SolveFailed as error:
            return [name, varied, *[None] * (len(COLUMNS) - 3), str(error).splitlines()[0][:120]]
        if panels is not None and "," not in name:
            panels.append(panel(name, scene, run))

        def shown(key: str, factor: float, how: str) -> str | None:
            value = run.measures[key].value if key in run.measures else None
            return None if value is None else format(factor * value, how)

        sides = [shown(f"amplitude_{side}", 1e3, ".2f") for side in ("left", "right")]
        period = run.measures["period"]
        scatter = None if not period.value or period.spread is None else 100 * period.spread / period.value
        return [
            name,
            varied,
            shown("fundamental_frequency", 1.0, ".1f"),
            shown("open_quotient", 1.0, ".2f"),
            shown("peak_flow", 1e6, ".0f"),
            format(1e6 * float(np.min(run["flow"])), ".0f"),
            format(1e6 * float(np.min(run["minimum_area"])), ".2f"),
            shown("left_right_phase", 180 / np.pi, ".0f"),
            "/".join(side or "-" for side in sides),
            shown("peak_contact_pressure", 1e-3, ".1f"),
            shown("contact_impulse", 1e6, ".1f"),
            shown("contact_length_fraction", 100.0, ".0f"),
            shown("sound_pressure_level", 1.0, ".1f"),
            shown("flow_h1_h2", 1.0, ".1f"),
            shown("sound_harmonics_to_noise", 1.0, ".1f"),
            shown("sound_cepstral_peak_prominence", 1.0, ".1f"),
            shown("peak_strain", 1.0, ".2f"),
            None if scatter is None else f"{scatter:.1f}",
        ]


def rows(options: Any, panels: list[Panel] | None) -> Iterator[list[object]]:
    text = options.accuracy or "as it is"
    changes = {"output.every": None, "output.start": None, **ACCURACY.get(text, {})}
    for name, scene in scenes().items():
        if name in (options.voices or (name,)):
            yield row(name, text, scene.replace(changes), options.start, panels)


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--voices", nargs="+", choices=tuple(scenes()))
    parser.add_argument("--accuracy", choices=tuple(ACCURACY), help="vary this")
    parser.add_argument("--from", dest="start", type=float, default=0.15, metavar="S")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the voices")
    chosen = parser.parse_args()
    drawn: list[Panel] | None = None if chosen.picture is None else []
    name = "lesions_" + chosen.accuracy.split()[-1] if chosen.accuracy else "lesions"
    record(name, COLUMNS, rows(chosen, drawn))
    if drawn is not None:
        draw(drawn, chosen.picture)
