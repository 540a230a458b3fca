"""Contact on quadratic faces against Hertz, by benchmarks/contact/hertz.py on coarse meshes."""

from __future__ import annotations

import pytest

from benchmarks.contact import hertz


def test_a_cylinder_of_mortar_faces_presses_as_hertz_says() -> None:
    for pair in ("plane", "alike"):
        found = hertz.solve(hertz.Case("cylinder", pair, 2, 4, "mortar", width=0.025))
        # Measured -1.5 % and +2.1 % on the plane; finer meshes come to -0.8 % and +0.9 %.
        assert abs(found["radius"]) < 0.03
        assert abs(found["peak"]) < 0.03


def test_four_flat_triangles_a_face_miss_the_pressure_by_a_third() -> None:
    found = hertz.solve(hertz.Case("cylinder", "plane", 2, 4, "nodes", width=0.025))
    assert found["peak"] == pytest.approx(1 / 3, abs=0.05)
    assert found["inner pressure"] == pytest.approx(1, abs=0.02)  # zero at a corner


def test_the_force_is_right_where_what_touches_is_narrower_than_a_face() -> None:
    """There the mean gap of a face says nothing: nodes inside hold by themselves."""
    fine, coarse, nodes = (
        hertz.solve(hertz.Case("cylinder", "plane", 2, edges, faces))
        for edges, faces in ((4, "mortar"), (0.25, "mortar"), (0.25, "nodes"))
    )
    assert coarse["ratio"] == pytest.approx(fine["ratio"], rel=0.05)
    assert coarse["ratio"] == pytest.approx(nodes["ratio"], rel=1e-3)
