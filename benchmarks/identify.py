"""Whether identification finds the tissue: errors and coverage over draws, and what an estimate takes.

    python benchmarks/identify.py same --draws 100      # the truth on the mesh of the estimate
    python benchmarks/identify.py refined --draws 30    # no inverse crime: a finer mesh, half the step
    python benchmarks/identify.py wrong --draws 12      # what the model has wrong
    python benchmarks/identify.py calibration --draws 60 --frames 60    # whole, truth from the prior
    python benchmarks/identify.py information           # how well it can be known at all
    python benchmarks/identify.py larynx                # time and memory at 9,864 unknowns
    python benchmarks/identify.py larynx --preset fine --size 6.5e-4 --before coarse    # and at over 30,000

A layered block is seen from above by 66 points at 4000 frames/s, 20 px/mm, with 0.1 px noise in the flow.
Known pressures on its medial face, and unknown ones of 30 Pa, drive it. In each draw the noise is new and
the prior's median is drawn about the truth, with the prior's own spread.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from identify_block import (
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
    errors,
    offsets,
    parameters,
    report,
    true_log,
)
from identify_calibration import calibration
from identify_information import information
from identify_larynx import larynx

import plica
from plica.identify import MarginalLikelihood, Responses, estimate, residual_test


def same(arguments: argparse.Namespace) -> dict[str, Any]:
    """The truth on the mesh of the estimate."""
    names = ("cover.E", *SEVEN)
    study = Study(Bench(COARSE, STEP, arguments.frames), names, arguments.drive)
    titles = ("viscosity", *names, "gain")
    print(
        f"{study.bench.unknowns} unknowns, {arguments.frames} frames, sweep {study.seconds:.1f} s", flush=True
    )
    found = []
    for draw in range(arguments.draws):
        rng = np.random.default_rng(1000 + draw)
        flow = study.bench.recording(study.responses, rng)
        found.append(study.one_step(flow, offsets(names, study.bench, rng)))
    out = {"one step": report("same mesh, one step from the truth", titles, *errors(found))}
    steps, whole = [], []
    for draw in range(arguments.whole):
        rng = np.random.default_rng(1000 + draw)
        flow = study.bench.recording(study.responses, rng)
        offset = offsets(names, study.bench, rng)
        model = study.bench.model(parameters(names, offset[:-1]), flow, arguments.drive)
        estimated = estimate(MarginalLikelihood(model))
        steps.append(estimated.iterations)
        whole.append((estimated.mean - study.truth, estimated.covariance))
        apart = (whole[-1][0] - found[draw][0]) / np.sqrt(np.diag(whole[-1][1]))
        print(
            f"draw {draw}: {estimated.iterations} iterations; from the one step in sd:",
            np.round(apart, 2),
            flush=True,
        )
    if whole:
        out["whole"] = report("same mesh, whole estimates", titles, *errors(whole))
    return out


def refined(arguments: argparse.Namespace) -> dict[str, Any]:
    """No inverse crime: the truth on a finer mesh with half the step; two coarser meshes estimate."""
    bench = Bench(TRUTH, STEP / 2, arguments.frames)
    blank = np.ones((bench.frames, len(bench.points.nodes), 2))
    seen = bench.model(parameters(SEVEN, np.zeros(7)), blank, arguments.drive)
    truth = seen.responses(true_log(SEVEN)[:-1], derivatives=False)
    studies = [
        Study(Bench(divisions, STEP, arguments.frames), SEVEN, arguments.drive)
        for divisions in (COARSE, FINE)
    ]
    moved = np.cumsum(truth.mean[0], axis=0)
    print(
        f"truth {bench.unknowns}, estimates {', '.join(str(s.bench.unknowns) for s in studies)} unknowns; "
        f"sweeps {', '.join(f'{s.seconds:.1f} s' for s in studies)}; up to "
        f"{np.abs(truth.mean[0]).max():.2f} px a frame, {np.abs(moved).max() / 20:.3f} mm",
        flush=True,
    )
    out = {}
    for share in (1.0, 0.25):  # the mean motion is linear in the drive
        print(f"\n==== known pressure {share * arguments.drive:g} Pa")
        out[f"{share * arguments.drive:g} Pa"] = both_meshes(bench, truth, studies, share, arguments.draws)
    for draw in range(arguments.whole):
        iterated(bench, truth, studies, 0.25, arguments.drive, draw)
    return out


def iterated(
    bench: Bench, truth: Responses, studies: list[Study], share: float, drive: float, draw: int
) -> None:
    """One draw estimated to the end on both meshes, from its prior's medians, beside the one step."""
    rng = np.random.default_rng(2000 + draw)
    flow = bench.recording(Responses(share * truth.mean, truth.lags), rng)
    offset = offsets(SEVEN, studies[0].bench, rng)
    start = None
    for study in studies:
        known = Responses(share * study.responses.mean, study.responses.lags)
        step, covariance = study.one_step(flow, offset, known)
        model = study.bench.model(parameters(SEVEN, offset[:-1]), flow, share * drive)
        began = time.perf_counter()
        found = estimate(MarginalLikelihood(model), start)
        seconds, start = time.perf_counter() - began, found.mean
        sd = np.sqrt(np.diag(covariance))
        error = (found.mean - study.truth) / sd
        print(
            f"draw {draw}, {study.bench.unknowns} unknowns: {found.iterations} iterations, {seconds:.0f} s; "
            f"error in sd {np.round(error, 2)}, of the one step {np.round(step / sd, 2)}",
            flush=True,
        )


