"""Contact where it is hardest: each case must end in a right answer or a clear refusal, never a wrong one.

    python -m benchmarks.extremes.contact                  # all cases
    python -m benchmarks.extremes.contact --cases overlap,slivers --contacts multipliers,Nitsche

After every step, what the engine says is held against what it does not use to find it: each node of one
contact surface against every cell of the other body (how deep it is below the other surface); the order
of the bodies, so that none has gone through the other; the sum of the forces of both sides and their
sign; energy against energy at the start plus work; the energy balance. Cases with a closed form are held
against it. A verdict is one of

    right              all hold, and the gaps left are within the tolerance (mortar: 0.05 edges)
    soft               all hold, and the gaps left are up to a quarter of an edge: finite stiffness
    gains 5 %          all hold but that contact makes energy, so much (over 2 %) of the largest
    refused            an error
    no contact         all hold, but nothing ever touched: says nothing of contact
    flagged            tissue folded over itself (inverted_tissue), or a node inside after the surfaces slid
                       further than a matched airway follows (contact_slide): a run says both
    WRONG              something does not hold

What there is to say of each goes to standard error.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from plica import _engine as engine
from plica.measures.run.cautions import largest_slide
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.changed import changed_mesh
from plica.scene.tissue_presets import TISSUE_PRESETS

E, NU, DENSITY, SIDE = 20e3, 0.3, 1040.0, 0.01


@dataclass
class Scene:
    """A simulation to step and what to hold it against."""

    simulation: Any
    mesh: Any
    steps: int
    first: np.ndarray  # (f, 3) triangles of the contact
    second: np.ndarray
    exact: Callable[[Any], str] = field(default=lambda found: "")  # what a closed form finds wrong, or ""


def contact_parts(width: float, stiffness: float) -> dict[str, dict[str, Any]]:
    """Enforcements; the penalty's stiffness at a node is ten times that of a cell of tissue."""
    return {
        "multipliers": {"enforcement": engine.Multipliers()},
        "saddle": {"enforcement": engine.Multipliers(solver="saddle")},
        "augmented": {"enforcement": engine.Augmented()},
        "Nitsche": {"enforcement": engine.Nitsche()},
        "penalty": {"enforcement": engine.Penalty(stiffness=10 * stiffness * width)},
        "massless": {"enforcement": engine.Multipliers(), "surface_mass": "redistributed"},
        "friction": {"enforcement": engine.Multipliers(), "friction": 0.3},
        "mortar": {"enforcement": engine.Multipliers(), "faces": "mortar"},
        "mortar augmented": {"enforcement": engine.Augmented(), "faces": "mortar"},
        "mortar penalty": {
            "enforcement": engine.Penalty(stiffness=10 * stiffness * width),
            "faces": "mortar",
        },
    }


CONTACTS = tuple(contact_parts(1.0, 1.0))


def edges(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Lengths of the edges of a surface."""
    pairs = np.unique(
        np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]]), 1), axis=0
    )
    return np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)


def distance(p: np.ndarray, triangles: np.ndarray) -> float:
    """Of a point to the nearest of triangles (f, 3, 3): exact, by face and edge."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = ((p - a) * normal).sum(1)
    foot = p - height[:, None] * normal
    inside = np.ones(len(a), bool)
    least = np.inf
    for i, j in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(j - i, foot - i) * normal).sum(1) >= 0
        t = np.clip(((p - i) * (j - i)).sum(1) / ((j - i) ** 2).sum(1), 0, 1)
        least = min(least, np.linalg.norm(p - i - t[:, None] * (j - i), axis=1).min())
    return min(least, np.abs(height[inside]).min(initial=np.inf))


