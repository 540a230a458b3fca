"""What an import brings: whoever steps a scene pays for no picture, no estimate and no plot."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import plica
from benchmarks.dynamics.parts import UNNEEDED, imported
from plica.scene import parts
from plica.scene.part import OneOf
from repository import ROOT


@pytest.mark.parametrize("module", UNNEEDED)
def test_an_import_brings_nothing_that_it_does_not_need(module: str) -> None:
    found = imported(module)
    assert module in found
    assert [name for name in found if name in UNNEEDED[module]] == []


def test_scenes_step_without_scipy_which_a_basis_is_made_with(tmp_path: Path) -> None:
    code = """
import sys, numpy, plica
scene = plica.Scene.model_validate({
    "mesh": {"block": {"size": [1e-2, 1e-2, 1e-2], "divisions": [2, 2, 2]}},
    "tissue": {"body": {"E": 1e4, "nu": 0.3}}, "supports": {"fixed": ["x_min"]}, "gravity": [0, 0, -9.81],
    "time": {"step": 1e-4, "duration": 1e-3}})
plica.build_simulation(scene).advance(10)
plica.build_simulation(scene, basis=numpy.random.default_rng(0).standard_normal((81, 4))).advance(10)
before = "scipy" in sys.modules
plica.reduce(scene, sys.argv[1], modes=4)
print(before, "scipy" in sys.modules)
"""
    made = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "basis.h5")], check=True, capture_output=True, text=True
    )
    assert made.stdout.split() == ["False", "True"]


def test_public_names_are_there_and_typed() -> None:
    stub = ast.parse((ROOT / "python/plica/__init__.pyi").read_text(encoding="utf-8"))
    typed = {
        part.asname: node.module
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for part in node.names
    }
    assert {*typed, "__version__"} == {*plica.__all__}
    for name, module in typed.items():
        found = getattr(plica, name)
        assert found is (
            sys.modules[f"plica.{name}"] if module == "plica" else getattr(sys.modules[str(module)], name)
        )
    with pytest.raises(AttributeError, match="no attribute 'foo'"):
        plica.foo  # noqa: B018


def test_what_a_part_of_a_scene_may_be_has_a_public_name() -> None:
    assert {*parts.__all__} <= {*plica.__all__}
    choices = [one for name in parts.__all__ if issubclass(one := getattr(parts, name), OneOf)]
    assert len(choices) > 5
    for choice in choices:
        assert {kind.__name__ for kind in choice.kinds.values()} <= {*parts.__all__}, choice


def test_the_root_loads_its_parts_when_they_are_asked_for() -> None:
    found = imported("plica")
    assert [name for name in found if name.startswith(("plica.scene", "pydantic", "numpy"))] == []
