"""Folds that differ: lesions, gaps of their own, a chink. Areas, volumes and masses are closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.identify.parameters import TissueParameters
from plica.report.glottis import draw_glottis
from plica.runs.lesions import lesion_cells, lesion_text
from plica.runs.materials import materials_of
from plica.scene.lesion_cells import lesions_with_cells
from plica.scene.mesh.build import build_mesh
from plica.scene.symmetry import nearest_image

MM = 1e-3
SIZES = {
    "length": 12 * MM,
    "thickness": 3 * MM,
    "gap": 0.6 * MM,
    "depth": 8 * MM,
    "cover": MM,
    "ligament": MM,
}
POLYP = {"fold": "left", "size": [5 * MM, 2.5 * MM, MM], "protrusion": 0.35 * MM}
CHINK = {"width": 1.2 * MM, "length": 6 * MM}


def scene_of(
    folds: dict[str, Any],
    larynx: str = "coarse",
    order: int = 2,
    *,
    around: int = 24,
    still: bool = False,
    **parts: Any,
) -> plica.Scene:
    """still: what is built takes no steps to speak of, and so no factor of its matrices."""
    options = plica.LarynxOptions(around=around)
    return plica.Scene(
        plica.Larynx(larynx=larynx, order=order, folds=plica.Folds(**SIZES | folds), options=options),
        parts.pop("tissue", "thesis_corrected"),
        time=plica.Stepping(step="50 us", duration="1 ms"),
        solver=plica.Solver(method="conjugate_gradients") if still else plica.Solver(),
        **parts,
    )


def mass_of(scene: plica.Scene) -> float:
    """kg, from the mass matrix."""
    values, _, _ = plica.build_simulation(scene).mass
    return float(np.sum(values)) / 3


def volume_of(scene: plica.Scene) -> float:
    """m^3, of cells with curved sides as the engine integrates them."""
    return mass_of(scene) / scene.tissue["body"].density


@pytest.mark.parametrize("order", [1, 2])
def test_a_lesion_and_its_mirror_image_have_the_same_shares_of_cells(order: int) -> None:
    """To the bit, whatever the order of a cell's corners; many cells are cut."""
    shares = []
    for fold in ("left", "right"):
        scene = scene_of({"lesions": [{"fold": fold, "size": [5 * MM, 1.6 * MM, 0.8 * MM]}]}, order=order)
        mesh = build_mesh(scene.mesh)
        ((_, cells, share),) = lesions_with_cells(scene, mesh)
        middle = np.asarray(mesh.points)[mesh.cells[cells][:, :4]].mean(axis=1).round(9)
        middle[:, 0] = np.abs(middle[:, 0])
        shares.append(share[np.lexsort(middle.T)])
    np.testing.assert_array_equal(*shares)
    assert np.count_nonzero(shares[0] < 1) > 50


def test_the_gap_is_narrowed_by_the_protrusion_at_the_top_of_the_bump() -> None:
    for fold, sign in (("left", -1), ("right", 1)):
        like = build_mesh(scene_of({}).mesh)
        mesh = build_mesh(scene_of({"lesions": [POLYP | {"fold": fold, "below_edge": 0}]}).mesh)
        points, before = np.asarray(mesh.points), np.asarray(like.points)
        top = np.argmin(np.linalg.norm(before - [sign * 0.3 * MM, 0, 0], axis=1))
        assert before[top] == pytest.approx([sign * 0.3 * MM, 0, 0], abs=1e-15)  # a node of the upper edge
        assert points[top, 0] == pytest.approx(-sign * 0.05 * MM, rel=1e-12)
        moved = (points != before).any(axis=1)
        np.testing.assert_array_equal(points[:, 1:], before[:, 1:])
        assert moved.any()
        assert (np.sign(before[moved, 0]) == sign).all()
        assert (sign * (before - points)[:, 0]).max() == pytest.approx(0.35 * MM)


