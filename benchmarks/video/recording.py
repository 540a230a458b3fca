"""A whole recording through `plica video`: time, memory, and what is left when the process is killed.

    python -m benchmarks.video.recording                              400 frames, preset video, then killed
    python -m benchmarks.video.recording --frames 2000 --preset fast --no-kill

The recording is the synthetic glottis, 256 x 256, two cycles in 43 frames, over and over with new noise; a
TIFF file, written and read frame by frame, so that its pages are no memory of the process (those of a mapped
NPY file would be). `plica video` runs in a process of its own. Its peak memory is the largest resident set
that the kernel saw, imports included.

Then the same once more in another directory, killed (SIGKILL: no handler runs, nothing is flushed) in the
middle of each step and started again each time; at the end every dataset is compared with the undisturbed
run's, bit by bit. At last a recording of 96 x 96 px is killed over and over: at random times, and, where
strace is installed, just before a random one of the system's writes to its results, where a file is in most
danger. Wherever a killed analysis cannot be continued, there is a message, and it is started again.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import tifffile

from benchmarks.harness.study import record, script_parser
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import load

FPS = 4000.0
CYCLE = 43  # frames of two cycles
NOISE = 2.0  # grey levels
LARGE = Synthetic(frequency=2 / CYCLE, amplitude=(9, 7), phase=(0.0, 0.6), noise=0.0)
SMALL = replace(LARGE, height=96, width=96, amplitude=(5, 4), opening=(2, 2), highlights=2)
BARS = (("drift again", 0.5), ("glottis", 0.5), ("flow", 0.3), ("flow", 0.5), ("flow", 1.0))
LATE = (0.2, 0.5, 0.8)
SMALL_FRAMES = 64
WRITES = 100  # of a run before it is killed, at most
FILES = ("results.h5", "flow.h5")
STEPS = ("drift", "glottis", "sides", "flow", "trust", "paths", "modes", "waves")  # as results.h5 does
BAR = re.compile(rb"\r(drift again|drift|glottis|flow):\s+\d+%\|[^|]*\|\s*(\d+)/(\d+)")


@dataclass
class Child:
    """A run of `plica video`."""

    wall: float = 0.0  # s
    processor: float = 0.0  # s
    memory: float = 0.0  # MB
    status: int = 0  # 0: came to its end; > 0: refused; < 0: killed
    last_line: str = ""  # last line of its message if it refused
    begun: dict[str, float] = field(default_factory=dict)  # s, when a step was first seen at work
    seen: tuple[str, int, int] = ("start", 0, 1)  # the last bar: step, frames done, frames


Stop = Callable[[Child, float], bool]
"""Of the process as far as it is known, and its age (s)."""


def run(
    movie: Path,
    directory: Path,
    preset: str,
    threads: int,
    stop: Stop | None = None,
    writes: int | None = None,
) -> Child:
    """Run to the end, or until `stop` says so, or up to the write of this number to its results."""
    command = [] if writes is None else killed_before(writes, directory)
    command += [sys.executable, "-m", "plica.commands.main", "video", str(movie), "-o", str(directory)]
    command += ["--fps", str(FPS), "--preset", preset, "--threads", str(threads)]
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    assert process.stderr is not None
    os.set_blocking(process.stderr.fileno(), False)
    child, text = Child(), b""
    while True:
        new = process.stderr.read() or b""
        text = (text + new)[-4000:]
        age = time.perf_counter() - start
        for name, done, total in BAR.findall(text):
            child.begun.setdefault(name.decode(), age)
            child.seen = (name.decode(), int(done), int(total))
        if child.seen[0] == "flow" and child.seen[1] == child.seen[2]:
            child.begun.setdefault("after flow", age)
        if stop is not None and stop(child, age):
            os.kill(process.pid, signal.SIGKILL)
        ended, status, used = os.wait4(process.pid, os.WNOHANG)
        if ended:
            break
        time.sleep(0.01)
    process.returncode = child.status = os.waitstatus_to_exitcode(status)
    process.stderr.close()
    if child.status > 0:
        child.last_line = text.decode(errors="replace").strip().splitlines()[-1]
    child.wall, child.processor = time.perf_counter() - start, used.ru_utime + used.ru_stime
    child.memory = used.ru_maxrss / 1024
    return child


def killed_before(write: int, directory: Path) -> list[str]:
    """The command that runs another and kills it when it begins this write, from 1 on, to its results."""
    paths = [f"-P{directory / name}{part}" for name in FILES for part in ("", ".part")]
    kill = f"inject=pwrite64:signal=SIGKILL:when={write}"
    return ["strace", "-f", "-qq", "-o", os.devnull, *paths, "-e", "trace=pwrite64", "-e", kill]


def write(movie: Path, options: Synthetic, frames: int) -> SyntheticGlottis:
    """Write the recording frame by frame; returns the glottis in it."""
    glottis = SyntheticGlottis(options)
    cycle = [glottis.frame(t) for t in range(CYCLE)]
    random = np.random.default_rng(7)
    with tifffile.TiffWriter(movie) as file:
        for k in range(frames):
            noisy = cycle[k % CYCLE] + NOISE * random.standard_normal(cycle[0].shape)
            image = np.round(np.clip(noisy, 0, 255)).astype(np.uint8)
            file.write(image, contiguous=False, photometric="minisblack")
    return glottis


def state(directory: Path) -> str:
    """What a killed process left: the steps that are whole, the flows, or that it does not open."""
    results, flows = (directory / name for name in FILES)
    try:
        there, pairs = [], ""
        if results.exists():
            with h5py.File(results, "r") as file:
                there = [name for name in STEPS if name in file]
        if flows.exists():
            with h5py.File(flows, "r") as file:
                pairs = f"; {np.count_nonzero(file['checksum'][:])} pairs"
        return (", ".join(there) or "no step") + pairs
    except (OSError, KeyError, RuntimeError) as error:
        return f"does not open: {error}"


def blocks(item: h5py.Dataset) -> Iterator[bytes]:
    """Its values as bytes, a hundred entries at a time."""
    if item.ndim == 0 or h5py.check_string_dtype(item.dtype):
        yield repr(item[()].tolist()).encode()
        return
    for k in range(0, item.shape[0], 100):
        yield item[k : k + 100].tobytes()


def differing(one: Path, other: Path) -> tuple[int, list[str]]:
    """How many datasets the first has, and the names of those that are not the same bits in the second."""
    count, wrong = 0, []
    for path in FILES:
        with h5py.File(one / path) as a, h5py.File(other / path) as b:
            names = [datasets(file) for file in (a, b)]
            count += len(names[0])
            wrong += sorted(names[0] ^ names[1])
            for name in sorted(names[0] & names[1]):
                same = a[name].shape == b[name].shape and a[name].dtype == b[name].dtype
                if not same or any(x != y for x, y in zip(blocks(a[name]), blocks(b[name]), strict=True)):
                    wrong.append(name)
    return count, wrong


def datasets(file: h5py.File) -> set[str]:
    names: list[str] = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return set(names)


def report(child: Child, directory: Path, glottis: SyntheticGlottis, movie: Path, preset: str) -> None:
    found = load(directory)
    frames = found.area.total.size
    truth = np.mean([sum(glottis.area(t % CYCLE)) for t in range(frames)])
    area = 100 * (found.area.total.mean() / truth - 1)
    pitch = found.measures["fundamental_frequency"].value
    pitch_text = "too few cycles" if pitch is None else f"{pitch:.1f}"
    sizes = [(directory / name).stat().st_size / 1e6 for name in FILES]
    columns = ["frames", "preset", "wall (s)", "processor (s)", "peak memory (MB)", "recording (MB)"]
    columns += ["results.h5, flow.h5 (MB)", "mean area", "f0 (Hz)", "true"]
    row = [frames, preset, f"{child.wall:.0f}", f"{child.processor:.0f}", f"{child.memory:.0f}"]
    row += [f"{movie.stat().st_size / 1e6:.0f}", f"{sizes[0]:.0f}, {sizes[1]:.0f}", f"{area:+.1f} %"]
    begun = {"opening": 0.0, **child.begun}
    spent = np.diff([*begun.values(), child.wall])
    steps = ", ".join(f"{name} {seconds:.1f}" for name, seconds in zip(begun, spent, strict=True))
    row += [pitch_text, f"{2 / CYCLE * FPS:.1f}"]
    record(f"video_long_{frames}", columns, [row], f"Wall time by step (s): {steps}.")


def at(step: str, share: float) -> Stop:
    """Stop where a step's bar stands at this share."""
    return lambda child, _: child.seen[0] == step and child.seen[1] >= share * child.seen[2]


