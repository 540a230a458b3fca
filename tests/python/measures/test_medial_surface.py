"""The edges of the medial surface, of contours and larynges where they are known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plica
from analytic_run import Phonation
from plica.measures.contour import medial_surface
from plica.measures.run.folds import place, rest_width
from plica.measures.run.measure import measure
from plica.scene.mesh.parts import Larynx

HEIGHT = 1e-3 * np.linspace(-5.0, 2.0, 1401)


def edges(width: np.ndarray) -> tuple[float, float]:
    found = medial_surface(width, HEIGHT)
    return 1e3 * HEIGHT[found.start], 1e3 * HEIGHT[found.stop - 1]


@pytest.mark.parametrize("preset", ["coarse", "demo", "fine"])
@pytest.mark.parametrize("order", [1, 2])
def test_the_parametric_larynx_has_its_own_edges_on_every_mesh(preset: str, order: int) -> None:
    mesh = plica.build_mesh(Larynx(larynx=preset, order=order))  # S18 and S26 of Table II
    assert edges(width_of(mesh)) == pytest.approx((-3.1, -0.4), abs=0.011)  # two sections


def width_of(mesh: Any, scene_text: str = "", height: np.ndarray = HEIGHT) -> np.ndarray:
    run: Any = SimpleNamespace(mesh=mesh, section_height=height, waveforms={}, scene_text=scene_text)
    return rest_width(run)


@pytest.mark.parametrize(
    ("turn", "scale", "move"),
    [
        ((-1, 1, 1), 1.0, (0, 0, 0)),  # a mirror image
        ((-1, -1, 1), 1.0, (0, 0, 0)),  # half a turn
        ((1, 1, 1), 0.25, (0, 0, 0)),
        ((1, -1, 1), 3.0, (0.1, -0.2, 0.3)),
    ],
)
def test_the_medial_surface_goes_with_the_mesh(
    turn: tuple[int, ...], scale: float, move: tuple[float, ...]
) -> None:
    mesh = plica.build_mesh(Larynx(larynx="coarse", order=2))
    faces = np.asarray(mesh.surfaces["airway"])
    if np.prod(turn) < 0:
        faces = faces[:, [0, 2, 1, 5, 4, 3]]  # a mirror image turns faces over
    points = scale * np.asarray(mesh.points) * turn + move
    placed = SimpleNamespace(points=points, surfaces={"lumen": faces})
    height = scale * HEIGHT + move[2]
    width = width_of(placed, '[airflow]\nsurface = "lumen"', height)
    np.testing.assert_allclose(width, scale * width_of(mesh), rtol=0, atol=1e-13)
    found = medial_surface(width, height)
    here = (height[[found.start, found.stop - 1]] - move[2]) / scale
    assert 1e3 * here == pytest.approx((-3.1, -0.4), abs=0.011)


@pytest.mark.parametrize("radius", [0.5, 1.0])
def test_rounded_lips_on_a_mesh_that_is_not_cut_by_nodes_have_their_edges(radius: float) -> None:
    """Folds of constant section along y whose nodes are not in the middle plane, from triangles of 0.1 mm."""
    angle = np.linspace(0, np.pi / 2, 25)
    lip = 1e-3 * radius * np.stack([1 - np.cos(angle), np.sin(angle)], axis=1)  # outward, up
    profile = np.concatenate(
        [[[2e-3, -4e-3]], np.stack([np.zeros(20), np.linspace(-2e-3, 0, 20)], 1)[:-1], lip]
    )
    profile[:, 0] += 0.2e-3  # half of the gap
    y = 1e-3 * np.array([-5.0, -3.2, -1.1, 1.6, 4.0, 5.0])
    k, n = len(profile), len(y)
    points = np.array([[side * x, at, z] for side in (1, -1) for at in y for x, z in profile])
    faces = []
    for side in range(2):
        for j in range(n - 1):
            for i in range(k - 1):
                a, b = side * k * n + j * k + i, side * k * n + (j + 1) * k + i
                for face in ([a, b, b + 1], [a, b + 1, a + 1]):
                    faces.append(face if side else face[::-1])
    normal = np.cross(*(points[np.array(faces)][:, i] - points[np.array(faces)][:, 0] for i in (1, 2)))
    assert ((normal[:, 0] < 0) == (points[np.array(faces)][:, 0, 0] > 0)).all()  # toward the airway
    mesh = SimpleNamespace(points=points, surfaces={"airway": np.array(faces)})
    height = np.linspace(-3.9e-3, 0.9e-3 * radius, 2001)
    found = medial_surface(width_of(mesh, height=height), height)
    edge = 1e-3 * radius * np.sin(0.436)  # 25 degrees from vertical
    assert height[found.start] == pytest.approx(-2e-3, abs=1e-5)
    assert height[found.stop - 1] == pytest.approx(edge, abs=radius * 6e-5)  # an angle of the lip


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
