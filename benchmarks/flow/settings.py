"""What constants of the flow's presets are worth, one changed at a time: Middlebury's pairs that chose them.

    python -m benchmarks.flow.settings ../shared/data/flow/middlebury

Mean end-point error (px). The gradient's first constants (zeta 1, two fine levels, five warps, a spacing of
2) came from a coarse grid, in factors of 3.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import plica
from benchmarks.flow.layers import BOTH, CHARBONNIER, FIRST
from benchmarks.flow.middlebury import CHOSE, read_frames, row
from benchmarks.harness.study import record, script_parser
from plica.video.motion.flow import endpoint_error, flow
from plica.video.motion.flow_file import read_flow

TAU_D, TAU_S = 0.01, 0.001  # of gradient
LORENTZIAN = {"data_penalty": "lorentzian", "smooth_penalty": "lorentzian"}
ROBUST: dict[str, dict[str, Any]] = {
    "as it is": {},
    **{f"lambda {value:g}": {"smoothness": value} for value in (0.02, 0.09, 0.15)},
    **{f"tau_S {value:g}": {"smooth_scale": value} for value in (0.03, 0.05, 0.2)},
    **{f"tau_D {value:g}": {"data_scale": value} for value in (2.5, 6.0)},
    "5 warps a level": {"warps": 5},
    "3 levels in the later stages": {"fine_levels": 3},
    "Charbonnier penalties (tau 0.35, 0.01)": CHARBONNIER,
}
GRADIENT: dict[str, dict[str, Any]] = {
    "at first": {},
    "ten warps": {"warps": 10},
    "ten warps of 40 sweeps": {"warps": 10, "sweeps": 40},
    "two stages, three warps": {"stages": 2, "warps": 3},
    **{f"lambda {value:g}": {"smoothness": value} for value in (0.03, 0.3)},
    **{f"zeta {value:g}": {"gradient_noise": value} for value in (0.3, 3.0)},
    **{
        f"both tau {times} times": {"data_scale": times * TAU_D, "smooth_scale": times * TAU_S}
        for times in (3, 10)
    },
    "Lorentzian penalties (tau 0.3 px, 0.1; lambda 0.45; ten warps)": LORENTZIAN
    | {"data_scale": 0.3, "smooth_scale": 0.1, "smoothness": 0.45, "warps": 10},
    "zeta 0.3, four fine levels": BOTH,
    "the same, four warps": BOTH | {"warps": 4},
    "the same, three warps, spacing 1.5: as it is": BOTH | {"warps": 3, "spacing": 1.5},
}


def rows(data: Path) -> Iterator[list[str]]:
    """A row for each setting."""
    frames = read_frames(data, CHOSE)
    truth = {name: read_flow(data / name / "flow10.flo") for name in CHOSE}
    given = [(f"`robust`, {name}", {"preset": "robust"} | change) for name, change in ROBUST.items()]
    given += [(f"`gradient`, {name}", FIRST | change) for name, change in GRADIENT.items()]
    for name, options in given:
        found = {
            pair: endpoint_error(
                flow(frames[f"{pair}_first"], frames[f"{pair}_second"], **options).flow, known
            )
            for pair, known in truth.items()
        }
        yield [name, *row(found, CHOSE)]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("data", type=Path, help="folder of the Middlebury sequences")
    data = parser.parse_args().data
    plica.set_threads(1)
    record("flow_settings", ["setting", *CHOSE, "mean"], rows(data))


if __name__ == "__main__":
    main()
