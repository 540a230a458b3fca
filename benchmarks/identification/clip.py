"""A recording without a truth, end to end: what comes of it, beside what was believed.

    python -m benchmarks.identification.clip oscillating_vocal_folds.mp4 --keep DIR

`plica video` analyses it, `plica larynx` fits a larynx to a frame, `plica identify` estimates two shear
moduli in it: with the camera's tilt estimated, as is the default, with the camera held, and in the preset as
it is.
Where the frame rate and the size of a pixel are not known, they are assumed: moduli are then known up to a
factor at best.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from plica import larynx_fit, video
from plica.identify import Identification, Settings, identify
from plica.identify.estimator.posterior import standard_deviations

SCENE = Path(__file__).resolve().parents[2] / "examples" / "normal_phonation.toml"
NAMES = ("cover.mu_fibre", "body.mu_fibre")
COLUMNS = ("prior's 95 % (kPa)", "median of mu' cover", "of mu' body", "the model follows")


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("clip", type=Path)
    parser.add_argument("--fps", type=float, default=1000.0)
    parser.add_argument("--mm-per-px", type=float, default=0.09)
    parser.add_argument("--frame", type=int, default=3, help="to which the larynx is fitted")
    parser.add_argument("--larynx", default="coarse", help="preset of its cells")
    parser.add_argument("--step", default="250 us")
    parser.add_argument("--preset", default="robust", help="of the flow")
    parser.add_argument(
        "--keep", type=Path, required=True, help="directory of the analysis and the estimates"
    )
    given = parser.parse_args()
    analysis = given.keep / "analysis"
    settings = video.Settings(fps=given.fps, mm_per_px=given.mm_per_px, preset=given.preset)
    found = video.analyse(given.clip, analysis, settings, progress=False)
    frame, mask = found.frames().frame(given.frame), found.mask(given.frame)
    fitted = larynx_fit.fit_larynx(frame, mask, mm_per_px=given.mm_per_px, larynx=given.larynx)
    print(
        f"fitted: r_in {1e3 * fitted.section.r_in:.1f} mm, half-width "
        f"{1e3 * fitted.section.half_width:.2f} mm, contour off by {fitted.error.mean:.1f} px",
        *fitted.warnings,
        sep="\n",
    )
    scene = plica.Scene.load(SCENE).replace(
        dict.fromkeys(("contact", "initial", "symmetry", "airflow"))
        | {"time.step": given.step, "output": plica.Output()}
    )
    cases = {
        "fitted, tilt estimated": (fitted.larynx, None),
        "fitted, camera held": (fitted.larynx, 0.0),
        f"{given.larynx} as it is, camera held": (plica.Larynx(larynx=given.larynx, order=2), 0.0),
    }
    columns = ["larynx", *COLUMNS, "residual test (time, space, tails, level)", "starts that ended here"]
    note = f"{found.count} frames; {given.fps:g}/s and {given.mm_per_px:g} mm a pixel are assumed."
    record("identify-clip", columns, rows(scene, cases, given.keep), note)


def rows(
    scene: plica.Scene, cases: dict[str, tuple[plica.Larynx, float | None]], keep: Path
) -> Iterator[list[str]]:
    """An estimate each, gone on with where it was begun; its table and warnings are printed."""
    for number, (name, (larynx, tilt_sd)) in enumerate(cases.items()):
        settings = Settings(parameters=NAMES, coarser="none", tilt_sd=tilt_sd)
        where = keep / f"identified-{number}"
        try:
            found = identify(
                keep / "analysis", scene.replace({"mesh": larynx}), where, settings, resume=where.exists()
            )
        except plica.SolveFailed as error:
            print(f"\n{name}: {error}\n", flush=True)
            yield [name, "", "", "", "", str(error), ""]
            continue
        print(f"\n{name}:", found.table, *found.warnings, "", sep="\n", flush=True)
        yield [name, *cells(found)]


def cells(found: Identification) -> list[str]:
    """Of a row."""
    posterior, r = found.posterior, found.posterior.residuals
    places = [posterior.names.index(name) for name in NAMES]
    half = standard_deviations() * posterior.prior_sd[places]
    low, high = np.exp(posterior.prior_mean[places] + np.outer((-1, 1), half)) / 1e3
    prior = "; ".join(f"{a:.1f} to {b:.0f}" for a, b in zip(low, high, strict=True))
    medians = [f"{posterior.median[k] / 1e3:.1f}" for k in places]
    scores = f"{r.in_time:+.1f} {r.in_space:+.1f} {r.tails:+.1f} {r.level:+.1f}"
    test = f"{'passed' if r.passed else 'failed'} ({scores})"
    share = f"{100 * found.picture.explained:.0f} %"
    return [prior, *medians, share, test, f"{posterior.ended_here} of {posterior.starts}"]


if __name__ == "__main__":
    main()
