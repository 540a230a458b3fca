"""Scenes: units, defaults, round trips, and that what is not named does not exist."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import plica
from plica import _engine
from plica.runs.build import fixed_components, probe_nodes
from plica.runs.materials import materials_of
from plica.scene.initial import initial_fields
from plica.scene.opening import Glottis, opening_pattern
from plica.units import read_quantity


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        ("0.8 kPa", "Pa", 800.0),
        ("50 us", "s", 5e-5),
        ("1e4 dyn/cm^2", "Pa", 1000.0),
        ("4 poise", "Pa s", 0.4),
        ("1 cmH2O", "Pa", 98.0665),
        ("8 cm H2O", "Pa", 784.532),
        ("8 cm_H2O", "Pa", 784.532),
        ("1 mm H2O", "Pa", 9.80665),
        ("1 mmHg", "Pa", 133.322387415),
        ("1 mm Hg", "Pa", 133.322387415),
        ("1 dyn/cm2", "Pa", 0.1),
        ("1.23e-3 g/cm^3", "kg/m^3", 1.23),
        ("1 m/s", "m/s", 1.0),
        ("-2.5mm", "m", -0.0025),
        (800, "Pa", 800.0),
        ("0.5", "", 0.5),
        ("50 %", "", 0.5),
        ("1e7 dyn/cm^3", "Pa/m", 1e8),
    ],
)
def test_a_quantity_is_read_to_the_nearest_number(value: Any, unit: str, expected: float) -> None:
    assert read_quantity(value, unit) == expected


@pytest.mark.parametrize(
    ("value", "unit", "relation"),
    [
        ("0.8 kHz", "Pa", '"kHz" has another dimension'),
        ("0.8 kpa", "Pa", '"kpa" is not known'),
        ("0.8", "Pa", "the text has no unit"),
        ("kPa", "Pa", "does not start with a number"),
        ("1..2 Pa", "Pa", "cannot be read"),
        ("1 Pa +", "Pa", "cannot be read"),
        (float("nan"), "Pa", "must be finite"),
        ("1e999 Pa", "Pa", "must be finite"),
        (True, "Pa", "must be a number in Pa"),
        (None, "Pa", "must be a number in Pa"),
        ("3 m", "", '"m" has another dimension'),
    ],
)
def test_what_is_not_such_a_quantity_is_refused(value: Any, unit: str, relation: str) -> None:
    with pytest.raises(ValueError, match="must be") as caught:
        read_quantity(value, unit)
    assert relation in str(caught.value)


@pytest.mark.parametrize("name", ["bar", "colliding", "phonating"])
def test_a_saved_scene_reads_back_equal(name: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    scene: plica.Scene = request.getfixturevalue(name)
    scene.save(tmp_path / "scene.toml")
    again = plica.Scene.load(tmp_path / "scene.toml")
    assert again == scene
    assert again.digest() == scene.digest()
    assert again.text() == scene.text()


def test_scenes_that_differ_in_one_number_are_not_equal(bar: plica.Scene) -> None:
    other = plica.Scene.from_text(bar.text().replace("nu = 0.3", "nu = 0.31"))
    assert other != bar
    assert other.digest() != bar.digest()


def test_defaults_are_the_engines() -> None:
    airflow, engine = plica.Airflow(), _engine.Airflow()
    for name in ("surface", "subglottal_pressure", "air_density"):
        assert getattr(airflow, name) == getattr(engine, name)
    assert airflow.model.viscous_slit is not None
    assert airflow.area.cut is not None
    for name in ("separation_ratio", "air_viscosity", "least_gap", "inertance"):
        assert getattr(airflow.model.viscous_slit, name) == getattr(engine.model, name)
    assert airflow.area.cut.sections == engine.area.sections
    assert plica.Bernoulli().zero_flow_fraction == _engine.Bernoulli().zero_flow_fraction == 0.5
    assert plica.HilberHughesTaylor().alpha == _engine.HilberHughesTaylor().alpha
    assert plica.Penalty().stiffness == _engine.Penalty().stiffness > 0
    assert plica.VolumePenalty().kappa == _engine.VolumePenalty().kappa > 0
    assert plica.Tissue(E=1.0, nu=0.0).density == _engine.Material(_engine.Isotropic()).density


@pytest.mark.parametrize("name", ["penalty", "volume_penalty"])
def test_a_penalty_is_named_like_any_other_contact(name: str) -> None:
    assert plica.Contact.model_validate(name) == plica.Contact.model_validate({name: {}})


def test_the_mass_of_the_contact_nodes_can_be_with_the_nodes_behind_them(colliding: plica.Scene) -> None:
    assert colliding.contact is not None
    assert colliding.contact.surface_mass == "kept"
    contact = plica.Contact(**{**dict(colliding.contact), "surface_mass": "redistributed"})
    moved = plica.build_simulation(plica.Scene(**{**dict(colliding), "contact": contact}))
    mesh, density = plica.build_mesh(colliding.mesh), colliding.tissue["a"].density
    values, _, row_start = moved.mass
    of_nodes = np.add.reduceat(values, row_start[:-1])[::3]
    touching = np.unique(np.concatenate([mesh.surfaces["a.x_max"], mesh.surfaces["b.x_min"]]))
    assert np.all(of_nodes[touching] == 0)
    assert np.all(np.delete(of_nodes, touching) > 0)
    assert of_nodes.sum() == pytest.approx(2 * density * 0.010 * 0.002**2, rel=1e-12)
    blocks = colliding.mesh.blocks
    thin = plica.Blocks(
        blocks={k: plica.Block(**{**dict(b), "divisions": (2, 1, 1)}) for k, b in blocks.items()}
    )
    with pytest.raises(plica.InvalidInput, match="four cells or more in depth"):
        plica.build_simulation(plica.Scene(**{**dict(colliding), "mesh": thin, "contact": contact}))


@pytest.mark.parametrize(("beta", "gamma"), [(1.0, 2.0), (40.0, 3.0)])
def test_newmark_is_limited_by_its_stability_alone(bar: plica.Scene, beta: float, gamma: float) -> None:
    time = plica.Stepping(step=1e-4, duration=4e-3, scheme=plica.Newmark(beta=beta, gamma=gamma))
    found = plica.build_simulation(plica.Scene(**{**dict(bar), "time": time})).advance(2)
    assert np.isfinite(found["kinetic_energy"]).all()
    assert found["numerical_loss"][-1] > 0


def test_a_part_speaks_for_itself() -> None:
    with pytest.raises(plica.InvalidInput) as caught:
        plica.Airflow(subglottal_pressure=-800)
    assert str(caught.value) == "Airflow: subglottal_pressure = -800 Pa; must be > 0. Is the sign right?"


def test_a_flow_that_jumps_needs_sweeps_after_it_is_held_and_no_other_does() -> None:
    few = plica.Coupling(iterated=plica.Iterated(max_sweeps=8, freeze_after=8))
    assert plica.Airflow(coupling=few).coupling == few
    relation = "coupling.iterated.max_sweeps = 8; must be > freeze_after = 8 with Bernoulli's flow."
    with pytest.raises(plica.SceneError) as caught:
        plica.Airflow(model="bernoulli", coupling=few)
    assert str(caught.value) == f"Airflow: {relation}"
    assert isinstance(caught.value, ValueError)


def test_a_part_cannot_be_changed(bar: plica.Scene) -> None:
    with pytest.raises(ValueError, match="frozen"):
        bar.time.step = 1.0


def test_several_problems_are_several_lines() -> None:
    with pytest.raises(plica.SceneError) as caught:
        plica.Scene.from_text("[time]\nstep = 0\nduration = -1\n", "s.toml")
    assert caught.value.problems == (
        "s.toml: mesh is missing.",
        "s.toml: tissue is missing.",
        "s.toml: time.step = 0 s; must be > 0.",
        "s.toml: time.duration = -1 s; must be > 0. Is the sign right?",
    )


def test_a_larynx_is_held_at_its_wall_unless_the_scene_says_otherwise(phonating: plica.Scene) -> None:
    mesh = plica.build_mesh(phonating.mesh)
    fixed = fixed_components(phonating, mesh)
    assert np.array_equal(np.flatnonzero(fixed.all(axis=1)), np.unique(mesh.node_sets["wall"]))
    assert np.array_equal(fixed.any(axis=1), fixed.all(axis=1))
    free = plica.Scene.from_text(phonating.text().replace('fixed = ["wall"]', "fixed = []"))
    assert not fixed_components(free, mesh).any()


def test_part_of_the_wall_can_be_held(phonating: plica.Scene) -> None:
    text = phonating.text().replace('fixed = ["wall"]', 'fixed = ["wall"]\nwall_from_y = "0.3 cm"')
    scene = plica.Scene.from_text(text)
    mesh = plica.build_mesh(scene.mesh)
    wall = np.asarray(mesh.node_sets["wall"])
    fixed = fixed_components(scene, mesh).all(axis=1)
    y = np.abs(np.asarray(mesh.points)[:, 1])
    assert 0 < fixed.sum() < len(wall)
    assert y[fixed].min() >= 0.003
    assert y[wall[~fixed[wall]]].max() < 0.003


def test_cartilages_hold_what_lies_beyond_the_ends_of_the_glottis() -> None:
    larynx = plica.Larynx(larynx="coarse", order=2, folds=plica.Folds(length="12 mm"))
    scene = plica.Scene(
        larynx,
        "thesis_corrected",
        time=plica.Stepping(step="50 us", duration="1 ms"),
        supports=plica.Supports(cartilages=True),
    )
    mesh = plica.build_mesh(scene.mesh)
    fixed = fixed_components(scene, mesh)
    y = np.abs(np.asarray(mesh.points)[:, 1])
    assert (fixed.all(axis=1) == fixed.any(axis=1)).all()
    assert y[fixed[:, 0]].min() == pytest.approx(6e-3, rel=1e-9)  # the tips
    assert y[~fixed[:, 0]].max() < 6e-3
    both = scene.replace({"supports.fixed": ("wall",)})
    assert fixed_components(both, mesh).sum() > fixed.sum()


def test_components_are_held_one_by_one(bar: plica.Scene) -> None:
    text = bar.text().replace('fixed = ["x_min"]', 'components = { x_min = "x", y_min = "yz" }')
    scene = plica.Scene.from_text(text)
    mesh = plica.build_mesh(scene.mesh)
    fixed = fixed_components(scene, mesh)
    points = np.asarray(mesh.points)
    assert np.array_equal(fixed[:, 0], points[:, 0] == points[:, 0].min())
    assert np.array_equal(fixed[:, 1], points[:, 1] == points[:, 1].min())
    assert np.array_equal(fixed[:, 1], fixed[:, 2])


def test_the_opening_pattern_is_one_at_the_upper_edge_and_zero_at_the_wall(
    phonating: plica.Scene,
) -> None:
    assert isinstance(phonating.mesh, plica.Larynx)
    mesh = plica.build_mesh(phonating.mesh)
    points = np.asarray(mesh.points)
    glottis = Glottis.of_larynx(phonating.mesh)
    pattern = opening_pattern(points, glottis)
    edge = np.array([[2.5e-4, 0.0, -4e-4], [-2.5e-4, 0.0, -4e-4]])  # S26 in the mid-plane
    # the pattern's square roots leave a few units in the last place
    np.testing.assert_allclose(opening_pattern(edge, glottis)[:, 0], [1.0, -1.0], atol=1e-14)
    assert np.all(pattern[:, 1:] == 0)
    assert np.all(pattern[:, 0] * points[:, 0] >= 0)
    assert np.abs(pattern).max() <= 1 + 1e-14
    assert np.abs(pattern[mesh.node_sets["wall"]]).max() < 1e-12
    assert (pattern[points[:, 0] > 0].sum() + pattern[points[:, 0] < 0].sum()) == pytest.approx(0, abs=1e-12)


def test_a_bar_starts_from_its_equilibrium_and_stays_there(bar: plica.Scene) -> None:
    data = bar.resolved()
    data["loads"] = [{"surface": "x_max", "traction": [50.0, 0.0, 0.0]}]
    data["initial"] = {"equilibrium": True}
    loaded = plica.Scene.model_validate(data)
    found = plica.equilibrium(loaded)
    simulation = plica.build_simulation(loaded)
    np.testing.assert_array_equal(np.asarray(simulation.displacement), found)
    assert np.abs(found).max() > 1e-6
    simulation.advance(20)
    moved = np.abs(np.asarray(simulation.displacement) - found).max()
    assert moved < 1e-7 * np.abs(found).max()


def test_initial_fields_vanish_where_held(bar: plica.Scene) -> None:
    mesh = plica.build_mesh(bar.mesh)
    fixed = fixed_components(bar, mesh)
    displacement, velocity = initial_fields(bar, mesh, fixed)
    assert displacement is None
    assert velocity is not None
    assert np.all(velocity[fixed] == 0)
    assert np.all(velocity[~fixed[:, 0]] == [0, 0, 0.1])


def test_one_side_can_have_its_own_tissue(phonating: plica.Scene) -> None:
    text = phonating.text() + '\n[tissue.cover.right]\nE_fibre = "14 kPa"\n'
    scene = plica.Scene.from_text(text)
    mesh = plica.build_mesh(scene.mesh)
    materials, names, cell_material = materials_of(scene, mesh)
    assert names == ["body", "ligament", "cover.left", "cover.right"]
    cover = np.asarray(mesh.cell_layer) == mesh.layer_names.index("cover")
    for number, side, stiffness in ((2, 1, 10e3), (3, 2, 14e3)):
        assert np.array_equal(cell_material == number, cover & (np.asarray(mesh.cell_side) == side))
        assert materials[number].elasticity.E_fibre == stiffness
        assert materials[number].elasticity.E == 1e3
    assert materials[2].elasticity.mu is None


@pytest.mark.parametrize("order", [1, 2])
def test_a_layer_without_tissue_is_shown_by_its_first_cell(colliding: plica.Scene, order: int) -> None:
    blocks = plica.Blocks(**{**dict(colliding.mesh), "order": order})
    scene = plica.Scene(blocks, {"a": colliding.tissue["a"]}, time=colliding.time)
    # hexahedra of 10/6 x 2 x 2 mm, 36 tetrahedra in "a"; "b" begins at x = 10.1 mm
    with pytest.raises(plica.SceneError, match=r"36 tetrahedra .* the first is cell 36 at \[") as raised:
        plica.build_simulation(scene)
    place = [float(text) for text in str(raised.value).split("at [")[1].split("]")[0].split(", ")]
    corners = np.asarray(plica.build_mesh(blocks).points)[np.asarray(plica.build_mesh(blocks).cells)[36, :4]]
    np.testing.assert_allclose(place, corners.mean(axis=0), rtol=1e-5)
    assert 0.0101 < place[0] < 0.0101 + 0.010 / 6


def test_probes_are_the_nearest_nodes(bar: plica.Scene) -> None:
    mesh = plica.build_mesh(bar.mesh)
    nodes = probe_nodes(bar, mesh)
    np.testing.assert_allclose(np.asarray(mesh.points)[nodes], [[0.01, 0.0, 0.0]], atol=1e-12)


def test_quadratic_tetrahedra_are_made_on_request(bar: plica.Scene) -> None:
    text = bar.text().replace("order = 1", "order = 2")
    mesh = plica.build_mesh(plica.Scene.from_text(text).mesh)
    assert mesh.order == 2
    assert len(mesh.cells) == len(plica.build_mesh(bar.mesh).cells)


def own_mesh(folder: Path, *, flip: bool = False) -> Path:
    """A block of 2 x 1 x 2 with labels 1 (below), 2 (above), and triangles 11 (bottom), 12 (top)."""
    block = plica.build_mesh(plica.Block(size=(2.0, 1.0, 2.0), divisions=(2, 1, 2)))
    points, cells = np.asarray(block.points) - [1.0, 0.0, 0.0], np.asarray(block.cells)
    bottom, top = (np.asarray(block.surfaces[name]) for name in ("z_min", "z_max"))
    label = np.where(points[cells].mean(axis=1)[:, 2] < 1.0, 1, 2)
    if flip:
        bottom = bottom[:, ::-1]
    labels = [label, np.full(len(bottom), 11), np.full(len(top), 12)]
    mesh = meshio.Mesh(
        points,
        [("tetra", cells), ("triangle", bottom), ("triangle", top)],
        cell_data={"gmsh:physical": labels, "gmsh:geometrical": labels},
        field_data={"below": np.array([1, 3]), "above": np.array([2, 3])},
    )
    path = folder / "own.msh"
    mesh.write(path, file_format="gmsh22")
    return path


OWN = """
[mesh]
file = "own.msh"
unit = "1 mm"
sides = "x"
layers = { below = 1, above = "above" }
surfaces = { bottom = 11, ends = [11, 12], skin = "boundary" }
[tissue.below]
E = 2e4
nu = 0.3
[tissue.above]
E = 1e4
nu = 0.3
[time]
step = 1e-4
duration = 1e-3
"""


@pytest.mark.parametrize("flip", [False, True])
def test_a_mesh_file_gives_names_to_its_labels(tmp_path: Path, flip: bool) -> None:
    own_mesh(tmp_path, flip=flip)
    (tmp_path / "s.toml").write_text(OWN)
    scene = plica.Scene.load(tmp_path / "s.toml")
    mesh = plica.build_mesh(scene.mesh)
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    centre = points[cells].mean(axis=1)
    assert np.ptp(points[:, 0]) == pytest.approx(2e-3)
    assert mesh.layer_names == ["below", "above"]
    assert np.array_equal(np.asarray(mesh.cell_layer) == 1, centre[:, 2] > 1e-3)
    assert np.array_equal(np.asarray(mesh.cell_side), np.where(centre[:, 0] < 0, 1, 2))
    a, b, c = np.moveaxis(points[mesh.surfaces["bottom"]], 1, 0)
    assert np.all(np.cross(b - a, c - a)[:, 2] < 0)  # outward is down, however the file turned them
    assert len(mesh.surfaces["ends"]) == 2 * len(mesh.surfaces["bottom"])
    assert len(mesh.surfaces["skin"]) == 32
    assert np.array_equal(mesh.node_sets["bottom"], np.flatnonzero(points[:, 2] == 0))


def test_a_mesh_file_can_become_quadratic(tmp_path: Path) -> None:
    own_mesh(tmp_path)
    (tmp_path / "s.toml").write_text(OWN.replace("[mesh]", "[mesh]\norder = 2"))
    mesh = plica.build_mesh(plica.Scene.load(tmp_path / "s.toml").mesh)
    assert np.asarray(mesh.cells).shape[1] == 10
    assert np.asarray(mesh.surfaces["bottom"]).shape[1] == 6


def test_absent_parts_are_not_constructed(bar: plica.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*args: object, **fields: object) -> None:
        raise AssertionError("constructed")

    absent = ("Airflow", "Contact", "Multipliers", "Load", "matched_airway", "flat_triangles", "larynx_mesh")
    for name in (*absent, "Lagged", "Extrapolated", "Iterated", "Penalty", "VolumePenalty", "combine"):
        monkeypatch.setattr(_engine, name, refuse)
    simulation = plica.build_simulation(bar)
    names = set(simulation.advance(1))
    assert not {"flow", "section_area", "contact_rows", "contact_work"} & names
    assert {"time", "kinetic_energy"} <= names


def test_a_bare_run_loads_no_library_that_it_does_not_use(tmp_path: Path, bar: plica.Scene) -> None:
    bar.save(tmp_path / "scene.toml")
    program = (
        "import sys, plica\n"
        "plica.run(plica.Scene.load(sys.argv[1]), sys.argv[2], progress=False)\n"
        "print([m for m in ('meshio', 'pint', 'xarray', 'matplotlib', 'tqdm', 'cv2') if m in sys.modules])"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "scene.toml"), str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_bars_on_mortar_faces_exchange_the_same_impulse(colliding: plica.Scene) -> None:
    impulse = []
    for faces in ("nodes", "mortar"):
        fields = colliding.model_dump(exclude_none=True)
        fields["contact"]["faces"] = faces
        fields["mesh"]["order"] = 2
        waves = plica.build_simulation(plica.Scene.model_validate(fields)).advance(40)
        impulse.append(np.asarray(waves["contact_force_first"])[:, 0].sum())
    assert impulse[0] < 0
    assert impulse[1] == pytest.approx(impulse[0], rel=0.01)


def test_mortar_faces_do_not_go_with_volumes() -> None:
    with pytest.raises(
        plica.SceneError, match=r'faces = "mortar"; must be "nodes" with contact.volume_penalty'
    ):
        plica.Contact(volume_penalty=plica.VolumePenalty(), faces="mortar")
