"""What the README shows is what there is."""

import math
import re
from pathlib import Path

import pytest

_ROOT = Path(__file__).parents[2]
_README = (_ROOT / "README.md").read_text(encoding="utf-8")


def _block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", _README, re.DOTALL)
    assert found is not None
    return found[1]


def test_cpp_of_the_readme_is_the_example_that_the_consumer_builds():
    example = (_ROOT / "examples" / "embedding.cpp").read_text(encoding="utf-8")
    assert example.endswith(_block("cpp"))


def test_python_of_the_readme_runs_and_the_folds_are_blown_open(capsys: pytest.CaptureFixture[str]):
    exec(compile(_block("python"), "README.md", "exec"), {})
    printed = re.fullmatch(r"peak flow ([0-9.]+) ml/s\n", capsys.readouterr().out)
    assert printed is not None
    at_rest = math.pi * 0.25e-3 * 7e-3 * math.sqrt(2 * 800.0 / 1.23)  # m^3/s: area of S26, Bernoulli's speed
    assert float(printed[1]) > 1.1 * 1e6 * at_rest


@pytest.mark.parametrize("target", sorted(set(re.findall(r"(?<!!)\[[^]]*\]\(([^)#:]+)\)", _README))))
def test_links_of_the_readme_lead_somewhere(target: str):
    assert (_ROOT / target).exists()
