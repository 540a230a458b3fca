"""Meshes of several formats that say something else than they mean: one sentence, with the place."""

from __future__ import annotations

import contextlib
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica

FORMATS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "gmsh 2.2 text": ("m.msh", "gmsh22", {"binary": False}),
    "gmsh 2.2 binary": ("m.msh", "gmsh22", {"binary": True}),
    "gmsh 4.1 text": ("m.msh", "gmsh", {"binary": False}),
    "gmsh 4.1 binary": ("m.msh", "gmsh", {"binary": True}),
    "med": ("m.med", "med", {}),
    "abaqus": ("m.inp", "abaqus", {}),
    "nastran": ("m.bdf", "nastran", {}),
    "vtu": ("m.vtu", "vtu", {}),
}
Mutation = Callable[[np.ndarray, np.ndarray], Any]


def out_of_range(points: np.ndarray, cells: np.ndarray) -> None:
    cells[3, 2] = len(points) + 5


def before_the_first(points: np.ndarray, cells: np.ndarray) -> None:
    cells[3, 2] = -1


def twice(points: np.ndarray, cells: np.ndarray) -> None:
    cells[5] = cells[4][[1, 2, 0, 3]]


def not_a_number(points: np.ndarray, cells: np.ndarray) -> None:
    points[7, 2] = np.nan


def unused(points: np.ndarray, cells: np.ndarray) -> None:
    cells[cells == 11] = 10


def turned(points: np.ndarray, cells: np.ndarray) -> None:
    cells[3] = cells[3][[1, 0, 2, 3]]


def all_turned(points: np.ndarray, cells: np.ndarray) -> None:
    cells[:] = cells[:, [1, 0, 2, 3]]


SAID: dict[Mutation, str] = {
    out_of_range: r"(element 4|tetra 3|an element) has (the )?node (18|17)\b",
    before_the_first: r"(element 4|tetra 3|an element) has (the )?node (0|-1)\b",
    twice: r"cell 5 at .* has the corners of cell 4",
    not_a_number: r"node 7 is at .*nan",
    unused: r"(node 11 at .* belongs to no cell|cell \d+ at .* has volume)",
    turned: r"cell 3 at .* has volume -.* inverted",
    all_turned: r"cell 0 at .* has volume -.* inverted",
}


def written(path: Path, kind: str, mutate: Mutation = lambda points, cells: None) -> Path:
    name, file_format, options = FORMATS[kind]
    block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=(2, 1, 1)))
    points, cells = np.array(block.points), np.array(block.cells).astype(np.int64)
    mutate(points, cells)
    labels: dict[str, Any] = {}
    if "gmsh" in file_format:
        labels = {f"gmsh:{one}": [np.ones(len(cells), dtype=int)] for one in ("physical", "geometrical")}
    made = meshio.Mesh(points, [("tetra", cells)], cell_data=labels)
    made.write(path / name, file_format=file_format, **options)
    return path / name


def refusal(file: Path) -> str:
    with pytest.raises(plica.SceneError) as caught:
        plica.build_mesh(plica.MeshFile(file=file))
    return str(caught.value)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_good_mesh_is_read_in_every_format(kind: str, tmp_path: Path) -> None:
    made = plica.build_mesh(plica.MeshFile(file=written(tmp_path, kind)))
    block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=(2, 1, 1)))
    np.testing.assert_array_equal(made.cells, block.cells)
    np.testing.assert_allclose(made.points, block.points, rtol=0, atol=1e-7)


@pytest.mark.parametrize("mutate", SAID, ids=lambda one: str(one.__name__))
@pytest.mark.parametrize("kind", FORMATS)
def test_a_bad_mesh_is_refused_in_every_format(kind: str, mutate: Mutation, tmp_path: Path) -> None:
    message = refusal(written(tmp_path, kind, mutate))
    assert re.search(SAID[mutate], message), message
    assert message.startswith("Scene: mesh")


