"""lambda by criteria that need no truth: what they are made of, and where they lead if it is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plica.commands import smoothness as smoothness_command
from plica.commands.main import main
from plica.errors import InvalidInput
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.errors import VideoError
from plica.video.glottis.midline import Midline
from plica.video.motion import smoothness
from plica.video.motion.flow import PairFlow, flow
from plica.video.motion.fold_edges import Folds
from plica.video.motion.frame_content import Seen, informing
from plica.video.motion.smoothness import (
    CRITERIA,
    LambdaReport,
    SmoothnessPair,
    _corner,
    _crossing,
    _lowest,
    lambda_report,
    noise_level,
)

NOISE = 4.0
GLOTTIS = SyntheticGlottis(
    Synthetic(height=72, width=72, amplitude=(4, 4), opening=(3, 3), noise=NOISE, highlights=0)
)
LADDER = (0.02, 0.08, 0.3, 1.2, 5.0)


def pair(t: int = 3) -> SmoothnessPair:
    one, two = (Seen(GLOTTIS.frame(k), GLOTTIS.mask(k)) for k in (t, t + 1))
    return SmoothnessPair(one.frame, two.frame, informing(one, two), one.tissue, NOISE)


def still() -> SmoothnessPair:
    """One picture twice, with noise of its own each time."""
    random = np.random.default_rng(5)
    clean = SyntheticGlottis(replace(GLOTTIS.options, noise=0.0)).frame(3)
    frames = [clean + NOISE * random.standard_normal(clean.shape) for _ in range(2)]
    tissue = np.ones(clean.shape, bool)
    return SmoothnessPair(*frames, tissue, tissue, NOISE)


@pytest.mark.parametrize("noise", [2.0, 5.0, 10.0])
def test_noise_is_told_from_tissue(noise: float) -> None:
    glottis = SyntheticGlottis(replace(GLOTTIS.options, height=160, width=160, noise=noise))
    assert noise_level(glottis.frame(3)) == pytest.approx(noise, rel=0.15)


def test_noise_of_a_shade_is_not_nothing() -> None:
    y, x = np.mgrid[0:32, 0:32].astype(float)
    assert noise_level(3 * x + 2 * y + 0.1 * x * y) == pytest.approx(0.1)  # the least


def test_without_motion_noise_alone_makes_the_residual() -> None:
    said = lambda_report([still()], "video", (0.3, 1.0, 3.0, 10.0, 100.0))
    assert said.expected[-1] == pytest.approx(NOISE * np.sqrt(2), rel=0.05)
    assert said.residual[-1] == pytest.approx(said.expected[-1], rel=0.05)


def test_a_flow_too_stiff_to_follow_noise_has_no_trace() -> None:
    said = lambda_report([still()], "video", (10.0, 20.0, 40.0, 80.0, 160.0))
    assert said.validation[-1] == pytest.approx(said.residual[-1] ** 2, rel=0.03)


def test_the_curves_go_with_lambda_as_they_must() -> None:
    said = lambda_report([pair()], "video", LADDER)
    assert (np.diff(said.roughness) < 0).all()
    assert said.residual[-1] > said.residual[0]
    assert (said.validation[:2] > said.residual[:2] ** 2).all()  # a loose fit follows noise


def test_cross_validation_comes_near_the_best_lambda() -> None:
    given = pair()
    truth, known = GLOTTIS.flow(3, 4)

    def error(smoothness: float) -> float:
        found = flow(
            given.first,
            given.second,
            preset="video",
            mask=given.told,
            intensity=(0.0, 255.0),
            smoothness=smoothness,
        ).flow
        return float(np.hypot(*np.moveaxis(found - truth, -1, 0))[known & given.counted].mean())

    least = min(map(error, LADDER))
    chosen = lambda_report([given], "video", LADDER).chosen["cross-validation"]
    assert chosen is not None
    assert error(LADDER[0]) > 1.5 * least  # it matters
    assert error(chosen) < 1.3 * least


def test_the_corner_of_a_curve_that_has_one() -> None:
    steps = 2.0 ** np.arange(-6, 7)
    assert _corner(steps, 1 + steps, 1 + 1 / steps) == pytest.approx(1.0)
    assert _corner(steps, steps / (1 + steps), 1 / (1 + steps)) is None  # bent the other way


def test_where_noise_explains_the_residual() -> None:
    steps = np.array([1.0, 2.0, 4.0, 8.0])
    assert _crossing(steps, np.array([0.8, 0.9, 1.1, 1.2])) == pytest.approx(2 * np.sqrt(2))
    assert _crossing(steps, np.array([1.1, 1.2, 1.3, 1.4])) is None
    twice = np.array([0.8, 1.2, 0.9, 1.1])
    assert _crossing(steps, twice) == pytest.approx(4 * np.sqrt(2))  # the last time


def test_the_least_of_a_curve_lies_between_the_lambdas_of_the_ladder() -> None:
    steps = 2.0 ** np.arange(6)
    assert _lowest(steps, 7 + np.log(steps / 3) ** 2) == pytest.approx(3.0)
    assert _lowest(steps, steps) is None  # at an end: the least may lie beyond
    assert _lowest(steps, -steps) is None


def test_noise_that_the_steadying_takes_away_is_not_expected() -> None:
    given, ladder = still(), (10.0, 20.0, 40.0, 80.0, 160.0)
    plain = lambda_report([given], "video", ladder).expected
    halved = replace(given, seen=lambda one, two: (0.5 * one, 0.5 * two))
    assert lambda_report([halved], "video", ladder).expected == pytest.approx(0.5 * plain)


def test_each_flow_is_told_what_the_recordings_was(monkeypatch: pytest.MonkeyPatch) -> None:
    line = Midline((GLOTTIS.midline, 5), (GLOTTIS.midline, 67))
    given = replace(pair(), folds=Folds(GLOTTIS.mask(3), GLOTTIS.mask(4), line))
    told: list[dict[str, Any]] = []

    def listening(*frames: Any, **options: Any) -> PairFlow:
        told.append(options)
        return flow(*frames, **options)

    monkeypatch.setattr(smoothness, "flow", listening)
    lambda_report([given], "fast", LADDER)
    assert sorted({options["smoothness"] for options in told}) == list(LADDER)
    for options in told:
        assert options["mask"] is given.told
        assert options["folds"] is given.folds
        assert options["preset"] == "fast"


def test_nothing_to_choose_by_is_refused() -> None:
    with pytest.raises(InvalidInput, match="0 pairs of frames, 0 without tissue; must be one or more"):
        lambda_report([])
    blind = replace(pair(), counted=np.zeros((72, 72), bool))
    with pytest.raises(InvalidInput, match="1 pairs of frames, 1 without tissue"):
        lambda_report([blind])
    with pytest.raises(
        InvalidInput, match=r"ladder = \[1.0, 0.5\]; must be 5 or more numbers above 0 that rise"
    ):
        lambda_report([pair()], "video", (1.0, 0.5))
    with pytest.raises(InvalidInput, match=r'lambda_report: preset = "vidoe"; must be one of robust,'):
        lambda_report([pair()], "vidoe")


def test_pairs_count_alike_in_squares() -> None:
    given = pair(3), replace(pair(6), noise=2 * NOISE)
    apart = [lambda_report([one], "fast", LADDER) for one in given]
    both = lambda_report(given, "fast", LADDER)
    for name in ("residual", "expected", "roughness"):
        squares = [getattr(one, name) ** 2 for one in apart]
        assert getattr(both, name) ** 2 == pytest.approx(np.mean(squares, axis=0))
    assert both.noise == pytest.approx(NOISE * np.sqrt(2.5))


CURVE = np.arange(1.0, 6.0)
REPORT = LambdaReport(
    "fast", 0.5, CURVE, CURVE, CURVE, CURVE, CURVE, {**dict.fromkeys(CRITERIA), "L-curve": 3.0}, NOISE
)


def test_the_report_says_where_a_criterion_chooses_nothing() -> None:
    rows = str(REPORT).splitlines()
    assert rows[1] == "discrepancy       no such lambda in the ladder"
    assert rows[2] == "L-curve           3"
    assert rows[4] == "noise             4.00 grey levels"
    assert len(rows) == 7 + CURVE.size


class Found(dict[str, Any]):
    """What of an analysis the command asks for."""

    def __init__(self, directory: Path, residual: list[float]) -> None:
        super().__init__({"flow/residual": np.array(residual)})
        self.directory, self.settings = directory, SimpleNamespace(preset="fast")


def test_the_command_takes_four_pairs_from_the_first_that_shows_tissue_to_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(smoothness_command, "_pair", lambda found, k: k)
    taken: list[int] = []

    def reported(pairs: list[int], preset: str) -> LambdaReport:
        assert preset == "fast"
        taken.extend(pairs)
        return REPORT

    monkeypatch.setattr(smoothness_command, "lambda_report", reported)
    found = Found(tmp_path, [np.nan, *[1.0] * 10, np.nan])
    assert smoothness_command.report_lambda(found) is REPORT  # type: ignore[arg-type]
    assert taken == [1, 4, 7, 10]
    blind = Found(tmp_path, [np.nan] * 3)
    with pytest.raises(VideoError, match="Lambda: no pair of frames shows tissue; must be one at least"):
        smoothness_command.report_lambda(blind)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws", "unrendered")
def test_the_command_says_it_beside_the_presets_lambda(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = Synthetic(height=64, width=64, frames=40, frequency=0.1, amplitude=(5, 5), opening=(2, 2))
    np.save(tmp_path / "film.npy", SyntheticGlottis(options).stack())
    where = tmp_path / "out"
    arguments = ["video", str(tmp_path / "film.npy"), "--preset", "fast", "--no-drift", "--lambda-report"]
    assert main([*arguments, "-o", str(where)]) == 0
    said = json.loads((where / "lambda.json").read_text())
    assert said["used"] == 0.045
    assert said["preset"] == "fast"
    assert set(said["chosen"]) == {"discrepancy", "L-curve", "cross-validation"}
    assert len(said["curves"]["residual"]) == len(said["curves"]["smoothness"]) == 11
    assert 1.0 < said["noise"] < 3.0
    assert "the flow was found with 0.045, that of fast" in capsys.readouterr().out
