"""Tissues by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import plica
from plica.scene.tissue_presets import TISSUE_PRESETS
from repository import EXAMPLES

_LAYERS = ("body", "ligament", "cover")


def _scene(tissue: Any) -> plica.Scene:
    return plica.Scene(
        plica.Larynx(larynx="thesis_coarse"), tissue, time=plica.Stepping(step="50 us", duration="1 ms")
    )


@pytest.mark.parametrize(
    ("name", "example"), [("thesis_corrected", "normal_phonation"), ("thesis", "thesis")]
)
def test_a_preset_is_the_tissue_that_the_example_writes_out(name: str, example: str) -> None:
    written = plica.Scene.load(EXAMPLES / f"{example}.toml").tissue
    preset = _scene(name).tissue
    assert set(preset) == set(written)
    for layer in _LAYERS:
        ours, theirs = (tissue.model_dump(exclude_none=True) for tissue in (preset[layer], written[layer]))
        assert set(ours) == set(theirs)
        for field, value in theirs.items():
            assert ours[field] == pytest.approx(value, rel=1e-12), (layer, field)


def test_a_layer_takes_a_preset_by_name_or_with_values_of_its_own() -> None:
    soft = {"preset": "thesis_corrected", "E_fibre": "5 kPa", "right": {"viscosity": 1}}
    scene = _scene({"body": "thesis_corrected", "ligament": "thesis", "cover": soft})
    normal = plica.TISSUE_PRESETS["thesis_corrected"]
    assert scene.tissue["body"] == normal["body"]
    assert scene.tissue["ligament"] == plica.TISSUE_PRESETS["thesis"]["ligament"]
    assert scene.tissue["cover"].E_fibre == 5000
    assert scene.tissue["cover"].E == normal["cover"].E
    assert scene.tissue["cover"].on("right").viscosity == 1
    assert plica.Scene.from_text(scene.text()) == scene


def test_a_preset_changed_on_one_side_is_stored_as_it_is() -> None:
    scene = _scene("thesis_corrected").replace({"tissue.cover.left": {"matrix_stiffening": 4.0}})
    stored = plica.Scene.from_text(scene.text())
    assert stored == scene
    assert stored.tissue["cover"].on("left").matrix_stiffening == 4
    assert stored.tissue["cover"].on("right") == plica.TISSUE_PRESETS["thesis_corrected"]["cover"]


@pytest.mark.parametrize(
    ("tissue", "message"),
    [
        ("norml", 'tissue = "norml"; must be one of thesis_corrected, thesis'),
        (
            {"body": "norml", "ligament": "thesis_corrected", "cover": "thesis_corrected"},
            'tissue.body = "norml"; must be one of',
        ),
        ({"skin": "thesis_corrected"}, 'the preset "thesis_corrected" has body, ligament, cover only'),
        ({"body": {"preset": 3}}, "tissue.body.preset = 3; must be one of"),
    ],
)
def test_a_preset_that_does_not_exist_is_refused(tissue: Any, message: str) -> None:
    with pytest.raises(plica.SceneError) as caught:
        _scene(tissue)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("own", "where"),
    [
        ({"E": "2 kPa"}, "tissue.cover.mu_transverse"),
        ({"nu": 0.5}, "tissue.cover.mu_transverse"),
        ({"left": {"E": "2 kPa"}}, "tissue.cover.left.mu_transverse"),
        ({"right": plica.TissueSide(E="2 kPa")}, "tissue.cover.right.mu_transverse"),
    ],
)
def test_another_stiffness_across_the_fibre_needs_its_shear_modulus(own: dict[str, Any], where: str) -> None:
    with pytest.raises(plica.SceneError, match=f"{where}: must be given with E or nu"):
        _scene({"body": "thesis", "ligament": "thesis", "cover": {"preset": "thesis"} | own})
    normal = {
        "body": "thesis_corrected",
        "ligament": "thesis_corrected",
        "cover": {"preset": "thesis_corrected"} | own,
    }
    assert _scene(normal).tissue["cover"].mu_transverse is None  # follows E and nu


def test_a_shear_modulus_that_is_given_is_taken() -> None:
    own = {"preset": "thesis", "E": "2 kPa", "mu_transverse": "1.2 kPa", "left": {"viscosity": 1}}
    tissue = _scene({"body": "thesis", "ligament": "thesis", "cover": own}).tissue["cover"]
    assert tissue.on("left").mu_transverse == tissue.on("right").mu_transverse == 1200


@pytest.mark.slow
def test_the_first_example_is_short_and_its_folds_close() -> None:
    text = (EXAMPLES / "first.toml").read_text(encoding="utf-8")
    assert len([line for line in text.splitlines() if line.strip() and line[0] != "#"]) <= 10
    found = plica.build_simulation(plica.Scene.from_text(text)).advance(400)
    touching = np.asarray(found["contact_rows"]) > 0
    assert touching.any()
    assert not touching[0]
    # They touch first where they meet first; the rest of the glottis is all but closed then.
    for name in ("minimum_area", "flow"):
        wave = np.asarray(found[name])
        assert wave[touching].min() < 0.05 * wave.max()


def test_numbers_of_the_corrected_tissue_are_as_they_are_written() -> None:
    for tissue in TISSUE_PRESETS["thesis_corrected"].values():
        for name, value in tissue.model_dump(exclude_none=True).items():
            if isinstance(value, float):
                assert len(repr(value)) <= 8, name  # 0.14, not 0.35 * 0.4 = 0.13999999999999999
