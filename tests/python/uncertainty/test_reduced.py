"""The uncertainty of a run in few coordinates: whose basis each level moves in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from plica.commands.main import main


@pytest.fixture
def reduced(bar: plica.Scene, tmp_path: Path) -> Path:
    """Of a bar's run in five modes."""
    plica.reduce(bar, tmp_path / "basis.h5", modes=5)
    scene = bar.replace({"reduction": {"basis": str(tmp_path / "basis.h5")}})
    return plica.run(scene, tmp_path / "reduced", progress=False).directory


def test_levels_of_a_reduced_run_are_by_step_in_its_own_basis(reduced: Path) -> None:
    (reduced.parent / "basis.h5").unlink()
    found = plica.estimate_uncertainty(reduced, progress=False)
    assert [level["name"] for level in found.levels] == ["step-2", "step-4"]
    own = _stored_basis(reduced)
    assert own.shape[1] == 5
    for name in ("step-2", "step-4"):
        np.testing.assert_array_equal(_stored_basis(reduced / "uncertainty" / name), own)
    assert any("a basis is of one mesh" in remark for remark in found.remarks)


def test_a_reduced_run_without_its_basis_is_refused_before_anything_is_computed(reduced: Path) -> None:
    (reduced / "basis.h5").unlink()
    with pytest.raises(plica.InvalidInput, match=r"basis\.h5: is missing"):
        plica.estimate_uncertainty(reduced, progress=False)
    assert not list((reduced / "uncertainty").glob("*/results.h5"))


def _stored_basis(directory: Path) -> Any:
    with h5py.File(directory / "basis.h5", "r") as file:
        return file["basis"][()]


def test_that_the_error_of_a_basis_is_not_seen_is_reported(
    bar: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    message = "the error of the reduced basis is not included"
    plica.run(bar, tmp_path / "full", progress=False)
    full = plica.estimate_uncertainty(tmp_path / "full", mesh="none", progress=False)
    assert not any(message in remark for remark in full.remarks)
    plica.reduce(bar, tmp_path / "basis.h5", modes=10)
    scene = bar.replace({"reduction": {"basis": str(tmp_path / "basis.h5")}})
    plica.run(scene, tmp_path / "run", progress=False)
    assert main(["uncertainty", str(tmp_path / "run"), "--mesh", "none"]) == 0
    assert message in capsys.readouterr().out
    assert message in (tmp_path / "run" / "uncertainty.json").read_text()
    assert message[1:] in (tmp_path / "run" / "report.html").read_text().replace("&#39;", "'")
