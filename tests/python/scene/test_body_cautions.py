"""How the bodies of a scene are held and where they are: what is said, and what is not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica
from caution_scenes import BLOCKS, LARYNX, Given
from mesh_parts import write_fold
from plica.measures.caution import Caution
from plica.scene.body_cautions import CHECKS, body_cautions
from plica.scene.mesh.overlap import find_overlap
from plica.scene.plausibility import scene_cautions


def said(changes: str, base: str = LARYNX) -> dict[str, Caution]:
    return said_of(Given(base, changes).build())


def said_of(scene: plica.Scene) -> dict[str, Caution]:
    found = scene_cautions(scene, plica.build_mesh(scene.mesh))
    names = {check.__name__ for check in CHECKS}
    return {one.name: one for one in found if one.name in names}


@pytest.mark.parametrize(
    "larynx", ["coarse", "demo", "fine", "thesis", "thesis_coarse", "thesis_demo", "thesis_medium"]
)
@pytest.mark.parametrize("order", [1, 2])
def test_a_preset_at_its_wall_gives_none(larynx: str, order: int) -> None:
    if order == 2 and larynx == "thesis":
        order = 1  # 80,000 nodes more
    scene = Given(LARYNX, f'without mesh.options\nmesh.larynx = "{larynx}"\nmesh.order = {order}').build()
    assert said_of(scene) == {}


FOLDS = 'without mesh.options\nmesh.larynx = "coarse"\n'


@pytest.mark.parametrize(
    ("lesion", "name", "words"),
    [
        ("size = [5e-3, 2e-3, 1e-3]", "unused_lesion", "lesions[0] changes nothing: stiffness and viscosity"),
        ("size = [5e-3, 2e-3, 1e-3], stiffness = 2", "", ""),
        ("size = [5e-3, 2e-3, 1e-3], viscosity = 0.5", "", ""),
        ("size = [5e-3, 2e-3, 1e-3], density = 1100", "", ""),
        (
            "size = [0.4e-3, 0.4e-3, 0.3e-3], stiffness = 2",
            "coarse_lesion",
            "has the tissue of 0.",
        ),
        ("size = [0.4e-3, 0.4e-3, 0.3e-3]", "unused_lesion", ""),
    ],
)
def test_a_lesion_that_changes_nothing_or_few_cells_is_said(lesion: str, name: str, words: str) -> None:
    found = said(f'{FOLDS}mesh.folds.lesions = [{{ fold = "left", {lesion} }}]')
    assert list(found) == ([name] if name else [])
    if name:
        assert words in found[name].seen


@pytest.mark.parametrize(
    ("gaps", "told"),
    [
        ('gap = "0.3 mm", left_gap = "0.1 mm", right_gap = "0.3 mm"', True),
        ('gap = "0.3 mm", left_gap = "0.1 mm", right_gap = "0.2 mm"', False),
        ('gap = "0.3 mm", left_gap = "0.1 mm"', False),
        ('left_gap = "0.1 mm", right_gap = "0.3 mm"', False),
    ],
)
def test_a_gap_that_both_sides_overrule_is_said(gaps: str, told: bool) -> None:
    found = said(f"{FOLDS}mesh.folds = {{ {gaps} }}")
    assert list(found) == (["unused_gap"] if told else [])
    if told:
        seen = found["unused_gap"].seen
        assert "gap = 0.3 mm only sets where the wall is" in seen
        assert "0.4 mm apart" in seen


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ('symmetry = "half"\ncontact.friction = 0.3', True),
        ('symmetry = "quarter"\ncontact.friction = 0.3', True),
        ('symmetry = "half"', False),
        ("contact.friction = 0.3", False),
    ],
)
def test_friction_between_mirror_images_is_said_to_do_nothing(changes: str, told: bool) -> None:
    found = said(changes)
    assert list(found) == (["unused_friction"] if told else [])
    if told:
        assert "contact.friction = 0.3 has no effect" in found["unused_friction"].seen


@pytest.mark.parametrize("second", ["airway", "nowhere"])
def test_friction_between_others_than_mirror_images_is_not_said_to_do_nothing(second: str) -> None:
    found = said(f'symmetry = "half"\ncontact.friction = 0.3\ncontact.second = "{second}"')
    assert "unused_friction" not in found


@pytest.mark.parametrize(
    ("changes", "name", "figure"),
    [
        ("supports.fixed = []", "free_body", "it has 0 held"),
        ('supports.components = { wall = "xz" }', "free_body", "can shift or turn"),
        ('supports.components = { wall = "yz" }', "free_body", "can shift or turn"),
        ('supports.components = { wall = "yz" }\nsymmetry = "half"', "", ""),  # it cannot shift along x
        ('supports.components = { wall = "xy" }\nsymmetry = "quarter"', "free_body", "can shift or turn"),
        ('supports.fixed = ["ends"]', "open_ends", "% of the 490 mm^2"),
        ('supports.fixed = ["wall"]\nsupports.wall_from_y = "3 mm"', "", ""),
        ('supports.components = { wall = "xyz" }', "", ""),
    ],
)
def test_a_larynx_that_is_not_held_is_said(changes: str, name: str, figure: str) -> None:
    found = said(changes)
    assert list(found) == ([name] if name else [])
    if name:
        assert figure in found[name].seen
        assert "wall" in found[name].advice


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ("without supports", ["free_body"]),
        ('supports.fixed = ["a.x_min"]', ["free_body"]),
        ('supports.fixed = ["a.x_min", "b.x_max"]', []),
        ('supports.fixed = ["a.x_min"]\nsupports.components = { "b.y_min" = "y" }', []),  # a slide is meant
        ("supports.fixed = []", []),
        ("without initial\nwithout supports", ["free_body"]),
    ],
)
def test_without_airflow_a_body_that_nothing_holds_is_said_unless_the_scene_says_so(
    changes: str, names: list[str]
) -> None:
    found = said(changes, BLOCKS)
    assert list(found) == names
    if names:
        one_is_held = "a.x_min" in changes
        assert ("supports.fixed = []" in found["free_body"].advice) != one_is_held
        assert ("1 of 2 bodies" if one_is_held else "2 of 2 bodies") in found["free_body"].seen


def test_what_is_said_of_a_run_is_said_of_its_stored_scene(tmp_path: Path) -> None:
    scene = Given(BLOCKS, 'without supports\ntime.duration = "50 us"').build()
    run = plica.run(scene, tmp_path / "run", progress=False)
    assert "free_body" in {one.name for one in plica.Run.load(tmp_path / "run").cautions}
    assert body_cautions(run.scene, run.mesh) == body_cautions(scene, plica.build_mesh(scene.mesh))


@pytest.mark.parametrize(
    ("corner", "overlap"),
    [
        ('["10 mm", 0, 0]', 0.0),  # touch
        ('["9.99 mm", 0, 0]', 0.01),
        ('["5 mm", "0.5 mm", "0.5 mm"]', 1.0),
        ('["5 mm", "2 mm", "1.9 mm"]', 0.0),
        ('["-12 mm", 0, 0]', 0.0),
    ],
)
def test_bodies_in_each_other_without_contact_are_said(corner: str, overlap: float) -> None:
    found = said(f"without contact\nmesh.blocks.b.corner = {corner}", BLOCKS)
    assert list(found) == (["overlapping_bodies"] if overlap else [])
    if overlap == 0.01:
        assert "1e-05 m deep" in found["overlapping_bodies"].seen
    moved = said('without contact\ninitial.displacement.a = ["0.2 mm", 0, 0]', BLOCKS)
    assert "overlapping_bodies" in moved


def test_cells_that_cross_without_a_node_in_each_other_overlap() -> None:
    """Two flat needles like a cross: separating axes are those of edges and faces, not of nodes."""
    needle = np.array([[-1, -0.1, 0], [-1, 0.1, 0], [1, 0, -0.1], [1, 0, 0.1]], dtype=float)
    turned = needle[:, [1, 0, 2]] * (1, -1, 1)
    cells, body = np.arange(8, dtype=np.int32).reshape(2, 4), np.array([0, 4], dtype=np.int32)
    found = find_overlap(np.concatenate([needle, turned]), cells, body)
    assert found is not None
    assert 0.05 < found[0] < 0.2
    assert find_overlap(np.concatenate([needle, turned + np.array([0, 0, 0.201])]), cells, body) is None
    assert find_overlap(np.concatenate([needle, turned]), cells, np.zeros(2, np.int32)) is None


def test_the_depth_of_overlap_is_that_of_random_cells_by_points() -> None:
    """Cells overlap if a mean of the corners of one is a mean of those of the other: by a linear program."""
    from scipy.optimize import linprog

    rng = np.random.default_rng(5)
    disagreed = both = 0
    for _ in range(100):
        x = rng.uniform(size=(8, 3))
        x[4:] += rng.uniform(-0.5, 0.5, size=3)
        equal = np.vstack([np.hstack([x[:4].T, -x[4:].T]), [[1] * 4 + [0] * 4], [[0] * 4 + [1] * 4]])
        meet = linprog(np.zeros(8), A_eq=equal, b_eq=[0, 0, 0, 1, 1]).status == 0
        found = find_overlap(x, np.arange(8).reshape(2, 4), np.array([0, 1])) is not None
        disagreed += meet != found
        both += meet
    assert 20 < both < 80  # of both there are some
    assert disagreed <= 1  # within a thousandth of their size


def extruded(tmp_path: Path, supports: plica.Supports) -> plica.Scene:
    """Two blocks beside a slit along y, as folds from front to back, from a file."""
    size = ("5 mm", "12 mm", "4 mm")
    both = plica.Blocks(
        blocks={
            "left": plica.Block(size=size, corner=("-5.2 mm", 0, 0), divisions=(2, 4, 3)),
            "right": plica.Block(size=size, corner=("0.2 mm", 0, 0), divisions=(2, 4, 3)),
        }
    )
    mesh = plica.build_mesh(both)
    kinds = {"airway": ("left.x_max", "right.x_min"), "outer": ("left.x_min", "right.x_max")}
    kinds |= {"front": ("left.y_max", "right.y_max"), "back": ("left.y_min", "right.y_min")}
    faces = {name: np.concatenate([mesh.surfaces[one] for one in of]) for name, of in kinds.items()}
    made = meshio.Mesh(
        np.asarray(mesh.points),
        [("tetra", np.asarray(mesh.cells)), *(("triangle", one) for one in faces.values())],
        cell_data={
            "label": [
                np.ones(len(mesh.cells), dtype=int),
                *(np.full(len(one), 2 + k) for k, one in enumerate(faces.values())),
            ]
        },
    )
    made.write(tmp_path / "folds.vtu")
    return plica.Scene(
        plica.MeshFile(
            file=tmp_path / "folds.vtu",
            layers={"body": 1},
            surfaces={name: 2 + k for k, name in enumerate(faces)},
        ),
        {"body": plica.Tissue(E="10 kPa", nu=0.3)},
        time=plica.Stepping(step="50 us", duration="20 ms"),
        airflow=plica.Airflow(),
        supports=supports,
    )


@pytest.mark.parametrize(
    ("supports", "figures"),
    [
        ({"fixed": ("outer", "front", "back")}, None),
        ({"fixed": ("outer",), "components": {"front": "y", "back": "y"}}, None),
        ({"fixed": ("outer",)}, ["mm^2 at the smallest y", "mm^2 at the largest y"]),
        ({"fixed": ("outer", "front")}, ["of the 40 mm^2 at the smallest y"]),
    ],
)
def test_folds_whose_front_or_back_is_free_are_said(
    tmp_path: Path, supports: dict[str, Any], figures: list[str] | None
) -> None:
    found = said_of(extruded(tmp_path, plica.Supports(**supports)))
    assert list(found) == ([] if figures is None else ["open_ends"])
    for figure in figures or ():
        assert figure in found["open_ends"].seen
    if figures and len(figures) == 1:
        assert "largest" not in found["open_ends"].seen


@pytest.mark.parametrize(
    ("held", "seen"),
    [
        (["ends"], None),
        (["back", "front"], None),
        (["ends_left"], "of the 60.9 mm^2 of the right fold at the smallest y"),
        (["back", "front_right"], "of the 60.9 mm^2 of the left fold at the largest y"),
        (["back", "front_body"], 'of the 60.9 mm^2 of layer "cover" at the largest y'),
        (["back"], "of the 122 mm^2 at the largest y"),
    ],
)
def test_an_end_of_one_fold_or_one_layer_that_is_free_is_said(
    held: list[str], seen: str | None, tmp_path: Path
) -> None:
    fields = write_fold(tmp_path / "fold.vtu")
    deep = {"plane": {"point": [0, "12 mm", 0], "normal": [0, 1, 0]}, "box": {"x": ["4 mm", "9 mm"]}}
    fields["surfaces"] |= {"back": 13, "front": 14, "front_body": deep}
    scene = plica.Scene(
        plica.MeshFile(mirror="fold", **fields),
        dict.fromkeys(("cover", "body"), plica.Tissue(E="10 kPa", nu=0.3)),
        time=plica.Stepping(step="50 us", duration="20 ms"),
        airflow=plica.Airflow(),
        supports=plica.Supports(fixed=["lateral", *held]),
    )
    found = said_of(scene)
    assert list(found) == ([] if seen is None else ["open_ends"])
    if seen is not None:
        assert seen in found["open_ends"].seen
        assert found["open_ends"].seen.count("mm^2") == (2 if held == ["ends_left"] else 1)


def test_bodies_that_a_mesher_did_not_join_are_said(tmp_path: Path) -> None:
    """Two layers with nodes of their own at the same places: the upper one is held by nothing."""
    block = plica.build_mesh(plica.Block(size=("4 mm", "2 mm", "2 mm"), divisions=(2, 1, 1)))
    points, cells = np.asarray(block.points), np.asarray(block.cells)
    points, cells = (
        np.concatenate([points, points + np.array([0, 0, 2e-3])]),
        np.concatenate([cells, cells + len(points)]),
    )
    label = np.repeat([1, 2], len(cells) // 2)
    meshio.Mesh(points, [("tetra", cells)], cell_data={"label": [label]}).write(tmp_path / "two.vtu")
    scene = plica.Scene(
        plica.MeshFile(
            file=tmp_path / "two.vtu",
            layers={"muscle": 1, "mucosa": 2},
            surfaces={"bottom": {"plane": {"point": (0, 0, 0), "normal": (0, 0, 1)}}},
        ),
        {name: plica.Tissue(E="10 kPa", nu=0.3) for name in ("muscle", "mucosa")},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        supports=plica.Supports(fixed=("bottom",)),
    )
    (found,) = said_of(scene).values()
    assert found.name == "free_body"
    assert "mucosa" in found.seen
    assert "6 nodes of the mesh have the place of another one" in found.seen
    assert "merge" in found.advice


@pytest.mark.parametrize(("unit", "said"), [(None, True), ("1 m", True), ("1 mm", False), ("1 cm", False)])
def test_a_mesh_file_without_a_unit_is_asked_for_it_without_airflow_too(
    tmp_path: Path, unit: str | None, said: bool
) -> None:
    block = plica.build_mesh(plica.Block(size=(20.0, 10.0, 6.0)))
    meshio.Mesh(np.asarray(block.points), [("tetra", np.asarray(block.cells))]).write(tmp_path / "b.vtu")
    file = plica.MeshFile(file=tmp_path / "b.vtu", **({} if unit is None else {"unit": unit}))
    scene = plica.Scene(
        file,
        {"body": plica.Tissue(E="10 kPa", nu=0.3)},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        supports=plica.Supports(fixed=()),
    )
    found = scene_cautions(scene, plica.build_mesh(file))
    assert [one.name for one in found] == (["mesh_size"] if said else [])
    if said:
        assert "mesh.unit = 1 m, and the mesh is 20 m" in found[0].seen
        assert 'mesh.unit = "1 mm"' in found[0].advice


@pytest.mark.parametrize(("axes", "said"), [([0, 1, 2], False), ([1, 0, 2], True)])
def test_a_larynx_with_its_front_to_the_side_is_said(tmp_path: Path, axes: list[int], said: bool) -> None:
    """A quarter of a turn about z: as files of another convention are."""
    mesh = plica.build_mesh(plica.Larynx(larynx="coarse"))
    turn = np.array([1.0, -1.0, 1.0]) if said else np.ones(3)
    airway, cells = np.asarray(mesh.surfaces["airway"]), np.asarray(mesh.cells)
    made = meshio.Mesh(
        np.asarray(mesh.points)[:, axes] * turn,
        [("tetra", cells), ("triangle", airway)],
        cell_data={"label": [np.ones(len(cells), dtype=int), np.full(len(airway), 2)]},
    )
    made.write(tmp_path / "turned.vtu")
    scene = plica.Scene(
        plica.MeshFile(
            file=tmp_path / "turned.vtu",
            surfaces={"airway": 2, "outside": "boundary"},
            layers={"body": 1},
            sides="x",
        ),
        {"body": plica.Tissue(E="10 kPa", nu=0.3)},
        time=plica.Stepping(step="50 us", duration="20 ms"),
        airflow=plica.Airflow(),
        supports=plica.Supports(fixed=("outside",)),
    )
    found = said_of(scene)
    assert list(found) == (["turned_airway"] if said else [])
    if said:
        assert "14 mm wide along x, but at one height 0.5 mm long" in found["turned_airway"].seen


def test_a_scene_that_is_refused_has_no_caution_on_its_bodies(tmp_path: Path) -> None:
    scene = Given(LARYNX, 'supports.fixed = ["wal"]').build()
    mesh = plica.build_mesh(scene.mesh)
    assert body_cautions(scene, mesh) == ()
    with pytest.raises(plica.SceneError, match='Did you mean "wall"'):
        plica.build_simulation(scene, mesh)