def both_meshes(
    bench: Bench, truth: Responses, studies: list[Study], share: float, draws: int
) -> dict[str, Any]:
    """Errors and coverage of two meshes and of their combination."""
    truth = Responses(share * truth.mean, truth.lags)
    responses = [Responses(share * s.responses.mean, s.responses.lags) for s in studies]
    found: list[list[tuple[np.ndarray, np.ndarray]]] = [[], [], []]
    shifts = []
    for draw in range(draws):
        rng = np.random.default_rng(2000 + draw)
        flow = bench.recording(truth, rng)
        offset = offsets(SEVEN, studies[0].bench, rng)
        for kept, study, known in zip(found, studies, responses, strict=False):
            kept.append(study.one_step(flow, offset, known))
        (coarse, _), (fine, covariance) = found[0][-1], found[1][-1]
        shift = fine - coarse
        found[2].append((fine, covariance + np.outer(shift, shift)))
        shifts.append(shift / np.sqrt(np.diag(covariance)))
    titles = ("viscosity", *SEVEN, "gain")
    shares = [f"{title} {share:+.1f}" for title, share in zip(titles, np.median(shifts, axis=0), strict=True)]
    print("median shift in sd:", ", ".join(shares))
    kinds = ("coarse mesh", "finer mesh", "finer mesh, with the mesh shift")
    return {kind: report(kind, titles, *errors(part)) for kind, part in zip(kinds, found, strict=True)}


def wrong(arguments: argparse.Namespace) -> dict[str, Any]:
    """What is wrong in the model and not known to be: the bias in sd, and whether the residuals tell."""
    named = (
        "as modelled",
        "cover 10 % thicker",
        "length + 5 %",
        "camera tilted 5 degrees",
        "drive modulated 20 %",
    )
    names = ("viscosity", *SEVEN, "gain")
    frames, x, y, z = arguments.frames, *SIZE
    study = Study(Bench(COARSE, STEP, frames), SEVEN, arguments.drive)
    true = [Bench(COARSE, STEP, frames) for _ in named]
    body, ligament, cover = THICKNESS
    true[1] = Bench(COARSE, STEP, frames, thickness=(body - 0.1 * cover, ligament, 1.1 * cover))
    true[2] = Bench(COARSE, STEP, frames, size=(x, 1.05 * y, z))
    true[3].camera = replace(CAMERA, tilt=-5.0, lean=5.0)
    true[4].modulation = 0.2
    out = {}
    for name, bench in zip(named, true, strict=True):
        responses = Study(bench, SEVEN, arguments.drive).responses
        scores, failed = [], 0
        for draw in range(arguments.draws):
            rng = np.random.default_rng(3000 + draw)
            flow = bench.recording(responses, rng)
            error, covariance = study.one_step(flow, np.zeros(len(names)))
            scores.append(error / np.sqrt(np.diag(covariance)))
            likelihood = MarginalLikelihood(study.model.seeing(flow))
            at = likelihood.evaluate_known(study.truth, study.responses)
            failed += not residual_test(likelihood, at).passed
        bias = np.mean(scores, axis=0)
        told = ", ".join(f"{n} {b:+.1f}" for n, b in zip(names, bias, strict=True))
        print(f"{name}: bias in sd {told}; residual test fails in {failed} of {arguments.draws}", flush=True)
        out[name] = {"bias": bias.tolist(), "failed": failed}
    return out


def main() -> None:
    """Run one of the benchmarks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("same", "refined", "wrong", "calibration", "information", "larynx"))
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--whole", type=int, default=0, help="of them, how many are iterated to the end")
    parser.add_argument("--drive", type=float, default=800.0, help="Pa, of the known pressure")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--preset", default="coarse")
    parser.add_argument("--size", type=float, help="m, of the larynx's edges instead of the preset's")
    parser.add_argument("--before", nargs="*", default=[], help="presets to start from")
    parser.add_argument("--seed", type=int, default=5000, help="of the first draw of calibration")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    plica.set_threads(arguments.threads)
    benches = {
        "same": same,
        "refined": refined,
        "wrong": wrong,
        "calibration": calibration,
        "information": information,
        "larynx": larynx,
    }
    measured = benches[arguments.what](arguments)
    if arguments.output:
        arguments.output.write_text(json.dumps(measured, indent=1))


if __name__ == "__main__":
    main()
