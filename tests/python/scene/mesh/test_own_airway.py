"""Wrong choices of surfaces in a larynx of one's own, as Gmsh labels it: one sentence that names the surface,
what it has and must have, and what to do."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import plica
from plica import _engine
from plica.scene.mesh.surface_fault import airway_fault, contact_fault

LEFT, RIGHT, WALL = 11, 12, 13

SCENE = """
[mesh]
file = "larynx.msh"
unit = "1 mm"
layers = { body = 1, ligament = 2, cover = 3 }
surfaces = { airway = [11, 12], airway_left = 11, airway_right = "right", wall = 13 }
[tissue]
body = { E = "20 kPa", nu = 0.45 }
ligament = { E = "3 kPa", nu = 0.45 }
cover = { E = "1 kPa", nu = 0.45 }
[supports]
fixed = ["wall"]
[airflow]
subglottal_pressure = "0.6 kPa"
[contact]
multipliers = {}
[time]
step = "50 us"
duration = "10 ms"
"""
WITHOUT_CONTACT = ("[contact]\nmultipliers = {}\n", "")
SURFACES = next(line + "\n" for line in SCENE.splitlines() if line.startswith("surfaces"))
OPENING = ("[time]", '[initial]\nopening_velocity = "-0.1 m/s"\n[time]')


@pytest.fixture(scope="module")
def larynx() -> _engine.TetMesh:
    options = plica.LarynxOptions(around=8, levels=(1, 1, 1, 1, 1, 2, 1, 1, 1, 1), body_rings=1)
    return plica.build_mesh(plica.Larynx(larynx="thesis_coarse", options=options))


@pytest.fixture(scope="module")
def folder(larynx: _engine.TetMesh, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With larynx.msh: in mm, with physical groups of the layers, of each fold's surface and of the rest."""
    made = tmp_path_factory.mktemp("own")
    cells = np.asarray(larynx.cells)
    left, right = (np.asarray(larynx.surfaces[f"airway_{side}"]) for side in ("left", "right"))
    inner = {tuple(face) for face in np.sort(np.concatenate([left, right]), axis=1).tolist()}
    boundary = np.asarray(_engine.boundary(cells)[0])
    wall = boundary[[tuple(face) not in inner for face in np.sort(boundary, axis=1).tolist()]]
    labels = [np.asarray(larynx.cell_layer) + 1]
    labels += [np.full(len(faces), k) for k, faces in ((LEFT, left), (RIGHT, right), (WALL, wall))]
    meshio.Mesh(
        1e3 * np.asarray(larynx.points),
        [("tetra", cells), ("triangle", left), ("triangle", right), ("triangle", wall)],
        cell_data={"gmsh:physical": labels, "gmsh:geometrical": [np.ones(len(part), int) for part in labels]},
        field_data={"left": np.array([LEFT, 2]), "right": np.array([RIGHT, 2]), "wall": np.array([WALL, 2])},
    ).write(made / "larynx.msh", file_format="gmsh22")
    return made


def complaint(folder: Path, *changes: tuple[str, str]) -> str:
    """What is said of the scene with these texts replaced, without the scene's name."""
    text = SCENE
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "s.toml").write_text(text)
    with pytest.raises(plica.SceneError) as caught:
        plica.build_simulation(plica.Scene.load(folder / "s.toml"))
    (line,) = str(caught.value).splitlines()
    return line.removeprefix("s.toml: ")


def test_the_right_choice_is_taken(folder: Path) -> None:
    (folder / "s.toml").write_text(SCENE.replace(*OPENING))
    assert plica.build_simulation(plica.Scene.load(folder / "s.toml")).info()["sections"] > 2


ALL = ("airway = [11, 12]", 'airway = "boundary"')
CLOSED = "faces (0.0037 m^2) enclose tissue, as all of the boundary does; must be open below and above"
SELECT = "Select in mesh.surfaces.airway the walls of the airway alone, by label, box, plane or facing."


