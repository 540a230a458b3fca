"""One meaning for every measure: the catalogue, and what reads it."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest

import plica
from analytic_run import AnalyticRun, Phonation, free_vibration
from plica.commands.output import MAIN_MEASURES, measures_table
from plica.errors import InvalidInput
from plica.measures.catalogue import CATALOGUE, catalogue_entry
from plica.measures.cycles import Cycles
from plica.measures.file import write_measures
from plica.measures.measure import Measure, Measures, average, whole
from plica.measures.run.folds import half_widths
from plica.measures.run.measure import measure, steady_cycles
from plica.measures.scale import Scale, shown_unit
from plica.measures.waveforms import RECORDED, STORED
from plica.report.wording import tables
from plica.runs.tubes import tract_response
from plica.units import read_quantity
from plica.video.files.signal_file import Signal
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.glottis.midline import Midline
from plica.video.measures import error_model
from plica.video.measures.signal_measures import signal_measures
from plica.video.measures.wave_measures import wave_measures
from plica.video.measures.waveforms import measures
from plica.video.motion.mucosal_wave import Fundamental

MM_PER_PX = 0.005  # so fine that no edge is uncertain for its pixels
BASE = Phonation(frequency=213.7)
BOTH = {
    name for name, entry in CATALOGUE.items() if entry.source == "both" and entry.recorded_from != "signal"
}
"""What the folds alone tell; of the sound, test_sound_quality.py."""


def filmed(run: AnalyticRun) -> GlottalArea:
    """The same folds, as a recording of one frame a step would have them: areas (px^2), edges (px)."""
    right, left = half_widths(run.waveforms)
    moves_most = int(np.argmax(np.ptp(right + left, axis=0)))
    px = 1e-3 * MM_PER_PX
    right, left = right[:, moves_most] / px, left[:, moves_most] / px
    total = run.waveforms["minimum_area"] / px**2
    share = np.divide(left, left + right, out=np.full(left.size, 0.5), where=total > 0)
    return GlottalArea(share * total, (1 - share) * total, left, right)


def glide(run: AnalyticRun) -> AnalyticRun:
    """The same folds ever faster: nothing settles."""
    bent = 1.0 + 0.3 * run.time / run.time[-1]
    waves = {
        name: np.apply_along_axis(
            lambda one: np.interp(bent * run.time % run.time[-1], run.time, one), 0, wave
        )
        for name, wave in run.waveforms.items()
        if name in ("minimum_area", "flow", "coronal_right", "coronal_left")
    }
    waves["flow_stopped"] = (waves["minimum_area"] <= 0).astype(int)
    return dataclasses.replace(run, waveforms={**run.waveforms, **waves})


VOICES = {
    "closing": BASE.run(),
    "closing on one side first": dataclasses.replace(
        BASE, amplitude_right=0.3e-3, right_phase=0.4, impulse=0.0
    ).run(),
    "asymmetric": dataclasses.replace(
        BASE, gap=0.6e-3, amplitude_left=0.2e-3, amplitude_right=0.1e-3, right_phase=0.4, impulse=0.0
    ).run(),
    "opposite": dataclasses.replace(
        BASE, gap=0.6e-3, amplitude_left=0.3e-3, amplitude_right=0.1e-3, right_phase=np.pi, impulse=0.0
    ).run(),
    "silent": dataclasses.replace(BASE, amplitude_left=0.0, amplitude_right=0.0, impulse=0.0).run(),
    "gliding": glide(BASE.run()),
}


@pytest.fixture(autouse=True)
def _few_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what a recording's intervals stand on, which test_error_model.py has; its values do not."""
    monkeypatch.setattr(error_model, "_DRAWS", 10)


@pytest.mark.parametrize("voice", VOICES)
def test_a_run_and_a_recording_of_the_same_folds_have_the_same_measures(voice: str) -> None:
    run = VOICES[voice]
    simulated = measure(run)
    # A recording has all cycles of a voice, a run the steady ones: here both have those of the run.
    steady = steady_cycles(run)
    same = dataclasses.replace(steady, starts=steady.starts - BASE.step)
    recorded, _ = measures(filmed(run), 1 / BASE.step, MM_PER_PX, 300.0, cycles=same)
    assert simulated.keys() & recorded.keys() == BOTH
    for name in BOTH:
        one, other = simulated[name], recorded[name]
        assert (one.unit, one.cycles, one.cautions) == (other.unit, other.cycles, other.cautions), name
        for value, again in ((one.value, other.value), (one.spread, other.spread)):
            # The recording's time begins a step earlier and its pixels are divided and multiplied again.
            exact = (
                None if value is None else pytest.approx(value, rel=1e-6, abs=1e-9 * abs(one.value or 1.0))
            )
            assert again == exact, name


