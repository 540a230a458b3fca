"""Folds of given sizes have these sizes in the mesh that is built of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import plica
from plica.measures.contour import rest_contour
from plica.scene.mesh.build import build_mesh

MM = 1e-3


def contour_of(**sizes: Any) -> tuple[Any, np.ndarray]:
    """The mesh, and height and half-width of the airway in its middle plane at the mesh's lines, (n, 2) m."""
    mesh = build_mesh(plica.Larynx(larynx="demo", folds=plica.Folds(**sizes)))
    points, faces = np.asarray(mesh.points), np.asarray(mesh.surfaces["airway"])
    height, left, right = rest_contour(points, faces).T
    np.testing.assert_allclose(left, -right, atol=1e-15)
    return mesh, np.column_stack((height, right))


@pytest.mark.parametrize("degrees", [0.0, 4.0, -4.0])
def test_the_glottis_is_as_wide_long_and_inclined_as_given(degrees: float) -> None:
    sizes = {"length": 16 * MM, "thickness": 3 * MM, "gap": 0.4 * MM, "depth": 9 * MM}
    mesh, contour = contour_of(**sizes, medial_angle=f"{degrees} deg")
    assert contour[:, 1].min() == pytest.approx(0.2 * MM, rel=1e-9)
    airway = np.unique(np.asarray(mesh.surfaces["airway"]))
    assert np.ptp(np.asarray(mesh.points)[airway, 1]) == pytest.approx(16 * MM, rel=1e-9)
    assert np.asarray(mesh.points)[:, 0].max() == pytest.approx(9.2 * MM, rel=1e-9)
    medial = contour[(contour[:, 0] > -3 * MM - 1e-9) & (contour[:, 0] < 1e-9)]
    assert medial[[0, -1], 0] == pytest.approx([-3 * MM, 0.0], abs=1e-9)
    slope = -np.tan(np.radians(degrees))
    narrow = 0.0 if degrees >= 0 else -3 * MM
    np.testing.assert_allclose(medial[:, 1], 0.2 * MM + slope * (medial[:, 0] - narrow), atol=1e-9)


@pytest.mark.parametrize("degrees", [0.0, 6.0])
def test_edges_are_round_and_leave_the_medial_surface_smoothly(degrees: float) -> None:
    radius, angle = 0.8 * MM, np.radians(degrees)
    folds = plica.Folds(
        edge_radius=radius, medial_angle=angle, inferior_angle=np.radians(40), thickness=2 * MM, gap=0.5 * MM
    )
    shape = folds.shape()
    sections = np.array(shape["sections"])
    edges = sections[shape["layers_from_section"] : shape["layers_to_section"] + 1]
    for edge, start in ((edges[:3], 2), (edges[3:], 0)):
        centre = edge[start] + radius * np.array([np.sin(angle), np.cos(angle)])  # across the medial surface
        np.testing.assert_allclose(np.hypot(*(edge - centre).T), radius, rtol=1e-9)
    lowest = edges[0] - sections[shape["layers_from_section"] - 1]
    assert np.degrees(np.arctan2(-lowest[1], lowest[0])) == pytest.approx(40)


def test_layers_have_the_volume_of_their_thickness() -> None:
    """A layer of level thickness t behind a medial surface of area A has some t A; of twice t, twice that."""
    thin, _ = contour_of(cover=0.5 * MM, ligament=0.5 * MM, edge_radius=0)
    thick, _ = contour_of(cover=0.5 * MM, ligament=1.0 * MM, edge_radius=0)
    volume = []
    for mesh in (thin, thick):
        points, cells, layer = (np.asarray(x) for x in (mesh.points, mesh.cells, mesh.cell_layer))
        each = np.linalg.det(points[cells[:, 1:4]] - points[cells[:, :1]]) / 6
        volume.append({name: each[layer == k].sum() for k, name in enumerate(mesh.layer_names)})
    assert volume[0]["cover"] == pytest.approx(volume[1]["cover"], rel=0.02)
    assert volume[1]["ligament"] / volume[0]["ligament"] == pytest.approx(2, rel=0.1)
    flat = 2 * 2.7 * 14 * 0.5 * MM**3
    assert volume[0]["cover"] == pytest.approx(flat, rel=0.1)