@pytest.mark.parametrize("order", [1, 2])
def test_the_tissue_grows_by_the_integral_of_the_bump(order: int) -> None:
    exact = np.pi / 3 * 2.5 * MM * 1.25 * MM * 0.35 * MM
    error = []
    for larynx, around in (("coarse", 12), ("coarse", 32)):
        own = {"larynx": larynx, "order": order, "around": around, "still": True}
        grown = volume_of(scene_of({"lesions": [POLYP]}, **own)) - volume_of(scene_of({}, **own))
        error.append(abs(grown / exact - 1))
    assert error[1] < (0.03 if order == 1 else 0.002)
    assert error[1] < error[0]


def test_the_mass_that_is_added_is_that_of_the_patch() -> None:
    heavy = POLYP | {"density": 2040.0}
    for change, volume in (
        ({"protrusion": 0}, 2 / 3 * np.pi * 2.5 * 1.25 * 1.0 * MM**3),
        ({}, np.pi * 2.5 * 1.25 * (2 / 3 * 1.0 + 0.35 / 3) * MM**3),
    ):
        light, heavier = (scene_of({"lesions": [own | change]}, still=True) for own in (POLYP, heavy))
        added = mass_of(heavier) - mass_of(light)
        assert added == pytest.approx(1020.0 * volume, rel=0.01)  # the border's parts, and the mesh


def test_a_lesion_of_the_tissues_own_constants_changes_no_bit() -> None:
    parts = {
        "airflow": plica.Airflow(subglottal_pressure="0.8 kPa", rise="1 ms", area=plica.Cut(sections=40)),
        "contact": plica.Multipliers(),
        "initial": plica.Initial(opening_velocity="-0.5 m/s"),
        "around": 12,
    }
    same = POLYP | {"protrusion": 0, "density": 1020.0}
    runs = [plica.build_simulation(scene_of({"lesions": own}, **parts)) for own in ([], [same])]
    first, second = (run.advance(20) for run in runs)
    assert len(materials_of(scene_of({"lesions": [same]}), build_mesh(scene_of({}).mesh))[0]) > 3
    for name, values in first.items():
        np.testing.assert_array_equal(values, second[name], err_msg=name)
    assert np.ptp(first["flow"]) > 0


def test_a_lesion_of_all_of_a_layer_is_a_change_of_its_constants() -> None:
    """Matrices to the bit: of one side, where factors are powers of two."""
    side = {"E": 2e3, "E_fibre": 20e3, "mu_fibre": 20e3, "viscosity": 0.07, "density": 1100.0}
    tissue = dict(plica.TISSUE_PRESETS["thesis_corrected"])
    changed = tissue | {"cover": tissue["cover"].replace({"right": plica.TissueSide(**side)})}
    whole = {
        "fold": "right",
        "size": [40 * MM, 40 * MM, 8 * MM],
        "layers": ["cover"],
        "stiffness": 2.0,
        "viscosity": 0.5,
        "density": 1100.0,
    }
    runs = [
        plica.build_simulation(own)
        for own in (
            scene_of({}, tissue=changed, still=True),
            scene_of({"lesions": [whole]}, tissue=tissue, still=True),
        )
    ]
    plain = plica.build_simulation(scene_of({}, tissue=tissue, still=True))
    for matrix in ("mass", "stiffness", "viscosity"):
        first, second = (getattr(run, matrix)[0] for run in runs)
        np.testing.assert_array_equal(first, second)
        assert (first != getattr(plain, matrix)[0]).any()


def test_a_cell_that_the_border_cuts_has_the_mean_by_its_share() -> None:
    scene = scene_of({"lesions": [POLYP | {"stiffness": 3.0, "viscosity": 2.0, "density": 1500.0}]})
    mesh = plica.scene_mesh(scene)
    materials, names, of_cell = materials_of(scene, mesh)
    plain, _, before = materials_of(scene_of({}), mesh)
    changed = np.flatnonzero(of_cell >= len(plain))
    assert (np.asarray(mesh.cell_side)[changed] == 1).all()
    np.testing.assert_array_equal(np.delete(of_cell, changed), np.delete(before, changed))
    for cell in changed:
        own, base = materials[of_cell[cell]], plain[before[cell]]
        share = (own.density - base.density) / (1500.0 - base.density)
        assert 0 < share <= 1
        assert pytest.approx(base.elasticity.E * (1 + 2 * share)) == own.elasticity.E
        assert own.elasticity.mu_fibre == pytest.approx(base.elasticity.mu_fibre * (1 + 2 * share))
        assert own.viscosity == pytest.approx(base.viscosity * (1 + share))
        assert names[of_cell[cell]].startswith(f"{mesh.layer_names[before[cell]]}.lesion.")