def older(seconds: float) -> Stop:
    return lambda _, age: age > seconds


def kill_in_every_step(
    movie: Path, whole: Path, undisturbed: Child, directory: Path, preset: str, threads: int
) -> None:
    """Kill and start again, from step to step; compare with the undisturbed run."""
    begun = undisturbed.begun
    rest = undisturbed.wall - begun["after flow"]
    points = {f"{step}, {share:.0%}": at(step, share) for step, share in BARS}
    points |= {
        f"after the flow, {share:.0%} of its time": older(begun["drift"] + share * rest) for share in LATE
    }
    spent, rows = 0.0, []
    for name, stop in points.items():
        child = run(movie, directory, preset, threads, stop)
        spent += child.processor
        if child.status > 0:
            rows.append(["started again", "refused, begun anew", child.last_line])
            shutil.rmtree(directory)
            child = run(movie, directory, preset, threads, stop)
            spent += child.processor
        ended = "" if child.status else " (ended before)"
        rows.append([f"{name}{ended}", "{} {}/{}".format(*child.seen), state(directory)])
    spent += run(movie, directory, preset, threads).processor
    count, wrong = differing(whole, directory)
    note = (
        f"Datasets that differ from the undisturbed run's: {len(wrong)} of {count}{': ' if wrong else ''}"
        f"{', '.join(wrong)}. Processor time of all runs together: {spent:.0f} s, undisturbed "
        f"{undisturbed.processor:.0f} s."
    )
    record("video_killed", ["killed in", "bar", "what is there then"], rows, note)


