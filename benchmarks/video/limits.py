"""What `plica video` measures of a glottis that is known, over ranges of noise and blur.

    python -m benchmarks.video.limits                    both parts
    python -m benchmarks.video.limits --part modes       planted modes alone: seconds

Glottis: the synthetic glottis, 256 x 256, 90 frames, 21.1 frames a cycle, the right fold swinging less and
leading by 0.6 rad, colliding; stored in 8 bits and taken through the steps of `plica video --no-drift`.
Errors of what its page says are found minus true, the largest of --seeds recordings that differ in noise
and texture; limits in the head, and bold what is beyond. Held: how many of the intervals of these measures,
of all recordings, hold the truth; beside it, of the open quotient, half of the interval's width, and the
median over these measures of half of the width over the error. Overlap: intersection over union of found and
true mask, the least of the frames at half of the largest area or more. Flow: mean distance from the true
flow on tissue, preset video, every second pair of the first cycle. Blur found: at the edges of the glottis
(plica.video.glottis.edge_blur); said: in how many recordings its doubt is.

Modes: three orthonormal patterns W with coefficients that are orthogonal in time, so that their variances are
l_1, l_2, l_3 exactly, and white noise of sigma px on each component of each flow. With N flows of n numbers
and g = n / (N - 1),

    all variance     l_1 + l_2 + l_3 + n sigma^2
    variance k       (l + sigma^2) (l + g sigma^2) / l,            l = l_k
    cos^2 of angle   (l^2 - g sigma^4) / (l (l + g sigma^2)),      between found and planted pattern k

where l > sqrt(g) sigma^2; below, the mode is lost among the noise's, whose variances lie between
sigma^2 (sqrt(g) - 1)^2 and sigma^2 (sqrt(g) + 1)^2 (Marchenko and Pastur). The last two are the limit of
large N and n at fixed g (Benaych-Georges and Nadakuditi, "The singular values and vectors of low rank
perturbations of large rectangular random matrices", 2012). In words: noise puts g sigma^2 into each of N - 1
directions; a leading mode keeps its variance and gains (1 + g) sigma^2, and loses share only to the many
small ones.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.measures.measure import Measures
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.files.recording import Recording
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures.waveforms import measures
from plica.video.motion.flow import flow
from plica.video.motion.frame_content import Seen, informing
from plica.video.motion.modes import modes
from plica.video.settings import Settings

FPS = 4000.0
FRAMES = 90
NOISE, BLUR = 2.0, 0.8  # where the other one is varied
NOISES = (0.0, 2.0, 10.0, 20.0)  # grey levels
BLURS = (0.0, 0.8, 1.5, 2.5)  # px
PAIRS = range(1, 22, 2)
COLUMNS = {  # measure: head, limit, digits
    "glottal_area_mean": ("mean area (%)", 2.0, 1),
    "amplitude_left": ("left amplitude (px)", 0.25, 2),
    "amplitude_right": ("right amplitude (px)", 0.25, 2),
    "fundamental_frequency": ("f0 (Hz)", 2.0, 1),
    "left_right_phase": ("phase (rad)", 0.1, 3),
    "open_quotient": ("open quotient", 0.02, 3),
}
WIDTHS = ("open quotient's half width", "half width over error")
SIGMAS = (0.0, 0.05, 0.2, 0.8, 3.2)  # px
VARIANCES = np.array([0.75, 0.2, 0.05]) * 1000.0  # px^2, summed over the frame


@dataclass
class Errors:
    """Of one recording."""

    measured: np.ndarray  # of COLUMNS
    held: int  # of their intervals
    halves: np.ndarray  # of COLUMNS: half of the interval's width, in the measure's unit
    ratios: np.ndarray  # the same over the error
    overlap: float  # least, of the masks at half of the largest area or more
    flow: float  # px
    blur: float  # px, found at the glottis' edges
    warned: bool  # of blur


def errors(options: Synthetic, folder: Path) -> Errors:
    glottis = SyntheticGlottis(options)
    np.save(folder / "glottis.npy", glottis.stack())
    settings = Settings(fps=FPS, correct_drift=False)
    analysis = analyse(folder / "glottis.npy", folder / "found", settings, until="glottis", progress=False)
    found, values = [analysis.mask(t) for t in range(FRAMES)], analysis.measures
    truth = np.array([glottis.area(t) for t in range(FRAMES)])
    held = against(values, exactly(glottis, truth))
    total = truth.sum(axis=1)
    wide = np.flatnonzero(total > 0.5 * total.max())
    overlap = min((found[t] & glottis.mask(t)).sum() / (found[t] | glottis.mask(t)).sum() for t in wide)
    recording = Recording.open(folder / "glottis.npy")
    warned = any("edges of the glottis are blurred" in doubt for doubt in analysis.doubts)
    missed = flow_error(glottis, recording, found)
    return Errors(*held, float(overlap), missed, float(analysis["sides/blur"]), warned)


def against(values: Measures, exact: dict[str, float]) -> tuple[np.ndarray, int, np.ndarray, np.ndarray]:
    """Measures against the truth, of COLUMNS: errors (of the area in %), how many intervals hold it, half of
    their widths, these over the errors."""
    error = np.array([float(values[name].value) - value for name, value in exact.items()])
    ends = np.array([values[name].interval for name in exact]).T
    truth = np.array(list(exact.values()))
    held = int(np.sum((ends[0] <= truth) & (truth <= ends[1])))
    half = (ends[1] - ends[0]) / 2
    unit = np.array([100 / value if name == "glottal_area_mean" else 1.0 for name, value in exact.items()])
    return error * unit, held, half * unit, half / np.maximum(np.abs(error), 1e-12)


def widths(halves: list[np.ndarray], ratios: list[np.ndarray]) -> list[str]:
    """The cells of WIDTHS: mean of the first, median of the second."""
    return [f"{np.mean([one[-1] for one in halves]):.3f}", f"{np.median(ratios):.2g}"]


def exactly(glottis: SyntheticGlottis, area: np.ndarray) -> dict[str, float]:
    """The true measures of COLUMNS."""
    options = glottis.options
    rows = np.linspace(0.45, 0.55, 21) * (0.85 - 0.15) * options.height + 0.15 * options.height
    edges = [np.array([glottis.edge(side, rows, t).mean() for t in range(options.frames)]) for side in (0, 1)]
    true, _ = measures(GlottalArea(area[:, 0], area[:, 1], *edges), FPS)
    exact = {name: float(true[name].value) for name in COLUMNS}
    exact["fundamental_frequency"] = options.frequency * FPS
    exact["left_right_phase"] = options.phase[0] - options.phase[1]
    return exact


def flow_error(glottis: SyntheticGlottis, recording: Recording, found: list[np.ndarray]) -> float:
    distances = []
    for t in PAIRS:
        one, two = recording.frame(t), recording.frame(t + 1)
        seen, then = Seen(one, found[t]), Seen(two, found[t + 1])
        there = flow(one, two, preset="video", mask=informing(seen, then), intensity=(0.0, 255.0)).flow
        truth, known = glottis.flow(t, t + 1)
        distances.append(np.hypot(*np.moveaxis(there - truth, -1, 0))[seen.tissue & known].mean())
    return float(np.mean(distances))


def glottis_table(seeds: int) -> None:
    heads = [f"{head}, limit {limit:g}" for head, limit, _ in COLUMNS.values()]
    columns = ["noise (grey)", "blur (px)", *heads, "intervals held", *WIDTHS, "masks' overlap", "flow (px)"]
    columns += ["blur found (px)", "said"]
    record("video_limits", columns, glottis_rows(seeds))


def glottis_rows(seeds: int) -> Iterator[list[str]]:
    shape = {"frames": FRAMES, "frequency": 0.0473, "amplitude": (9, 7), "phase": (0.0, 0.6)}
    for noise, blur in dict.fromkeys(chain(((s, BLUR) for s in NOISES), ((NOISE, b) for b in BLURS))):
        found = []
        for seed in range(1, seeds + 1):
            with tempfile.TemporaryDirectory() as folder:
                found.append(errors(Synthetic(**shape, noise=noise, blur=blur, seed=seed), Path(folder)))
        measured = np.array([one.measured for one in found])
        worst = measured[np.abs(measured).argmax(axis=0), range(len(COLUMNS))]
        cells = [f"{noise:g}", f"{blur:g}"]
        for value, (_, limit, digits) in zip(worst, COLUMNS.values(), strict=True):
            cell = f"{value:+.{digits}f}"
            cells.append(f"**{cell}**" if abs(value) > limit else cell)
        cells.append(f"{sum(one.held for one in found)} of {seeds * len(COLUMNS)}")
        cells += widths([one.halves for one in found], [one.ratios for one in found])
        cells += [f"{min(one.overlap for one in found):.2f}", f"{max(one.flow for one in found):.3f}"]
        cells += [
            f"{np.mean([one.blur for one in found]):.2f}",
            f"{sum(one.warned for one in found)} of {seeds}",
        ]
        yield cells


def planted(frames: int = 60, size: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (frames, 3) px and patterns (3, size, size, 2), orthogonal both."""
    y, x = (np.mgrid[0:size, 0:size] - (size - 1) / 2) / size
    bell = np.exp(-20 * x**2 - 8 * y**2)
    one = np.stack([np.sign(x) * bell, 0 * bell], axis=-1)  # the folds part
    two = np.stack([bell, 0 * bell], axis=-1)  # they swing to one side
    three = np.stack([np.sign(x) * np.sin(2 * np.pi * y) * bell, 0 * bell], axis=-1)  # front against back
    patterns = np.stack([w / np.linalg.norm(w) for w in (one, two, three)])
    angle = 2 * np.pi * np.arange(frames) / 20
    time = np.stack([np.sin(angle), np.cos(angle), np.sin(2 * angle)], axis=1)
    return time / time.std(axis=0, ddof=1) * np.sqrt(VARIANCES), patterns


