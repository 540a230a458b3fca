"""``plica video --lambda-report``: what three criteria say of lambda, in words and as lambda.json."""

from __future__ import annotations

import json

import numpy as np

from plica.storage.files import write_text
from plica.video.analysis import Analysis
from plica.video.errors import VideoError
from plica.video.files.recording import Grey
from plica.video.glottis.midline import Midline
from plica.video.motion.drift import without_drift
from plica.video.motion.fold_edges import Folds
from plica.video.motion.frame_content import Seen, informing
from plica.video.motion.smoothness import LambdaReport, SmoothnessPair, lambda_report, noise_level

__all__ = ["report_lambda"]

_PAIRS = 4


def report_lambda(found: Analysis) -> LambdaReport:
    """Of four pairs of frames, spread over the recording; writes lambda.json beside the results.

    Raises
    ------
    VideoError
        Where no pair of frames shows tissue, or the recording is not there any more.
    """
    seen = np.flatnonzero(np.isfinite(found["flow/residual"]))
    if not seen.size:
        raise VideoError("Lambda: no pair of frames shows tissue; must be one at least. Is it the larynx?")
    chosen = np.unique(seen[np.linspace(0, seen.size - 1, _PAIRS).round().astype(int)])
    said = lambda_report([_pair(found, int(k)) for k in chosen], found.settings.preset)
    text = json.dumps(said.as_dict(), indent=1) + "\n"
    write_text(text, found.directory / "lambda.json")
    return said


def _pair(found: Analysis, k: int) -> SmoothnessPair:
    steady = found.frames()
    before, after = (Seen(steady.frame(n), found.mask(n)) for n in (k, k + 1))
    noise = np.median([noise_level(frame) for frame in steady.recording.frames(k, k + 2)])
    motion = steady.motion[k : k + 2]

    def steadied(one: Grey, two: Grey) -> tuple[Grey, Grey]:
        first, second = without_drift([one, two], motion)
        return first, second

    return SmoothnessPair(
        before.frame,
        after.frame,
        informing(before, after),
        before.tissue,
        float(noise),
        Folds(before.glottis, after.glottis, Midline.of(found["flow/midline"])),
        steadied,
    )