def test_where_lesions_overlap_factors_multiply() -> None:
    whole = {"fold": "left", "size": [40 * MM, 40 * MM, 8 * MM], "layers": ["cover"], "stiffness": 2.0}
    scene = scene_of({"lesions": [whole, whole]})
    mesh = plica.scene_mesh(scene)
    materials, _, of_cell = materials_of(scene, mesh)
    cover = mesh.layer_names.index("cover")
    left = (np.asarray(mesh.cell_side) == 1) & (np.asarray(mesh.cell_layer) == cover)
    assert {materials[k].elasticity.E for k in of_cell[left]} == {4e3}


def test_what_stiffens_is_that_of_the_layer_on_each_side_and_in_a_lesion() -> None:
    cover = plica.TISSUE_PRESETS["thesis_corrected"]["cover"]
    own = {"stiffening": 1.5, "matrix_stiffening": 3.0, "left": {"matrix_stiffening": 5.0}}
    tissue = dict(plica.TISSUE_PRESETS["thesis_corrected"]) | {"cover": cover.replace(own)}
    scene = scene_of({"lesions": [POLYP | {"stiffness": 2.0}]}, tissue=tissue, around=12)
    materials, names, _ = materials_of(scene, plica.scene_mesh(scene))
    expected = {"cover.left": (1.5, 5.0), "cover.right": (1.5, 3.0), "ligament": (0, 0), "body": (0, 0)}
    found: dict[str, set[tuple[float, float]]] = {}
    for name, material in zip(names, materials, strict=True):
        layer = name.partition(".lesion.")[0]
        found.setdefault(layer, set()).add((material.stiffening, material.matrix_stiffening))
    assert found == {layer: {values} for layer, values in expected.items()}
    assert any(name.startswith("cover.left.lesion.") for name in names)


def densities_of(*lesions: dict[str, Any]) -> np.ndarray:
    """kg/m^3, of each cell."""
    scene = scene_of({"lesions": lesions}, around=12)
    materials, _, of_cell = materials_of(scene, plica.scene_mesh(scene))
    return np.array([material.density for material in materials])[of_cell]


def test_where_lesions_overlap_the_density_is_the_mean_of_theirs_in_any_order() -> None:
    flat = POLYP | {"protrusion": 0}
    heavy, light = flat | {"density": 1500.0}, flat | {"density": 900.0, "from_front": 7 * MM}
    stiff = flat | {"stiffness": 3.0}  # no density of its own
    plain, one, other = densities_of(), densities_of(heavy), densities_of(light)
    share = (one - plain) / (1500.0 - plain), (other - plain) / (900.0 - plain)
    total = share[0] + share[1]
    expected = plain * np.maximum(1 - total, 0) + (share[0] * 1500.0 + share[1] * 900.0) / np.maximum(
        total, 1
    )
    assert (total > 1.5).any()
    assert ((share[0] > 0) & (share[1] > 0) & (total < 1)).any()
    found = densities_of(heavy, light)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    np.testing.assert_array_equal(found, densities_of(light, heavy))
    np.testing.assert_array_equal(densities_of(stiff, heavy), one)


