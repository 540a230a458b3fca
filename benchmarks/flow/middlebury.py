"""Flow: end-point error against run time of plica's presets, and of peers on the same pairs and cores.

Pairs on which constants of the presets were chosen stand apart from those that chose nothing: plica is
compared with peers on these, where the data folder has them.

    python -m benchmarks.flow.middlebury --data ../shared/data/flow/middlebury
    python -m benchmarks.flow.middlebury --data ... --peers peers/bin/python
    python -m benchmarks.flow.middlebury --data ... --peers ... --rounds 5 \
        --picture docs/images/flow_error_time.png

Times (the last line) say something on an idle machine only.

Peers need an environment of their own: python -m venv peers, then
peers/bin/pip install opencv-contrib-python-headless scikit-image
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.flow.method import PEERS, PLICA
from benchmarks.harness.study import record, script_parser
from plica.video.files.image_file import read_image
from plica.video.motion.flow import endpoint_error
from plica.video.motion.flow_file import read_flow

CHOSE = ("RubberWhale", "Venus", "Dimetrodon")  # constants of the presets
UNSEEN = ("Grove2", "Grove3", "Hydrangea", "Urban2", "Urban3")
TIMED = "RubberWhale"
WORKER = Path(__file__).with_name("method.py")


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of the Middlebury sequences")
    parser.add_argument("--peers", type=Path, help="Python of the peers' environment")
    parser.add_argument("--rounds", type=int, default=0, help="also times: medians over so many, in turn")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--picture", type=Path, help="draw error against time there; with --rounds")
    options = parser.parse_args()
    if options.picture and not options.rounds:
        parser.error("--picture needs times; add --rounds 5.")

    unseen = [name for name in UNSEEN if (options.data / name).is_dir()]
    truth = {name: read_flow(options.data / name / "flow10.flo") for name in (*CHOSE, *unseen)}
    methods = [(name, sys.executable) for name in PLICA]
    if options.peers:
        methods += [(name, str(options.peers)) for name in PEERS]
    errors: dict[str, dict[str, float]] = {}
    times: dict[str, list[list[float]]] = {name: [] for name, _ in methods}
    with tempfile.TemporaryDirectory() as folder:
        frames, timed, result = (Path(folder) / f"{name}.npz" for name in ("frames", "timed", "result"))
        np.savez(frames, **read_frames(options.data, tuple(truth)))
        np.savez(timed, **read_frames(options.data, (TIMED,)))
        for name, python in methods:
            found = run(python, name, frames, result, options.threads)
            errors[name] = {pair: endpoint_error(found[pair], known) for pair, known in truth.items()}
        for _ in range(options.rounds):
            for name, python in methods:
                found = run(python, name, timed, result, options.threads)
                kinds = (f"{TIMED}_wall", f"{TIMED}_processor", "memory")
                times[name].append([float(found[kind]) for kind in kinds])

    for kind, pairs in (("chose", CHOSE), ("unseen", unseen)):
        if pairs:
            rows = ([name, *row(error, pairs)] for name, error in errors.items())
            record(f"flow_{kind}", ["method", *pairs, "mean"], rows)
    if not unseen:
        print("\nThese pairs chose constants of plica's presets: they do not compare plica with peers.")
    if options.rounds:
        taken = ([name, *(f"{value:.3g}" for value in np.median(times[name], axis=0))] for name in errors)
        note = f"{TIMED}, medians of {options.rounds} rounds in turn, threads: {options.threads}."
        record("flow_time", ["method", "wall (s)", "processor (s)", "memory (MB)"], taken, note)
    if options.picture:
        counted = unseen or CHOSE
        drawn = [
            (
                name,
                float(np.mean([error[pair] for pair in counted])),
                float(np.median(times[name], axis=0)[1]),
            )
            for name, error in errors.items()
        ]
        draw(
            drawn,
            options.picture,
            f"{len(unseen)} pairs that chose nothing" if unseen else "pairs that chose",
        )


def run(python: str, name: str, frames: Path, result: Path, threads: int) -> dict[str, np.ndarray]:
    """What method.py finds, in a process of its own."""
    command = [python, WORKER, name, frames, result, str(threads)]
    subprocess.run(command, check=True, env=os.environ | {"OMP_NUM_THREADS": str(threads)})
    return dict(np.load(result))


def row(error: dict[str, float], pairs: Sequence[str]) -> list[str]:
    """Cells of a table: the error of each pair, and their mean."""
    values = [error[pair] for pair in pairs]
    return [f"{value:.3f}" for value in [*values, float(np.mean(values))]]


def read_frames(data: Path, pairs: Sequence[str]) -> dict[str, np.ndarray]:
    return {
        f"{name}_{which}": read_image(data / name / f"frame{number}.png")
        for name in pairs
        for which, number in (("first", 10), ("second", 11))
    }


def draw(rows: list[tuple[str, float, float]], picture: Path, pairs: str) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 4.2), layout="constrained")
    for name, error, seconds in rows:
        ours = name.startswith("plica")
        axes.plot(seconds, error, "o" if ours else "s", color="tab:red" if ours else "0.5")
        to_left, below = (
            name
            in (
                "plica gradient",
                "plica robust",
                "plica fast",
                "DeepFlow",
                "scikit-image ILK",
                "OpenCV TV-L1",
            ),
            name in ("plica robust", "plica reference", "plica fast", "Farneback"),
        )
        axes.annotate(
            name,
            (seconds, error),
            textcoords="offset points",
            xytext=(-5 if to_left else 5, -11 if below else 4),
            ha="right" if to_left else "left",
            fontsize=8,
        )
    axes.set(
        xscale="log",
        xlabel="processor time for 584 x 388 (s)",
        ylabel=f"mean end-point error (px), {pairs}",
    )
    axes.set_ylim(bottom=0)
    axes.margins(x=0.15)
    axes.grid(which="both", alpha=0.3)
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=130)


if __name__ == "__main__":
    main()
