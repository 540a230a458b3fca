"""The airflow alone, in a rigid M5 glottis, beside what is published of a static model 7.5 times life-size.

    python -m benchmarks.validation.static_flow       5 minutes on a busy machine

Published, as the abstracts say it: [F] "Pressure distributions in a static physical model of the uniform
glottis: entrance and exit coefficients" (PMC3078031), which also quotes van den Berg's coefficients 1.375 and
0.5; [D] "Divergent or convergent glottal angles: which give greater flow?"; [L] Li, Scherer and others,
"The effect of glottal angle on intraglottal pressure". Assumed: a straight part of 3 mm (the axial length of
the glottis in [D]), 12 mm from front to back (what flows and Reynolds numbers of [D] make together), air of
1.2 kg/m^3. Nothing is fitted; 1 cmH2O is 98.07 Pa. Record: `static_flow`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation import m5
from plica import _engine

COLUMNS = ["what", "published", "Plica, separation ratio 1.2", "1.3"]
STRAIGHT, ALONG, AIR, VISCOSITY = 3.0, 12.0, 1.2, 1.8e-5
WATER = 98.07  # Pa
EDGE = 0.3  # mm
PRESSURES = (3, 5, 10, 15)  # cmH2O
ANGLES = (5, 10, 20, 40)  # degrees between both folds
RATIOS = (1.2, 1.3)
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Rigid:
    """A glottis that does not move."""

    flow: _engine.GlottalFlow
    areas: Floats
    entrance: float
    """m, height at which the straight part begins"""

    def at(self, pressure: float) -> tuple[Floats, float]:
        """Pressures of the sections (Pa) and the flow (m^3/s)."""
        pressures, flow = self.flow.evaluate(self.areas, pressure)
        return np.asarray(pressures)[: len(self.areas)], flow


@cache
def _built(diameter: float, angle: float) -> tuple[plica.Scene, _engine.TetMesh, float]:
    """The scene, its mesh, and the height (m) at which the straight part begins."""
    shape = m5.M5.static(STRAIGHT, np.radians(angle))
    with tempfile.TemporaryDirectory() as folder:
        quarter = m5.Quarter(shape, diameter, edge=EDGE, along=1, length=ALONG)
        path = m5.write_quarter(quarter, Path(folder) / "rigid.msh")
        scene = m5.scene(path, plica.Tissue(E="1 GPa", nu=0.3), order=1)
        scene = scene.replace({"symmetry": None, "airflow.air_density": AIR})
        return scene, plica.build_mesh(scene.mesh), float(1e-3 * shape.corners()[2, 1])


@cache
def rigid(diameter: float, angle: float = 0.0, ratio: float = 1.2) -> Rigid:
    """By the least width (mm), the angle between both folds (degrees, positive where it diverges) and the
    ratio of separation."""
    scene, mesh, entrance = _built(diameter, angle)
    model = {"viscous_slit": {"separation_ratio": ratio, "air_viscosity": VISCOSITY}}
    flow = _engine.GlottalFlow(plica.build_simulation(scene.replace({"airflow.model": model}), mesh))
    points = np.asarray(mesh.points)
    widths = csr_array(flow.width_map(), shape=(len(flow.width_spacing()), len(points))) @ points[:, 0]
    return Rigid(flow, np.asarray(flow.areas(widths)), entrance)


def flows(diameter: float, angle: float, ratio: float) -> Floats:
    """m^3/s at each of the pressures."""
    glottis = rigid(diameter, angle, ratio)
    return np.array([glottis.at(WATER * pressure)[1] for pressure in PRESSURES])


def more(diameter: float, angle: float, ratio: float) -> Floats:
    """%, by how much the divergent glottis lets through more than the convergent one of the same angle."""
    return 100 * (flows(diameter, angle, ratio) / flows(diameter, -angle, ratio) - 1)


def entrance_coefficient(diameter: float, pressure: float, ratio: float = 1.2) -> float:
    """Loss of pressure up to the straight part of a uniform glottis, in kinetic pressures there."""
    glottis = rigid(diameter, 0.0, ratio)
    pressures, flow = glottis.at(WATER * pressure)
    there = float(np.interp(glottis.entrance, np.asarray(glottis.flow.height), pressures))
    return (WATER * pressure - there) / _kinetic(flow, diameter)


def exit_coefficient(diameter: float, pressure: float, ratio: float = 1.2) -> float:
    """Rise of pressure from its least value to the jet's, in kinetic pressures of the straight part."""
    pressures, flow = rigid(diameter, 0.0, ratio).at(WATER * pressure)
    return -float(pressures.min()) / _kinetic(flow, diameter)


