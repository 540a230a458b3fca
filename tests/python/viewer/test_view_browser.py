"""The page of a run in a browser that draws on the processor: what its pixels show is what the run has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import plica
from analytic_run import Phonation
from browser import CHROMIUM, Browser
from filmed_folds import moved, shifted, voiced
from plica.films.surface import skin
from repository import ROOT
from view_pictures import draw

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium: apt install chromium; nothing else runs the page's JavaScript"
    ),
]

RIGHT, LEFT, SPACE = ("ArrowRight", 39), ("ArrowLeft", 37), (" ", 32)
Pixels = NDArray[np.uint8]


def opened(page: Path, folder: Path, *, webgl: bool = True) -> Browser:
    browser = Browser(page, folder, webgl=webgl)
    browser.tell("Runtime.evaluate", expression="ready", awaitPromise=True)
    return browser


def as_run(given: Any) -> Any:
    """What was moved, as a run without waveforms."""
    run = Phonation(impulse=0.0).run()
    return replace(run, mesh=given.mesh, fields=given.fields, waveforms={}, section_height=np.empty(0))


@pytest.fixture(scope="module")
def voice(phonating: plica.Scene, tmp_path_factory: pytest.TempPathFactory) -> plica.Run:
    scene = phonating.replace({"output": plica.Output(every="0.25 ms")})
    return plica.run(scene, tmp_path_factory.mktemp("voice") / "run", progress=False)


@pytest.fixture
def browser(voice: plica.Run, tmp_path: Path) -> Iterator[Browser]:
    with opened(plica.write_view(voice, tmp_path / "view.html"), tmp_path / "browser") as found:
        yield found
        assert found.faults() == []
        assert found.value("performance.getEntriesByType('resource').length") == 0


def drawn(browser: Browser, *, named: bool = False) -> Pixels:
    """The surface, without the names of directions unless they are asked for."""
    if not named:
        browser.value("document.querySelectorAll('#stage span, #bar').forEach(one => one.style.opacity = 0)")
    return browser.picture("#stage")


def differing(first: Pixels, second: Pixels) -> int:
    """Pixels that differ by more than what the next phase of nothing does, none."""
    return int((first != second).any(axis=-1).sum())


def phase(browser: Browser) -> int:
    return int(browser.value("phase"))


def look(browser: Browser, name: str, *, cuts: bool = False) -> None:
    """From a side, without the cuts of the beginning unless they are kept."""
    browser.click(f"#from-{name}")
    if not cuts and browser.value("by('cut-z').checked"):
        browser.click("#cut-z")


def pixels_of_mm(browser: Browser) -> float:
    """By the bar that the page shows."""
    width, text = browser.value("[by('bar').getBoundingClientRect().width, by('bar').textContent]")
    assert text.endswith(" mm")
    return float(width) / float(text.removesuffix(" mm"))


def test_slider_keys_and_curves_go_to_the_same_phases(browser: Browser) -> None:
    look(browser, "above", cuts=True)
    first = drawn(browser)
    assert phase(browser) == 0
    assert browser.value("by('label').textContent") == "0.00 ms"
    left, top, width, height = browser.box("#phase")
    browser.drag((left + 8, top + height / 2), (left + width - 8, top + height / 2))
    assert phase(browser) == 8
    last = drawn(browser)
    assert differing(first, last) > 1000  # the glottis has opened
    assert browser.value("by('label').textContent") == "2.00 ms"
    browser.value("by('phase').blur()")
    browser.key(*LEFT)
    assert phase(browser) == 7
    assert differing(last, drawn(browser)) > 100
    browser.key(*RIGHT)
    assert differing(last, drawn(browser)) == 0
    # The curve at its other end, and in its middle.
    left, top, width, height = browser.box(".curve .u-over")
    browser.drag((left + 1, top + height / 2))
    assert phase(browser) == 0
    assert browser.value("by('phase').value") == "0"
    assert differing(first, drawn(browser)) == 0
    left, top, width, height = browser.box(".curve .u-over")  # the window has scrolled
    browser.drag((left + 1, top + height / 2), (left + 0.52 * width, top + height / 2))
    assert phase(browser) == 4


def test_the_line_of_the_curves_stands_at_the_phase_and_the_values_are_the_run_s(
    browser: Browser, voice: plica.Run
) -> None:
    red = np.array([0xD2, 0x60, 0x3A])
    said = "document.querySelector('.curve p').textContent"
    assert browser.value(said) == "glottal area: –"  # a step has one, the beginning has none
    for k in (2, 6):
        browser.value(f"show({k})")
        width = browser.box(".curve .u-over")[2]
        picture = browser.picture(".curve .u-over")
        columns = np.flatnonzero((np.abs(picture.astype(int) - red) < 40).all(axis=-1).mean(axis=0) > 0.9)
        assert columns.mean() + 0.5 == pytest.approx(width * k / 8, abs=2)
        step = int(np.argmin(np.abs(voice.time - voice.fields["time"][k])))
        name, value, unit = browser.value(said).rsplit(" ", 2)
        assert (name, unit) == ("glottal area:", "mm²")
        assert float(value) == pytest.approx(1e6 * voice["minimum_area"][step], rel=5e-3)


def test_it_plays_until_it_is_stopped(browser: Browser) -> None:
    browser.key(*SPACE)
    browser._until(lambda: phase(browser) == 3, "the phases run")
    browser._until(lambda: phase(browser) == 1, "they begin again")
    browser.click("#play")
    rested = phase(browser)
    assert browser.value("by('play').textContent") == "Play"
    browser.tell("Runtime.evaluate", expression="new Promise(f => setTimeout(f, 600))", awaitPromise=True)
    assert phase(browser) == rested


def test_what_is_drawn_is_where_the_run_has_it(browser: Browser, voice: plica.Run) -> None:
    points = np.asarray(voice.mesh.points)
    nodes = np.unique(skin(points, np.asarray(voice.mesh.cells)))
    level = browser.value("page.level")
    for k in (0, 3, 8):
        browser.value(f"show({k})")
        found = np.reshape(browser.value("[...larynx.geometry.attributes.position.array]"), (-1, 3))
        wanted = 1e3 * (points + np.asarray(voice.displacement[k]))[nodes]
        assert np.abs(found - wanted).max() < 0.5 * level + 2e-6  # mm: float32


def test_the_glottis_from_above_has_the_area_that_a_film_has(tmp_path: Path) -> None:
    """A second algorithm: the film's exact outline of the folds, along the same line of sight."""
    given = moved(voiced(amplitude=0.6e-3), np.arange(6) * 1e-3)
    camera = plica.Camera(mm_per_px=0.04, width=400, height=400, centre=(0.0, 0.0, 0.0))
    clip = plica.film(given, camera)
    areas = [clip.area(k) for k in range(6)]
    assert max(areas) > 8e-6
    with opened(plica.write_view(as_run(given), tmp_path / "view.html"), tmp_path / "browser") as browser:
        look(browser, "above")
        browser.tell(
            "Emulation.setDeviceMetricsOverride", width=1300, height=900, deviceScaleFactor=3, mobile=False
        )
        browser.value("larynx.front.color.set(0)")
        for k in (int(np.argmax(areas)), 3):
            browser.value(f"show({k})")
            picture = drawn(browser)
            scale = pixels_of_mm(browser) * picture.shape[1] / browser.box("#stage")[2]
            middle = [size // 2 for size in picture.shape[:2]]
            tall, wide = round(7.5 * scale), round(1.5 * scale)  # around the glottis, within the wall
            seen = picture[middle[0] - tall : middle[0] + tall, middle[1] - wide : middle[1] + wide, 0]
            inner = float((seen / picture[9, 9, 0]).sum())  # tissue is black, edges are in between
            assert inner / scale**2 == pytest.approx(1e6 * areas[k], rel=0.02)


def test_a_cut_shows_the_section_of_a_bar_in_one_colour(bar: plica.Scene, tmp_path: Path) -> None:
    run = plica.run(bar, tmp_path / "run", progress=False)
    with opened(plica.write_view(run, tmp_path / "view.html"), tmp_path / "browser") as browser:
        inside = np.array([0x9A, 0x5A, 0x50])

        def cut_area() -> float:
            picture = drawn(browser).astype(int)
            return float((np.abs(picture - inside) < 3).all(axis=-1).sum()) / pixels_of_mm(browser) ** 2

        look(browser, "right")
        assert cut_area() == 0
        browser.click("#cut-x")
        assert cut_area() == pytest.approx(2 * 2, rel=0.04)  # mm^2; a pixel is 1 % of a side
        whole = drawn(browser)
        browser.click("#flip-x")  # what is left is seen from its end
        assert cut_area() == 0
        assert differing(whole, drawn(browser)) > 5000
        browser.click("#cut-x")
        browser.click("#from-above")
        browser.value("by('at-z').value = 1")
        browser.value("by('at-z').dispatchEvent(new Event('input', { bubbles: true }))")
        assert cut_area() == pytest.approx(10 * 2, rel=0.04)
        assert browser.value("[...document.querySelectorAll('#stage span')].map(one => one.textContent)") == [
            "x", "−x", "y", "−y", "z", "−z",
        ]  # fmt: skip
        assert browser.faults() == []


def test_colours_are_those_of_the_bar_where_light_comes_from_all_sides(tmp_path: Path) -> None:
    """All moves at 0.5 m/s, which is the largest, and nothing is strained."""
    given = moved(shifted(0.3e-3, 0.4e-3), np.arange(4) * 1e-3)
    with opened(plica.write_view(as_run(given), tmp_path / "view.html"), tmp_path / "browser") as browser:
        browser.value("larynx.lamp.intensity = 0; larynx.scene.children.forEach(one => {"
                      "if (one.isAmbientLight) one.intensity = Math.PI; }); larynx.draw()")  # fmt: skip
        table = np.reshape(browser.value("page.colours"), (-1, 3))
        for name, colour, largest in (("speed", table[-1], "0.5 m/s"), ("strain", table[0], "nowhere any")):
            browser.click(f"input[value={name}]")
            assert browser.value("by('largest').textContent") == largest
            picture = drawn(browser).astype(int)
            tissue = (np.abs(picture - colour) <= 2).all(axis=-1)
            assert tissue[tissue.shape[0] // 2, tissue.shape[1] // 2]
            paper = (np.abs(picture - picture[9, 9]) <= 2).all(axis=-1)
            assert (tissue | paper).mean() > 0.98  # the rest is edges
            assert tissue.mean() > 0.1
        ends = browser.picture("#colours").astype(int)
        row = ends[ends.shape[0] // 2]
        assert np.abs(row[6] - table[0]).max() < 12
        assert np.abs(row[-7] - table[-1]).max() < 12


def test_sides_are_named_where_they_are(browser: Browser, voice: plica.Run) -> None:
    def place(name: str) -> tuple[float, float]:
        at = browser.value(
            f"(() => {{ const name = one => one.textContent === '{name}';"
            "const one = [...document.querySelectorAll('#stage span')].find(name);"
            "const box = one.getBoundingClientRect();"
            "return [box.left + box.width / 2, box.top + box.height / 2, one.hidden]; })()"
        )
        assert not at[2], name
        return at[0], at[1]

    look(browser, "above")
    left, right, front, back = (place(name) for name in ("left", "right", "front", "back"))
    assert left[0] + 100 < right[0]  # of a larynx with its right fold at larger x, as in the report
    assert front[1] + 100 < back[1]
    assert browser.value("larynx.names.filter(one => one.span.hidden).map(one => one.span.textContent)") == [
        "top", "bottom",
    ]  # fmt: skip
    look(browser, "front")
    assert place("right")[0] + 100 < place("left")[0]  # who is looked at from the front
    assert place("top")[1] + 100 < place("bottom")[1]


def test_one_fold_can_be_shown_alone(browser: Browser) -> None:
    look(browser, "above")

    def tissue() -> tuple[float, float]:
        picture = drawn(browser)
        seen = (picture != picture[9, 9]).any(axis=-1)[10:-10, 10:-10]
        half = seen.shape[1] // 2
        return float(seen[:, :half].mean()), float(seen[:, half:].mean())

    both = tissue()
    assert both[0] == pytest.approx(both[1], rel=0.02)
    for fold, side in (("left", 0), ("right", 1)):
        browser.click(f"input[value={fold}]")
        alone = tissue()
        assert alone[side] == pytest.approx(both[side], rel=0.02)
        assert alone[1 - side] < 0.02 * both[side]


def test_the_pictures_of_the_docs_are_drawn(voice: plica.Run, tmp_path: Path) -> None:
    files = draw(plica.write_view(voice, tmp_path / "view.html"), tmp_path, tmp_path / "browser")
    for file in files:
        with Image.open(file) as picture, Image.open(ROOT / "docs/images" / file.name) as shown:
            assert picture.size[0] == shown.size[0]
            assert np.ptp(np.asarray(picture)) > 200


def test_dragging_turns_the_larynx(browser: Browser) -> None:
    before = drawn(browser)
    x, y = browser.place("#picture")
    browser.drag((x, y), (x + 60, y + 10), (x + 120, y + 20))
    assert differing(before, drawn(browser)) > 10_000


def test_without_webgl_the_page_says_so_and_its_curves_work(voice: plica.Run, tmp_path: Path) -> None:
    page = plica.write_view(voice, tmp_path / "view.html")
    with opened(page, tmp_path / "browser", webgl=False) as browser:
        assert browser.value("by('missing').textContent") == (
            "The surface is not shown: this browser has no WebGL 2, or it is turned off. Turn it on, or use "
            "another browser. The waveforms below work without it."
        )
        assert browser.value("[by('missing').hidden, by('stage').hidden, by('tools').hidden]") == [
            False, True, True,
        ]  # fmt: skip
        left, top, width, height = browser.box(".curve .u-over")
        browser.drag((left + width - 1, top + height / 2))
        assert phase(browser) == 8
        assert browser.value("by('phase').value") == "8"
        assert browser.faults() == []
