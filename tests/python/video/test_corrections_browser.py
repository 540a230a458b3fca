"""The page of corrections in a browser, drawn on with the mouse: what it saves is what was drawn."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from browser import CHROMIUM, Browser
from corrected_pages import page_content, unpacked
from plica.commands.main import main
from plica.video.analysis import load
from plica.video.files.corrections import Corrections, read_corrections

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium: apt install chromium; nothing else runs the page's JavaScript"
    ),
]

LEFT, RIGHT, Z = ("ArrowLeft", 37), ("ArrowRight", 39), ("z", 90)


class Page:
    """A page of corrections in a browser, in pixels of the recording."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser

    def drag(self, *places: tuple[float, float]) -> None:
        """The mouse over these places of the picture: x, y in px, pixel centres at whole numbers."""
        left, top, _, _ = self.browser.box("#picture")
        zoom = self.browser.value("zoom()")
        self.browser.drag(*((left + (x + 0.5) * zoom, top + (y + 0.5) * zoom) for x, y in places))

    def take(self, tool: str) -> None:
        self.browser.click(f"input[name=tool][value={tool}]")

    def text(self, name: str) -> str:
        return str(self.browser.value(f"document.getElementById('{name}').textContent"))

    def show(self, frame: int) -> None:
        """Go to a frame by the arrow keys."""
        for key in (*[LEFT] * 20, *[RIGHT] * 20):
            if self.text("label").split(",")[0] == f"frame {frame}":
                return
            self.browser.key(*key)
        raise AssertionError(f"frame {frame} is not on the page")

    def save(self) -> Corrections:
        self.browser.click("#save")
        return read_corrections(self.browser.downloaded("corrections.json"))


