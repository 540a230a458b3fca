import dataclasses
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import plica
from analytic_run import AnalyticRun, Phonation, free_vibration
from plica.commands.output import measures_table
from plica.measures.cycles import Cycles, find_cycles
from plica.measures.measure import Measure, Measures
from plica.measures.run.cautions import cautions
from plica.measures.run.measure import measure
from plica.measures.scale import Scale
from plica.report.drawing import draw
from plica.report.progress import figures_shown
from plica.report.run import write_report
from plica.report.run.cycle import (
    Outline,
    medial_edge,
    nearest_frames,
    phase_instants,
    phases,
    pressure_scale,
    superior_cycle,
)
from plica.report.run.page import banner, remark, sections
from plica.report.run.reading import read
from plica.report.run.sound import read_sound
from plica.report.run.waveforms import closed_times, glottal_waveforms, shade
from plica.report.wording import number, row, tables

base = Phonation(frequency=213.7, vertical_lag=0.6, amplitude_right=0.4e-3)
airflow_figures = {
    "Glottal area and flow, last cycles",
    "Kymogram of the mid-plane",
    "Whole run",
    "Coronal section",
    "From above",
    "Pressure in the glottis",
    "Trajectories in the coronal plane",
    "Spectrum of flow and sound",
    "Spectrogram",
}