def van_den_berg(diameter: float, pressure: float) -> float:
    """m^3/s: 1.375 - 0.5 kinetic pressures, and Poiseuille's loss in the straight part."""
    d, length = 1e-3 * diameter, 1e-3 * ALONG
    kinetic = 0.875 * 0.5 * AIR / (d * length) ** 2
    friction = 12 * VISCOSITY * 1e-3 * STRAIGHT / (length * d**3)
    drop = WATER * pressure
    return float(2 * drop / (friction + np.sqrt(friction**2 + 4 * kinetic * drop)))


def _kinetic(flow: float, diameter: float) -> float:
    return 0.5 * AIR * (flow / (1e-6 * diameter * ALONG)) ** 2


def _span(values: Floats, digits: int = 0) -> str:
    return f"{values.min():+.{digits}f} to {values.max():+.{digits}f}"


def rows() -> Iterator[list[object]]:
    narrow = "divergent against convergent, {} degrees, {:g} cm: flow (%)"
    for d in (0.4, 0.8, 1.6, 0.05, 3.2):
        said = "[D] always more, some 5 to 25" if 0.1 < d < 3 else "[D] always less, by 10 to 30"
        found = [_span(np.concatenate([more(d, angle, r) for angle in ANGLES])) for r in RATIOS]
        yield [narrow.format("5 to 40", d / 10), said, *found]
    for d in (0.1, 0.2):
        for angles, said in (((5, 10), "[D] more"), ((20, 40), "[D] less")):
            found = [_span(np.concatenate([more(d, angle, r) for angle in angles])) for r in RATIOS]
            yield [narrow.format(f"{angles[0]} and {angles[1]}", d / 10), said, *found]
    yield from _resistances()
    yield from _coefficients()


def _resistances() -> Iterator[list[object]]:
    """By the angle, at a width of 0.06 cm."""
    angles = (-40, -20, -10, -5, 0, 5, 10, 20, 40)
    most, least, lowest = [], [], []
    order = []
    for ratio in RATIOS:
        flow = [flows(0.6, angle, ratio)[2] for angle in angles]
        suction = [rigid(0.6, angle, ratio).at(10 * WATER)[0].min() for angle in angles]
        most.append(f"{angles[int(np.argmin(flow))]}")
        least.append(f"{angles[int(np.argmax(flow))]}")
        order.append("yes" if np.all(np.diff(flow[:5]) < 0) else "no")
        lowest.append(f"{angles[int(np.argmin(suction))]}")
    where = "0.06 cm, 10 cmH2O: angle (degrees, divergent positive) of "
    yield [where + "the greatest resistance", "[L] 0", *most]
    yield [where + "the least resistance", "[L] 10", *least]
    yield [where + "the lowest pressure", "[L] 10", *lowest]
    yield ["... resistance falls with the angle of convergence", "[L] yes", *order]


def _coefficients() -> Iterator[list[object]]:
    yield [
        "uniform, 0.005 to 0.32 cm, 3 to 15 cmH2O: entrance coefficient",
        "[F] 0.69 to 17.6, falling with width and pressure",
        *(_span(_over_widths(entrance_coefficient, ratio), 2) for ratio in RATIOS),
    ]
    yield [
        "uniform, 0.04 cm, 3 to 15 cmH2O: entrance coefficient",
        "[F] van den Berg 1.375",
        *(_span(np.array([entrance_coefficient(0.4, p, r) for p in PRESSURES]), 2) for r in RATIOS),
    ]
    yield [
        "uniform, 0.04 cm, 3 to 15 cmH2O: exit coefficient",
        "[F] van den Berg 0.5",
        *(_span(np.array([exit_coefficient(0.4, p, r) for p in PRESSURES]), 2) for r in RATIOS),
    ]
    for pressure in PRESSURES:
        berg = van_den_berg(0.4, pressure)
        found = [rigid(0.4, 0.0, ratio).at(WATER * pressure)[1] for ratio in RATIOS]
        yield [
            f"uniform, 0.04 cm, {pressure} cmH2O: flow (cm^3/s)",
            f"van den Berg's coefficients {1e6 * berg:.0f}",
            *(f"{1e6 * flow:.0f} ({100 * (flow / berg - 1):+.0f} %)" for flow in found),
        ]


def _over_widths(coefficient: object, ratio: float) -> Floats:
    assert callable(coefficient)
    widths = (0.05, 0.075, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
    return np.array([coefficient(d, p, ratio) for d in widths for p in PRESSURES])


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    record("static_flow", COLUMNS, rows())