def predicted(sigma: float, frames: int, numbers: int) -> tuple[np.ndarray, np.ndarray]:
    """Shares (3) and angles (3, rad) of the planted modes under noise."""
    g, s2 = numbers / (frames - 1), sigma**2
    lost = np.sqrt(g) * s2 >= VARIANCES
    variance = (VARIANCES + s2) * (VARIANCES + g * s2) / VARIANCES
    cosine2 = (VARIANCES**2 - g * s2**2) / (VARIANCES * (VARIANCES + g * s2))
    variance = np.where(lost, s2 * (1 + np.sqrt(g)) ** 2, variance)
    angle = np.arccos(np.sqrt(np.where(lost, 0.0, cosine2)))
    return variance / (VARIANCES.sum() + numbers * s2), angle


def modes_table() -> None:
    time, patterns = planted()
    flows = np.tensordot(time, patterns, 1)
    rms = np.sqrt(VARIANCES.sum() / flows[0].size)
    columns = ["sigma (px)", "noise's part of all variance", "shares found", "predicted"]
    columns += ["angles to the planted ones (rad)", "predicted"]
    note = f"{len(flows)} flows of {flows[0].size} numbers, root mean square {rms:.2f} px."
    record("video_modes", columns, modes_rows(flows, patterns), note)


def modes_rows(flows: np.ndarray, patterns: np.ndarray) -> Iterator[list[str]]:
    frames, numbers = flows.shape[0], flows[0].size
    for sigma in SIGMAS:
        random = np.random.default_rng(3)
        found = modes(flows + sigma * random.standard_normal(flows.shape), 3)
        overlap = np.tensordot(found.patterns, patterns, ((1, 2, 3), (1, 2, 3)))
        angle = np.arccos(np.minimum(1.0, np.abs(np.diag(overlap))))
        share, turned = predicted(sigma, frames, numbers)
        noise = numbers * sigma**2 / (VARIANCES.sum() + numbers * sigma**2)
        cells = [f"{sigma:g}", f"{noise:.4f}"]
        cells += [", ".join(f"{value:.4f}" for value in row) for row in (found.share, share)]
        yield cells + [", ".join(f"{value:.3f}" for value in row) for row in (angle, turned)]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--part", choices=("both", "glottis", "modes"), default="both")
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    if options.part != "modes":
        glottis_table(options.seeds)
    if options.part != "glottis":
        modes_table()


if __name__ == "__main__":
    main()
