"""The uncertainty of a settled voice: levels begin in its orbit and go on until they settle."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import plica
from conftest import THESIS_TISSUE, TINY_LARYNX
from plica.measures.cycles import Cycles
from plica.uncertainty import estimate
from plica.uncertainty.level import PlannedLevel
from plica.uncertainty.sample import Sampled


@pytest.fixture(scope="module")
def voice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The directory of a voice of a very coarse larynx that has settled."""
    scene = plica.Scene(
        plica.Larynx(larynx="thesis_coarse", options=plica.LarynxOptions(**TINY_LARYNX)),
        {layer: plica.Tissue(**fields) for layer, fields in THESIS_TISSUE.items()},
        time=plica.Stepping(step="0.1 ms", duration="0.15 s"),
        airflow=plica.Airflow(subglottal_pressure="1.55 kPa", area=plica.Cut(sections=40)),
        contact=plica.Multipliers(),
        initial=plica.Initial(opening_velocity=0.1),
        output=plica.Output(checkpoint_every="50 ms"),
    )
    directory = tmp_path_factory.mktemp("voice") / "run"
    plica.run(scene, directory, progress=False)
    return directory


def test_levels_of_a_settled_voice_begin_in_its_orbit(voice: Path) -> None:
    found = plica.estimate_uncertainty(voice, mesh="none", progress=False)
    run = plica.Run.load(voice)
    frequency = found.measures["fundamental_frequency"]
    assert frequency.value == run.measures["fundamental_frequency"].value
    assert frequency.step is not None
    assert set(frequency.step.values) == {"run", "step-2", "step-4"}
    assert found.waveforms == {}
    assert "from the steady vibration at 150" in found.source
    assert "kinetic_energy" not in found.measures  # of the end of the run alone
    # a voice at the edge of contact: at smaller steps its folds do not touch
    assert found.measures["contact_impulse"].numerical is None
    assert any("contact_impulse" in remark for remark in found.remarks)
    assert all(level["steps"] < 2 * run.steps for level in found.levels)
    from_rest = plica.run(run.scene.replace({"time.step": "50 us"}), voice / "half", progress=False)
    assert frequency.step.values["step-2"] == pytest.approx(
        from_rest.measures["fundamental_frequency"].value, rel=5e-3
    )


def test_a_voice_continues_where_it_was_stopped_at_the_same_state(voice: Path) -> None:
    first = plica.estimate_uncertainty(voice, mesh="none", progress=False)
    for slot in voice.glob("checkpoint-*.h5"):
        slot.unlink()  # the state is kept with the levels
    for left in (voice / "uncertainty" / "orbit-step-2").iterdir():
        left.unlink()
    again = plica.estimate_uncertainty(voice, mesh="none", progress=False)
    assert again.measures == first.measures


@pytest.mark.slow
def test_a_voice_that_continues_has_a_state_and_levels_of_its_own(voice: Path, tmp_path: Path) -> None:
    longer = tmp_path / "run"
    shutil.copytree(voice, longer)
    plica.estimate_uncertainty(longer, mesh="none", budget=0.0, progress=False)
    with h5py.File(longer / "uncertainty" / "start.h5") as file:
        before = float(file["time"][()])
    energy = plica.Run.load(longer / "uncertainty" / "orbit-step-2").waveforms["kinetic_energy"][0]
    mine = longer / "uncertainty" / "orbit-notes"
    mine.mkdir()
    plica.run(
        plica.Run.load(longer).scene.replace({"time.duration": "0.2 s"}), longer, resume=True, progress=False
    )
    found = plica.estimate_uncertainty(longer, mesh="none", budget=0.0, progress=False)
    with h5py.File(longer / "uncertainty" / "start.h5") as file:
        after = float(file["time"][()])
    assert before < 0.2 <= after
    level = plica.Run.load(longer / "uncertainty" / "orbit-step-2")
    assert level.waveforms["kinetic_energy"][0] != energy  # it began anew
    assert f"from the steady vibration at {1e3 * after:.4g} ms" in found.source
    assert mine.is_dir()


