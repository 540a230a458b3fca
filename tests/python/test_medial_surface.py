"""The edges of the medial surface, of contours and larynges where they are known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import plica
from analytic_run import Phonation
from plica.measures.contour import medial_surface
from plica.phonation.measures.folds import place, rest_width
from plica.phonation.measures.measure import measure
from plica.phonation.scene.mesh_parts import Larynx

HEIGHT = 1e-3 * np.linspace(-5.0, 2.0, 1401)


def edges(width: np.ndarray) -> tuple[float, float]:
    found = medial_surface(width, HEIGHT)
    return 1e3 * HEIGHT[found.start], 1e3 * HEIGHT[found.stop - 1]


@pytest.mark.parametrize("preset", ["coarse", "demo", "fine"])
@pytest.mark.parametrize("order", [1, 2])
def test_the_parametric_larynx_has_its_own_edges_on_every_mesh(preset: str, order: int) -> None:
    mesh = plica.build_mesh(Larynx(larynx=preset, order=order))  # S18 and S26 of Table II
    width = rest_width(SimpleNamespace(mesh=mesh, section_height=HEIGHT, waveforms={}))
    assert edges(width) == pytest.approx((-3.1, -0.4), abs=0.011)  # two sections


@pytest.mark.parametrize("angle", [-20, -10, 0, 10, 20])
def test_a_convergent_or_divergent_glottis_has_its_edges(angle: float) -> None:
    z = 1e3 * HEIGHT
    half = 1.0 + np.tan(np.radians(angle)) * np.clip(z + 3, 0, 2.7)
    half += np.tan(np.radians(40)) * np.maximum(-3 - z, 0) + 4 * np.maximum(z + 0.3, 0)
    assert edges(2e-3 * half) == pytest.approx((-3, -0.3), abs=0.011)


def test_rounded_edges_end_where_their_tangent_is_25_degrees_from_vertical() -> None:
    z, radius = 1e3 * HEIGHT, 0.987
    above = np.clip(z, 0, 0.98)
    half = 0.2 + radius - np.sqrt(radius**2 - above**2) + 10 * np.maximum(z - 0.98, 0)
    half += np.tan(np.radians(40)) * np.maximum(-3 - z, 0)
    assert edges(2e-3 * half) == pytest.approx((-3, radius * np.sin(0.436)), abs=0.011)


@pytest.mark.parametrize("lag", [0.6, 1.0, -0.5])
def test_a_travelling_wave_has_its_lag_between_the_edges_and_is_said_to_run_downward(lag: float) -> None:
    run = Phonation(vertical_lag=lag, gap=0.6e-3, impulse=0.0, amplitude_left=2e-4, amplitude_right=2e-4)
    found = measure(run.run())["vertical_phase_difference"]
    assert found.value == pytest.approx(lag, abs=1e-3)
    assert all(f"{side} edge at" in found.note for side in ("inferior", "superior"))
    assert all(height in found.note for height in ("-3 mm", "-0.5 mm"))
    assert any("inferior edge lags" in text for text in found.cautions) == (lag < 0)


@pytest.mark.parametrize(("dip", "said"), [(0.0, False), (0.05, False), (0.3, True)])
def test_pulses_of_two_summits_are_said(dip: float, said: bool) -> None:
    run = Phonation(impulse=0.0).run()
    phase = (200.0 * run.time) % 1.0
    pulse = np.maximum(np.cos(2 * np.pi * phase), 0) * (
        1 - dip * np.exp(-((((phase + 0.5) % 1 - 0.5) / 0.06) ** 2))
    )
    run.waveforms["minimum_area"][:] = 1e-5 * np.maximum(pulse, 0.0)
    cautions = measure(run)["open_quotient"].cautions
    assert any("several summits" in text for text in cautions) == said


def test_a_height_is_told_in_mm_and_by_the_edges_of_the_medial_surface() -> None:
    height = 1e-3 * np.array([-6.0, -3.0, -1.0, -0.5, 0.25])
    medial = slice(1, 4)  # -3 to -0.5 mm
    assert place(2, medial, height) == "at z = -1 mm, on the medial surface"
    assert place(4, medial, height) == "at z = 0.25 mm, 0.75 mm above the superior edge of the medial surface"
    assert place(0, medial, height) == "at z = -6 mm, 3 mm below the inferior edge of the medial surface"
    found = measure(Phonation(impulse=0.0).run())
    for name in ("amplitude_left", "amplitude_right"):
        assert "z = " in found[name].note
        assert "section" not in found[name].note
