"""Order of each time scheme on a smooth forced motion, against the exact solution of the discretised block.

A viscous block held at one side is driven at 60 Hz. Its steady motion u = Re z exp(i w t) with
(K + i w C - w^2 M) z = F is exact for the mesh, every mode included; the run starts on it. Errors are
relative to the amplitudes, after 24 ms; the order is log2 of the ratio to the line above. Central
differences have a lumped mass, whose own steady motion they are held against, and steps below their limit.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from benchmarks.harness.study import record, script_parser
from plica import _engine as engine
from plica.verify.bodies.body import SCHEMES, Body, held

FREQUENCY, END = 60.0, 0.024
STEPS = (30, 60, 120, 240, 480)
CENTRAL = "central differences"
COLUMNS = ["scheme", "step (us)", "displacement", "order", "velocity", "order", "acceleration", "order"]


def rows() -> Iterator[list[str]]:
    """A row for each scheme and step."""
    mesh = engine.block_mesh(corner=(0, 0, 0), size=(0.02, 0.01, 0.01), divisions=(6, 3, 3))
    material = engine.Material(engine.Isotropic(20e3, 0.3), density=1040.0, viscosity=1.5)
    body = Body(mesh, material, held(mesh, "x_min"))
    load = engine.Load(surface="x_max", traction=(30.0, 20.0, -10.0), frequency=FREQUENCY)

    w = 2 * np.pi * FREQUENCY

    def steady(lumped: bool) -> NDArray[np.complex128]:
        probe = body.simulation(scheme=engine.Newmark(), step=1e-4, loads=[load], lumped_mass=lumped)
        mass, stiffness, viscosity = (body.on_free(m) for m in (probe.mass, probe.stiffness, probe.viscosity))
        force = np.asarray(probe.state()["load"])[body.free]
        return np.asarray(spsolve(stiffness + 1j * w * viscosity - w**2 * mass, force))

    for name, scheme in (SCHEMES | {CENTRAL: engine.CentralDifferences()}).items():
        before, lumped = np.full(3, np.nan), name == CENTRAL
        z = steady(lumped)
        for steps in (16 * n for n in STEPS) if lumped else STEPS:
            sim = body.simulation(
                scheme=scheme,
                step=END / steps,
                solver_tolerance=1e-13,
                lumped_mass=lumped,
                loads=[load],
                displacement=body.field(z.real),
                velocity=body.field((1j * w * z).real),
            )
            sim.advance(steps)
            exact = z * np.exp(1j * w * END)
            errors = np.array(
                [
                    np.linalg.norm(np.asarray(value).ravel()[body.free] - ((1j * w) ** k * exact).real)
                    / np.linalg.norm(w**k * z)
                    for k, value in enumerate((sim.displacement, sim.velocity, sim.acceleration))
                ]
            )
            orders = np.log2(before / errors)
            before = errors
            cells = [cell for e, o in zip(errors, orders, strict=True) for cell in (f"{e:.2e}", f"{o:.2f}")]
            yield [name, f"{1e6 * END / steps:.3g}", *("" if cell == "nan" else cell for cell in cells)]


if __name__ == "__main__":
    script_parser(__doc__).parse_args()
    record("orders", COLUMNS, rows())