@pytest.mark.parametrize(
    ("kind", "good", "bad", "said"),
    [
        ("gmsh 2.2 text", b"\n12 1.0", b"\n11 1.0", "node 11 is in the file 2 times"),
        ("gmsh 2.2 text", b"\n12 1.0", b"\n40 1.0", "element 7 has node 12; must be a node of the file"),
        ("gmsh 4.1 text", b"\n12\n", b"\n11\n", "node 11 is in the file 2 times"),
        ("gmsh 4.1 text", b"\n12\n", b"\n40\n", "element 7 has node 12; must be a node of the file"),
        (
            "gmsh 4.1 binary",
            struct.pack("<QQ", 11, 12),
            struct.pack("<QQ", 11, 11),
            "node 11 is in the file 2 times",
        ),
        ("abaqus", b"\n12, 1.0", b"\n11, 1.0", "an element has the node 12"),
        (
            "gmsh 2.2 binary",
            struct.pack("<id", 12, 1.0),
            struct.pack("<id", 40, 1.0),
            "node 40 has the place of node 12",
        ),
        ("gmsh 4.1 text", b"\n4.1 0 8", b"\n4.0 0 8", "must be of 2.2 or 4.1"),
    ],
)
def test_nodes_are_in_the_file_once(kind: str, good: bytes, bad: bytes, said: str, tmp_path: Path) -> None:
    file = written(tmp_path, kind)
    data = file.read_bytes()
    assert good in data
    file.write_bytes(data.replace(good, bad, 1))
    assert said in refusal(file)


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind.startswith("gmsh")])
def test_a_broken_gmsh_file_is_one_sentence(kind: str, tmp_path: Path) -> None:
    """Cut, and with bytes changed: whatever is read of it, no error but a refusal."""
    file = written(tmp_path, kind)
    data, rng = file.read_bytes(), np.random.default_rng(2)
    for _ in range(40):
        broken = bytearray(data)
        for place in rng.integers(0, len(data), 3):
            broken[place] = int(rng.integers(0, 256))
        file.write_bytes(bytes(broken[: int(rng.integers(20, len(data)))] if rng.random() < 0.3 else broken))
        with contextlib.suppress(plica.InvalidInput):
            plica.build_mesh(plica.MeshFile(file=file))


ABAQUS = """*HEADING
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
5, 1., 1., 1.
*ELEMENT, TYPE=C3D4, ELSET=MUSCLE
1, 1, 2, 3, 4
*ELEMENT, TYPE=C3D4, ELSET=MUCOSA
2, 2, 3, 4, 5
"""


def test_sets_of_elements_are_labels(tmp_path: Path) -> None:
    (tmp_path / "m.inp").write_text(ABAQUS)
    file = plica.MeshFile(file=tmp_path / "m.inp", layers={"deep": "MUSCLE", "upper": "MUCOSA"})
    assert list(plica.build_mesh(file).cell_layer) == [0, 1]
    assert plica.build_mesh(plica.MeshFile(file=tmp_path / "m.inp")).layer_names == ["body"]
    with pytest.raises(plica.SceneError, match=r'mesh.layers.deep = "MUSKLE"; must be a label .*"MUSCLE"'):
        plica.build_mesh(
            plica.MeshFile(file=tmp_path / "m.inp", layers={"deep": "MUSKLE", "upper": "MUCOSA"})
        )


def test_an_element_may_be_in_several_sets(tmp_path: Path) -> None:
    (tmp_path / "m.inp").write_text(ABAQUS + "*ELSET, ELSET=ALL\n1, 2\n")
    every = plica.MeshFile(file=tmp_path / "m.inp", layers={"deep": "ALL"})
    assert list(plica.build_mesh(every).cell_layer) == [0, 0]
    with pytest.raises(plica.SceneError, match=r"mesh\.layers\.rest has a label that another layer has"):
        plica.build_mesh(every.replace({"layers.rest": "MUCOSA"}))
    with pytest.raises(plica.SceneError, match=r"mesh\.layers leaves out"):
        plica.build_mesh(plica.MeshFile(file=tmp_path / "m.inp", layers={"deep": "MUSCLE"}))


GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
2 7 "airway"
2 8 "upper"
3 7 "tissue"
$EndPhysicalNames
$Entities
0 0 2 1
1 0 0 0 1 1 1 1 7 0
2 0 0 0 1 1 1 2 8 7 0
1 0 0 0 1 1 1 1 7 0
$EndEntities
$Nodes
1 4 1 4
3 1 0 4
1
2
3
4
0 0 0
1 0 0
0 1 0
0 0 1
$EndNodes
$Elements
3 3 1 3
2 1 2 1
1 1 2 3
2 2 2 1
2 1 2 4
3 1 4 1
3 1 2 3 4
$EndElements
"""


@pytest.mark.parametrize("label", ["airway", 7])
def test_a_face_in_two_physical_groups_is_in_both(label: str | int, tmp_path: Path) -> None:
    """The reader gives each face the number of its first group only."""
    (tmp_path / "m.msh").write_text(GMSH)
    file = plica.MeshFile(
        file=tmp_path / "m.msh", layers={"body": "tissue"}, surfaces={"airway": label, "upper": "upper"}
    )
    mesh = plica.build_mesh(file)
    assert len(mesh.surfaces["airway"]) == 2
    assert len(mesh.surfaces["upper"]) == 1
