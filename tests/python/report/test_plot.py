"""Figures of our own: ticks, what is where on the page, and pictures that other programs read."""

from __future__ import annotations

import base64
import io
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from plica.report.plot import Panel, Plot, reduced, viridis
from plica.report.ticks import linear_ticks, log_ticks


@pytest.mark.parametrize("seed", range(20))
def test_linear_ticks_are_round_even_inside_and_written_as_they_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(50):
        low = float(rng.normal()) * 10.0 ** rng.integers(-2, 4)
        high, most = low + 10.0 ** float(rng.uniform(-2, 4)), float(rng.uniform(2, 12))
        ticks = linear_ticks(low, high, most)
        values = [low + share * (high - low) for share in ticks.shares]
        assert all(-1e-8 <= share <= 1 + 1e-8 for share in ticks.shares)
        assert 0 < len(values) <= most + 1
        if len(values) > 1:
            steps = np.diff(values)
            assert steps == pytest.approx(np.full(len(steps), steps[0]), rel=1e-6)
            mantissa = steps[0] / 10.0 ** np.floor(np.log10(steps[0]) + 1e-9)
            assert min(abs(mantissa - one) for one in (1, 2, 2.5, 5)) < 1e-6
            written = [float(text.replace("−", "-")) for text in ticks.labels if "·" not in text]
            if len(written) == len(values):
                assert written == pytest.approx(values, abs=1e-6 * steps[0] + 1e-9 * abs(low))


def test_ticks_far_from_one_have_a_power_of_ten() -> None:
    assert linear_ticks(0.0, 2e-5, 4).labels == ["0", "0.5·10⁻⁵", "1·10⁻⁵", "1.5·10⁻⁵", "2·10⁻⁵"]
    assert linear_ticks(-2e6, 0.0, 2).labels == ["−2·10⁶", "−1·10⁶", "0"]


def test_logarithmic_ticks_are_powers_of_ten_or_round_numbers_within_one() -> None:
    found = log_ticks(1e-6, 1e-2, 10)
    assert found.labels == ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"]
    assert found.shares == pytest.approx(np.linspace(0, 1, 5))
    assert log_ticks(1e-12, 1.0, 4).labels == ["10⁻¹²", "10⁻⁸", "10⁻⁴", "10⁰"]
    within = log_ticks(2.0, 8.0, 4)
    assert within.labels == ["2", "4", "6", "8"]
    assert within.shares == pytest.approx([0, 0.5, np.log(3) / np.log(4), 1])


def test_a_reduced_line_keeps_its_ends_of_range_and_its_order() -> None:
    x = np.linspace(0.0, 1.0, 20_000)
    y = np.sin(400 * x)
    y[12_345] = 7.0
    kept_x, kept_y = reduced(x, y)
    assert kept_x.size <= 3000
    assert kept_y.max() == 7.0
    assert (np.diff(kept_x) >= 0).all()


def test_marks_are_where_their_coordinates_are() -> None:
    panel = Panel(10.0, 20.0, 100.0, 50.0, x_range=(0.0, 10.0), y_range=(-1.0, 1.0))
    panel.line(np.array([0.0, 5.0, 7.0, 10.0]), np.array([-1.0, 1.0, np.nan, 0.0]), "red")
    panel.bands.append((2.0, 4.0, "grey", 0.2))
    svg = panel.svg("name")
    assert '<path d="M10.00,70.00L60.00,20.00M110.00,45.00" fill="none" stroke="red"' in svg
    assert '<rect x="30.00" y="20.00" width="20.00" height="50.00" fill="grey"' in svg


def test_a_logarithmic_panel_has_the_middle_of_its_range_in_its_middle() -> None:
    panel = Panel(0.0, 0.0, 100.0, 40.0, x_range=(0.0, 1.0), y_range=(1e-4, 1.0), log=True)
    panel.line(np.array([0.0, 1.0]), np.array([1e-2, 1e-4]), "red")
    assert 'd="M0.00,20.00L100.00,40.00"' in panel.svg("name")


def test_equal_scales_are_equal_and_stay_inside() -> None:
    panel = Panel(10.0, 20.0, 100.0, 50.0)
    panel.with_equal_scales((-1.0, 1.0), (0.0, 4.0))
    assert panel.width / 2.0 == pytest.approx(panel.height / 4.0)
    assert (panel.top, panel.height) == (20.0, 50.0)
    assert panel.left + 0.5 * panel.width == pytest.approx(60.0)


def test_a_figure_is_xml_and_its_picture_has_its_pixels_upwards() -> None:
    plot = Plot("A & B", (4.0, 3.0))
    (panel,) = plot.column(1)
    colours = viridis(np.array([[0.0, 1.0, 0.5], [1.0, 0.0, 0.5]]))
    panel.picture(colours, (0.0, 1.0), (0.0, 1.0))
    panel.x_range = panel.y_range = (0.0, 1.0)
    panel.x_label, panel.legend = "a < b", [("x & y", "red")]
    svg = plot.drawing("", 'of "this" <and> that').svg
    ElementTree.fromstring(svg)
    (coded,) = re.findall(r"base64,([^\"]+)", svg)
    with Image.open(io.BytesIO(base64.b64decode(coded))) as picture:
        np.testing.assert_array_equal(np.asarray(picture), colours[::-1])


def test_viridis_is_that_of_matplotlib() -> None:
    from matplotlib import colormaps

    share = np.linspace(0.0, 1.0, 101)
    theirs = 255 * colormaps["viridis"](share)[:, :3]
    assert np.abs(viridis(share) - theirs).max() < 4  # of 255, between its 21 colours
