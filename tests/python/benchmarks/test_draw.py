"""`python -m benchmarks.extremes.draw`: random voices, and how each ends."""

from __future__ import annotations

import pytest

import plica
from benchmarks.extremes.draw import COLUMNS, PRESSURE, SOFTER, VISCOSITY, drawn, outcome, scene_of, summary
from caution_scenes import LARYNX
from plica.scene.tissue_presets import TISSUE_PRESETS


def test_more_scenes_of_a_seed_begin_with_the_same_ones_and_lie_in_their_ranges() -> None:
    many = drawn(1, 200)
    assert many[:3] == drawn(1, 3)
    assert many[0] != drawn(2, 1)[0]
    for voice in many:
        for layer, (low, high) in SOFTER.items():
            assert low <= getattr(voice, layer) <= high
        assert VISCOSITY[0] <= voice.viscosity <= VISCOSITY[1]
        assert PRESSURE[0] <= voice.pressure <= PRESSURE[1]
    below = sum(voice.body < (0.1 * 1.5) ** 0.5 for voice in many)
    assert 70 < below < 130  # log-uniform: half of them, and three standard deviations of 7


def test_a_scene_has_the_factors_of_its_draw_and_nothing_else_is_changed() -> None:
    voice = drawn(1, 1)[0]
    scene = scene_of(voice)
    for layer in SOFTER:
        tissue, preset = scene.tissue[layer], TISSUE_PRESETS["thesis_corrected"][layer]
        for name in ("E", "E_fibre", "mu_fibre"):
            assert getattr(tissue, name) == pytest.approx(getattr(voice, layer) * getattr(preset, name))
        assert tissue.viscosity == pytest.approx(voice.viscosity * preset.viscosity)
        assert (tissue.nu, tissue.density) == (preset.nu, preset.density)
    assert scene.symmetry == "quarter"
    assert scene.airflow is not None
    assert scene.airflow.subglottal_pressure == voice.pressure
    assert scene_of(voice, None).symmetry is None


def test_a_voice_that_fails_is_told_from_one_that_ends() -> None:
    scene = plica.Scene.from_text(LARYNX, "larynx").replace(
        {"symmetry": "quarter", "initial.opening_velocity": -2.5, "contact.max_passes": 1}
    )
    ended = outcome(scene)
    assert (ended["ended"], ended["f0"], ended["at"]) == ("silent", None, pytest.approx(10.0))
    assert 0 < ended["facing"] <= ended["touching"]
    assert "facing_contact" in ended["said"]
    failed = outcome(scene.replace({"contact.friction": 0.3}))
    assert failed["ended"] == "failed"
    assert failed["at"] < 10.0
    assert "after 1 passes" in failed["said"]


def test_the_summary_counts_how_scenes_ended() -> None:
    row: list[object] = [0] * len(COLUMNS)
    made = []
    for end, folded, facing in (("voiced", 3, 0), ("voiced", 0, 0), ("failed", 4, 2)):
        row[COLUMNS.index("ended")] = end
        row[COLUMNS.index("cells folded at most")] = folded
        row[COLUMNS.index("of these by facing nodes")] = facing
        made.append(list(row))
    assert summary(made).startswith("Of 3 scenes 2 voiced, 1 failed; in 2 cells folded, in 1 nodes were held")
