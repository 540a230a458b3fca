"""CalculiX on equal bars that meet (R3): the same mesh, penalty and scheme, as its input file has them.

Its contact shortens steps by rules of its own and takes no fixed ones, so the step of ours is its longest.
Strains are small to it as well: at a hundredth of the speed it finds a hundredth of the motion. It reads no
more than 20 characters of a number.
"""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.verify.bodies.bars import Problem
from plica.verify.bodies.impact import PENALTY, displacement_error, first_impact

__all__ = ["deck", "measure"]

Array = NDArray[np.float64]
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
"""Of C3D4, S1 to S4."""
LIMIT = 3600.0
"""s; longer is a hang."""


def deck(problem: Problem, alpha: float) -> str:
    """The input of the whole run with the HHT scheme of this alpha, penalty contact from face to face."""
    bar = problem.bar
    body, parts = problem.build(bar)
    steps = round(problem.duration / bar.step)
    return "\n".join(
        [
            "*NODE, NSET=ALL",
            *(f"{n}, {x:.12g}, {y:.12g}, {z:.12g}" for n, (x, y, z) in enumerate(body.mesh.points, 1)),
            "*ELEMENT, TYPE=C3D4, ELSET=BARS",
            *(f"{n}, " + ", ".join(str(a + 1) for a in cell) for n, cell in enumerate(body.mesh.cells, 1)),
            *_surface(body.mesh, "STRUCK", "a.x_max"),
            *_surface(body.mesh, "STRIKES", "b.x_min"),
            "*MATERIAL, NAME=TISSUE",
            "*ELASTIC",
            f"{bar.E:.12g}, {bar.nu:.12g}",
            "*DENSITY",
            f"{bar.density:.12g}",
            "*SOLID SECTION, ELSET=BARS, MATERIAL=TISSUE",
            "*SURFACE INTERACTION, NAME=PENALTY",
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
            f"{PENALTY * bar.modulus / bar.edge:.12g}",
            "*CONTACT PAIR, INTERACTION=PENALTY, TYPE=SURFACE TO SURFACE",
            "STRIKES, STRUCK",
            "*BOUNDARY",
            "ALL, 2, 3",
            "*INITIAL CONDITIONS, TYPE=VELOCITY",
            *(f"{n}, 1, {v:.12g}" for n, v in enumerate(parts["velocity"][:, 0].tolist(), 1)),
            f"*STEP, INC={100 * steps}",
            f"*DYNAMIC, ALPHA={alpha:.12g}",
            ", ".join(f"{t:.12g}" for t in (bar.step, steps * bar.step, 1e-9 * bar.step, bar.step)),
            "*NODE PRINT, NSET=ALL",
            "U",
            "*CONTACT PRINT, SLAVE=STRIKES, MASTER=STRUCK",
            "CF",
            "*EL PRINT, ELSET=BARS, TOTALS=ONLY",
            "ELSE, ELKE",
            "*END STEP",
            "",
        ]
    )


def _surface(mesh: Any, name: str, of_mesh: str) -> Iterator[str]:
    wanted = {tuple(sorted(face)) for face in np.asarray(mesh.surfaces[of_mesh]).tolist()}
    yield f"*SURFACE, NAME={name}, TYPE=ELEMENT"
    for number, cell in enumerate(np.asarray(mesh.cells).tolist(), 1):
        for side, face in enumerate(FACES, 1):
            if tuple(sorted(cell[k] for k in face)) in wanted:
                yield f"{number}, S{side}"


def measure(problem: Problem, text: str) -> dict[str, float]:
    """What a run of this input gave, as `impact.measure` has it; RuntimeError where it does not end."""
    with tempfile.TemporaryDirectory() as directory:
        Path(directory, "bars.inp").write_text(text, encoding="ascii")
        try:
            finished = subprocess.run(
                ["ccx", "bars"],
                cwd=directory,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
                capture_output=True,
                text=True,
                check=False,
                timeout=LIMIT,
            )
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"ccx did not end within {LIMIT:g} s.") from None
        if finished.returncode:
            errors = re.findall(r"\*ERROR[^*]*", finished.stdout) or [finished.stderr]
            raise RuntimeError(f"ccx ended with {finished.returncode}: {' '.join(errors[-1].split())}")
        printed = Path(directory, "bars.dat").read_text(encoding="ascii")
    return _judged(problem, printed)


def _judged(problem: Problem, printed: str) -> dict[str, float]:
    bar = problem.bar
    body, parts = problem.build(bar)
    x = np.asarray(body.mesh.points)[:, 0]
    own = parts["measured"]
    time, moved = _blocks(printed, r"displacements \(vx,vy,vz\)")
    if not len(time) or time[-1] < (1 - 1e-6) * problem.duration:
        raise RuntimeError(f"ccx ended before t = {problem.duration:g} s.")
    moved = moved.reshape(len(time), len(x), 4)[:, :, 1]
    _, force = _blocks(printed, r"statistics for slave set", r"total surface force")
    internal, kinetic = (_blocks(printed, rf"total {kind} energy")[1] for kind in ("internal", "kinetic"))
    speed = parts["velocity"][:, 0]
    brought = 0.5 * bar.density * 2 * bar.length * bar.edge**2 * float(np.abs(speed).max()) ** 2
    pressure = np.abs(force.reshape(len(time), -1)[:, 0]) / bar.edge**2
    struck, strikes = (np.flatnonzero((np.abs(x) < 1e-9 * bar.length) & side) for side in (~own, own))
    return {
        "displacement": displacement_error(problem, x[own] - x[own].min(), time, moved[:, own]),
        **first_impact(problem, time, pressure),
        "energy end": float(internal[-1, 0] + kinetic[-1, 0]) / brought,
        # Both faces have the same nodes in the same order.
        "penetration": float(max((moved[:, struck] - moved[:, strikes]).max(), 0.0) / bar.edge),
    }


def _blocks(printed: str, title: str, below: str = "") -> tuple[Array, Array]:
    """Times and numbers (times, any) of the blocks of a title, from the line `below` it on."""
    between = rf"[\s\S]*?{below}.*\n\s*" if below else ""
    found = re.findall(rf"{title}.*time +(\S+)\s*\n{between}((?:[ \d.E+-]+\n)+)", printed)
    return (
        np.array([float(time) for time, _ in found]),
        np.array([np.array(numbers.split(), float) for _, numbers in found]),
    )
