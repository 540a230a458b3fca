"""The first page of a recording's report: what to write down, what not, and why."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import ndimage

from plica.measures.measure import Measure, whole
from plica.report.wording import tables
from plica.video.analysis import Analysis, analyse
from plica.video.light import light_of
from plica.video.measures.frame_flags import in_doubt
from plica.video.report.page import write_report
from plica.video.report.summary import Recorded, summary
from plica.video.settings import Settings


def _film(count: int = 90) -> np.ndarray:
    y, x = np.mgrid[0:110, 0:90].astype(float)
    shape = np.clip(1 - ((y - 55) / 45) ** 2, 0, None)
    frames = []
    for t in range(count):
        half = shape * np.maximum(2 + 8 * np.sin(2 * np.pi * t / 21.3), 0)
        covered = np.clip(half + 0.5 - np.abs(x - 44.5), 0, 1)
        frames.append(ndimage.gaussian_filter(150 - 128 * covered, 0.8))
    noisy = np.array(frames) + np.random.default_rng(1).normal(0, 1.5, (count, 110, 90))
    noisy[:, :2] = 255.0  # the scale's end
    return np.round(noisy).astype(np.uint8)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """Of four cycles, with its page."""
    where = tmp_path_factory.mktemp("summary")
    np.save(where / "film.npy", _film(94))
    settings = Settings(fps=4000, correct_drift=False)
    done = analyse(where / "film.npy", where / "a", settings, until="glottis", progress=False)
    write_report(done)
    return done


def _judged(*items: Measure) -> dict[str, Recorded]:
    found = SimpleNamespace(measures={item.name: item for item in items})
    rows = {item.name: SimpleNamespace(name=item.name) for item in items}
    kept, left_out = summary(found, rows)  # type: ignore[arg-type]
    assert all(not one.reason for one in kept)
    assert all(one.reason for one in left_out)
    return {one.row.name: one for one in (*kept, *left_out)}


def test_what_is_known_well_is_written_down_and_the_rest_has_its_reason() -> None:
    def frequency(half: float, *cautions: str) -> Measure:
        item = whole("fundamental_frequency", 200.0)
        spread = replace(item, bound=None, cautions=cautions)
        return SimpleNamespace(  # type: ignore[return-value]
            name=item.name,
            value=spread.value,
            interval=None if half == 0 else (200 - half, 200 + half),
            note="",
            cautions=cautions,
        )

    name = "fundamental_frequency"
    everywhere = "edges are placed to 0.5 px, and the lesser amplitude is 2 px"
    assert _judged(frequency(4.0))[name].reason == ""
    assert _judged(frequency(4.0, everywhere))[name].reason == ""
    assert _judged(frequency(12.0))[name].reason == "its interval is wide"
    assert _judged(frequency(4.0, "one", "two"))[name].reason == "one (and more: see below)"
    assert _judged(frequency(0.0))[name].reason == "no interval is known"
    assert _judged(frequency(0.0, "frames are missing"))[name].reason == "frames are missing"
    unknown = SimpleNamespace(name=name, value=None, interval=None, note="no cycles", cautions=())
    assert _judged(unknown)[name].reason == "no cycles"  # type: ignore[arg-type]


def test_the_first_page_has_both_and_the_reasons_of_the_light(found: Analysis) -> None:
    rows = {row.name: row for _, part in tables(found.measures) for row in part}
    kept, left_out = summary(found, rows)
    assert {"fundamental_frequency", "open_quotient"} <= {one.row.name for one in kept}
    assert {"jitter", "shimmer"} <= {one.row.name for one in left_out}  # of four cycles
    text = (found.directory / "report.html").read_text()
    assert text.index("To write down") < text.index("Not to write down") < text.index("All measures")
    assert "only 3 cycles" in text or "only 4 cycles" in text


@pytest.mark.usefixtures("few_draws")
def test_the_reason_that_makes_the_light_what_it_is_comes_first(tmp_path: Path) -> None:
    np.save(tmp_path / "film.npy", _film(30))  # without three cycles
    settings = Settings(fps=4000, correct_drift=False)
    found = analyse(tmp_path / "film.npy", tmp_path / "a", settings, until="glottis", progress=False)
    light = light_of(found)
    assert light.shown == "red"
    assert not any(map(in_doubt, found.flags))
    assert not any("frames are in doubt" in reason for reason in light.reasons)
    assert light.reasons[0].startswith("No cycles were found")
    assert light.said == " ".join(light.reasons)
    assert len(light.reasons) >= 2


def test_what_comes_before_the_tables_is_printed_on_two_sheets(found: Analysis) -> None:
    weasyprint = pytest.importorskip("weasyprint")
    page = (found.directory / "report.html").read_text()
    light = page.index('<ul class="reasons">') + len('<ul class="reasons">')
    reasons = "".join(f"<li>{'A reason of two lines. ' * 6}</li>" for _ in range(8))
    for text in (page, page[:light] + reasons + page[light:]):
        lead = text[: text.index('<h2 class="rest">')]
        assert len(weasyprint.HTML(string=lead).render().pages) == 2


def test_a_reason_ends_as_a_sentence_does() -> None:
    found = SimpleNamespace(
        doubts=["is fps the rate of recording?", "the gap is hidden"],
        signals=SimpleNamespace(doubts=[]),
        measures={},
        cycles=SimpleNamespace(count=5, no_period=""),
        flags=["", ""],
        count=2,
        complete=False,
    )
    assert light_of(found).said.startswith("Is fps the rate of recording? The gap is hidden. ")
