"""Layers of another thickness: where they end, what moves, and how far the estimate would."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import plica
from layered_block import SIZE, layered_mesh, layered_model, simulated
from plica import _engine
from plica.identify import MarginalLikelihood, MotionModel, TissueParameter, estimate
from plica.identify.estimator.thickness import layers_below, thicker, thickness_shift, thickness_warnings
from plica.scene.mesh.changed import changed_mesh

VISCOSITY = TissueParameter(("cover.viscosity", "ligament.viscosity", "body.viscosity"), name="viscosity")
NAMES: list[Any] = [VISCOSITY, "cover.E", "cover.mu_fibre", "ligament.mu_fibre"]
FRAMES = 30


def volumes(mesh: _engine.TetMesh) -> np.ndarray:
    """(m) m^3, of the straight cells."""
    x = np.asarray(mesh.points)[np.asarray(mesh.cells)[:, :4]]
    return np.linalg.det(x[:, 1:] - x[:, :1]) / 6


def test_layers_end_where_they_were_made() -> None:
    mesh = layered_mesh()
    z = {name: np.asarray(mesh.points)[nodes, 2] for name, nodes in layers_below(mesh, "z_max").items()}
    assert list(z) == ["cover", "ligament"]
    assert np.allclose(z["cover"], 2e-3)
    assert np.allclose(z["ligament"], 1e-3)


def test_layers_side_by_side_have_no_thickness() -> None:
    block = _engine.block_mesh(size=SIZE, divisions=(4, 2, 3))
    x = np.asarray(block.points)[np.asarray(block.cells)].mean(axis=1)[:, 0]
    beside = (x > SIZE[0] / 2).astype(np.int32)
    mesh = changed_mesh(block, cell_layer=beside, layer_names=["left", "right"])
    assert layers_below(mesh, "z_max") == {}


def test_a_thicker_layer_takes_from_the_deepest_tissue() -> None:
    mesh = layered_mesh()
    before, after = np.asarray(mesh.points), np.asarray(thicker(mesh, "z_max", "cover", 1.1).points)
    assert np.allclose(after[:, :2], before[:, :2], rtol=0, atol=1e-12)
    expected = np.interp(before[:, 2], [0, 1e-3, 2e-3, 3e-3], [0, 0.9e-3, 1.9e-3, 3e-3])
    assert np.allclose(after[:, 2], expected, rtol=0, atol=1e-12)
    assert np.allclose(thicker(mesh, "z_max", "ligament", 1.0).points, before, rtol=0, atol=1e-15)


def test_a_larynx_s_layers_grow_by_what_is_asked() -> None:
    mesh = plica.build_mesh(plica.Larynx(larynx="coarse", order=2))
    assert list(layers_below(mesh, "airway")) == ["cover", "ligament"]
    thick = thicker(mesh, "airway", "cover", 1.1)
    before, after = volumes(mesh), volumes(thick)
    assert (after > 0).all()
    share = {
        name: after[layer == k].sum() / before[layer == k].sum()
        for layer in [np.asarray(mesh.cell_layer)]
        for k, name in enumerate(mesh.layer_names)
    }
    # A layer of thickness t about an airway is thicker by 10 %, and of the ligament behind it only the place
    # moves, outward: its volume grows with its circumference, by less.
    assert share["cover"] == pytest.approx(1.1, abs=0.03)
    assert share["ligament"] == pytest.approx(1.0, abs=0.05)
    airway = np.unique(np.asarray(mesh.surfaces["airway"]))
    assert np.array_equal(np.asarray(thick.points)[airway], np.asarray(mesh.points)[airway])


@pytest.mark.slow
def test_the_shift_is_that_of_a_second_estimate() -> None:
    mesh, rng = layered_mesh(), np.random.default_rng(4)

    def model_on(other: _engine.TetMesh) -> MotionModel:
        return layered_model(NAMES, flow, other)

    flow = simulated(layered_model(NAMES, np.ones((FRAMES, 12, 2)), mesh), rng, pressure=20.0, flow=0.02)
    likelihood = MarginalLikelihood(model_on(mesh))
    found = estimate(likelihood)
    thick = thicker(mesh, "z_max", "cover")
    predicted = thickness_shift(found, likelihood, model_on(thick)) / found.sd
    again = estimate(MarginalLikelihood(model_on(thick)))
    moved = (again.mean - found.mean) / found.sd
    assert np.abs(moved).max() > 2
    # Two steps of a problem that is not linear: to a quarter of the largest shift.
    assert np.allclose(predicted, moved, rtol=0, atol=0.25 * np.abs(moved).max())
    assert np.abs(thickness_shift(found, likelihood, model_on(mesh)) / found.sd).max() < 0.1
    message = thickness_warnings(found, likelihood, mesh, "z_max", model_on)
    worst = found.names[int(np.argmax(np.abs(moved)))]
    assert any(f'"{worst}" would be' in text and 'layer "cover"' in text for text in message)


def test_tissue_of_one_layer_has_no_doubt_of_thickness() -> None:
    mesh = _engine.block_mesh(size=SIZE, divisions=(1, 2, 3))
    assert layers_below(mesh, "z_max") == {}


def thickness(mesh: _engine.TetMesh, layer: str) -> float:
    """Mean of a layer, m: its volume over the area of its lower side is that of thin layers alone."""
    lower = layers_below(mesh, "airway")[layer]
    above = list(layers_below(mesh, "airway"))
    upper = above.index(layer)
    points = np.asarray(mesh.points)
    start = (
        np.unique(mesh.surfaces["airway"]) if upper == 0 else layers_below(mesh, "airway")[above[upper - 1]]
    )
    gaps = np.linalg.norm(points[lower][:, None] - points[start][None], axis=2).min(axis=1)
    return float(gaps.mean())


@pytest.mark.parametrize("factor", [0.8, 0.9, 1.1, 1.2])
@pytest.mark.parametrize(
    ("larynx", "order"),
    [
        ("coarse", 1),
        ("coarse", 2),
        ("thesis_coarse", 2),
        pytest.param("demo", 1, marks=pytest.mark.slow),
        pytest.param("demo", 2, marks=pytest.mark.slow),
    ],
)
def test_a_larynx_s_layers_may_be_a_fifth_thicker_or_thinner(larynx: str, order: int, factor: float) -> None:
    mesh = plica.build_mesh(plica.Larynx(larynx=larynx, order=order))
    layers = layers_below(mesh, "airway")
    assert list(layers) == ["cover", "ligament"]
    for layer in layers:
        thick = thicker(mesh, "airway", layer, factor)
        _engine.check_mesh(thick)
        assert _engine.least_jacobian_ratios(np.asarray(thick.points), np.asarray(thick.cells)).min() > 0
        airway = np.unique(mesh.surfaces["airway"])
        assert np.array_equal(np.asarray(thick.points)[airway], np.asarray(mesh.points)[airway])
        # To the nearest nodes above, which lie aslant.
        assert thickness(thick, layer) / thickness(mesh, layer) == pytest.approx(factor, abs=0.05)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("factor", [0.01, 0.6, 1.4, 2.5])
def test_a_layer_that_has_no_room_is_refused_with_factor_and_cell(order: int, factor: float) -> None:
    """Whatever comes back, the engine takes; the largest factors never do."""
    mesh = plica.build_mesh(plica.Larynx(larynx="coarse", order=order))
    for layer in layers_below(mesh, "airway"):
        refusal = ""
        try:
            _engine.check_mesh(thicker(mesh, "airway", layer, factor))
        except plica.InvalidInput as error:
            refusal = str(error)
        if refusal or factor >= 2.5:
            assert f'thicker: factor = {factor:g} of the layer "{layer}"' in refusal
            assert re.search(r"cell \d+", refusal)


def test_a_layer_without_room_is_a_warning_of_the_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    """The estimate is there by then: that one of its doubts cannot be computed must not lose it."""

    def no_room(*_: Any) -> Any:
        raise plica.InvalidInput("thicker: factor = 1.1; must be nearer 1: cell 7.")

    monkeypatch.setattr("plica.identify.estimator.thickness.thicker", no_room)
    none: Any = None
    found = thickness_warnings(none, none, layered_mesh(), "z_max", none)
    assert len(found) == 2
    assert 'layer "cover" is not known: thicker: factor = 1.1' in found[0]