@pytest.mark.parametrize("run", [free_vibration(), VOICES["closing"]], ids=["free", "phonation"])
def test_what_a_run_has_is_a_runs(run: AnalyticRun) -> None:
    assert all(CATALOGUE[name].source in ("run", "both") for name in measure(run))


def test_every_quantity_is_measured_of_what_the_catalogue_says() -> None:
    rough = dict.fromkeys(("friction_loss", "air_inertial_energy"), np.zeros(BASE.steps))
    tract = tract_response(plica.Tract(vowel={"name": "a"}), plica.Airflow())
    waves = {**VOICES["closing"].waveforms, **rough}
    run = dataclasses.replace(VOICES["closing"], waveforms=waves, vocal_tract=tract)
    simulated = {*measure(run), *measure(free_vibration())}
    recorded = set(measures(filmed(run), length=100.0)[0])
    unseen, line = (
        Fundamental(np.full((9, 9, 2), np.nan), np.full((9, 9, 3), np.nan)),
        Midline((4, 0), (4, 8)),
    )
    recorded |= {item.name for item in wave_measures(unseen, line, np.ones((9, 9), bool), 10.0, 1.0, 1.0)}
    signal, none = Signal(np.zeros(100), 8000.0), Cycles(np.zeros(0), "none", "none", recorded=True)
    recorded |= {item.name for item in signal_measures(signal, signal, np.zeros(9), none, 4e3).measures}
    for source, found in (("run", simulated), ("video", recorded)):
        assert found == {name for name, entry in CATALOGUE.items() if entry.source in (source, "both")}


def test_the_unit_that_people_read_is_of_the_quantitys_dimension() -> None:
    for entry in CATALOGUE.values():
        factor, shown = entry.people()
        if shown != entry.unit:
            text = f"1 {shown}".replace("N s", "N*s")
            assert read_quantity(text, entry.unit) * factor == pytest.approx(1.0), entry.name


def test_a_recording_without_a_scale_is_in_pixels_and_frames() -> None:
    time = np.arange(120.0)
    edge = 8 * np.maximum(0, np.sin(2 * np.pi * time / 15))
    found, _ = measures(GlottalArea(100 * edge, 100 * edge, edge, edge), length=200.0)
    units = {
        "glottal_area_max": "px^2",
        "amplitude_left": "px",
        "period": "frames",
        "left_right_phase": "rad",
    }
    assert {name: found[name].unit for name in units} == units
    assert found["fundamental_frequency"].unit == "1/frame"
    beats = 1 + 0.5 * (np.arange(120) // 15 % 2)
    alternating, _ = measures(GlottalArea(*(beats * edge for _ in range(4))))
    message = " ".join(alternating["fundamental_frequency"].cautions)
    assert "(0.06667 1/frame)" in message
    assert "Hz" not in message
    assert found["amplitude_left"].quantity.people(found["amplitude_left"].scale) == (1.0, "px")
    assert catalogue_entry("deepest_gap").people(Scale("px")) == (1.0, "px")
    assert shown_unit("m") == (1e3, "mm")


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("f0", 'Did you mean "fundamental_frequency"?'),
        ("OQ", 'Did you mean "open_quotient"?'),
        ("peak_flw", 'Did you mean "peak_flow"?'),
        ("nothing like it", "must be one of fundamental_frequency, "),
    ],
)
def test_a_measure_that_is_not_there_is_answered_with_the_nearest(asked: str, message: str) -> None:
    found = measure(VOICES["closing"])
    with pytest.raises(InvalidInput, match=re.escape(message)):
        found[asked]
    with pytest.raises(KeyError, match=rf'^Measures: "{asked}"; must be one of '):
        found[asked]
    assert found.get(asked) is None
    assert asked not in found
    with pytest.raises(InvalidInput, match="unknown"):
        Measure("unknown", 1.0)


