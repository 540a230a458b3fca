"""lambda by criteria that need no truth, where the best lambda is known: the synthetic glottis.

    python -m benchmarks.flow.lambda_choice --preset video

For each recording (160 x 160 px; noise, grain and contrast of the texture as named) the lambda with the least
mean distance from the true flow of all tissue, of a ladder of factors of 2 about the preset's, and what the
criteria of `plica video --lambda-report` choose from the frames alone, each with its error over the least.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.motion.flow import PRESETS, flow
from plica.video.motion.frame_content import Seen, informing
from plica.video.motion.smoothness import CRITERIA, SmoothnessPair, lambda_report, noise_level

GLOTTIS = {"height": 160, "width": 160, "amplitude": (6, 5), "opening": (3, 3), "highlights": 0}
RECORDINGS = {
    "noise 1": Synthetic(**GLOTTIS, noise=1.0, seed=81),
    "noise 2": Synthetic(**GLOTTIS, noise=2.0, seed=82),
    "noise 5": Synthetic(**GLOTTIS, noise=5.0, seed=83),
    "noise 10": Synthetic(**GLOTTIS, noise=10.0, seed=84),
    "noise 2, contrast 8": Synthetic(**GLOTTIS, noise=2.0, texture=8.0, seed=85),
    "noise 5, grain 4": Synthetic(**GLOTTIS, noise=5.0, grain=4.0, seed=86),
}
TIMES = (2, 9, 16)


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--preset", choices=tuple(PRESETS), default="video")
    preset = parser.parse_args().preset
    plica.set_threads(1)
    heads = ("recording", "noise found", "best lambda (its error)", "the preset's")
    own = PRESETS[preset].smoothness
    note = f"Preset `{preset}`, lambda {own:g}; beside each lambda its error over the least."
    record("flow_lambda", [*heads, *CRITERIA], rows(preset), note)


def rows(preset: str) -> Iterator[list[str]]:
    """A row for each recording."""
    ladder = PRESETS[preset].smoothness * 2.0 ** np.arange(-5, 6)
    for name, options in RECORDINGS.items():
        glottis = SyntheticGlottis(options)
        frames = {t: glottis.frame(t) for k in TIMES for t in (k, k + 1)}
        noise = float(np.median([noise_level(frame) for frame in frames.values()]))
        pairs, known = [], []
        for t in TIMES:
            one, two = (Seen(frames[k], glottis.mask(k)) for k in (t, t + 1))
            pairs.append(SmoothnessPair(one.frame, two.frame, informing(one, two), one.tissue, noise))
            known.append(glottis.flow(t, t + 1))

        def error(smoothness: float, pairs: list[SmoothnessPair] = pairs, known: list = known) -> float:
            off = []
            for pair, (truth, there) in zip(pairs, known, strict=True):
                found = flow(
                    pair.first,
                    pair.second,
                    preset=preset,
                    mask=pair.told,
                    intensity=(0.0, 255.0),
                    smoothness=smoothness,
                ).flow
                off.append(np.hypot(*np.moveaxis(found - truth, -1, 0))[pair.counted & there].mean())
            return float(np.mean(off))

        errors = np.array([error(value) for value in ladder])
        least = float(errors.min())
        report = lambda_report(pairs, preset, ladder)
        cells = [
            "none" if value is None else f"{value:.3g}, {error(value) / least:.2f}"
            for value in (report.chosen[criterion] for criterion in CRITERIA)
        ]
        kept = error(PRESETS[preset].smoothness) / least
        yield [name, f"{noise:.1f}", f"{ladder[errors.argmin()]:.3g} ({least:.3f} px)", f"{kept:.2f}", *cells]


if __name__ == "__main__":
    main()