def depth(points: np.ndarray, cells: np.ndarray, nodes: np.ndarray, surface: np.ndarray) -> float:
    """How far the deepest of the nodes that are in a cell is from the surface.

    Without those nearer to another face of that body: they have come in where there is no contact.
    """
    corners = points[cells[:, :4]]
    edges = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    volume = np.linalg.det(edges)
    good = np.abs(volume) > 1e-12 * np.abs(volume).max()
    inverse = np.linalg.inv(edges[good])
    local = np.einsum("cij,ncj->nci", inverse, points[nodes][:, None] - corners[good, 0])
    inside = ((local.min(2) > 1e-9) & (local.sum(2) < 1 - 1e-9)).any(1)
    if not inside.any():
        return 0.0
    faces, known = (
        np.asarray(engine.boundary(cells[:, :4])[0]),
        {tuple(sorted(face)) for face in surface.tolist()},
    )
    side = np.array([face for face in faces.tolist() if tuple(sorted(face)) not in known])
    deepest = 0.0
    for node in nodes[inside]:
        way = distance(points[node], points[surface])
        if way <= distance(points[node], points[side]):
            deepest = max(deepest, way)
    return deepest


def judge(scene: Scene, contact: str) -> tuple[str, str]:
    """The verdict on a scene, and what there is to say about it."""
    simulation, mesh = scene.simulation, scene.mesh
    rest, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    own = bodies(cells, len(rest))
    nodes = [np.unique(surface) for surface in (scene.first, scene.second)]
    if own[nodes[0][0]] == own[nodes[1][0]]:  # the folds are one body: by the sign of x
        own = (rest[:, 0] > 0).astype(int)
        left = rest[cells[:, :4]].mean(1)[:, 0] < 0
        others = [cells[~left], cells[left]]
    else:
        others = [cells[own[cells[:, 0]] == own[other[0]]] for other in nodes[::-1]]
    edge = edges(rest, np.concatenate([scene.first, scene.second])).mean()
    start = float(simulation.state()["initial"])
    deepest, made, overshoot, opened = 0.0, 0.0, 0.0, 0.0
    largest, wave = max(start, 1e-30), []
    for _ in range(scene.steps):
        now = {key: np.asarray(value[-1]) for key, value in simulation.advance(1).items() if len(value)}
        wave.append(now)
        folded = int(now["inverted_tissue"])
        if folded:  # the engine's own sign that nothing means anything from here on
            return "flagged", f"{folded} cells folded at step {len(wave)}"
        x = rest + simulation.displacement
        if not np.isfinite(x).all():
            return "WRONG", "positions are not finite"
        both, size = (
            now["contact_force_first"] + now["contact_force_second"],
            abs(now["contact_force_first"]).max(),
        )
        if abs(both).max() > 1e-9 * size:
            return "WRONG", f"forces of both sides differ by {abs(both).max() / size:.1e}"
        if now["largest_multiplier"] > 0:
            return "WRONG", f"a tensile force of {float(now['largest_multiplier']):.1e} N"
        energy = float(now["kinetic_energy"] + now["elastic_energy"])
        largest = max(largest, energy, abs(float(now["load_work"])))
        opened = max(opened, abs(float(now["energy_balance_error"])) / largest)
        # Beyond energy at the start and work, less what the time scheme itself may have made.
        losses = float(now["viscous_loss"]) + min(float(now["numerical_loss"]), 0.0)
        gained = energy + losses - float(now["load_work"]) - start
        made = max(made, gained / largest)
        overshoot = max(overshoot, -float(now["numerical_loss"]) / max(start, 1e-30))
        for own_nodes, other, surface in zip(nodes, others, (scene.second, scene.first), strict=True):
            deepest = max(deepest, depth(x, other, own_nodes, surface) / edge)
        if (x[nodes[1], 0].mean() - x[nodes[0], 0].mean()) < -0.5 * edge:
            return "WRONG", "the bodies have gone through each other"
    closed = max(int(now["contact_rows"]) for now in wave)
    slid = max(float(now["contact_slide"]) for now in wave)
    note = f"deepest {deepest:.0e} edges, {closed} closed"
    if overshoot > 1:
        note += f"; the time scheme alone makes {overshoot:.1f} times the energy at the start"
    wrong = scene.exact(wave)
    if wrong:
        return "WRONG", wrong
    if opened > 1e-5:
        return "WRONG", f"energy balance open by {opened:.1e} of the energy"
    most = 0.05 if "mortar" in contact else 1.1e-5
    soft = contact in ("Nitsche", "penalty", "mortar penalty")
    if deepest > (0.25 if soft else most):
        flagged = slid > largest_slide
        return ("flagged", f"slid by {slid:.2f} edges; {note}") if flagged else ("WRONG", note)
    if not closed and scene.exact is not never_closed:
        return "no contact", note
    if made > 0.02:
        return f"gains {100 * made:.0f} %", note
    return ("soft" if deepest > most else "right"), note


