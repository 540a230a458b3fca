"""Whether identification finds the tissue: errors and coverage over draws, and what an estimate takes.

    python -m benchmarks.identification.estimates WHAT [OPTIONS]

    same --draws 100                                      the truth on the mesh of the estimate
    refined --draws 30                                    no inverse crime: a finer mesh, half the step
    wrong --draws 12                                      what the model has wrong
    calibration --draws 60 --frames 60                    whole, truth from the prior
    information                                           how well it can be known at all
    collisions --draws 20 --frames 60                     what closed frames cost
    larynx                                                time and memory at 9,864 unknowns
    larynx --preset fine --size 6.5e-4 --before coarse    and at over 30,000

A layered block is seen from above by 66 points at 4000 frames/s, 20 px/mm, with 0.1 px noise in the flow.
Known pressures on its medial face, and unknown ones of 30 Pa, drive it. In each draw the noise is new and
the prior's median is drawn about the truth, with the prior's own spread.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.identification.block import (
    CAMERA,
    COARSE,
    FINE,
    SEVEN,
    SIZE,
    STEP,
    THICKNESS,
    TRUTH,
    Bench,
    Study,
    offsets,
    parameters,
    statistics_rows,
    true_log,
)
from benchmarks.identification.calibration import calibration
from benchmarks.identification.collisions import collisions
from benchmarks.identification.information import information
from benchmarks.identification.larynx import larynx
from plica.identify import MarginalLikelihood, Responses, estimate

NUMBERS = ("viscosity", *SEVEN, "gain")


def same(arguments: argparse.Namespace) -> None:
    """The truth on the mesh of the estimate."""
    names = ("cover.E", *SEVEN)
    study = Study(Bench(COARSE, STEP, arguments.frames), names, arguments.drive)
    found = []
    for draw in range(arguments.draws):
        rng = np.random.default_rng(1000 + draw)
        flow = study.bench.recording(study.responses, rng)
        found.append(study.one_step(flow, offsets(names, study.bench, rng)))
    note = (
        f"{arguments.draws} draws, {arguments.frames} frames, {arguments.drive:g} Pa; "
        f"{study.bench.unknowns:,} unknowns."
    )
    columns = ["viscosity", *names, "gain"]
    record("identify-same", ["", *columns, "all"], statistics_rows(found), note)
    if arguments.whole:
        rows = whole(study, names, found[: arguments.whole], arguments.drive)
        record("identify-same-whole", ["draw", "evaluations", *columns], rows)


def whole(
    study: Study, names: tuple[str, ...], steps: list[tuple[np.ndarray, np.ndarray]], drive: float
) -> Iterator[list[str]]:
    """Whole estimates: how many sd apart from the one step they end."""
    for draw, (step, _) in enumerate(steps):
        rng = np.random.default_rng(1000 + draw)
        flow = study.bench.recording(study.responses, rng)
        offset = offsets(names, study.bench, rng)
        model = study.bench.model(parameters(names, offset[:-1]), flow, drive)
        found = estimate(MarginalLikelihood(model))
        apart = np.abs(found.mean - study.truth - step) / found.sd
        yield [str(draw + 1), str(found.iterations), *[f"{value:.2f}" for value in apart]]


def refined(arguments: argparse.Namespace) -> None:
    """No inverse crime: the truth on a finer mesh with half the step; two coarser meshes estimate."""
    bench = Bench(TRUTH, STEP / 2, arguments.frames)
    blank = np.ones((bench.frames, len(bench.points.nodes), 2))
    seen = bench.model(parameters(SEVEN, np.zeros(7)), blank, arguments.drive)
    truth = seen.responses(true_log(SEVEN)[:-1], derivatives=False)
    studies = [
        Study(Bench(divisions, STEP, arguments.frames), SEVEN, arguments.drive)
        for divisions in (COARSE, FINE)
    ]

    def rows() -> Iterator[list[str]]:
        for share in (0.25, 1.0):  # the mean motion is linear in the drive
            moved = share * np.abs(np.cumsum(truth.mean[0], axis=0)).max() * CAMERA.mm_per_px
            known = f"{share * arguments.drive:g} Pa, {moved:.1f} mm"
            for row in both_meshes(bench, truth, studies, share, arguments.draws):
                yield [known, *row]

    note = f"{arguments.draws} draws, {arguments.frames} frames; the truth has {bench.unknowns:,} unknowns."
    record("identify-refined", ["known pressure", "unknowns", "", *NUMBERS, "all"], rows(), note)
    if arguments.whole:
        draws = range(arguments.whole)
        made = (row for d in draws for row in iterated(bench, truth, studies, 0.25, arguments.drive, d))
        record("identify-refined-whole", ["draw", "unknowns", "evaluations", "error in sd", *NUMBERS], made)


def iterated(
    bench: Bench, truth: Responses, studies: list[Study], share: float, drive: float, draw: int
) -> Iterator[list[str]]:
    """One draw estimated to the end on both meshes, from its prior's medians, beside the one step."""
    rng = np.random.default_rng(2000 + draw)
    flow = bench.recording(Responses(share * truth.mean, truth.lags), rng)
    offset = offsets(SEVEN, studies[0].bench, rng)
    start = None
    for study in studies:
        known = Responses(share * study.responses.mean, study.responses.lags)
        step, covariance = study.one_step(flow, offset, known)
        model = study.bench.model(parameters(SEVEN, offset[:-1]), flow, share * drive)
        found = estimate(MarginalLikelihood(model), start)
        start, sd = found.mean, np.sqrt(np.diag(covariance))
        for what, error in (("of the whole", found.mean - study.truth), ("of one step", step)):
            cells = [f"{value:+.1f}" for value in error / sd]
            yield [str(draw + 1), f"{study.bench.unknowns:,}", str(found.iterations), what, *cells]


