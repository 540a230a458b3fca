"""Paper C's Table I on the synthetic glottis, whose flow is known: lambda, penalties and pyramid levels.

For each setting, means over pairs of frames of one recording and, in brackets, half of the 95 % interval of
the difference from the default, pair by pair (so that what all settings share in a pair drops out): the
distance from the true flow on tissue (px), the residual I(x + u, t + dt) - I(x, t) (grey levels), and Paper
C's warp error, Eq. (15): root mean square of I(x, t + dt) - I(x - u, t) over the centred 97 % of each side
(94 % of the area). The last parts give the flow error of every preset, and by phase of the cycle, for the
default.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.motion.flow import PRESETS, flow, warp_error
from plica.video.motion.frame_content import Seen, informing

SMOOTHNESS = (0.01, 0.045, 0.1, 0.5, 1.0, 2.0)
PENALTIES = ("lorentzian", "quadratic")
LEVELS = (None, 1)
PHASES = ("opening", "open", "closing", "closed", "collision")


def errors(glottis: SyntheticGlottis, t: int, options: dict[str, Any]) -> tuple[float, float, float]:
    """Distance from the true flow, residual and Eq. (15) of the pair of frames from t on."""
    first, second = glottis.frame(t), glottis.frame(t + 1)
    seen, then = Seen(first, glottis.mask(t)), Seen(second, glottis.mask(t + 1))
    found = flow(first, second, mask=informing(seen, then), intensity=(0.0, 255.0), **options)
    truth, known = glottis.flow(t, t + 1)
    counted = seen.tissue & known
    distance = np.hypot(*np.moveaxis(found.flow - truth, -1, 0))[counted].mean()
    left = found.residual[counted & np.isfinite(found.residual)]
    return float(distance), float(np.sqrt(np.mean(left**2))), warp_error(first, second, found.flow).rms


def phase_of(glottis: SyntheticGlottis, t: int) -> str:
    """What the folds do from t to t + 1."""
    before, after = (sum(glottis.area(s)) for s in (t, t + 1))
    largest = max(sum(glottis.area(s)) for s in range(21))
    if before > 0 and after == 0:
        return "collision"
    if before == after == 0:
        return "closed"
    if min(before, after) > 0.85 * largest:
        return "open"
    return "opening" if after > before else "closing"


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--pairs", type=int, default=20, help="of frames, from the first on: a cycle is 20")
    parser.add_argument("--noise", type=float, default=2.0)
    options = parser.parse_args()
    glottis = SyntheticGlottis(
        Synthetic(height=160, width=160, amplitude=(6, 6), opening=(3, 3), noise=options.noise)
    )
    default = np.array([errors(glottis, t, {}) for t in range(options.pairs)])
    heads = ["lambda", "penalties", "levels", "flow error (px)", "residual (grey)", "Eq. (15) (grey)"]
    record("flow_sweep", heads, sweep(glottis, default))
    off = (
        [preset, f"{np.mean([errors(glottis, t, {'preset': preset})[0] for t in range(options.pairs)]):.3f}"]
        for preset in PRESETS
    )
    record("flow_sweep_presets", ["preset", "flow error (px)"], off)
    names = np.array([phase_of(glottis, t) for t in range(options.pairs)])
    phases = (
        [name, (names == name).sum(), f"{default[names == name, 0].mean():.3f}"]
        for name in PHASES
        if (names == name).any()
    )
    record("flow_sweep_phases", ["phase", "pairs", "flow error (px)"], phases)


def sweep(glottis: SyntheticGlottis, default: np.ndarray) -> Iterator[list[str]]:
    """A row for each lambda, penalty and depth of the pyramid."""
    for levels in LEVELS:
        for penalty in PENALTIES:
            for smoothness in SMOOTHNESS:
                chosen = {"smoothness": smoothness, "data_penalty": penalty, "smooth_penalty": penalty}
                if levels is not None:
                    chosen["levels"] = levels
                found = np.array([errors(glottis, t, chosen) for t in range(len(default))])
                half = 1.96 * (found - default).std(axis=0, ddof=1) / np.sqrt(len(default))
                cells = [
                    f"{mean:.3f} ({spread:.3f})"
                    for mean, spread in zip(found.mean(axis=0), half, strict=True)
                ]
                depth = "all" if levels is None else str(levels)
                yield [f"{smoothness:g}", penalty, depth, *cells]


if __name__ == "__main__":
    main()