def bodies(cells: np.ndarray, nodes: int) -> np.ndarray:
    """(n) number of the body that each node is in: cells that share nodes."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    i, j = np.repeat(cells[:, 0], cells.shape[1] - 1), cells[:, 1:].ravel()
    return connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(nodes, nodes)))[1]


# --- Two blocks ---------------------------------------------------------------------------------------------


def blocks(
    contact: str,
    *,
    gap: float = 0.5e-3,
    speed: float = 1.0,
    slide: float = 0.3,
    step: float = 50e-6,
    steps: int = 60,
    stiffer: float = 1.0,
    held: bool = True,
    rigid: bool = False,
    order: int = 1,
    viscosity: float = 0.5,
    squeeze: float = 0.0,
    divisions: tuple[int, int, int] = (4, 3, 3),
    traction: tuple[float, float, float] | None = None,
    pulled: str = "b.x_max",
    exact: Callable[[Any], str] = lambda wave: "",
    **contact_options: Any,
) -> Scene:
    """Two cubes of 10 mm that fly at each other and slide, their far ends held or not.

    stiffer: of the right one's E; rigid: all of it held; squeeze: of its layer at the interface,
    down to so much of an edge (slivers).
    """
    a = engine.block_mesh(corner=(-SIDE, 0, 0), size=(SIDE, SIDE, SIDE), divisions=divisions)
    b = engine.block_mesh(corner=(gap, 0, 0), size=(SIDE, SIDE, SIDE), divisions=divisions)
    mesh = engine.combine(a, b, "a.", "b.")
    points = np.array(mesh.points)
    if squeeze:
        layer = np.abs(points[:, 0] - gap - SIDE / divisions[0]) < 1e-9
        points[layer, 0] = gap + squeeze * SIDE / divisions[0]
    right = np.arange(len(points)) >= len(a.points)
    cells = np.asarray(mesh.cells)
    layer = right[cells[:, 0]].astype(np.int32)
    mesh = changed_mesh(mesh, points=points, cell_layer=layer, layer_names=["a", "b"])
    if order == 2:
        mesh = engine.to_quadratic(mesh)
        points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
        right = np.zeros(len(points), bool)
        right[np.unique(cells[np.asarray(mesh.cell_layer) == 1])] = True
    fixed = np.zeros((len(points), 3), bool)
    if held:
        fixed[mesh.node_sets["a.x_min"]] = True
        fixed[mesh.node_sets["b.x_max"]] = True
    if rigid:
        fixed[right] = True
    velocity = np.where(right[:, None], [-speed / 2, 0.0, -slide / 2], [speed / 2, slide / 2, 0.0])
    velocity[fixed] = 0
    first, second = (engine.flat_triangles(mesh.surfaces[name]) for name in ("a.x_max", "b.x_min"))
    parts = dict(contact_parts(SIDE / divisions[0], E)[contact])
    if parts.get("faces") == "mortar":
        parts["faces"] = engine.Mortar(mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"])
    materials = [
        engine.Material(engine.Isotropic(E=modulus, nu=NU), density=DENSITY, viscosity=viscosity)
        for modulus in (E, stiffer * E)
    ]
    simulation = engine.Simulation(
        mesh,
        materials,
        ["a", "b"],
        np.asarray(mesh.cell_layer),
        fixed,
        scheme=engine.HilberHughesTaylor(),
        step=step,
        solver_tolerance=1e-10,
        velocity=velocity,
        loads=[engine.Load(surface=pulled, traction=traction)] if traction else [],
        contact=engine.Contact(
            airway=engine.matched_airway(points, first, second, (1, 0, 0)), **(parts | contact_options)
        ),
    )
    return Scene(simulation, mesh, steps, first, second, exact=exact)


def unlike_bars(contact: str, ratio: float) -> Scene:
    """R3, unequal impedances: the soft bar meets a stiffer one at 1 m/s; v Z1 Z2 / (Z1 + Z2) for 2 L / c."""
    n, length = 40, 0.01
    w, c = length / n, np.sqrt(E / DENSITY)
    a = engine.block_mesh(corner=(-length, 0, 0), size=(length, w, w), divisions=(n, 1, 1))
    b = engine.block_mesh(corner=(0, 0, 0), size=(length, w, w), divisions=(n, 1, 1))
    mesh = engine.combine(a, b, "a.", "b.")
    right = np.arange(len(mesh.points)) >= len(a.points)
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[:, 1:] = True
    fixed[mesh.node_sets["b.x_max"]] = True
    velocity = np.zeros((len(mesh.points), 3))
    velocity[~right, 0] = 1.0
    first, second = (engine.flat_triangles(mesh.surfaces[name]) for name in ("a.x_max", "b.x_min"))
    parts = dict(contact_parts(w, E)[contact])
    if parts.get("faces") == "mortar":
        parts["faces"] = engine.Mortar(mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"])
    materials = [
        engine.Material(engine.Isotropic(E=m, nu=0.0), density=DENSITY, viscosity=0.0) for m in (E, ratio * E)
    ]
    step = w / c
    simulation = engine.Simulation(
        mesh,
        materials,
        ["a", "b"],
        right[np.asarray(mesh.cells)[:, 0]].astype(np.int32),
        fixed,
        scheme=engine.HilberHughesTaylor(),
        step=step,
        solver_tolerance=1e-10,
        velocity=velocity,
        contact=engine.Contact(airway=engine.matched_airway(mesh.points, first, second, (1, 0, 0)), **parts),
    )
    z1, z2 = DENSITY * c, DENSITY * c * np.sqrt(ratio)

    def exact(wave: Any) -> str:
        pressure = np.array([abs(float(now["contact_force_first"][0])) for now in wave]) / w**2
        plateau = float(np.median(pressure[: 2 * n - 4])) / (z1 * z2 / (z1 + z2))
        impulse = float(pressure.sum()) * step / (z1 * z2 / (z1 + z2) * 2 * length / c)
        wrong = abs(plateau - 1) > 0.02 or abs(impulse - 1) > 0.03
        return f"plateau {plateau:.3f}, impulse {impulse:.3f} of exact" if wrong else ""

    return Scene(simulation, mesh, 3 * n, first, second, exact=exact)


def never_closed(wave: Any) -> str:
    return "contact where there is none" if any(now["contact_rows"] for now in wave) else ""


def all_closed(rows: int) -> Callable[[Any], str]:
    def exact(wave: Any) -> str:
        most = max(int(now["contact_rows"]) for now in wave)
        return "" if most >= rows else f"{most} of {rows} nodes closed"

    return exact


# --- The coarse larynx --------------------------------------------------------------------------------------


def larynx(
    contact: str,
    *,
    step: float = 50e-6,
    steps: int = 60,
    pressure: float = 800.0,
    closing: float = 1.0,
    right: dict[str, float] | None = None,
    exact: Callable[[Any], str] = lambda wave: "",
    displaced: float = 0.0,
    tolerance: float = 1e-9,
) -> Scene:
    """The coarse larynx, its folds thrown at each other; `right`: factors of the right fold's tissue."""
    tissue = {
        name: layer.model_dump(exclude_none=True)
        | ({"right": {key: factor * getattr(layer, key) for key, factor in right.items()}} if right else {})
        for name, layer in TISSUE_PRESETS["thesis_corrected"].items()
    }
    width = 0.5e-3
    parts = dict(contact_parts(width, 5e3)[contact])
    mortar = parts.pop("faces", None)
    kind = type(parts.pop("enforcement")).__name__
    chosen = {
        "Multipliers": {"multipliers": {"solver": "saddle" if contact == "saddle" else "auto"}},
        "Augmented": {"augmented": {}},
        "Nitsche": {"nitsche": {}},
        "Penalty": {"penalty": {"stiffness": 10 * 5e3 * width}},
    }[kind]
    data = {
        "mesh": {"larynx": "thesis_coarse", "order": 1},
        "tissue": tissue,
        "airflow": {"subglottal_pressure": pressure},
        "contact": chosen | parts | ({"faces": "mortar"} if mortar else {}),
        "time": {"step": step, "duration": step * steps},
        "initial": {"opening_velocity": -closing}
        | ({"opening_displacement": displaced} if displaced else {}),
        "solver": {"tolerance": tolerance},
    }
    scene = plica.Scene.model_validate(data)
    mesh = build_mesh(scene.mesh)
    first, second = (engine.flat_triangles(mesh.surfaces[name]) for name in ("airway_left", "airway_right"))
    return Scene(build_simulation(scene, mesh), mesh, steps, first, second, exact=exact)


