"""False maxima: an estimate whose residuals fail is begun again, and ends at the highest of its ends."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import plica
from benchmarks.identification.calibration import Drawn
from layered_block import SIZE, correlated_in_time, layered_model, one_number, shown, simulated
from plica.identify import (
    Evaluation,
    Iteration,
    MarginalLikelihood,
    Noise,
    Scoring,
    Settings,
    estimate,
    estimate_from_flow,
    posterior_warnings,
)
from plica.identify.estimator.estimate import estimate_and_evaluation
from plica.identify.estimator.starts import start_points
from plica.identify.estimator.wording import started
from plica.identify.settings import MOST_STARTS

FRAMES = 12


class TwoTops(MarginalLikelihood):
    """Of cover.E, with a top of height 3 that the prior's median leads to, and one of height 30, 1.5 sd away;
    the first frames know the latter alone. The information is that of each top."""

    false, true, sd = 0.1, -1.5, 0.05
    heights = (3.0, 30.0)
    short = False

    def __init__(self, model: Any) -> None:
        super().__init__(model)
        self.asked: list[int] = []

    def of_first(self, share: float) -> MarginalLikelihood:
        found = super().of_first(share)
        self.asked.append(found.model.observation.frames)
        made = TwoTops(found.model)
        made.short = True
        return made

    def density(self, x: float) -> tuple[float, float, float]:
        off = x - self.prior_mean[0]
        width = 10 * self.sd if self.short else self.sd
        nearer_false = not self.short and off > 0.5 * (self.false + self.true)
        d = (off - (self.false if nearer_false else self.true)) / width
        return self.heights[0 if nearer_false else 1] - 0.5 * d * d, -d / width, width**-2

    def evaluate(self, x: ArrayLike) -> Evaluation:
        at = self._point(x)
        value, slope, curvature = self.density(at[0])
        base = super().evaluate(self.prior_mean)
        made = replace(
            base, point=at, value=value, gradient=np.array([slope]), information=np.array([[curvature]])
        )
        self._last = made
        return made

    def evaluate_known(self, x: ArrayLike, responses: Any) -> Evaluation:
        return self.evaluate(x)

    def value(self, x: ArrayLike) -> float:
        return self.density(np.array(x, dtype=float)[0])[0]


def outlying(log_sd: float = 1.0) -> TwoTops:
    """Whose residuals fail their test everywhere, by tails."""
    model = one_number(log_sd)
    flow = np.array(model.observation.flow)
    flow[3:7, 2] += 3.0
    return TwoTops(model.seeing(flow))


def test_of_several_ends_the_most_probable_is_taken() -> None:
    likelihood = outlying()
    seen: list[Iteration] = []
    found, at = estimate_and_evaluation(likelihood, options=Scoring(starts=3), progress=seen.append)
    assert not found.residuals.passed
    assert (found.starts, found.ended_here) == (3, 2)
    assert started(found) == "started 3 times, 2 ended here, 1 at less probable maxima or without convergence"
    assert found.mean[0] == pytest.approx(likelihood.prior_mean[0] + likelihood.true, abs=0.05)
    assert at.point == pytest.approx(found.mean, abs=0.05)
    assert {at.start for at in seen} == {1, 2, 3}
    assert any("false maximum of the density (started 3 times" in text for text in posterior_warnings(found))


def test_starts_that_were_begun_are_not_made_again() -> None:
    """Stopped at the first point of the third start on the whole recording."""
    likelihood = outlying()
    seen: list[Iteration] = []
    whole = estimate(likelihood, options=Scoring(starts=3), progress=seen.append)
    third = next(at for at in seen if at.start == 3 and at.share == 1)
    kept = {at.start: at.point for at in seen if at.share == 1 and at.start < 3} | {3: third.point}
    assert set(kept) == {1, 2, 3}
    again, watched = outlying(), list[Iteration]()
    found = estimate(again, options=Scoring(starts=3), progress=watched.append, kept=kept)
    assert (found.starts, found.ended_here) == (whole.starts, whole.ended_here) == (3, 2)
    assert found.mean == pytest.approx(whole.mean, abs=1e-12)
    assert again.asked == []
    assert {at.share for at in watched} == {1.0}
    assert [at.start for at in watched].count(1) == 1 < [at.start for at in seen].count(1)


def test_a_third_start_is_made_where_two_were_begun() -> None:
    likelihood, seen = outlying(), list[Iteration]()
    ends = {1: likelihood.prior_mean + likelihood.false, 2: likelihood.prior_mean + likelihood.true}
    fresh, resumed = (
        list(islice(start_points(likelihood, ends[1], Scoring(), kept=k), 4)) for k in (None, ends)
    )
    assert resumed[:2] == [ends[1], ends[2]]
    assert np.array_equal(resumed[2:], fresh[2:])
    estimate(likelihood, ends[1], Scoring(starts=3), seen.append, ends)
    assert {at.start for at in seen if at.share < 1} == {3}


@pytest.mark.slow
def test_what_stands_on_a_learned_error_is_no_start_and_continues_where_it_was() -> None:
    likelihood, seen = MarginalLikelihood(one_number(0.5)), list[Iteration]()
    found = estimate_from_flow(likelihood, None, Scoring(), seen.append)[0]
    assert {at.start for at in seen} == {0, 1}
    kept = {1: found.mean, 0: found.mean + 3 * found.sd}
    watched: list[Iteration] = []
    again = estimate_from_flow(likelihood, None, Scoring(), watched.append, kept=kept)[0]
    assert np.array_equal(watched[0].point, kept[1])
    assert np.array_equal(next(at.point for at in watched if at.start == 0), kept[0])
    # each ends within 0.05 sd, on an error that was learned within 0.5 sd
    assert again.mean == pytest.approx(found.mean, abs=0.2 * found.sd[0])


def test_climbs_on_the_first_frames_are_reported_as_they_go() -> None:
    seen: list[Iteration] = []
    found = estimate(outlying(), options=Scoring(starts=3), progress=seen.append)
    assert found.starts == 3
    shares = {start: [at.share for at in seen if at.start == start] for start in (1, 2, 3)}
    assert set(shares[1]) == {1.0}
    assert set(shares[2]) == set(shares[3]) == {0.25, 0.5, 1.0}
    assert shares[2] == sorted(shares[2])
    compared = [at for at in seen if math.isnan(at.step)]
    assert len(compared) == MOST_STARTS - 2
    assert {(at.start, at.share) for at in compared} == {(3, 0.25)}


def test_iterations_of_a_flow_count_none_on_the_first_frames() -> None:
    seen: list[Iteration] = []
    options = Scoring(starts=2)
    found = estimate_from_flow(outlying(), None, options, seen.append, learn=False)[0]
    whole = [at.number for at in seen if at.share == 1]
    assert len(whole) < len(seen)
    assert whole == list(range(len(whole)))
    assert found.iterations == len(whole) - 1


def test_a_later_end_that_is_less_probable_leaves_the_estimate_and_its_evaluation_at_the_best() -> None:
    likelihood = outlying()
    likelihood.heights = (30.0, 3.0)
    found, at = estimate_and_evaluation(likelihood, options=Scoring(starts=2))
    assert (found.starts, found.ended_here) == (2, 1)
    assert found.mean[0] == pytest.approx(likelihood.prior_mean[0] + likelihood.false, abs=0.05)
    assert at.point == pytest.approx(found.mean, abs=0.05)


def test_scanned_tissues_are_even_in_the_prior_and_the_most_probable_ones_of_the_first_frames_come_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = sys.modules["plica.identify.estimator.starts"]
    monkeypatch.setattr(module, "graduated", lambda _likelihood, start, *_: start)
    likelihood = outlying(log_sd=1.3)
    mean, sd = likelihood.prior_mean[0], likelihood.prior_sd[0]
    scanned = np.array(list(start_points(likelihood, likelihood.prior_mean, Scoring())))[2:, 0]
    below = [0.5 * math.erfc(-(x - mean) / sd / math.sqrt(2)) for x in scanned]  # of the prior
    # van der Corput's numbers 1 to 16: all sixteenths, and half of the first
    assert np.sort(below) == pytest.approx([1 / 32, *np.arange(1, 16) / 16], abs=1e-12)
    width = 10 * likelihood.sd
    density = -0.5 * ((scanned - mean - likelihood.true) / width) ** 2 - 0.5 * ((scanned - mean) / sd) ** 2
    assert (np.diff(density) < 0).all()


def test_the_first_quarter_and_half_are_of_the_frames_that_show_something() -> None:
    """7 of 10: the second of them is the third frame, the fourth the sixth."""
    model = one_number(1.0)
    flow = np.array(model.observation.flow)
    flow[[1, 4, 8]] = np.nan
    likelihood = TwoTops(model.seeing(flow))
    next(islice(start_points(likelihood, likelihood.prior_mean, Scoring()), 1, None))
    assert likelihood.asked == [3, 6]


def test_two_starts_that_end_at_one_place_are_enough() -> None:
    likelihood = outlying()
    found = estimate(likelihood, np.array([likelihood.prior_mean[0] - 1.4]), Scoring(starts=5))
    assert not found.residuals.passed
    assert (found.starts, found.ended_here) == (2, 2)


def test_one_start_stays_where_it_ends() -> None:
    likelihood = outlying()
    found = estimate(likelihood, options=Scoring(starts=1))
    assert (found.starts, found.ended_here) == (1, 1)
    assert found.mean[0] == pytest.approx(likelihood.prior_mean[0] + likelihood.false, abs=0.05)
    assert any("which another start may avoid" in text for text in posterior_warnings(found))


def test_nothing_is_restarted_where_the_residuals_pass() -> None:
    found = estimate(MarginalLikelihood(one_number(0.5)), options=Scoring(starts=5))
    assert found.residuals.passed
    assert found.starts == 1


def test_where_the_first_start_has_no_end_another_may_have() -> None:
    likelihood = outlying(log_sd=5.0)
    likelihood.false = 3.5  # more than two steps away
    short = Scoring(max_iterations=2, starts=1)
    with pytest.raises(plica.SolveFailed, match="after 2 iterations"):
        estimate(likelihood, options=short)
    with pytest.raises(plica.SolveFailed, match="after 2 iterations"):
        estimate(outlying(log_sd=5.0), np.array([20.0]), options=short)
    found = estimate(likelihood, options=replace(short, starts=3, longest_step=2.0))
    assert found.mean[0] == pytest.approx(likelihood.prior_mean[0] + likelihood.true, abs=0.05)


def test_starts_that_store_no_energy_are_left_out() -> None:
    """Of a wide prior of nu most tissues of the prior are none."""
    named = [plica.identify.TissueParameter(("cover.nu",), plica.identify.Prior(0.6, 2.0))]
    flow = simulated(layered_model(named, np.ones((FRAMES, 12, 2))), np.random.default_rng(2), pressure=50.0)
    likelihood = MarginalLikelihood(layered_model(named, flow))
    points = list(start_points(likelihood, likelihood.prior_mean, Scoring()))
    assert 2 < len(points) < 18
    assert all(math.isfinite(likelihood.value(x)) for x in points)


def test_a_first_quarter_without_motion_leaves_the_first_end() -> None:
    """Of 12 frames the first 3 are still: no tissue can be compared on them."""
    model = one_number(1.0)
    flow = np.array(model.observation.flow)
    flow[3:7, 2] += 3.0
    flow[: math.ceil(len(flow) / 4)] = 0.0
    likelihood = TwoTops(model.seeing(flow))
    likelihood.true = likelihood.false  # no second end
    assert len(list(start_points(likelihood, likelihood.prior_mean, Scoring()))) == 2
    found = estimate(likelihood, options=Scoring(starts=5))
    assert not found.residuals.passed
    assert found.mean[0] == pytest.approx(likelihood.prior_mean[0] + likelihood.false, abs=0.05)


def test_a_start_that_cannot_be_evaluated_leaves_the_first_end(monkeypatch: pytest.MonkeyPatch) -> None:
    likelihood = outlying()
    first = likelihood.prior_mean
    with pytest.raises(plica.InvalidInput, match="finite numbers"):
        estimate(likelihood, np.full_like(first, np.nan))
    module = sys.modules["plica.identify.estimator.estimate"]
    monkeypatch.setattr(module, "start_points", lambda *_: iter([first, np.full_like(first, np.nan)]))
    found = estimate(likelihood, options=Scoring(starts=2))
    assert (found.starts, found.ended_here) == (2, 1)
    assert found.mean[0] == pytest.approx(first[0] + likelihood.false, abs=0.05)


@pytest.mark.parametrize("frames", [5, 8])
def test_the_first_frames_alone_are_those_before_missing_ones(frames: int) -> None:
    """Later pressures move nothing that is seen: the same likelihood, from a longer sweep."""
    names: list[Any] = ["cover.E", "cover.viscosity"]
    rng = np.random.default_rng(3)
    sd = rng.uniform(0.05, 0.2, (FRAMES, 12, 2))
    flow = simulated(layered_model(names, np.ones((FRAMES, 12, 2))), rng)
    model = layered_model(names, flow, sd=sd, gain_sd=0.5)
    error = replace(correlated_in_time(FRAMES, 3), outliers=rng.uniform(size=(FRAMES, 12)) < 0.1)
    cut = np.array(flow)
    cut[frames:] = np.nan
    for own in (None, error):
        noise = Noise(30.0, 0.9, 0.0, 0.2)
        short = MarginalLikelihood(model, noise, own).of_first(frames / FRAMES)
        missing = MarginalLikelihood(model.seeing(cut), noise, own)
        x = short.prior_mean + 0.1
        assert short.model.steps < missing.model.steps
        assert short.value(x) == pytest.approx(missing.value(x), rel=1e-10)
        assert short.evaluate(x).gradient == pytest.approx(missing.evaluate(x).gradient, rel=1e-6)


def test_a_part_shorter_than_the_lags_of_the_flows_error_is_refused() -> None:
    model = one_number(1.0)
    frames = model.observation.frames
    with pytest.raises(plica.errors.InvalidInput, match="lags"):
        MarginalLikelihood(model, flow_error=correlated_in_time(frames, 3)).of_first(2 / frames)


@pytest.mark.parametrize("share", [0.0, -0.5, 1.1, math.nan])
def test_no_part_is_refused(share: float) -> None:
    with pytest.raises(plica.errors.InvalidInput, match=rf"share = {share:g}; must be in \(0, 1\]"):
        MarginalLikelihood(one_number(1.0)).of_first(share)


def test_a_share_that_floats_exceed_takes_no_frame_more() -> None:
    assert 7 / 25 * 25 > 7
    likelihood = MarginalLikelihood(layered_model(["cover.E"], np.ones((25, 12, 2))))
    assert likelihood.of_first(7 / 25).model.observation.frames == 7


def test_points_stand_at_their_column_and_row() -> None:
    """Those of the grid that the camera, which looks down at the block, was asked for."""
    x, y = np.meshgrid(np.linspace(0.3e-3, 3.7e-3, 3), np.linspace(1e-3, 5e-3, 4))
    asked = shown(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, SIZE[2])]))
    assert not np.allclose(asked, asked[:, ::-1])
    assert one_number(1.0).image_positions == pytest.approx(asked, rel=1e-9)


def test_a_part_of_one_frame_is_too_short() -> None:
    with pytest.raises(plica.errors.InvalidInput, match=r"shape \(1, 12, 2\); must be .* with N >= 2"):
        MarginalLikelihood(one_number(1.0)).of_first(1e-12)


@pytest.mark.slow
def test_a_skipped_cycle_is_left() -> None:
    """A draw of the calibration whose one start ends more than 4 sd away."""
    drawn = Drawn(60, 800.0)
    truth, model = drawn.recording(15086)
    alone = estimate(MarginalLikelihood(model), options=Scoring(starts=1))
    assert not alone.residuals.passed
    assert np.abs((alone.mean - truth) / alone.sd).max() > 4
    found = estimate(MarginalLikelihood(model))
    assert (found.starts, found.ended_here) == (2, 1)
    assert found.residuals.passed
    assert np.abs((found.mean - truth) / found.sd).max() < 4


def test_a_number_of_starts_that_is_none_is_refused() -> None:
    with pytest.raises(plica.InvalidInput, match="starts = 0; must be > 0"):
        Scoring(starts=0)
    for wrong in (0, 19):
        with pytest.raises(plica.SceneError, match="starts"):
            Settings(starts=wrong)