@pytest.mark.parametrize(
    ("folds", "area"),
    [
        ({}, np.pi / 4 * 12 * 0.6),
        ({"left_gap": 0.9 * MM}, np.pi / 4 * 12 * (0.9 + 0.3)),
        ({"left_gap": 0.2 * MM, "right_gap": 0.5 * MM}, np.pi / 4 * 12 * 0.7),
        ({"posterior_chink": CHINK}, np.pi / 4 * 12 * 0.6 + 9 / 16 * 1.2 * 6),
        ({"posterior_chink": CHINK, "right_gap": 0.5 * MM}, np.pi / 4 * 12 * 0.8 + 9 / 16 * 1.2 * 6),
    ],
)
def test_the_area_at_rest_is_the_closed_form(folds: dict[str, Any], area: float) -> None:
    """At the height of the medial surface; the flow's sections of a mesh with curved sides, too."""
    surface = plica.Folds(**SIZES | folds).surface()
    y = np.linspace(-6 * MM, 6 * MM, 200_001)
    width = surface.at(-1.0, y, np.full_like(y, -MM)) + surface.at(1.0, y, np.full_like(y, -MM))
    assert np.trapezoid(width, y) == pytest.approx(area * MM**2, rel=1e-6)

    airflow = plica.Airflow(subglottal_pressure="1 Pa", area=plica.Cut(sections=100))
    scene = scene_of(folds, airflow=airflow, still=True).replace({"time.step": "0.1 us"})
    simulation = plica.build_simulation(scene)
    found = np.min(simulation.advance(1)["section_area"])
    assert found == pytest.approx(area * MM**2, rel=0.01)


def test_a_chink_of_like_folds_is_symmetric() -> None:
    mesh = build_mesh(scene_of({"posterior_chink": CHINK}).mesh)
    points = np.asarray(mesh.points)
    mirrored = points * [-1, 1, 1]
    assert sorted(map(tuple, mirrored)) == sorted(map(tuple, points + 0.0))
    parts = {
        "airflow": plica.Airflow(subglottal_pressure="0.8 kPa", rise="1 ms", area=plica.Cut(sections=40)),
        "contact": plica.Multipliers(),
        "initial": plica.Initial(opening_velocity="-0.5 m/s"),
        "around": 12,
    }
    whole, half = (
        plica.build_simulation(scene_of({"posterior_chink": CHINK}, **parts, symmetry=symmetry)).advance(20)
        for symmetry in (None, "half")
    )
    for name in ("flow", "minimum_area"):
        np.testing.assert_allclose(half[name], whole[name], rtol=1e-6)


@pytest.mark.parametrize("around", [12, 16, 24])
@pytest.mark.parametrize("folds", [{"left_gap": 0.9 * MM}, {"lesions": [POLYP]}])
def test_nodes_of_unlike_folds_stay_partners(folds: dict[str, Any], around: int) -> None:
    """Also in the middle of sides, which are less curved where cells would fold over."""
    points = np.asarray(build_mesh(scene_of(folds, around=around).mesh).points)
    before = np.asarray(build_mesh(scene_of({}, around=around).mesh).points)
    image = nearest_image(before, 0)
    np.testing.assert_allclose(points[image, 1:], points[:, 1:], atol=1e-15)
    assert (points[image, 0] != -points[:, 0]).any()


def test_a_posture_and_finite_strain_keep_the_lesion_where_it_is_in_the_tissue() -> None:
    scene = scene_of({"lesions": [POLYP | {"stiffness": 3.0}]}, order=1, around=12)
    posture = scene.replace({"posture": {"elongation": 0.05}})
    rest, stretched = plica.scene_mesh(scene), plica.scene_mesh(posture)
    assert np.abs(np.asarray(stretched.points) - np.asarray(rest.points)).max() > 0.1 * MM
    np.testing.assert_array_equal(materials_of(posture, stretched)[2], materials_of(scene, rest)[2])
    for own in (scene, posture):
        small = own.replace({"initial": {"opening_displacement": "1 nm"}})
        healthy = small.replace({"mesh.folds.lesions[0].stiffness": 1.0})
        runs = [
            plica.build_simulation(start) for start in (small, small.replace({"strain": "finite"}), healthy)
        ]
        for run in runs:
            run.advance(3)
        linear, finite, without = (np.asarray(run.velocity) for run in runs)
        size = np.abs(linear).max()
        np.testing.assert_allclose(finite, linear, atol=1e-5 * size)  # small motion is linear
        assert np.abs(without - linear).max() > 0.05 * size


