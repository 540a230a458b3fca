"""Draws the pictures of docs/view.md from a page of `plica view`, in a browser:

PYTHONPATH=tests/python .venv/bin/python tests/python/view_pictures.py runs/demo/view.html docs/images
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from browser import Browser

WIDTH, HEIGHT = 1240, 1180  # px of the window
SHOWN = 900  # px, width of a picture
MOST = (
    "(() => { const all = larynx.levels[0], sums = page.time.map((_, k) =>"
    "all.subarray(k * page.nodes, (k + 1) * page.nodes).reduce((sum, level) => sum + level, 0));"
    "return sums.indexOf(Math.max(...sums)); })()"
)
"""The phase in which most nodes touch."""


def draw(page: Path, folder: Path, work: Path) -> list[Path]:
    """The page where the folds touch most, and there a coronal cut beside the right fold's medial surface;
    returns the files."""
    with Browser(page, work, webgl=True) as browser:
        browser.tell("Runtime.evaluate", expression="ready", awaitPromise=True)
        browser.tell(
            "Emulation.setDeviceMetricsOverride",
            width=WIDTH,
            height=HEIGHT,
            deviceScaleFactor=1,
            mobile=False,
        )
        browser.value(f"show({MOST})")
        browser.click("input[value=strain]")
        whole = Image.fromarray(browser.picture("main")).crop((0, 0, WIDTH - 24, HEIGHT))
        parts = []
        browser.click("input[value='contact pressure']")
        for clicked in (("#from-front", "#cut-y"), ("#from-left", "#cut-y", "input[value=right]")):
            for selector in clicked:
                browser.click(selector)
            parts.append(browser.picture("#stage"))
        assert browser.faults() == []
    pictures = {"view.jpg": whole, "view_cut.jpg": Image.fromarray(np.concatenate(parts, axis=1))}
    for name, picture in pictures.items():
        small = picture.resize(
            (SHOWN, round(SHOWN * picture.height / picture.width)), Image.Resampling.LANCZOS
        )
        small.save(folder / name, quality=88, optimize=True)
    return [folder / name for name in pictures]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        print(*draw(Path(sys.argv[1]), Path(sys.argv[2]), Path(place)))
