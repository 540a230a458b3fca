"""Larynxes at a posture: what is stretched, what sees it, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

import plica
from interrupted_runs import assert_resumes_to_the_bit
from plica import InvalidInput, SceneError, SolveFailed, _engine
from plica.identify.model.model import require_linear
from plica.runs import scene_mesh
from plica.scene.held import fixed_components
from plica.scene.mesh.summary import mesh_summary


def voice(posture: Any = None, **parts: Any) -> plica.Scene:
    """A larynx of few cells, whose fibres stiffen."""
    tissue = {
        layer: plica.TISSUE_PRESETS["thesis_corrected"][layer].replace({"stiffening": 2.0})
        for layer in ("body", "ligament", "cover")
    }
    return plica.Scene(
        plica.Larynx(larynx="coarse"),
        tissue,
        time=plica.Stepping(step="50 us", duration="1 ms"),
        airflow=plica.Airflow(subglottal_pressure="300 Pa"),
        posture=posture,
        **parts,
    )


def modes(scene: plica.Scene, count: int = 3) -> np.ndarray:
    return np.asarray(plica.eigenmodes(scene, count).frequency)


def test_no_posture_and_none_to_speak_of_are_the_same_to_the_bit() -> None:
    plain, still = plica.scene_mesh(voice()), plica.scene_mesh(voice(plica.Posture(elongation=0.0)))
    assert still.rest is None
    np.testing.assert_array_equal(plain.points, still.points)


def test_what_is_held_moves_by_the_elongation_and_the_rest_follows() -> None:
    scene = voice(plica.Posture(elongation=0.15))
    mesh = plica.scene_mesh(scene)
    rest, x = np.asarray(mesh.rest), np.asarray(mesh.points)
    np.testing.assert_array_equal(rest, plica.build_mesh(scene.mesh).points)
    wall = np.asarray(mesh.node_sets["wall"])
    middle = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
    aside = 1.15**-0.5
    np.testing.assert_allclose(
        x[wall], middle + (rest[wall] - middle) * (aside, 1.15, aside), rtol=0, atol=1e-16
    )
    moved = x - rest
    # symmetric as the larynx is, to what Newton's method leaves
    for axis in (0, 1):
        mirrored = rest * np.where(np.arange(3) == axis, -1, 1)
        order = np.lexsort(np.round(rest, 9).T), np.lexsort(np.round(mirrored, 9).T)
        image = moved[order[1]] * np.where(np.arange(3) == axis, -1, 1)
        np.testing.assert_allclose(moved[order[0]], image, rtol=0, atol=1e-9 * np.abs(moved).max())


def test_pitch_rises_with_elongation_and_with_the_muscles_that_bring_it_about() -> None:
    rest, longer = modes(voice()), modes(voice(plica.Posture(elongation=0.2)))
    assert longer[0] > 1.04 * rest[0]
    muscles = plica.Posture(
        muscles=plica.Muscles(cricothyroid=0.5, thyroarytenoid=0.3, lateral_cricoarytenoid=0.2)
    )
    assert muscles.stretch == pytest.approx(0.2 * (1.5 - 0.3) - 0.04)
    np.testing.assert_allclose(modes(voice(muscles)), modes(voice(plica.Posture(elongation=0.2))), rtol=1e-9)


def test_a_muscle_that_pulls_raises_the_pitch_of_a_larynx_of_the_same_length() -> None:
    rest, tense = modes(voice()), modes(voice(plica.Posture(active_stress={"body": "20 kPa"})))
    assert tense[0] > 1.02 * rest[0]


def test_a_quarter_moves_as_the_whole() -> None:
    posture = plica.Posture(elongation=0.1)
    whole, quarter = (plica.build_simulation(voice(posture, symmetry=part)) for part in (None, "quarter"))
    found = [one.advance(10) for one in (whole, quarter)]
    np.testing.assert_allclose(found[1]["flow"], found[0]["flow"], rtol=1e-7)
    np.testing.assert_allclose(
        quarter.displacement, whole.displacement, rtol=0, atol=1e-6 * np.abs(whole.displacement).max()
    )


def test_small_steps_about_the_posture_are_those_of_the_nonlinear_tissue() -> None:
    """K is the slope of the force there: its answer to a little more elongation is the nonlinear one."""
    scene = voice(plica.Posture(elongation=0.15))
    more = voice(plica.Posture(elongation=0.1505))
    mesh, further = plica.scene_mesh(scene), plica.scene_mesh(more)
    step = np.asarray(further.points) - np.asarray(mesh.points)
    simulation = plica.build_simulation(scene)
    K = csr_array(simulation.stiffness, shape=(step.size, step.size))
    wall = np.zeros(step.shape, dtype=bool)
    wall[np.asarray(mesh.node_sets["wall"])] = True
    held, free = wall.ravel(), ~wall.ravel()
    linear = np.zeros(step.size)
    linear[held] = step.ravel()[held]
    linear[free] = spsolve(K[free][:, free].tocsc(), -(K[free][:, held] @ linear[held]))
    error = np.abs(linear - step.ravel()).max() / np.abs(step).max()
    assert error < 2e-3


@pytest.mark.slow
def test_a_killed_run_goes_on_to_the_bit(tmp_path: Path) -> None:
    scene = voice(plica.Posture(elongation=0.1)).replace({"time.duration": "10 ms"})
    assert_resumes_to_the_bit(scene, tmp_path, 60)


@pytest.mark.parametrize(
    ("posture", "message"),
    [
        ({"elongation": 2}, r"elongation = 2; must be <= 1"),
        ({"elongation": "20 mm"}, r"elongation = .20 mm.; must be a number"),
        ({"elongation": -0.6}, r"elongation = -0.6; must be > -0.5"),
        ({}, "give one"),
        ({"elongation": 0.1, "muscles": {"cricothyroid": 0.2}}, "must be left out: muscles set it"),
        ({"muscles": {"cricothyroid": 1.2}}, r"cricothyroid = 1.2; must be <= 1"),
        ({"muscles": {"cricothyroid": -0.1}}, r"cricothyroid = -0.1; must be >= 0"),
        ({"muscles": {"vocalis": 0.1}}, "vocalis"),
        ({"active_stress": {"body": "1 mm"}}, "active_stress"),
        ({"active_stress": {"body": "-1 kPa"}}, r"active_stress.body = .* must be >= 0"),
        ({"elongation": 0.1, "contraction": 1.5}, r"contraction = 1.5; must be <= 1"),
        ({"stretch": 0.1}, "stretch"),
    ],
)
def test_bad_postures_are_refused(posture: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        voice(posture)


def test_postures_that_a_scene_cannot_have_are_refused() -> None:
    with pytest.raises(SceneError, match=r"posture\.active_stress\.muscle is not a layer"):
        plica.scene_mesh(voice(plica.Posture(active_stress={"muscle": "1 kPa"})))
    slender = plica.Scene(
        plica.Block(size=("1 mm", "16 mm", "1 mm"), divisions=(2, 16, 2)),
        {"body": plica.Tissue(E="10 kPa", nu=0.4)},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        supports=plica.Supports(fixed=("y_min", "y_max")),
        posture=plica.Posture(elongation=-0.2),
    )
    message = r"posture\.elongation = -0\.2: no equilibrium beyond .* % of it: the tissue buckles"
    with pytest.raises(SolveFailed, match=message):
        plica.scene_mesh(slender)
    one_end = slender.replace({"supports.fixed": ["y_min"], "posture.elongation": 0.2})
    with pytest.raises(SceneError, match=r"posture\.elongation = 0\.2: what is held spans 0 % of the length"):
        plica.scene_mesh(one_end)
    with pytest.raises(SceneError, match=r"tissue\.body\.stiffening = 90 .* fibres would bear exp\("):
        plica.scene_mesh(voice(plica.Posture(elongation=0.3)).replace({"tissue.body.stiffening": 90}))
    printed = voice(plica.Posture(elongation=0.1)).replace({"tissue": "thesis"})
    with pytest.raises(SceneError, match=r"tissue\.body\.mu_transverse = .* must be left out"):
        plica.scene_mesh(printed)
    with pytest.raises(SceneError, match=r"stiffening = 1.* without E_fibre.* Use matrix_stiffening\."):
        plica.Tissue(E="1 kPa", nu=0.3, stiffening=1)
    loose = voice(plica.Posture(elongation=0.1)).replace({"supports": {"fixed": []}})
    with pytest.raises(SceneError, match="posture"):
        plica.scene_mesh(loose)
    with pytest.raises(InvalidInput, match="posture is given; must be left out"):
        require_linear(voice(plica.Posture(elongation=0.1)).replace({"symmetry": None}))


@pytest.mark.parametrize(
    ("posture", "given"),
    [
        (
            {"muscles": {"thyroarytenoid": 0.9, "lateral_cricoarytenoid": 0.1}},
            "posture.muscles.thyroarytenoid = 0.9, posture.muscles.lateral_cricoarytenoid = 0.1 "
            "(elongation -0.2)",
        ),
        (
            {"elongation": -0.2, "active_stress": {"body": 10.0}},
            "posture.elongation = -0.2, posture.active_stress.body = 10 Pa",
        ),
        ({"active_stress": {"body": "300 kPa"}}, "posture.active_stress.body = 300000 Pa"),
    ],
)
def test_a_posture_that_fails_is_called_by_what_was_given(posture: dict[str, Any], given: str) -> None:
    slender = plica.Scene(
        plica.Block(size=("1 mm", "16 mm", "1 mm"), divisions=(2, 16, 2)),
        {"body": plica.Tissue(E="10 kPa", nu=0.4)},
        time=plica.Stepping(step="50 us", duration="1 ms"),
        supports=plica.Supports(fixed=("y_min", "y_max") if "elongation" in given else ("y_min",)),
        posture=plica.Posture(**posture),
    )
    with pytest.raises(SolveFailed, match=f"Scene: {re.escape(given)}: no equilibrium beyond"):
        plica.scene_mesh(slender)


def test_a_mesh_at_rest_is_none_of_a_posture() -> None:
    scene = voice(plica.Posture(elongation=0.1))
    with pytest.raises(InvalidInput, match=r"the mesh given is at rest; must be that of the scene"):
        plica.build_simulation(scene, plica.build_mesh(scene.mesh))
    with pytest.raises(InvalidInput, match=r"the mesh given is at a posture; must be that of the scene"):
        plica.build_simulation(voice(), plica.scene_mesh(scene))


def test_what_is_held_does_not_depend_on_the_posture() -> None:
    supports = plica.Supports(fixed=("wall",), wall_from_y="7.3 mm")
    scene = voice(plica.Posture(elongation=0.05), supports=supports)
    fixed = fixed_components(scene, plica.scene_mesh(scene))
    np.testing.assert_array_equal(fixed, fixed_components(scene, plica.build_mesh(scene.mesh)))


@pytest.mark.parametrize(("elongation", "order"), [(-0.15, 1), (0.1, 1), (-0.1, 2)])
def test_the_ends_of_the_airway_are_whole(elongation: float, order: int) -> None:
    still = {"solver": {"method": "conjugate_gradients"}}  # takes no steps, and needs no factor
    scene = voice(plica.Posture(elongation=elongation)).replace({"mesh.order": order, **still})
    mesh = plica.scene_mesh(scene)
    flow = _engine.GlottalFlow(plica.build_simulation(scene, mesh))
    widths = csr_array(flow.width_map(), shape=(len(flow.width_spacing()), len(mesh.points)))
    areas = np.asarray(flow.areas(widths @ np.asarray(mesh.points)[:, 0]))
    assert areas[0] == pytest.approx(areas[1], rel=0.1)
    assert areas[-1] == pytest.approx(areas[-2], rel=0.1)


def test_the_opening_moves_the_nodes_that_it_moves_at_rest() -> None:
    opening = plica.Initial(opening_velocity="0.1 m/s")
    rest, longer = (
        plica.build_simulation(voice(posture, initial=opening)).velocity
        for posture in (None, plica.Posture(elongation=0.2))
    )
    np.testing.assert_array_equal(rest, longer)
    assert np.abs(rest).max() > 0.05


def test_folds_that_are_unlike_stay_partners_in_contact() -> None:
    """Nodes that face each other at rest are partners at the posture, whichever fold is the other one."""
    parts = {"contact": plica.Multipliers(), "initial": plica.Initial(opening_velocity="-1.2 m/s")}
    scene, exchanged = (
        voice(plica.Posture(elongation=0.2), **parts).replace({f"tissue.cover.{side}": {"stiffening": 0.5}})
        for side in ("left", "right")
    )
    simulation, other = plica.build_simulation(scene), plica.build_simulation(exchanged)
    mesh = plica.scene_mesh(scene)
    left, right = (np.unique(mesh.surfaces[f"airway_{side}"]) for side in ("left", "right"))
    x = np.asarray(mesh.points)
    assert np.abs(np.sort(x[left, 2]) - np.sort(x[right, 2])).max() > 1e-7
    found, mirrored = simulation.advance(20), other.advance(20)
    assert found["contact_rows"].max() > 0
    np.testing.assert_allclose(mirrored["flow"], found["flow"], rtol=1e-5)
    np.testing.assert_array_equal(mirrored["contact_rows"], found["contact_rows"])


def test_the_mesh_says_what_became_of_the_glottis() -> None:
    text = mesh_summary(plica.scene_mesh(voice(plica.Posture(elongation=0.2))))
    lengths, widths = r"airway ([\d.]+) mm long, at rest ([\d.]+); ", r"([\d.]+) mm wide, at rest ([\d.]+)"
    found = re.search(f"{lengths}.* {widths}", text)
    assert found is not None
    now, rest, gap, gap_at_rest = map(float, found.groups())
    assert now == pytest.approx(1.2 * rest, rel=0.03)
    assert gap_at_rest == pytest.approx(0.5, abs=0.01)
    assert 0.3 < gap < 0.5
    assert "posture" not in mesh_summary(plica.scene_mesh(voice()))


def test_the_way_to_a_posture_is_by_postures_of_less_elongation() -> None:
    mesh = plica.build_mesh(plica.Larynx(larynx="coarse"))
    points, fixed = np.asarray(mesh.points), fixed_components(voice(), mesh)
    whole = scene_mesh.held_at(plica.Posture(elongation=-0.4), points, fixed)
    half = scene_mesh.held_at(plica.Posture(elongation=-0.2), points, fixed)
    np.testing.assert_allclose(whole(0.5), half(1.0), rtol=0, atol=1e-16)
    assert not whole(0.0).any()
    assert np.abs(whole(0.5) - 0.5 * whole(1.0)).max() > 1e-4  # no straight line


def test_a_posture_at_which_the_folds_cross_is_refused() -> None:
    scene = plica.Scene.of_voice("female").replace(
        {"mesh.larynx": "coarse", "posture": {"muscles": {"cricothyroid": 0.6}}}
    )
    with pytest.raises(
        SceneError, match=r"posture.contraction = 0.5: the folds are -0.1\d* mm apart .* smaller"
    ):
        plica.scene_mesh(scene)


def test_folds_that_cross_near_their_ends_alone_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """By mid-side nodes, and by less than 2 um; planes through nodes find them where even ones do not."""
    look, seen = scene_mesh._require_open, []
    monkeypatch.setattr(scene_mesh, "_require_open", lambda *given: seen.append(given))
    coarse = plica.Scene.of_voice("female").replace({"mesh.larynx": "coarse", "symmetry": None})
    for elongation in (0.12, 0.1):
        plica.scene_mesh(coarse.replace({"posture": {"elongation": elongation}}))
    crossed, apart = seen
    for planes in (2, 40):
        monkeypatch.setattr(scene_mesh, "_PLANES", planes)
        with pytest.raises(
            SceneError, match=r"the folds are -0.001\d* mm apart at y = -?5\.\d* mm .* smaller"
        ):
            look(*crossed)
        look(*apart)
    mesh = apart[-1]
    airway = np.unique(mesh.surfaces["airway"])
    rest, now = (np.asarray(points)[airway, 0] for points in (mesh.rest, mesh.points))
    aside = np.abs(rest) > 1e-9
    assert (np.sign(now[aside]) == np.sign(rest[aside])).all()