@pytest.mark.parametrize(
    ("changes", "sentences"),
    [
        ([ALL], ['airflow.surface = "airway": its 448', CLOSED, SELECT]),
        ([ALL, WITHOUT_CONTACT], ['airflow.surface = "airway": its 448', CLOSED, SELECT]),
        ([ALL, WITHOUT_CONTACT, OPENING], ["initial.opening_velocity needs the", ' its 448', CLOSED, SELECT]),
        (
            [("airway = [11, 12]", "airway = 11")],
            [
                'airflow.surface = "airway": none of its 88 faces (0.000826 m^2) looks toward smaller x, so '
                'that '
                "the right fold is missing; must have both folds",
                SELECT,
            ],
        ),
        (
            [("airway = [11, 12]", "airway = 13")],
            [
                'airflow.surface = "airway": its walls look away from each other',
                "are at x = 0.00566 m, the others at -0.00566 m (means); must face each other",
                SELECT,
            ],
        ),
        (
            [("airway = [11, 12]", "airway = { facing = { along = [0, 0, 1] } }"), WITHOUT_CONTACT],
            ['airflow.surface = "airway": ', " m; must have one x at each height", SELECT],
        ),
        (
            [("airway = [11, 12]", "Airway = [11, 12]")],
            [
                'airflow.surface = "airway"; must be a surface of the mesh, one of Airway, airway_left, ',
                'Did you mean "Airway"? Select in mesh.surfaces.airway its faces',
            ],
        ),
        (
            [('airway_left = 11, airway_right = "right", ', "")],
            [
                'contact.first = "airway_left"; must be a surface of the mesh, one of airway, wall. Select '
                'in '
                "mesh.surfaces.airway_left the faces of one side alone",
            ],
        ),
        (
            [("airway_left = 11", "airway_left = [11, 12]")],
            [
                'contact.second = "airway_right": it has 88 of its 88 faces in common with first = '
                '"airway_left"; '
                "must have none. Give each side faces of its own",
            ],
        ),
        (
            [("multipliers", 'second = "wall"\nmultipliers')],
            [
                'contact.second = "wall": its mean normal (0, 0, 0) does not point from its centre (0, 0, 0) '
                'm to '
                'that of "airway_left", (-0.00336, 0, ',
                "Select in mesh.surfaces.wall the faces that can touch airway_left alone.",
            ],
        ),
        (
            [("multipliers", "direction = [0, 1, 0]\nmultipliers")],
            [
                "contact.direction = (0, 1, 0): it is 90 degrees off the mean normals of the surfaces, (1, "
                "0, 0); "
                "must be the direction in which they face each other. Set contact.direction",
            ],
        ),
        (
            [("multipliers", 'airway = "boundary"\nmultipliers')],
            [
                'contact.airway = "boundary"; must be one of matched, triangulated: how the air between the '
                "surfaces is meshed. The surfaces themselves are contact.first and contact.second.",
            ],
        ),
        (
            [("airway = [11, 12]", 'airway = "Boundary"')],
            ['mesh.surfaces.airway = "Boundary"; must be a label of triangles', 'Did you mean "boundary"?'],
        ),
        (
            [(SURFACES, ""), ('fixed = ["wall"]', "fixed = []")],
            ['airflow.surface = "airway"; must be a surface of the mesh, which has none yet. Select in'],
        ),
    ],
)  # fmt: skip
def test_a_wrong_choice_is_one_sentence_that_says_what_to_do(
    folder: Path, changes: list[tuple[str, str]], sentences: list[str]
) -> None:
    said = complaint(folder, *changes)
    for sentence in sentences:
        assert sentence in said


def test_a_larynx_has_no_fault_whichever_of_its_sides_is_first(larynx: _engine.TetMesh) -> None:
    assert airway_fault(larynx, "airway") == ""
    for names in (("airway_left", "airway_right"), ("airway_right", "airway_left")):
        assert contact_fault(larynx, names, (-2.0, 0.1, 0.0)) == ""
        assert contact_fault(larynx, names, None) == ""


def test_two_blocks_with_a_gap_have_no_fault_and_their_far_sides_have() -> None:
    blocks = {
        name: plica.Block(corner=(x, 0, 0), size=(1e-2, 2e-3, 2e-3))
        for name, x in (("a", 0.0), ("b", 1.01e-2))
    }
    mesh = plica.build_mesh(plica.Blocks(blocks=blocks))
    assert contact_fault(mesh, ("a.x_max", "b.x_min"), (1.0, 0.0, 0.0)) == ""
    assert contact_fault(mesh, ("a.x_min", "b.x_min"), None).startswith(
        'first = "a.x_min": its mean normal (-1, '
    )