def test_an_identified_stiffness_of_a_layer_keeps_the_factor_of_its_lesion() -> None:
    scene = scene_of({"lesions": [POLYP | {"stiffness": 3.0}]}, around=12)
    materials, names, _ = materials_of(scene, plica.scene_mesh(scene))
    parameters = TissueParameters(materials, names, ["cover.mu_fibre"])
    assert np.exp(parameters.prior_mean[0]) == pytest.approx(10e3)  # of the layer, not of the lesion
    stiffness = parameters.coefficients(np.log([20e3]))[0]
    before = parameters.coefficients(np.log([10e3]))[0]
    cover = [k for k, name in enumerate(names) if name.startswith("cover")]
    assert len(cover) > 2
    np.testing.assert_allclose(np.asarray(stiffness)[cover, 4], 2 * np.asarray(before)[cover, 4])
    assert len(set(np.round(np.asarray(before)[cover, 4], 6))) > 2


def test_folds_open_away_from_each_other_where_a_lesion_stands_across_the_middle_plane() -> None:
    lesion = POLYP | {"below_edge": 0}
    scene = scene_of({"lesions": [lesion]}, initial={"opening_velocity": 0.1}, still=True)
    mesh = plica.scene_mesh(scene)
    across = (np.asarray(mesh.points)[:, 0] > 0) & np.isin(
        np.arange(len(mesh.points)), np.asarray(mesh.cells)[np.asarray(mesh.cell_side) == 1]
    )
    velocity = np.asarray(plica.build_simulation(scene).velocity)[:, 0]
    assert across.sum() > 0
    assert (velocity[across] < -0.05).all()


def test_a_stored_scene_keeps_what_differs_and_others_know_nothing_of_it() -> None:
    folds = {"lesions": [POLYP], "left_gap": 0.5 * MM, "posterior_chink": CHINK}
    scene = scene_of(folds)
    assert plica.Scene.from_text(scene.text()) == scene
    softer = scene.replace({"mesh.folds.lesions[0].stiffness": 0.5})
    assert softer.mesh.folds.lesions[0].stiffness == 0.5
    assert not {"lesions", "left_gap", "posterior_chink"} & scene_of({}).resolved()["mesh"]["folds"].keys()


def test_lesions_are_drawn_and_told(tmp_path: Path) -> None:
    scene = scene_of({"lesions": [POLYP], "posterior_chink": CHINK})
    mesh = plica.scene_mesh(scene)
    assert all(len(cells) for cells in lesion_cells(scene, mesh))
    assert lesion_text(scene, mesh).startswith("\nlesion 0 (left): ")
    plain, marked = tmp_path / "plain.svg", tmp_path / "marked.svg"
    draw_glottis(mesh, plain)
    draw_glottis(mesh, marked, lesion_cells(scene, mesh))
    assert "#5b1a3a" in marked.read_text()
    assert "#5b1a3a" not in plain.read_text()


