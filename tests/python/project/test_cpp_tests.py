"""Tests of the engine compare numbers by their own size."""

from __future__ import annotations

from repository import ROOT


def test_numbers_are_compared_by_approx_of_the_tests() -> None:
    """doctest's own allows epsilon in units as well, so that any two small numbers are equal to it."""
    files = sorted((ROOT / "tests" / "cpp").rglob("*.?pp"))
    assert len(files) > 80
    assert [path.name for path in files if "doctest::Approx" in path.read_text()] == ["approx.hpp"]
