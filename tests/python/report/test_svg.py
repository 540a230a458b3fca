"""Drawings made short: every point and every pixel is where it was."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
import pytest
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from PIL import Image

from plica.report.svg import shortened


def drawn() -> str:
    figure = Figure(figsize=(6, 3))
    FigureCanvasSVG(figure)
    axes = figure.subplots(1, 2)
    x = np.linspace(0, 6, 200)
    axes[0].plot(x, np.where(np.abs(np.sin(3 * x)) > 0.1, np.sin(3 * x), np.nan), "o-", ms=2)
    axes[0].fill_between(x, np.cos(x), 2 + np.sin(x))
    axes[1].imshow(np.random.default_rng(0).uniform(size=(30, 40)), cmap="magma", interpolation="none")
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg")
    return buffer.getvalue()


def points(path: str) -> np.ndarray:
    """(n, 2) of a path of M, L, l, z, C and Q: read by the rules of SVG, numbers one by one."""
    found: list[tuple[float, float]] = []
    begun = here = (0.0, 0.0)
    for letter, rest in re.findall(r"([A-Za-z])([^A-Za-z]*)", path):
        numbers = [float(number) for number in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", rest)]
        for x, y in zip(numbers[::2], numbers[1::2], strict=True):
            here = (here[0] + x, here[1] + y) if letter == "l" else (x, y)
            found.append(here)
        begun = here if letter == "M" else begun
        here = begun if letter == "z" else here
    return np.array(found)


def test_every_point_of_every_path_is_where_it_was() -> None:
    text = drawn()
    before, after = (re.findall(r' d="([^"]*)"', one) for one in (text, shortened(text)))
    assert len(before) == len(after) > 20
    for one, other in zip(before, after, strict=True):
        assert points(other) == pytest.approx(points(one), abs=0.0051)
        assert one.count("M") == other.count("M")
        assert one.count("z") == other.count("z")
    assert sum(map(len, after)) < 0.6 * sum(map(len, before))


def test_every_pixel_of_a_picture_is_what_it_was() -> None:
    text = drawn()
    pictures = [
        Image.open(io.BytesIO(base64.b64decode(re.findall(r'base64,([^"]*)"', one)[0])))
        for one in (text, shortened(text))
    ]
    assert [picture.mode for picture in pictures] == ["RGBA", "P"]
    assert (np.asarray(pictures[1].convert("RGBA")) == np.asarray(pictures[0])).all()


def test_a_style_is_the_same() -> None:
    short = shortened(
        '<g style="fill: #010203; font: 9.5px sans-serif"><path d="M 1.5 2.5 L 1 -2.25 z "/></g>'
    )
    assert short == '<g style="fill:#010203;font:9.5px sans-serif"><path d="M1.5 2.5l-0.5-4.75z"/></g>'
