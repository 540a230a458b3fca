"""What mirroring refuses: one sentence that names the place, what it has and must have, and what to do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica
from mesh_parts import write_fold

Change = Callable[[dict[str, Any], meshio.Mesh], None]
FACING = {"facing": {"along": [-1, 0, 0], "within": "80 deg"}}


def flat(value: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    return lambda y, z: np.full_like(y, value)


def shifted(axis: int, by: float) -> Change:
    def change(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
        mesh.points[:, axis] += by

    return change


def given(**changes: Any) -> Change:
    def change(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
        fields |= changes

    return change


def surfaces(**changes: Any) -> Change:
    def change(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
        fields["surfaces"] = fields["surfaces"] | changes

    return change


def uneven_cut(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
    """One node of the cut lies 0.9 um beside it."""
    mesh.points[np.flatnonzero(mesh.points[:, 1] == 0)[7], 1] = 0.9e-3


def hinged_cut(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
    """One node of the cut is in the plane, all around it are beside it."""
    x, y, z = mesh.points.T
    near = (y == 0) & (abs(z - 4) < 1.5) & (x > 1) & (x < 8)
    near[np.flatnonzero(near)[np.argmin(np.abs(x[near] - 4.6) + np.abs(z[near] - 4))]] = False
    mesh.points[near, 1] = 0.5


def bent_edge(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
    """A mid-side node of the cut lies 10 um beside it."""
    cells = mesh.cells[0].data
    ends = mesh.points[cells[:, :2], 1] == 0
    mesh.points[cells[np.flatnonzero(ends.all(axis=1))[0], 4], 1] += 0.01


def inverted(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
    mesh.cells[0].data[3, :2] = mesh.cells[0].data[3, 1::-1]


def both_folds(fields: dict[str, Any], mesh: meshio.Mesh) -> None:
    """The fold and its image, beside the plane."""
    made = plica.build_mesh(plica.MeshFile(mirror="fold", **fields))
    mesh.points = 1e3 * np.asarray(made.points) + [9.5, 0, 0]
    cells, faces = np.asarray(made.cells), [made.surfaces[name] for name in ("airway", "lateral", "ends")]
    mesh.cells = [meshio.CellBlock("tetra", cells)] + [meshio.CellBlock("triangle", part) for part in faces]
    labels = [np.asarray(made.cell_layer) + 1, *(np.full(len(part), 11 + k) for k, part in enumerate(faces))]
    mesh.cell_data = {"label": labels}
    fields["surfaces"] |= {"ends": 13}


QUARTER = {"y": (0.0, 6.0)}
Q_ENDS = surfaces(ends=14)

# What the file has, how it is mirrored, what is changed, and what is said.
CASES: dict[str, tuple[dict[str, Any], str, list[Change], str]] = {
    "across x": (
        {"gap": flat(-0.1)},
        "fold",
        [],
        'mesh.mirror = "fold": part.vtu lies on both sides of the plane x = 0: node 140 at (-0.0001, 0, '
        "0.004) m and node 4 at (0.009, 0, 0) m; must lie on one. Cut it in that plane, move it if it",
    ),
    "across y": (
        {"y": (-6.0, 6.0)},
        "quarter",
        [],
        "lies on both sides of the plane y = 0: node 0 at (0.004967, -0.006, 0) m and node 30 at (0.004967, "
        '0.006, 0) m; must lie on one. Cut it in that plane, or if it is all of a fold, use mirror = "fold".',
    ),
    "nothing in y = 0": (
        {"y": (1.0, 6.0)},
        "quarter",
        [Q_ENDS],
        "has no face in the plane y = 0, where a quarter is cut from the fold; must have some. Nearest is "
        "node 0 at (0.004967, 0.001, 0) m. Move the mesh, or",
    ),
    "a cut that is not flat": (
        QUARTER,
        "quarter",
        [Q_ENDS, uneven_cut],
        "almost ends in the plane y = 0: node 37 at (0.006388, 9e-07, 0.001) m, of 6 faces; must end in it, "
        "or at least 1.7e-06 m beside it. Cut it flat",
    ),
    "a cut in few faces": (
        QUARTER,
        "quarter",
        [Q_ENDS, hinged_cut],
        "meets the plane y = 0 in node 140 at (0.0002, 0, 0.004) m without a face there; must end in it in "
        "faces, as only these hold both sides together. Cut it in that plane.",
    ),
    "a curved cut": (
        QUARTER,
        "quarter",
        [Q_ENDS, given(order=2), bent_edge],
        "has the edge between nodes 0 and 35 in the plane y = 0, but its mid-side node 318 at (0.004371, "
        "1e-05, 0.0005) m beside it; must be in it. Cut it flat.",
    ),
    "another midplane": (
        {},
        "fold",
        [shifted(0, 20.0)],
        "is 0.0202 m from the plane x = 0, further than it is wide (0.0088 m); the plane must be the mid",
    ),
    "almost touching": (
        {"gap": flat(1e-3)},
        "fold",
        [],
        "almost ends in the plane x = 0: node 140 at (1e-06, 0, 0.004) m, of 48 faces",
    ),
    "touching": (
        {"gap": flat(0.0)},
        "fold",
        [],
        "mesh.surfaces.airway has 48 of its 96 faces in the plane x = 0, which mesh.mirror makes the "
        "inside of one tissue; must have none there, as no support, load or air can be there. Leave them out "
        "of it, or if the folds touch at rest, leave a small gap between them.",
    ),
    "touching, by direction": (
        {"gap": flat(0.0)},
        "fold",
        [surfaces(airway=FACING)],
        "mesh.mirror: both folds are one tissue at (0, 0.006, 0.004) m, in the middle of the airway "
        '"airway", as the mesh of the file reaches the plane x = 0 there; must not, as air '
        "passes between the folds.",
    ),
    "touching in an edge": (
        {"gap": lambda y, z: 0.01 * (z - 6) ** 2},
        "fold",
        [],
        "mesh.surfaces.airway touches the plane x = 0 in the edge between the nodes 210 and 215, which "
        "mesh.mirror gives to both folds; must only end there. Is x = 0 the midplane between the folds?",
    ),
    "touching in a node": (
        {"gap": lambda y, z: 0.01 * ((z - 6) ** 2 + (y - 8) ** 2)},
        "fold",
        [],
        "mesh.mirror: node 230 at (0, 0.008, 0.006) m is of both folds, which no face in the plane x = 0 "
        "joins there (1 such nodes are free); must be held along x in supports",
    ),
    "a free commissure": (
        {"gap": lambda y, z: 0.1 * (12 - y)},
        "fold",
        [surfaces(ends=13)],
        "mesh.mirror: node 170 at (0, 0.012, 0.004) m is of both folds",
    ),
    "a support in the cut": (
        QUARTER,
        "quarter",
        [],
        "mesh.surfaces.ends has 64 of its 128 faces in the plane y = 0, which mesh.mirror makes the "
        "inside of one tissue; must have none there, as no support, load or air can be there. Leave them out "
        "of it.",
    ),
    "a surface of the cut": (
        QUARTER,
        "quarter",
        [Q_ENDS, surfaces(cut={"plane": {"point": [0, 0, 0], "normal": [0, 1, 0]}})],
        "mesh.surfaces.cut has 64 of its 64 faces in the plane y = 0",
    ),
    "an airway that faces outward": (
        {},
        "fold",
        [surfaces(airway=12, lateral=11)],
        'airflow.surface = "airway": its walls look away from each other',
    ),
    "both folds": (
        {},
        "fold",
        [both_folds],
        'mesh.mirror: the walls of the airway "airway" that the file has look toward smaller and toward '
        "larger x; must all look toward the plane x = 0, as those of one fold. If the file has both folds,",
    ),
    "a bad mesh": ({}, "fold", [inverted], "mesh: TetMesh: cell 3 at (0.00"),
    "sides": (
        {},
        "fold",
        [given(sides={"left": 1, "right": 2})],
        ': sides: must be "x" or left out with mesh.mirror: the file has one fold',
    ),
    "a name with a side": (
        {},
        "fold",
        [surfaces(airway_left=11)],
        "surfaces.airway_left: must be named without the side with mesh.mirror: the file has one fold",
    ),
    "another word": ({}, "half", [], 'mirror = "half"; must be one of fold, quarter.'),
}


@pytest.mark.parametrize("kind", CASES)
def test_a_part_that_cannot_be_mirrored_is_one_sentence(kind: str, tmp_path: Path) -> None:
    shape, mirror, changes, sentence = CASES[kind]
    fields = write_fold(path := tmp_path / "part.vtu", **shape)
    mesh = meshio.read(path)
    if kind == "a curved cut":
        mesh = quadratic(mesh)
    for change in changes:
        change(fields, mesh)
    mesh.write(path)
    with pytest.raises(plica.SceneError) as caught:
        plica.build_simulation(scene_of(fields, mirror))
    (line,) = str(caught.value).splitlines()
    assert sentence in line


def quadratic(mesh: meshio.Mesh) -> meshio.Mesh:
    made = plica._engine.to_quadratic(
        plica._engine.TetMesh(
            points=mesh.points,
            cells=mesh.cells[0].data,
            surfaces={str(k): part.data for k, part in enumerate(mesh.cells[1:])},
        )
    )
    faces = [("triangle6", np.asarray(made.surfaces[str(k)])) for k in range(len(mesh.cells) - 1)]
    cells = [("tetra10", np.array(made.cells)), *faces]
    return meshio.Mesh(np.array(made.points), cells, cell_data=mesh.cell_data)


def scene_of(fields: dict[str, Any], mirror: str) -> plica.Scene:
    return plica.Scene(
        plica.MeshFile(mirror=mirror, **fields),
        {"cover": plica.Tissue(E="3 kPa", nu=0.4), "body": plica.Tissue(E="10 kPa", nu=0.4)},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        airflow=plica.Airflow(),
        supports=plica.Supports(fixed=["lateral", "ends"]),
    )


@pytest.mark.parametrize("mirror", ["fold", "quarter"])
def test_what_is_changed_is_what_is_wrong(mirror: str, tmp_path: Path) -> None:
    fields = write_fold(tmp_path / "part.vtu", **QUARTER)
    if mirror == "quarter":
        fields["surfaces"] = fields["surfaces"] | {"ends": 14}
    assert plica.build_simulation(scene_of(fields, mirror)).info()["sections"] > 2


def test_a_symmetry_that_the_mirrored_mesh_has_not_is_refused(tmp_path: Path) -> None:
    scene = scene_of(write_fold(tmp_path / "part.vtu", y=(-6.0, 7.0)), "fold")
    with pytest.raises(plica.SceneError, match="at its mirror image in the plane y = 0"):
        plica.build_simulation(scene.replace({"symmetry": "quarter"}))


@pytest.mark.parametrize("mesh", [{"larynx": "coarse"}, {"block": {"size": [1, 1, 1]}}])
def test_other_meshes_are_not_mirrored(bar: plica.Scene, mesh: dict[str, Any]) -> None:
    with pytest.raises(plica.SceneError, match="mirror is not known"):
        bar.replace({"mesh": mesh | {"mirror": "fold"}})
