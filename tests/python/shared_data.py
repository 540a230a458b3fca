"""Test data that are no part of the sources: ../shared/data beside the checkout, under their own licences."""

from __future__ import annotations

from pathlib import Path

import pytest

__all__ = ["shared_data"]

_DATA = Path(__file__).resolve().parents[3] / "shared" / "data"


def shared_data(name: str) -> Path:
    """A file or folder of the test data; skips the test where it is not there."""
    path = _DATA / name
    if not path.exists():
        pytest.skip(f"{name} is not among the test data: {_DATA}")
    return path
