"""Flow: end-point error against run time of plica's presets, and of peers on the same pairs and cores.

    python benchmarks/flow.py --data ../shared/data/flow/middlebury
    python benchmarks/flow.py --data ... --peers peers/bin/python --picture docs/images/flow_error_time.png

Peers need an environment of their own: python -m venv peers, then
peers/bin/pip install opencv-contrib-python-headless scikit-image
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from flow_method import PEERS, PLICA

from plica.video.flow import endpoint_error
from plica.video.flow_file import read_flow
from plica.video.image_file import read_image

SEQUENCES = ("RubberWhale", "Venus", "Dimetrodon")
WORKER = Path(__file__).with_name("flow_method.py")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True, help="folder of the Middlebury sequences")
    parser.add_argument("--peers", type=Path, help="Python of the peers' environment")
    parser.add_argument("--rounds", type=int, default=5, help="medians over so many; all methods take turns")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--picture", type=Path, help="draw error against time there")
    options = parser.parse_args()

    truth = {name: read_flow(options.data / name / "flow10.flo") for name in SEQUENCES}
    methods = [(name, sys.executable) for name in PLICA]
    if options.peers:
        methods += [(name, str(options.peers)) for name in PEERS]
    runs: dict[str, list[dict[str, np.ndarray]]] = {name: [] for name, _ in methods}
    with tempfile.TemporaryDirectory() as folder:
        frames, result = Path(folder) / "frames.npz", Path(folder) / "result.npz"
        np.savez(frames, **read_frames(options.data))
        for _ in range(options.rounds):
            for name, python in methods:
                command = [python, WORKER, name, frames, result, str(options.threads)]
                subprocess.run(
                    command, check=True, env=os.environ | {"OMP_NUM_THREADS": str(options.threads)}
                )
                runs[name].append(dict(np.load(result)))

    print(f"| Method | {' | '.join(SEQUENCES)} | mean | wall (s) | processor (s) | memory (MB) |")
    print("|---" * (len(SEQUENCES) + 5) + "|")
    rows = []
    for name, found in runs.items():
        errors = [endpoint_error(found[0][sequence], truth[sequence]) for sequence in SEQUENCES]
        wall, processor = (
            float(np.median([run[f"RubberWhale_{kind}"] for run in found])) for kind in ("wall", "processor")
        )
        memory = float(np.median([run["memory"] for run in found]))
        cells = [f"{error:.3f}" for error in [*errors, float(np.mean(errors))]]
        print(f"| {name} | {' | '.join(cells)} | {wall:.3f} | {processor:.3f} | {memory:.0f} |", flush=True)
        rows.append((name, float(np.mean(errors)), processor))
    print(
        f"\nTimes and memory are those of RubberWhale, 584 x 388: medians of {options.rounds} rounds in "
        f"which all took turns, {options.threads} threads."
    )
    if options.picture:
        draw(rows, options.picture)


def read_frames(data: Path) -> dict[str, np.ndarray]:
    return {
        f"{name}_{which}": read_image(data / name / f"frame{number}.png")
        for name in SEQUENCES
        for which, number in (("first", 10), ("second", 11))
    }


def draw(rows: list[tuple[str, float, float]], picture: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 4.2), layout="constrained")
    for name, error, seconds in rows:
        ours = name.startswith("plica")
        axes.plot(seconds, error, "o" if ours else "s", color="tab:red" if ours else "0.5")
        to_left, below = (
            name in ("plica gradient", "plica robust", "plica fast", "scikit-image ILK", "OpenCV TV-L1"),
            name in ("DeepFlow", "plica gradient"),
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
        ylabel="mean end-point error of the three sequences (px)",
    )
    axes.set_ylim(bottom=0)
    axes.margins(x=0.15)
    axes.grid(which="both", alpha=0.3)
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=130)


if __name__ == "__main__":
    main()
