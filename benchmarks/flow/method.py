"""One way to find the flow, run and measured in a process of its own.

    method.py NAME FRAMES RESULT THREADS

FRAMES is an npz with NAME_first and NAME_second, grey floats in [0, 255], and with NAME_mask where plica is
to know which pixels count (peers take no mask). RESULT becomes an npz with the
flow, the wall time and the processor time of each pair, and the memory that the process took beyond its
imports and these arrays (MB). It imports what NAME needs only: peers run in an environment of theirs,
without plica.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

Flow = Callable[[np.ndarray, np.ndarray, "np.ndarray | None"], np.ndarray]
PLICA = ("plica gradient", "plica robust", "plica reference", "plica thesis", "plica fast")
PEERS = (
    "DIS ultrafast",
    "DIS fast",
    "DIS medium",
    "Farneback",
    "DeepFlow",
    "OpenCV TV-L1",
    "scikit-image TV-L1",
    "scikit-image ILK",
)


def method(name: str, threads: int) -> Flow:
    """The function that takes two grey frames and a mask, or None, and returns (rows, columns, 2)."""
    if name.startswith("plica "):
        import plica

        plica.set_threads(threads)
        return lambda first, second, mask: plica.flow(first, second, preset=name.split()[1], mask=mask).flow
    if name.startswith("scikit-image "):
        from skimage.registration import optical_flow_ilk, optical_flow_tvl1

        find = optical_flow_tvl1 if name.endswith("TV-L1") else optical_flow_ilk
        # It takes floats in [0, 1] and returns (v, u).
        return lambda first, second, _: np.stack(find(first / 255, second / 255)[::-1], axis=-1)
    import cv2

    cv2.setNumThreads(threads)
    if name.startswith("DIS "):
        made = cv2.DISOpticalFlow_create(getattr(cv2, f"DISOPTICAL_FLOW_PRESET_{name.split()[1].upper()}"))
    elif name == "Farneback":
        made = cv2.FarnebackOpticalFlow_create()
    elif name == "DeepFlow":
        made = cv2.optflow.createOptFlow_DeepFlow()
    else:
        made = cv2.optflow.DualTVL1OpticalFlow_create()
    # OpenCV's own take 8 bits.
    return lambda first, second, _: made.calc(
        np.round(first).astype(np.uint8), np.round(second).astype(np.uint8), None
    )


def status(name: str) -> float:
    """A line of this process's status (Linux), MB."""
    lines = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return int(lines[name].split()[0]) / 1024


def start_of_peak() -> float:
    """What is resident now (MB), from which on the peak counts."""
    Path("/proc/self/clear_refs").write_text("5")
    return status("VmRSS")


def main(name: str, frames: str, result: str, threads: str) -> None:
    find = method(name, int(threads))
    pairs = dict(np.load(frames))
    found: dict[str, np.ndarray | float] = {}
    names = [key.removesuffix("_first") for key in pairs if key.endswith("_first")]
    corner = np.s_[:96, :96]
    find(
        pairs[names[0] + "_first"][corner], pairs[names[0] + "_second"][corner], None
    )  # wakes threads, loads code
    before = start_of_peak()
    for pair in names:
        wall, processor = time.perf_counter(), time.process_time()
        found[pair] = find(pairs[pair + "_first"], pairs[pair + "_second"], pairs.get(pair + "_mask"))
        found[pair + "_processor"] = time.process_time() - processor
        found[pair + "_wall"] = time.perf_counter() - wall
    found["memory"] = status("VmHWM") - before
    np.savez(result, **found)


if __name__ == "__main__":
    main(*sys.argv[1:])