CASES: dict[str, Callable[[str], Scene]] = {
    "blocks, as usual": lambda c: blocks(c),
    "step x 100, blocks": lambda c: blocks(c, step=5e-3, steps=10),
    "step x 100, larynx": lambda c: larynx(c, step=5e-3, steps=10, closing=3.0),
    "stiffness ratio 1e6, bars": lambda c: unlike_bars(c, 1e6),
    "stiffness ratio 1e6, blocks": lambda c: blocks(c, stiffer=1e6),
    "one block rigid (held)": lambda c: blocks(c, rigid=True),
    "right fold 1e6 times as stiff": lambda c: larynx(
        c, right={"E": 1e6, "E_fibre": 1e6, "mu_fibre": 1e6}, steps=60, closing=1.4, tolerance=1e-13
    ),
    "gap 0, blocks at rest": lambda c: blocks(
        c, gap=0.0, speed=0.0, slide=0.0, steps=20, traction=(-200.0, 0, 0), held=False
    ),
    "gap 0, blocks fly": lambda c: blocks(c, gap=0.0),
    "gap 0, larynx": lambda c: larynx(c, displaced=-0.25e-3, steps=40),
    "overlap 0.1 mm, blocks": lambda c: blocks(c, gap=-0.1e-3),
    "overlap 4 mm, blocks": lambda c: blocks(c, gap=-4e-3),
    "overlap 1e-9 m, blocks": lambda c: blocks(c, gap=-1e-9),
    "overlap, larynx": lambda c: larynx(c, displaced=-0.5e-3),
    "40 % tension asymmetry, 5 kPa": lambda c: larynx(
        c, pressure=5e3, closing=-1.0, right={"E_fibre": 0.6, "mu_fibre": 0.6}, steps=120
    ),
    "velocity x 50, blocks": lambda c: blocks(c, speed=50.0, slide=15.0, steps=40),
    "velocity x 50, free blocks": lambda c: blocks(c, speed=50.0, slide=0.0, held=False, steps=40),
    "velocity x 50, larynx": lambda c: larynx(c, closing=50.0, steps=20),
    "slivers 1e-3": lambda c: blocks(c, squeeze=1e-3),
    "slivers 1e-6": lambda c: blocks(c, squeeze=1e-6),
    "contact set empty": lambda c: blocks(c, speed=-1.0, exact=never_closed),
    "contact set complete": lambda c: blocks(c, gap=0.0, slide=0.0, exact=all_closed(16)),
    "2 kPa of shear on the contact surface": lambda c: blocks(
        c, pulled="b.x_min", traction=(0, 0, 2000.0), held=False, viscosity=0.0
    ),
    "step / 4": lambda c: blocks(c, step=12.5e-6, steps=240),
}


def outcome(case: str, contact: str) -> tuple[str, str]:
    try:
        verdict, note = judge(CASES[case](contact), contact)
    except (plica.InvalidInput, plica.SolveFailed) as error:
        verdict, note = "refused", " ".join(str(error).split())
    return verdict, note


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--cases", default="", help="parts of their names, by commas; all where left out")
    parser.add_argument("--contacts", default=",".join(CONTACTS))
    options = parser.parse_args()
    contacts = options.contacts.split(",")
    cases = [case for case in CASES if any(part in case for part in options.cases.split(","))]
    record("contact_extremes", ["case", *contacts], rows(cases, contacts))


def rows(cases: list[str], contacts: list[str]) -> Iterator[list[str]]:
    """The verdicts on each case."""
    for case in cases:
        verdicts = []
        for contact in contacts:
            verdict, note = outcome(case, contact)
            print(f"{case}, {contact}: {verdict}: {note}", file=sys.stderr, flush=True)
            verdicts.append(verdict)
        yield [case, *verdicts]


if __name__ == "__main__":
    main()