def test_a_stored_scene_keeps_the_sizes_and_changes_by_them() -> None:
    scene = plica.Scene(
        plica.Larynx(larynx="coarse", order=2, folds=plica.Folds(length="12 mm")),
        "thesis_corrected",
        time=plica.Stepping(step="50 us", duration="1 ms"),
    )
    assert plica.Scene.from_text(scene.text()) == scene
    longer = scene.replace({"mesh.folds.length": "13 mm"})
    mesh = plica.scene_mesh(longer)
    airway = np.unique(np.asarray(mesh.surfaces["airway"]))
    assert np.ptp(np.asarray(mesh.points)[airway, 1]) == pytest.approx(13 * MM)
    finer = scene.replace({"mesh.larynx": "demo"})
    assert finer.mesh.folds == scene.mesh.folds
    assert finer.mesh.all_options()["around"] > scene.mesh.all_options()["around"]


@pytest.mark.parametrize("stored", [False, True])
def test_more_is_cut_from_the_tips_of_folds_unless_another_share_is_given(stored: bool) -> None:
    def larynx(**parts: Any) -> plica.Larynx:
        scene = plica.Scene(
            plica.Larynx(larynx="coarse", **parts),
            "thesis_corrected",
            time=plica.Stepping(step="50 us", duration="1 ms"),
        )
        mesh = (plica.Scene.from_text(scene.text()) if stored else scene).mesh
        assert isinstance(mesh, plica.Larynx)
        return mesh

    def cut(mesh: plica.Larynx, **changes: Any) -> float:
        return float(mesh.replace(changes).all_options()["tip_cut"])

    plain, folded = larynx(), larynx(folds=plica.Folds())
    assert cut(plain) == cut(folded, folds=None) == 0.1
    assert cut(folded) == cut(plain, folds=plica.Folds()) == 1
    assert cut(folded, larynx="demo") == cut(folded, folds={"length": "13 mm"}) == 1
    assert cut(folded, larynx="demo", folds=None) == cut(plain, larynx="demo") == 0.1
    for own in (0.1, 0.3):
        mesh = larynx(folds=plica.Folds(), options=plica.LarynxOptions(tip_cut=own))
        assert cut(mesh) == cut(mesh, larynx="demo") == cut(mesh, folds=None) == own


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (
            {"folds": {"length": "20 mm"}},
            "mesh.folds.depth = 0.00775 m; must be >= 10.05 mm, so that",
        ),
        ({"folds": {"length": 16}}, "mesh.folds.length = 16 m; must be <= 0.03 m"),
        ({"folds": {"medial_angle": 3}}, "mesh.folds.medial_angle = 3 rad; must be <= 0.35 rad"),
        ({"folds": {"medial_angle": "30 deg"}}, 'mesh.folds.medial_angle = "30 deg"; must be <= 20.05 deg'),
        ({"folds": {"length": "40mm"}}, 'mesh.folds.length = "40mm"; must be <= 30 mm'),
        (
            {"folds": {"depth": "20 mm", "inferior_angle": "20.5 deg"}},
            "mesh.folds.inferior_angle = 20.5 deg; must be larger: the inferior surface",
        ),
        ({"folds": {"gap": 0}}, "mesh.folds.gap = 0 m; must be > 0"),
        ({"folds": {"thicknes": 1e-3}}, 'mesh.folds.thicknes is not known. Did you mean "thickness"?'),
        (
            {"folds": {}, "options": {"major": 7e-3}},
            "mesh.options.major = 0.007; must be left out: mesh",
        ),
        ({"folds": {}, "larynx": "thesis"}, 'mesh.folds: must be left out: the larynx "thesis" is meshed in'),
    ],
)
def test_sizes_that_no_larynx_has_are_refused(mesh: dict[str, Any], message: str) -> None:
    with pytest.raises(plica.SceneError) as error:
        plica.Scene(
            {"larynx": "coarse", **mesh},
            "thesis_corrected",
            time=plica.Stepping(step="50 us", duration="1 ms"),
        )
    assert message in str(error.value)
