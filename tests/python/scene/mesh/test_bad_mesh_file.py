"""Every kind of bad mesh file is one clear sentence, and nothing on the disk."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest

import plica
from complaints import refused, refused_scene

BLOCK = """
[mesh]
file = "m.vtu"
layers = { body = 1 }
[tissue.body]
E = 1e4
nu = 0.3
[time]
step = 1e-4
duration = 1e-3
"""


def block_mesh() -> meshio.Mesh:
    block = plica.build_mesh(plica.Block(size=(1.0, 1.0, 1.0), divisions=(2, 1, 1)))
    cells = np.array(block.cells)
    return meshio.Mesh(
        np.array(block.points), [("tetra", cells)], cell_data={"label": [np.ones(len(cells), dtype=int)]}
    )


def invert(mesh: meshio.Mesh) -> None:
    mesh.cells[0].data[3] = mesh.cells[0].data[3][[1, 0, 2, 3]]


def repeat(mesh: meshio.Mesh) -> None:
    mesh.cells[0].data[5] = mesh.cells[0].data[4]


def flatten(mesh: meshio.Mesh) -> None:
    mesh.points[:, 2] = 0.0


def add_point(mesh: meshio.Mesh) -> None:
    mesh.points = np.vstack([mesh.points, [[5.0, 5.0, 5.0]]])


def change_label(mesh: meshio.Mesh) -> None:
    mesh.cell_data["label"][0][2] = 7


def two_labels(mesh: meshio.Mesh) -> None:
    mesh.cell_data["other"] = [mesh.cell_data["label"][0]]


def only_triangles(mesh: meshio.Mesh) -> None:
    mesh.cells = [meshio.CellBlock("triangle", mesh.cells[0].data[:, :3])]


def add_wedge(mesh: meshio.Mesh) -> None:
    wedge = meshio.CellBlock("wedge", np.array([[0, 1, 2, 3, 4, 5]]))
    mesh.cells.append(wedge)
    mesh.cell_data["label"].append(np.ones(1, dtype=int))


def large_label(mesh: meshio.Mesh) -> None:
    mesh.cell_data["label"][0] = mesh.cell_data["label"][0].astype(np.int64)
    mesh.cell_data["label"][0][2] = 2**32 + 1


def nothing(mesh: meshio.Mesh) -> None:
    """The mesh is good; the scene is not."""


MESHES: dict[str, tuple[Callable[[meshio.Mesh], None], tuple[str, str], str]] = {
    "inverted": (invert, ("", ""), "cell 3"),
    "duplicate": (repeat, ("", ""), "cell"),
    "flat": (flatten, ("", ""), "cell"),
    "unreferenced node": (add_point, ("", ""), "node 12"),
    "unmapped label": (
        change_label,
        ("", ""),
        "mesh.layers leaves out tetrahedra with the labels [7] of m.vtu.",
    ),
    "unknown label": (
        nothing,
        ("body = 1", "body = 3"),
        "mesh.layers.body = 3; must be a label of tetrahedra in m.vtu",
    ),
    "unknown name": (
        nothing,
        ("body = 1", 'body = "muscle"'),
        'mesh.layers.body = "muscle"; must be a label of',
    ),
    "several label data": (
        two_labels,
        ("layers", 'labels = "labl"\nlayers'),
        'mesh.labels = "labl"; must be one of',
    ),
    "no tetrahedra": (only_triangles, ("", ""), "m.vtu has no tetrahedra; it has one of triangle."),
    "another solid": (add_wedge, ("", ""), "m.vtu has wedge cells; all solid cells must be tetrahedra."),
    "large label": (large_label, ("", ""), "m.vtu has a label 4294967297; must be below 2^31."),
    "no triangles": (
        nothing,
        ("[tissue", "surfaces = { skin = 1 }\n[tissue"),
        "must be a label of triangles in m.vtu",
    ),
    "unknown side": (
        nothing,
        ("[tissue", "sides = { left = 1, right = 2 }\n[tissue"),
        "mesh.sides.right = 2; must be",
    ),
    "one label for both sides": (
        nothing,
        ("[tissue", "sides = { left = 1, right = 1 }\n[tissue"),
        "mesh.sides.right has a label that the other side has too.",
    ),
    "side without sides": (
        nothing,
        ("[time]", "[tissue.body.left]\nE = 2e4\n[time]"),
        "tissue.body.left has no",
    ),
    "larynx pattern": (
        nothing,
        ("[time]", "[initial]\nopening_velocity = 1\n[time]"),
        "initial.opening_velocity needs the glottis",
    ),
    "unit": (nothing, ("layers", 'unit = "1 s"\nlayers'), 'mesh.unit = "1 s"; must be a number in m'),
}


@pytest.mark.parametrize("kind", MESHES)
def test_a_bad_mesh_file_is_one_sentence(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil, (good, bad), sentence = MESHES[kind]
    mesh = block_mesh()
    spoil(mesh)
    mesh.write(tmp_path / "m.vtu")
    assert sentence in refused_scene(BLOCK.replace(good, bad, 1), tmp_path, capsys)


@pytest.mark.parametrize(("name", "content"), [("m.vtu", "not a mesh"), ("m.xyz", "1 2 3"), ("m.msh", "")])
def test_what_is_not_a_mesh_is_refused(
    name: str, content: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(content)
    (tmp_path / "s.toml").write_text(BLOCK.replace("m.vtu", name))
    message = refused(["mesh", str(tmp_path / "s.toml")], capsys)
    assert f"s.toml: mesh.file: {name} cannot be read as a mesh" in message