@pytest.fixture(scope="module")
def analysed(movie: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("drawn") / "the patient's"
    assert main(["glottis", str(movie), "-o", str(directory), "--fps", "4000", "--quiet"]) == 0
    assert (
        main(["masks", str(directory), "--page", str(directory / "c.html"), "--frames", "3,20", "--quiet"])
        == 0
    )
    return directory


@pytest.fixture
def page(analysed: Path, tmp_path: Path) -> Iterator[Page]:
    with Browser(analysed / "c.html", tmp_path) as browser:
        yield Page(browser)
        assert browser.faults() == []


def test_what_is_drawn_is_what_is_read(page: Page, analysed: Path) -> None:
    told = page_content(analysed / "c.html")
    found = {frame["number"]: unpacked(frame["mask"], told) for frame in told["frames"]}
    page.show(3)
    page.browser.click("#clear")
    for _ in range(4):
        page.browser.key("[", 219)
    assert page.text("size-said") == "1 px"
    page.drag((40, 30), (48, 30), (48, 60))  # the thinnest brush, across and down
    page.take("eraser")
    page.drag((48, 40), (48, 44))
    wanted = np.zeros((95, 97), bool)
    wanted[30, 40:49] = wanted[30:61, 48] = True
    wanted[40:45, 48] = False
    for _ in range(6):
        page.browser.key("]", 221)
    page.browser.key("b", 66)
    page.drag((20, 70))  # a disc of 7 px
    y, x = np.mgrid[:95, :97]
    wanted |= np.hypot(x - 20, y - 70) <= 3.5
    page.drag((60, 10), (70, 80))
    page.browser.key(*Z, control=True)  # that was a slip
    page.show(20)
    page.drag((3, 2), (-5, 2))  # over the border
    saved = page.save()
    assert sorted(saved.masks) == [3, 20]
    assert np.array_equal(saved.masks[3], wanted)
    assert np.array_equal(saved.masks[20], found[20] | (np.hypot(np.maximum(x - 3, 0), y - 2) <= 3.5))
    assert saved.settings == {}


def test_the_command_shown_takes_what_was_drawn(
    page: Page, analysed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = page_content(analysed / "c.html")
    widest = max(told["frames"], key=lambda frame: unpacked(frame["mask"], told).sum())
    assert page.text("label") == f"frame {widest['number']}"
    mask = unpacked(widest["mask"], told)
    left = int(np.flatnonzero(mask[47])[0])
    page.drag((left, 44), (left, 50))  # to the left of the left fold's edge
    ends = np.array(told["midline"])
    page.take("midline")
    page.drag((ends[0], ends[1]), (ends[0] + 1, ends[1] + 1), (ends[0] + 1, ends[1] + 2))
    page.take("scale")
    page.drag((10, 20))
    page.drag((40, 60))
    page.browser.type("2.5")
    saved = page.save()
    assert list(saved.masks) == [widest["number"]]
    drawn = saved.masks[widest["number"]]
    assert (drawn & ~mask).sum() > 10
    assert not (mask & ~drawn).any()
    assert saved.midline == pytest.approx(ends + np.array([1, 2, 0, 0]), abs=0.2)  # the window's pixels
    assert saved.mm_per_px == pytest.approx(2.5 / 50, rel=0.01)
    assert saved.region is None
    assert "the mask of a frame, the midline, the scale, 0.05" in page.text("summary")
    words = shlex.split(page.text("command"))
    assert words[:2] == ["plica", "glottis"]
    assert str(analysed) in words
    assert "--fps" not in page.text("command")  # the directory keeps it
    monkeypatch.chdir(page.browser.downloads)
    assert main([*words[1:], "--quiet"]) == 0
    done = load(analysed)
    assert np.array_equal(done.mask(widest["number"]), drawn)
    assert done.midline.ends == pytest.approx(saved.midline)
    assert done.settings.mm_per_px == saved.mm_per_px
    assert done.settings.fps == 4000


def test_another_region_is_analysed_beside_by_the_command_shown(
    page: Page, analysed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page.take("region")
    page.drag((12, 8), (20, 20))  # too small
    assert "must have 16 px or more" in page.text("said")
    page.drag((12.5, 88.5), (40, 40), (84.5, 6.5))  # from the lower left corner, between pixels
    saved = page.save()
    assert saved.region == (13, 7, 72, 82)
    words = shlex.split(page.text("command"))
    assert f"{analysed}_region" in words
    assert "--fps=4000.0" in words
    monkeypatch.chdir(page.browser.downloads)
    assert main([*words[1:], "--quiet"]) == 0
    assert load(Path(f"{analysed}_region")).frames().shape == (82, 72)


def test_nothing_is_saved_where_nothing_was_corrected(page: Page) -> None:
    page.browser.click("#save")
    assert page.text("said") == "Nothing was corrected: there is nothing to save."
    page.drag((10, 10), (20, 20))
    page.take("midline")
    page.drag((48, 90), (10, 60))
    page.take("scale")
    page.drag((10, 20))
    page.drag((40, 60))
    page.browser.click("#save")
    assert "Enter the distance of the two points" in page.text("said")
    for _ in range(4):
        page.browser.click("#undo")
    assert page.text("summary") == "nothing yet"
    page.browser.click("#undo")
    assert page.text("said") == "There is nothing to undo."
    page.browser.click("#save")
    assert page.text("said") == "Nothing was corrected: there is nothing to save."
    assert list(page.browser.downloads.iterdir()) == []


def test_a_midline_across_the_picture_is_taken_back(page: Page, analysed: Path) -> None:
    ends = page_content(analysed / "c.html")["midline"]
    page.take("midline")
    page.drag((ends[0], ends[1]), (2, ends[3] - 5))
    assert "must run within 45 degrees of the vertical" in page.text("said")
    assert page.text("summary") == "nothing yet"


def test_a_frame_that_is_right_may_be_said_to_be(page: Page, analysed: Path) -> None:
    page.show(3)
    page.browser.click("#taken")
    told = page_content(analysed / "c.html")
    mask = next(unpacked(frame["mask"], told) for frame in told["frames"] if frame["number"] == 3)
    assert np.array_equal(page.save().masks[3], mask)