class Page(HTMLParser):
    """What a browser would fetch, which ids there are, and whether every element is closed."""

    empty = frozenset({"meta", "br", "hr", "img", "link", "input"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.fetched: list[str] = []
        self.ids: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.elements.append((tag, given))
        self.ids += [value for name, value in attrs if name == "id" and value]
        links = {"src", "href", "xlink:href", "srcset", "data", "poster"}
        self.fetched += [value for name, value in attrs if name in links and value]
        if tag not in self.empty:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.empty:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_figures_that_take_their_time_are_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def paint(figure: Figure) -> None:
        figure.subplots().plot([0, 1])

    def message(*shown: bool) -> str:
        with figures_shown(*shown):
            for title in ("one", "two"):
                draw(title, "", "", (1, 1), paint)
        return capsys.readouterr().err

    assert message() == ""  # within two seconds
    monkeypatch.setattr("plica.report.progress._AFTER", 0.0)
    assert "report: 2 figures" in message()
    assert message(False) == ""
    draw("three", "", "", (1, 1), paint)
    assert capsys.readouterr().err == ""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    scene = base.run().scene_text + '\n[output]\ntitle = "a <b> & c"\n'
    run = dataclasses.replace(base.run(), scene_text=scene)
    path = tmp_path_factory.mktemp("normal phonation") / "report.html"
    assert write_report(run, path) == path
    assert path.stat().st_size < 5_000_000
    assert list(path.parent.iterdir()) == [path]
    return path.read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_page_fetches_nothing(page: str) -> None:
    assert all(link.startswith(("#", "data:")) for link in Page(page).fetched)
    assert not re.search(r"<(script|link|iframe)\b|@import", page)
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", page))


@pytest.mark.slow
def test_the_page_is_well_formed_and_every_id_is_unique(page: str) -> None:
    read_page = Page(page)
    assert read_page.open == []
    assert len(read_page.ids) == len(set(read_page.ids))


@pytest.mark.slow
def test_every_figure_has_its_text_for_those_who_do_not_see_it(page: str) -> None:
    pictures = [given for tag, given in Page(page).elements if tag == "svg"]
    assert len(pictures) == len(airflow_figures) + 2  # contact and energy
    assert all(given.get("role") == "img" and given.get("aria-label") for given in pictures)


@pytest.mark.slow
def test_the_page_follows_the_readers_light_or_dark_and_prints(page: str) -> None:
    assert "prefers-color-scheme: dark" in page
    assert "@media print" in page
    assert "currentColor" in page
    assert "#010203" not in page


@pytest.mark.slow
def test_the_page_holds_every_measure_the_scene_and_the_versions(page: str) -> None:
    ids = set(Page(page).ids)
    assert measure(base.run()).keys() <= ids
    assert ">213.7<" in page
    assert "subglottal_pressure = &#34;800.0 Pa&#34;" in page
    assert "a &lt;b&gt; &amp; c" in page
    assert f"numpy {np.__version__}" in page
    assert all(f"<h3>{title}</h3>" in page for title in airflow_figures)


def test_suction_has_another_colour_than_no_pressure() -> None:
    scale = pressure_scale(np.array([[np.nan, 800.0], [0.0, -300.0]]))
    assert scale(-0.3) == 0.0
    assert scale(0.0) == pytest.approx(3 / 11)
    assert scale(0.8) == 1.0
    assert pressure_scale(np.array([0.0, 800.0]))(0.0) == 0.0


def shaded(run: AnalyticRun) -> list[tuple[float, float]]:
    """Beginning and end (ms) of what the figure of the glottal area shades."""
    axes = Figure().subplots()
    shade(axes, closed_times(read(run), 5))
    return [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]


def test_what_is_shaded_is_closed_and_the_rest_is_the_open_quotient() -> None:
    # Area max(gap + amplitude cos, 0), closed where it is at most 5 % of gap + amplitude: about half a turn.
    run = dataclasses.replace(base, amplitude_right=0.5e-3, vertical_lag=0.0).run()
    level = 0.05 * (base.gap + 0.5e-3) - base.gap
    half = np.arccos(-level / 0.5e-3) / (2 * np.pi) * 1e3 / 213.7
    found = shaded(run)
    ends = 1e3 * read(run).cycles.starts[-6:]
    inner = [(a, b) for a, b in found if a > ends[0] + 0.1 and b < ends[-1] - 0.1]
    assert len(inner) >= 4
    for begin, end in inner:
        middle = 0.5 * (begin + end) * 213.7e-3 % 1.0
        assert middle == pytest.approx(0.5, abs=0.01)
        assert end - begin == pytest.approx(2 * half, abs=0.05)  # a step
    open_quotient = measure(run)["open_quotient"].value
    assert open_quotient is not None
    assert sum(b - a for a, b in found) / (ends[-1] - ends[0]) == pytest.approx(1 - open_quotient, abs=2e-3)


def test_a_flow_that_contact_stops_is_shaded_whatever_the_area() -> None:
    run = dataclasses.replace(base, gap=1e-3, amplitude_right=0.5e-3, vertical_lag=0.0).run()  # never closes
    assert shaded(run) == []
    stopped = (run.time * 213.7) % 1.0 > 0.8
    waveforms = {**run.waveforms, "flow_stopped": stopped.astype(int)}
    found = shaded(dataclasses.replace(run, waveforms=waveforms))
    assert len(found) >= 5
    assert all((0.5 * (a + b) * 213.7e-3) % 1.0 == pytest.approx(0.9, abs=0.02) for a, b in found[1:-1])


def test_inverted_cells_are_of_how_many() -> None:
    found = measure(doubtful(base.run(), 0, 3))["inverted_tissue_max"]
    assert (found.value, found.note) == (3, "of 1 cells")  # the analytic mesh has one
    assert "of 1 cells" in measures_table({found.name: found})


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_views_from_above_have_front_at_the_top_and_right_at_the_right(turned: float) -> None:
    # Right, front and up are right-handed: who looks to the front, upright, has the right at his right.
    run = base.run()
    fields = {**run.fields, "displacement": turned * np.asarray(run.fields["displacement"])}
    fields["displacement"][..., 2] *= turned
    points = np.array(run.mesh.points) * (turned, turned, 1.0)
    mesh = dataclasses.replace(run.mesh, points=points)
    waveforms = dict(run.waveforms)
    for side in ("left", "right"):
        waveforms[f"coronal_{side}"] = np.asarray(run.waveforms[f"coronal_{side}"]) * (turned, turned, 1.0)
    reading = read(dataclasses.replace(run, mesh=mesh, fields=fields, waveforms=waveforms))
    outline = Outline.of(reading, 3)
    middle = outline.y.size // 2
    assert outline.left[middle] < outline.right[middle]
    plain = Outline.of(read(run), 3)
    assert outline.right == pytest.approx(plain.right, abs=1e-9, nan_ok=True)
    picture = superior_cycle(reading)
    assert picture is not None
    names = re.findall(r">(L|R|front|back)<", picture.svg)
    assert [names.count(name) for name in ("L", "R", "front", "back")] == [phases] * 4


def test_without_cycles_nothing_is_shaded() -> None:
    still = dataclasses.replace(base, amplitude_left=0.0, amplitude_right=0.0, gap=0.0, impulse=0.0).run()
    assert shaded(still) == []


def titles(run: AnalyticRun) -> set[str]:
    reading = read(run)
    return {drawing.title for _, drawings in sections(reading, read_sound(reading)) for drawing in drawings}


@pytest.mark.slow
def test_absent_parts_have_no_section(tmp_path: Path) -> None:
    assert titles(free_vibration(steps=600)) == {"Probes", "Spectrum", "Energy balance"}
    assert titles(dataclasses.replace(base, impulse=0.0).run()) == airflow_figures | {"Energy balance"}
    text = write_report(free_vibration(steps=600), tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Kymogram" not in text
    assert "Contact" not in text


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_without_frames_there_is_no_view_from_above() -> None:
    run = dataclasses.replace(base.run(), fields={})
    assert titles(run) == (airflow_figures - {"From above"}) | {"Contact", "Energy balance"}


def test_the_cycles_of_a_run_are_found_once(
    phonating: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []

    def counted(*record: Any, **options: Any) -> Cycles:
        found.append(find_cycles(*record, **options))
        return found[-1]

    monkeypatch.setattr("plica.measures.run.measure.find_cycles", counted)
    run = plica.run(phonating, tmp_path / "run", progress=False)
    assert "fundamental_frequency" in run.measures
    write_report(run, tmp_path / "run" / "report.html")
    assert len(found) == 1


def cut(run: AnalyticRun, steps: int) -> AnalyticRun:
    """As a kill leaves it."""
    waveforms = {name: values[:steps] for name, values in run.waveforms.items()}
    return dataclasses.replace(run, time=run.time[:steps], waveforms=waveforms)


def test_a_complete_run_has_no_banner() -> None:
    reading = read(base.run())
    assert banner(reading) == ""
    assert remark(reading).startswith("Measured over 11 cycles")


def test_an_interrupted_run_says_how_far_it_came() -> None:
    assert "not complete: it has 700 of 1200 steps, to 35 ms" in banner(read(cut(base.run(), 700)))


def test_a_failed_run_says_why() -> None:
    run = dataclasses.replace(cut(base.run(), 700), failure="Simulation: the solver did not converge.")
    assert banner(read(run)) == (
        "This run failed after 700 of 1200 steps, to 35 ms. Simulation: the solver did not converge."
    )


def doubtful(run: AnalyticRun, unconverged: int, inverted: int) -> AnalyticRun:
    """The run with so many last steps without a converged coupling, and with 1, 2, ... inverted cells."""
    late = np.maximum(np.arange(run.time.size) - run.time.size + 1 + inverted, 0)
    converged = np.arange(run.time.size) < run.time.size - unconverged
    left_out = np.where(late == inverted, 0.006, 0.005)
    found = {
        "coupling_converged": converged.astype(np.int32),
        "inverted_tissue": late.astype(np.int32),
        "inverted_by_layer": late.astype(np.int32)[:, None],
        "strain_neglected": left_out,
    }
    return dataclasses.replace(run, waveforms={**run.waveforms, **found})


UNCONVERGED = "In 7 of 1200 steps, first at 59.7 ms, the coupling of airflow and tissue did not converge"
FOLDED = "3 of 1 cells were inverted at 60 ms (3 in the body), the most"


@pytest.mark.parametrize(
    ("unconverged", "inverted", "message"),
    [(7, 0, [UNCONVERGED]), (0, 3, [FOLDED]), (7, 3, [FOLDED, UNCONVERGED])],
)
def test_cautions_count_the_steps_in_doubt(unconverged: int, inverted: int, message: list[str]) -> None:
    found = cautions(doubtful(base.run(), unconverged, inverted))
    assert len(found) == len(message)
    for caution, beginning in zip(found, message, strict=True):
        assert str(caution).startswith(beginning)


def test_a_part_of_a_run_may_be_in_doubt_too() -> None:
    (caution,) = cautions(cut(doubtful(base.run(), 1200, 0), 700))
    assert caution.seen.startswith("In 700 of 700 steps, first at 0.05 ms, the coupling")


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_the_page_has_every_caution_of_its_own(tmp_path: Path) -> None:
    run = doubtful(base.run(), 7, 3)
    text = write_report(run, tmp_path / "report.html").read_text(encoding="utf-8")
    assert len(re.findall(r"Caution \d+: ", text)) == 2
    assert f"Caution 1: {FOLDED}" in text
    assert f"Caution 2: {UNCONVERGED}" in text


class Doubted(AnalyticRun):
    """A run whose fundamental frequency is doubted."""

    @property
    def measures(self) -> Measures:
        """With one caution."""
        found = measure(self)
        name = "fundamental_frequency"
        return Measures({**found, name: dataclasses.replace(found[name], cautions=("by hand",))}.values())


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_tile_has_the_mark_of_its_caution(tmp_path: Path) -> None:
    run = Doubted(**vars(base.run()))
    text = write_report(run, tmp_path / "report.html").read_text(encoding="utf-8")
    tiles = re.findall(r'<div class="tile"><dt>(.*?)</dt>', text)
    assert len(tiles) > 3
    assert [tile for tile in tiles if "<sup>" in tile] == ["Fundamental frequency<sup>1</sup>"]


@pytest.mark.slow
@pytest.mark.parametrize("steps", [0, 1, 40])
def test_a_run_of_any_length_gives_a_page(tmp_path: Path, steps: int) -> None:
    text = write_report(cut(base.run(), steps), tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{steps} of 1200 steps" in text
    assert ("<svg" in text) == (steps > 1)


@pytest.mark.slow
def test_a_silent_run_gives_a_page_without_cycles(tmp_path: Path) -> None:
    still = dataclasses.replace(base, amplitude_left=0.0, amplitude_right=0.0, impulse=0.0).run()
    text = write_report(still, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "No cycles: no oscillation" in text
    assert "Flow and glottal area are of the last third of the run, from 40.05 to 60.00 ms." in text
    assert 'class="tile"' not in text
    assert "<h3>Kymogram of the mid-plane</h3>" in text


def ringing() -> AnalyticRun:
    """Folds that never touch, pushed off once: their motion falls by 7 % a cycle."""
    run = dataclasses.replace(base, gap=1e-3, impulse=0.0).run()
    area = 5e-6 + 0.4e-6 * np.exp(-0.07 * 213.7 * run.time) * np.cos(2 * np.pi * 213.7 * run.time)
    return dataclasses.replace(run, waveforms={**run.waveforms, "minimum_area": area, "flow": 40 * area})


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_decay_is_no_voice_for_tiles_text_and_table(tmp_path: Path) -> None:
    run = ringing()
    text = write_report(run, tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.search(
        r">No voice\. What has a value is of the last 3 cycles, from [\d.]+ to [\d.]+ ms\.", text
    )
    assert text.count("There is no voice: ") == 1
    assert "Measured over" not in text
    assert 'class="tile"' not in text
    assert "Shaded" not in text
    assert "In these cycles the glottis does not close" in text
    table = measures_table(measure(run), short=True)
    assert re.search(r"^fundamental_frequency +- +weak: .*; free decay: ", table, re.MULTILINE)
    assert not re.search(r"(open|speed)_quotient", table)
    assert re.search(r"^peak_flow +\d", table, re.MULTILINE)


def test_the_shares_of_a_period_have_no_value_where_there_is_no_voice() -> None:
    found = measure(ringing())
    names = ("fundamental_frequency", "period", "open_quotient", "open_quotient_1_percent", "speed_quotient")
    for name in (
        *names,
        "closing_quotient",
        "vertical_phase_difference",
        "left_right_phase",
        "converging_while_opening",
    ):
        assert found[name].value is None
        assert "free decay" in found[name].note
        assert found[name].cautions == ()
    assert found["amplitude_growth"].value == pytest.approx(np.expm1(-0.07), rel=0.01)
    assert found["glottal_area_max"].cycles == 3


def test_a_voice_that_closes_is_shaded_with_its_open_quotient() -> None:
    drawing = glottal_waveforms(read(base.run()))
    assert "Shaded: the glottis is closed (area at most 5 %" in drawing.caption
    assert f"open quotient of {row(measure(base.run())['open_quotient']).value}." in drawing.caption


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_what_a_caution_says_is_no_note_of_a_measure_too(tmp_path: Path) -> None:
    run = base.run()
    dip = 1 - 0.5 * np.exp(-30 * (1 - np.cos(2 * np.pi * 213.7 * run.time)))
    area = run.waveforms["minimum_area"] * dip
    dented = Doubted(**vars(dataclasses.replace(run, waveforms={**run.waveforms, "minimum_area": area})))
    text = write_report(dented, tmp_path / "report.html").read_text(encoding="utf-8")
    assert text.count("pulses have several summits") == 1
    marks = dict(re.findall(r'<tr id="(\w+)"><th scope="row">[^<]*<sup>([^<]*)</sup>', text))
    assert marks["open_quotient"] == "1"
    assert marks["fundamental_frequency"] == "2"  # the first note, counted on from the caution
    assert re.search(r'<ol class="notes" start="2">\s*<li>by hand</li>', text)


def test_sparse_frames_lend_each_other_their_phase() -> None:
    # A frame every 1.7 periods: eight of them in a run, none of two in the same cycle.
    run = dataclasses.replace(base, steps=12000, frame_every=160).run()
    reading = read(run)
    chosen = nearest_frames(reading, phase_instants(reading))
    shown = (np.asarray(run.fields["time"])[chosen] - reading.cycles.starts[0]) * 213.7
    apart = (shown - np.arange(phases) / phases + 0.5) % 1.0 - 0.5
    # 74 frames with spread phases: half of their distance, and the tolerance of 0.01 for a later one.
    assert np.abs(apart).max() < 0.03
    assert np.ptp(np.asarray(run.fields["time"])[chosen]) > 2 / 213.7


def test_the_medial_edge_is_the_nearest_point_of_the_surface_at_each_y() -> None:
    points = np.array([[2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [5.0, 1.0, 1.0]])
    faces = np.array([[0, 1, 3], [1, 2, 3]])
    y = np.array([-0.5, 0.0, 0.5, 1.0, 1.75])
    np.testing.assert_allclose(medial_edge(points, faces, y, 1.0), [np.nan, 2.0, 1.5, 1.0, 1.75])
    points[:, 0] *= -1
    np.testing.assert_allclose(medial_edge(points, faces, y, -1.0), [np.nan, -2.0, -1.5, -1.0, -1.75])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (213.7004, "213.7"),
        (0.83249, "0.8325"),
        (0.8, "0.8"),
        (-0.16864, "−0.1686"),
        (1200.0, "1200"),
        (0.0, "0"),
        (3.14e-9, "3.14 × 10⁻⁹"),
        (-2.5e12, "−2.50 × 10¹²"),
        (float("nan"), "–"),
    ],
)
def test_numbers_read_as_people_write_them(value: float, text: str) -> None:
    assert number(value) == text


def test_measures_read_in_the_units_of_the_field() -> None:
    flow = row(Measure("peak_flow", 5.293e-4, 3.1e-6, 7, cautions=("changing",)))
    assert (flow.label, flow.value, flow.unit, flow.spread, flow.cycles) == (
        "Peak flow",
        "529.3",
        "ml/s",
        "3.1",
        "7",
    )
    assert flow.cautions == ("changing",)
    none = row(Measure("open_quotient", None, note="no oscillation"))
    assert (none.value, none.unit, none.spread, none.cycles) == ("–", "", "", "")
    assert none.note == "no oscillation"  # and no definition of what is not there
    phase = row(Measure("left_right_phase", np.pi))
    assert (phase.value, phase.unit) == ("180", "°")
    assert row(Measure("contact_impulse", 2e-6)).unit == "µN s"
    assert row(Measure("amplitude_left", 12.0, scale=Scale("px"))).unit == "px"


def test_every_measure_is_listed_under_its_group() -> None:
    found = measure(base.run())
    assert {line.name for _, rows in tables(found) for line in rows} == set(found)