def both_meshes(
    bench: Bench, truth: Responses, studies: list[Study], share: float, draws: int
) -> list[list[str]]:
    """Errors and coverage of two meshes, and of the finer with the shift between both in its intervals, or
    with the part of it that an error of second order leaves."""
    truth = Responses(share * truth.mean, truth.lags)
    responses = [Responses(share * s.responses.mean, s.responses.lags) for s in studies]
    found: list[list[tuple[np.ndarray, np.ndarray]]] = [[], [], [], []]
    for draw in range(draws):
        rng = np.random.default_rng(2000 + draw)
        flow = bench.recording(truth, rng)
        offset = offsets(SEVEN, studies[0].bench, rng)
        for kept, study, known in zip(found, studies, responses, strict=False):
            kept.append(study.one_step(flow, offset, known))
        (coarse, _), (fine, covariance) = found[0][-1], found[1][-1]
        for kept, part in zip(found[2:], (1.0, 1 / 3), strict=True):
            shift = part * (fine - coarse)
            kept.append((fine, covariance + np.outer(shift, shift)))
    names = [f"{study.bench.unknowns:,}" for study in studies]
    kinds = [*names, f"{names[1]}, with the shift", "with a third of it"]
    return [
        [kind, *row]
        for k, (kind, part) in enumerate(zip(kinds, found, strict=True))
        for row in statistics_rows(part)[1 if k < 2 else 2 :]
    ]


def wrong(arguments: argparse.Namespace) -> None:
    """What is wrong in the model and not known to be: the bias in sd, and whether the residuals tell."""
    note = f"{arguments.draws} draws, {arguments.frames} frames, {arguments.drive:g} Pa; bias in sd."
    columns = ["wrong in the model", *NUMBERS, "residual test fails"]
    record("identify-wrong", columns, wrong_rows(arguments), note)


def wrong_rows(arguments: argparse.Namespace) -> Iterator[list[str]]:
    """One fault after the other."""
    frames, x, y, z = arguments.frames, *SIZE
    study = Study(Bench(COARSE, STEP, frames), SEVEN, arguments.drive)
    body, ligament, cover = THICKNESS
    true = {
        name: Bench(COARSE, STEP, frames)
        for name in ("nothing", "camera tilted 5 degrees about both axes", "drive modulated by 20 % at 37 Hz")
    }
    thicker = (body - 0.1 * cover, ligament, 1.1 * cover)
    true["cover 10 % thicker"] = Bench(COARSE, STEP, frames, thickness=thicker)
    true["length + 5 %"] = Bench(COARSE, STEP, frames, size=(x, 1.05 * y, z))
    true["camera tilted 5 degrees about both axes"].camera = replace(CAMERA, tilt=-5.0, lean=5.0)
    true["drive modulated by 20 % at 37 Hz"].modulation = 0.2
    for name, bench in true.items():
        responses = Study(bench, SEVEN, arguments.drive).responses
        scores, failed = [], 0
        for draw in range(arguments.draws):
            rng = np.random.default_rng(3000 + draw)
            flow = bench.recording(responses, rng)
            error, covariance = study.one_step(flow, np.zeros(len(NUMBERS)))
            scores.append(error / np.sqrt(np.diag(covariance)))
            likelihood = MarginalLikelihood(study.model.seeing(flow))
            at = likelihood.evaluate_known(study.truth, study.responses)
            failed += not likelihood.residual_test(at).passed
        bias = [f"{value:+.1f}" for value in np.mean(scores, axis=0)]
        yield [name, *bias, f"{failed} of {arguments.draws}"]


STUDIES = {
    "same": same,
    "refined": refined,
    "wrong": wrong,
    "calibration": calibration,
    "information": information,
    "collisions": collisions,
    "larynx": larynx,
}


def main() -> None:
    """Run one of the benchmarks."""
    parser = script_parser(__doc__)
    parser.add_argument("what", choices=STUDIES)
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--whole", type=int, default=0, help="of them, how many are iterated to the end")
    parser.add_argument("--drive", type=float, default=800.0, help="Pa, of the known pressure")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--preset", default="coarse")
    parser.add_argument("--size", type=float, help="m, of the larynx's edges instead of the preset's")
    parser.add_argument("--before", nargs="*", default=[], help="presets to start from")
    parser.add_argument("--seed", type=int, default=5000, help="of the first draw of calibration")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    plica.set_threads(arguments.threads)
    STUDIES[arguments.what](arguments)


if __name__ == "__main__":
    main()