@pytest.mark.parametrize("settles_after", [1, 2, 3, 9])
def test_a_level_that_has_not_settled_continues_twice_and_no_more(
    settles_after: int, bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lengths: list[int] = []

    class Made:
        def __init__(self, steps: int) -> None:
            self.steps = steps

        def between(self, start: float, end: None) -> Made:
            return self

    def continued(level: PlannedLevel, *parts: Any, **options: Any) -> Any:
        lengths.append(level.scene.time.steps)
        return Made(level.scene.time.steps)

    def sampled(run: Any, *, of_cycles: bool) -> Sampled:
        settled = len(lengths) >= settles_after
        return Sampled(Cycles(np.arange(10.0), verdict="steady" if settled else "changing"), {})

    monkeypatch.setattr(estimate, "_continued", continued)
    monkeypatch.setattr(estimate, "sampled", sampled)
    monkeypatch.setattr(estimate, "fields_of", lambda *parts: (None, None))
    own = Sampled(Cycles(1e-3 * np.arange(10)), {})  # nine cycles of ten steps
    level = PlannedLevel("step-2", "step", 2, bar)
    start: Any = object()
    run: Any = None
    made = estimate._run_level(level, run, own, start, tmp_path, shown=False)
    assert lengths == [40, 130, 220][: min(settles_after, 3)]
    assert made.found.cycles.settled == (settles_after <= 3)


def test_a_second_call_makes_a_level_no_longer_than_the_first(
    bar: plica.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = 40

    class Made:
        @property
        def steps(self) -> int:
            return held

        def between(self, start: float, end: None) -> Made:
            return self

    def continued(level: PlannedLevel, *parts: Any, **options: Any) -> Any:
        nonlocal held
        held = max(held, level.scene.time.steps)
        return Made()

    changing = Sampled(Cycles(np.arange(10.0), verdict="changing"), {})
    monkeypatch.setattr(estimate, "_continued", continued)
    monkeypatch.setattr(estimate, "sampled", lambda run, *, of_cycles: changing)
    monkeypatch.setattr(estimate, "fields_of", lambda *parts: (None, None))
    own = Sampled(Cycles(1e-3 * np.arange(10)), {})
    level = PlannedLevel("step-2", "step", 2, bar)
    start: Any = object()
    run: Any = None
    for _ in range(2):
        estimate._run_level(level, run, own, start, tmp_path, shown=False)
        assert held == 40 + 2 * 90


@pytest.mark.parametrize(("steps", "cycles"), [(1100, 4), (2100, 9)])
def test_the_scatter_of_every_average_is_found_from_few_cycles_and_from_many(steps: int, cycles: int) -> None:
    from analytic_run import Phonation
    from plica.measures.run.measure import measure, steady_cycles
    from plica.uncertainty.sample import _scatter

    run = Phonation(frequency=100.0, steps=steps).run()  # blocks of one cycle, and of two
    found = steady_cycles(run)
    assert found.count == cycles
    means = measure(run, found)
    scatter = _scatter(run, found, means)
    averaged = {name for name, item in means.items() if item.value is not None and item.spread is not None}
    assert {"fundamental_frequency", "period", "open_quotient", "peak_flow"} <= averaged <= scatter.keys()


def test_an_average_that_one_block_alone_has_has_no_statistical_error() -> None:
    from analytic_run import Phonation
    from plica.uncertainty import sample

    run: Any = Phonation(frequency=100.0, steps=2100).run()
    whole = sample.sampled(run, of_cycles=True)
    last = whole.cycles.starts[-2]
    for name in ("contact_force_first", "contact_force_second"):
        run.waveforms[name][run.time < last] = 0.0  # the folds meet in the last cycle alone
    found = sample.sampled(run, of_cycles=True)
    assert found.samples["contact_impulse"].value > 0
    assert found.samples["contact_impulse"].scatter is None
    assert found.samples["fundamental_frequency"] == whole.samples["fundamental_frequency"]


@pytest.mark.parametrize("unknown", ["run", "level"])
def test_a_mean_whose_statistical_error_is_unknown_is_not_compared(unknown: str, bar: plica.Scene) -> None:
    """The values agree by chance: that is no bound of 0."""
    from types import SimpleNamespace

    from plica.measures.measure import Measure
    from plica.uncertainty.comparison import Computed, compared_measures
    from plica.uncertainty.sample import Sample

    def of(scatter: float | None) -> Sampled:
        item = Measure("peak_flow", 4e-4, spread=1e-6, cycles=9)
        return Sampled(Cycles(np.arange(10.0)), {"peak_flow": Sample(item, scatter)})

    run: Any = SimpleNamespace(scene=bar, mesh=SimpleNamespace(cells=np.zeros((6, 4))))
    finer: Any = SimpleNamespace(scene=bar.replace({"time.step": 0.5 * bar.time.step}), mesh=run.mesh)
    level = PlannedLevel("step-2", "step", 2, finer.scene)

    def compared(own: float | None, its: float | None) -> Any:
        return compared_measures(run, of(own), of(own), [Computed(level, finer, of(its))])["peak_flow"]

    known = compared(1e-6, 1e-6)
    assert known.numerical > 0
    assert known.statistical == 1e-6
    found = compared(*((None, 1e-6) if unknown == "run" else (1e-6, None)))
    assert found.numerical is None
    assert found.statistical == (None if unknown == "run" else 1e-6)
    assert found.spread == 1e-6