@pytest.mark.parametrize(
    ("folds", "message"),
    [
        ({"lesions": [POLYP | {"fold": "upper"}]}, 'lesions[0].fold = "upper"; must be one of left, right.'),
        (
            {"lesions": [POLYP | {"from_front": "13 mm"}]},
            "lesions[0].from_front = 0.013 m; must be <= 12 mm, the",
        ),
        ({"lesions": [POLYP | {"from_front": "-1 mm"}]}, "lesions[0].from_front = "),
        (
            {"lesions": [POLYP | {"below_edge": "4 mm"}]},
            "lesions[0].below_edge = 0.004 m; must be <= 3 mm, the",
        ),
        ({"lesions": [POLYP | {"size": [0, MM, MM]}]}, "lesions[0].size[0] = 0 m; must be > 0"),
        ({"lesions": [POLYP | {"size": [MM, MM]}]}, "lesions[0].size[2] is missing"),
        (
            {"lesions": [POLYP | {"size": [MM, MM, "9 mm"]}]},
            "lesions[0].size[2] = 0.009 m; must be <= 8 mm, the depth",
        ),
        ({"lesions": [{"fold": "left"}]}, "lesions[0].size is missing"),
        ({"lesions": [POLYP | {"stiffness": 0}]}, "lesions[0].stiffness = 0; must be > 0"),
        ({"lesions": [POLYP | {"viscosity": -1}]}, "lesions[0].viscosity = -1; must be >= 0"),
        ({"lesions": [POLYP | {"density": 0}]}, "lesions[0].density = 0 kg/m^3; must be > 0"),
        ({"lesions": [POLYP | {"protrusion": -MM}]}, "lesions[0].protrusion = -0.001 m; must be >= 0"),
        (
            {"lesions": [POLYP | {"protrusion": "0.7 mm"}]},
            "lesions[0].protrusion = 0.0007 m; must be < 0.6 mm: ",
        ),
        (
            {"lesions": [POLYP, POLYP | {"fold": "right"}]},
            "lesions[0].protrusion = 0.00035 m; must be < 0.25 mm: ",
        ),
        (
            {"lesions": [POLYP | {"from_front": 2 * MM}]},
            "lesions[0].size[0] = 0.005 m; must be <= 4 mm, so that what protrudes",
        ),
        (
            {"lesions": [POLYP | {"stifness": 2}]},
            'lesions[0].stifness is not known. Did you mean "stiffness"?',
        ),
        ({"left_gap": 0}, "left_gap = 0 m; must be > 0"),
        ({"right_gap": "5 mm"}, 'right_gap = "5 mm"; must be <= 4 mm.'),
        ({"posterior_chink": {"width": -MM, "length": MM}}, "posterior_chink.width = -0.001 m; must be > 0"),
        (
            {"posterior_chink": {"width": MM, "length": "13 mm"}},
            "posterior_chink.length = 0.013 m; must be <= 12 mm",
        ),
        ({"posterior_chink": {"width": MM}}, "posterior_chink.length is missing"),
    ],
)
def test_what_no_fold_has_is_refused(folds: dict[str, Any], message: str) -> None:
    with pytest.raises(plica.SceneError) as error:
        plica.Scene(
            {"larynx": "coarse", "folds": SIZES | folds},
            "thesis_corrected",
            time=plica.Stepping(step="50 us", duration="1 ms"),
        )
    (line,) = str(error.value).splitlines()
    assert f"Scene: mesh.folds.{message}" in line


def test_a_lesion_between_the_points_of_the_mesh_is_refused() -> None:
    scene = scene_of({"lesions": [POLYP | {"size": ["1 um", "1 um", "1 um"], "protrusion": 0}]})
    with pytest.raises(plica.SceneError, match=r"lesions\[0\].size: no tissue of the mesh is in the lesion"):
        plica.build_simulation(scene)
    scene = scene_of({"lesions": [POLYP | {"layers": ["covr"]}]})
    with pytest.raises(plica.SceneError, match=r'layers\[0\] = "covr"; must be .*Did you mean "cover"'):
        plica.build_simulation(scene)


def test_a_shape_that_folds_the_mesh_over_is_refused_with_what_is_possible() -> None:
    scene = scene_of({"left_gap": 4 * MM, "depth": 6.4 * MM, "length": 12.4 * MM}, around=12)
    with pytest.raises(
        plica.SceneError, match=r"mesh.folds: left_gap.* must be at most 0\.\d+ of what they are"
    ):
        plica.scene_mesh(scene)


def test_a_lesion_is_as_deep_as_the_tissue_at_most() -> None:
    lesion = {"fold": "left", "size": ["5 mm", "1.6 mm", "7 mm"]}
    assert plica.Folds(depth="7 mm", gap="0.6 mm", lesions=[lesion]).lesions[0].size[2] == 7e-3
    with pytest.raises(plica.SceneError, match=r"size\[2\].* = 0.0071.*must be <= 7 mm, the depth"):
        plica.Folds(depth="7 mm", gap="0.6 mm", lesions=[lesion | {"size": ["5 mm", "1.6 mm", "7.1 mm"]}])