def test_the_file_has_definition_note_and_cautions(tmp_path: Path) -> None:
    found = measure(VOICES["gliding"])
    path = write_measures(found, tmp_path / "measures.json")
    entries = json.loads(path.read_text())
    assert "5 % of the cycle's largest" in entries["open_quotient"]["definition"]
    assert entries["amplitude_left"]["note"].startswith("at z = ")
    assert any("not settled" in text for text in entries["fundamental_frequency"]["cautions"])


def test_the_terminal_says_below_a_number_what_speaks_against_it() -> None:
    found = Measures(
        [
            Measure(
                "fundamental_frequency", 278.2, 79.0, 3, cautions=("not settled", "autocorrelation: 331.7 Hz")
            ),
            Measure("open_quotient", 0.61, 0.02, 3, cautions=("not settled",)),
            Measure("speed_quotient", None, note="the folds never close"),
            Measure("contact_impulse", 2.5e-6, 1e-7, 3),
        ]
    )
    text, _, meaning = measures_table(found, short=True).partition("\n\n")
    assert "scatter: standard deviation" in meaning
    lines = [line.split() for line in text.splitlines()]
    assert lines == [
        ["fundamental_frequency", "278", "Hz", "scatter", "of", "3", "cycles", "79", "!"],
        ["!", "not", "settled"],
        ["!", "autocorrelation:", "331.7", "Hz"],
        ["open_quotient", "0.61", "scatter", "of", "3", "cycles", "0.02", "!"],  # said above
        ["speed_quotient", "-", "the", "folds", "never", "close"],
        ["contact_impulse", "2.5", "uN", "s", "scatter", "of", "3", "cycles", "0.1"],
    ]


@pytest.mark.parametrize("short", [True, False])
def test_a_voice_that_does_not_settle_is_not_printed_as_one_that_does(short: bool) -> None:
    message = measures_table(measure(VOICES["gliding"]), short=short)
    steady = measures_table(measure(VOICES["closing"]), short=short)
    assert re.search(r"fundamental_frequency .*!\n    ! not settled", message)
    doubted = ("peak_contact_pressure", "sound_jitter", "sound_shimmer")  # of any run, and of twelve cycles
    steady = "\n".join(line for line in steady.splitlines() if not line.startswith(doubted))
    assert not re.search(r"!\n|not settled", steady)


def test_a_voice_that_is_silent_says_so_once_in_the_short_table() -> None:
    message = measures_table(measure(VOICES["silent"]), short=True)
    assert len(re.findall(r"^\w+ +- +no oscillation", message, re.MULTILINE)) == 1


def test_a_record_that_is_too_short_is_called_so_once() -> None:
    short = "too short: 0 complete cycles of the glottal area; at least 3 are needed"
    thirds = f"over the last third of the record; {short}"
    found = Measures(
        [
            Measure("fundamental_frequency", None, note=short),
            Measure("peak_flow", 2e-4, cautions=(thirds,)),
            Measure("mean_flow", 1e-4, cautions=(thirds,)),
        ]
    )
    for brief in (True, False):
        message = measures_table(found, short=brief)
        assert message.count("too short") == 1
        assert re.findall(r"^ +! (.*)$", message, re.MULTILINE) == ["over the last third of the record"]


def test_a_reason_given_as_a_caution_is_not_reported_again_in_the_short_table() -> None:
    few = "too few cycles"
    found = Measures(
        [Measure("fundamental_frequency", 110.0, cautions=(few,)), Measure("open_quotient", None, note=few)]
    )
    assert measures_table(found, short=True).count(few) == 1
    assert "open_quotient" in measures_table(found)


def test_a_measure_that_has_a_value_keeps_its_note_whatever_others_lack() -> None:
    same = "at z = 1.2 mm"
    found = Measures(
        [Measure("amplitude_left", None, note=same), Measure("amplitude_right", 1e-3, note=same)]
    )
    shown = {row.name: row.note for _, rows in tables(found) for row in rows}
    assert shown["amplitude_left"].startswith(same)
    assert shown["amplitude_right"].startswith(same)