def kill_over_and_over(folder: Path, kills: int, threads: int) -> None:
    """Kill a small recording's run and go on from what is left; at random times, then at random writes."""
    movie, whole, directory = folder / "small.tif", folder / "small", folder / "again"
    write(movie, SMALL, SMALL_FRAMES)
    undisturbed = run(movie, whole, "fast", threads)
    random = np.random.default_rng(11)
    again = partial(run, movie, directory, "fast", threads)
    ways = {"at random times": lambda: again(older(random.uniform(0, undisturbed.wall)))}
    if shutil.which("strace"):
        ways["at random writes"] = lambda: again(writes=int(random.integers(1, WRITES)))
    else:
        print("strace is not installed: not killed at writes.")
    columns = ["killed", "refused after", "ran to the end", "of them with other bits"]
    note = f"{SMALL_FRAMES} frames of 96 x 96 px, killed {kills} times each way."
    rows = ([how, *tally(whole, directory, kill, again, kills)] for how, kill in ways.items())
    record("video_killed_often", columns, rows, note)


def tally(
    whole: Path, directory: Path, kill: Callable[[], Child], again: Callable[[], Child], kills: int
) -> tuple[int, int, int]:
    """Of runs that were killed so often: how many were refused, came to their end, have other bits."""
    killed = refused = finished = wrong = 0
    while killed <= kills:
        child = kill() if killed < kills else again()  # the last goes on with what is left
        if child.status < 0:
            killed += 1
            continue
        killed += killed == kills
        refused += child.status > 0
        if not child.status:
            finished += 1
            wrong += bool(differing(whole, directory)[1])
        shutil.rmtree(directory)
    return refused, finished, wrong


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--frames", type=int, default=400, help="0: the small recording alone")
    parser.add_argument("--preset", default="video")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--no-kill", action="store_true", help="the undisturbed run alone")
    parser.add_argument("--kills", type=int, default=30, help="of the small recording, each way")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        movie, whole = folder / "glottis.tif", folder / "whole"
        if options.frames:
            glottis = write(movie, LARGE, options.frames)
            undisturbed = run(movie, whole, options.preset, options.threads)
            if undisturbed.status:
                raise SystemExit(undisturbed.last_line)
            report(undisturbed, whole, glottis, movie, options.preset)
            if not options.no_kill:
                again = folder / "killed"
                kill_in_every_step(movie, whole, undisturbed, again, options.preset, options.threads)
        if not options.no_kill:
            kill_over_and_over(folder, options.kills, options.threads)


if __name__ == "__main__":
    main()
