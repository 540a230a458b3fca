"""What the README, and the pages on Python and C++, show is what there is."""

import math
import re
from pathlib import Path
from typing import Any

import pytest

import plica
from plica.commands.main import main
from repository import ROOT

_README, _PYTHON, _EMBEDDING = (
    (ROOT / page).read_text(encoding="utf-8") for page in ("README.md", "docs/python.md", "docs/embedding.md")
)


def _block(page: str, language: str, number: int = 0) -> str:
    return re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)[number]


def test_the_readme_goes_from_one_sentence_to_where_to_go_on_one_screen():
    parts = ["**Plica", "](docs/images/", "```sh", "```python", "| To | Read |"]
    places = [_README.index(part) for part in parts]
    assert places == sorted(places)
    assert len(_README.splitlines()) <= 60


def test_toml_of_the_page_on_python_is_the_first_example():
    first = plica.Scene.load(ROOT / "examples" / "first.toml")
    assert plica.Scene.from_text(_block(_PYTHON, "toml")) == first


def test_cpp_of_the_page_on_embedding_is_the_example_that_the_consumer_builds():
    example = (ROOT / "examples" / "embedding.cpp").read_text(encoding="utf-8")
    assert example.endswith(_block(_EMBEDDING, "cpp"))


def test_python_of_the_readme_runs_and_the_folds_are_blown_open(capsys: pytest.CaptureFixture[str]):
    assert _block(_PYTHON, "python") == _block(_README, "python")
    exec(compile(_block(_README, "python"), "README.md", "exec"), {})
    printed = re.fullmatch(r"peak flow ([0-9.]+) ml/s\n", capsys.readouterr().out)
    assert printed is not None
    at_rest = math.pi * 0.25e-3 * 7e-3 * math.sqrt(2 * 800.0 / 1.23)  # m^3/s: area of S26, Bernoulli's speed
    assert float(printed[1]) > 1.1 * 1e6 * at_rest
    message = re.search(r"Both print the same number, ([0-9.]+) ml/s", _EMBEDDING)
    assert message is not None
    assert float(printed[1]) == pytest.approx(float(message[1]), abs=0.005)  # as many digits as are said


def test_ten_lines_of_python_store_a_run_in_place_of_its_last_two_lines(tmp_path: Path):
    lines = _block(_PYTHON, "python").replace('"10 ms"', '"0.5 ms"').splitlines()[:-2]
    call = re.search(r'`(plica\.run\(scene, )"runs/mine"\)`', _PYTHON)
    assert call is not None
    names: dict[str, Any] = {}
    exec("\n".join([*lines, f"run = {call[1]}{str(tmp_path / 'mine')!r}, progress=False)"]), names)
    run = names["run"]
    assert run["flow"].shape == (10,)
    assert run.to_xarray()["flow"].attrs["units"] == "m^3/s"
    assert "peak_flow" in run.measures
    assert main(["report", str(tmp_path / "mine")]) == 0
    assert (tmp_path / "mine" / "report.html").exists()


@pytest.mark.slow
def test_python_varies_a_scene_and_continues(
    phonating: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    phonating.replace({"time.duration": "12 ms", "output.every": None}).save("scene.toml")
    names: dict[str, Any] = {"plica": plica}
    block = compile(_block(_PYTHON, "python", 1), "python.md", "exec")
    exec(block, names)
    stored = {path: path.read_bytes() for path in tmp_path.rglob("*.*")}
    exec(block, names)
    assert stored == {path: path.read_bytes() for path in tmp_path.rglob("*.*")}
    peaks = [plica.Run.load(f"runs/{pressure}")["flow"].max() for pressure in (600, 800, 1000)]
    assert peaks == sorted(peaks)
    assert len(set(peaks)) == 3
    assert names["late"].time.size == 40
    assert names["late"].measures["steps"].value == 40
    assert names["run"].scene.tissue["cover"].E == 2000.0


@pytest.mark.parametrize("target", sorted(set(re.findall(r"(?<!!)\[[^]]*\]\(([^)#:]+)\)", _README))))
def test_links_of_the_readme_lead_somewhere(target: str):
    assert (ROOT / target).exists()