def test_why_measures_have_no_value_is_reported_at_the_first_and_named_by_the_others() -> None:
    short, closed = "too short: 12 samples", "the folds never close"
    found = Measures(
        [
            Measure("fundamental_frequency", None, note=short),
            Measure("period", None, note=short),
            Measure("open_quotient", None, note=closed),
            Measure("amplitude_left", 1e-3, note="at z = 1.2 mm"),
            Measure("amplitude_right", 1e-3, note="at z = 1.2 mm"),
            Measure("speed_quotient", None, note=short),
        ]
    )
    message = dict(re.findall(r"^(\w+) +- +(.*)$", measures_table(found), re.MULTILINE))
    assert message == {
        "fundamental_frequency": short,
        "period": "see fundamental_frequency",
        "open_quotient": closed,
        "speed_quotient": "see fundamental_frequency",
    }
    shown = {row.name: row.note for _, rows in tables(found) for row in rows}
    assert {name: shown[name] for name in message} == {
        "fundamental_frequency": short,
        "period": "see Fundamental frequency",
        "open_quotient": closed,
        "speed_quotient": "see Fundamental frequency",
    }
    assert shown["amplitude_left"].startswith("at z = 1.2 mm; ")
    assert shown["amplitude_right"].startswith("at z = 1.2 mm; ")


def test_the_terminal_shows_the_units_of_the_field() -> None:
    message = measures_table(measure(VOICES["closing"]))
    units = dict(re.findall(r"^(\w+) +\S+ +([a-zA-Z][\w/^]*(?: s)?)(?: |$)", message, re.MULTILINE))
    assert units["contact_impulse"] == "uN s"
    assert units["peak_flow"] == "ml/s"
    assert units["contact_force_left_peak"] == "mN"
    assert units["kinetic_energy"] == "uJ"
    assert units["deepest_gap"] == "um"
    assert units["left_right_phase"] == "deg"


def test_the_main_measures_are_those_of_a_run() -> None:
    assert set(MAIN_MEASURES) <= set(measure(VOICES["closing"]))


def test_no_measure_has_the_name_of_a_waveform_of_another_quantity() -> None:
    shared = (STORED.keys() | RECORDED.keys()) & CATALOGUE.keys()
    # At the end, or over the whole run, of the waveform itself.
    same = {"kinetic_energy", "elastic_energy", "load_work", "viscous_loss", "numerical_loss", "contact_work"}
    same |= {"flow_work", "air_supplied_energy", "air_viscous_energy", "air_inertial_energy"}
    same |= {"subglottal_pressure"}
    assert shared == same | {"friction_loss", "energy_balance_error", "deepest_gap", "largest_multiplier"}
    for name in shared - {"energy_balance_error"}:  # relative, of the run
        assert STORED[name].unit == CATALOGUE[name].unit


def test_no_unit_or_label_of_a_measure_stands_beside_the_catalogue() -> None:
    package = Path(plica.__file__).parent
    labels = {entry.label for entry in CATALOGUE.values() if " " in entry.label}
    literals = re.compile(
        r'\b(?:whole|absent|average|per_cycle|Measure)\([^()]*"(?:m|s|Pa|N|N s|J|Hz|1|rad)"'
    )
    for file in sorted(package.rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        assert not literals.search(text), file
        if file.parent.name != "catalogue" and file.name != "waveforms.py":
            assert not {label for label in labels if f'"{label}"' in text}, file


def test_a_quantity_that_no_cycle_defines_says_so_beside_its_note() -> None:
    assert average("speed_quotient", np.full(3, np.nan), "edges").note == ("edges; undefined in every cycle")


def test_a_scatter_of_more_than_a_hundred_is_a_plain_number() -> None:
    shown = measures_table({"peak_flow": Measure("peak_flow", 430e-6, 154e-6, 3)})
    assert "scatter of 3 cycles 150" in shown


def test_a_value_without_scatter_has_four_digits_and_a_count_all_of_them() -> None:
    found = Measures([whole("energy_balance_error", 8.79387e-10), whole("steps", 1234567.0)])
    assert [line.split()[:2] for line in measures_table(found).splitlines()] == [
        ["energy_balance_error", "8.794e-10"],
        ["steps", "1234567"],
    ]


def test_a_scatter_of_round_off_is_none() -> None:
    (line, *_) = measures_table(Measures([Measure("amplitude_asymmetry", -0.1111, 1.3e-16, 3)])).splitlines()
    assert line.endswith("scatter of 3 cycles 0")
