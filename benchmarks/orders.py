"""Order of each time scheme on a smooth forced motion, against the exact solution of the discretised block.

A viscous block held at one side is driven at 60 Hz. Its steady motion u = Re z exp(i w t) with
(K + i w C - w^2 M) z = F is exact for the mesh, every mode included; the run starts on it. Errors are
relative to the amplitudes, after 24 ms; the order is log2 of the ratio to the line above.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

from plica import _engine as engine

SCHEMES: dict[str, Any] = {
    "HHT(-0.3)": engine.HilberHughesTaylor(alpha=-0.3),
    "HHT(-1/3)": engine.HilberHughesTaylor(alpha=-1 / 3),
    "HHT(-0.1)": engine.HilberHughesTaylor(alpha=-0.1),
    "trapezoidal": engine.Newmark(),
    "Newmark(1, 3/2)": engine.Newmark(beta=1.0, gamma=1.5),
}
FREQUENCY, END = 60.0, 0.024


def main() -> None:
    mesh = engine.block_mesh(corner=(0, 0, 0), size=(0.02, 0.01, 0.01), divisions=(6, 3, 3))
    fixed = np.zeros((len(mesh.points), 3), bool)
    fixed[mesh.node_sets["x_min"]] = True
    material = engine.Material(engine.Isotropic(20e3, 0.3), density=1040.0, viscosity=1.5)
    load = engine.Load(surface="x_max", traction=(30.0, 20.0, -10.0), frequency=FREQUENCY)

    def simulation(scheme: Any, step: float, **initial: Any) -> Any:
        return engine.Simulation(
            mesh,
            [material],
            ["block"],
            np.zeros(len(mesh.cells), int),
            fixed,
            scheme=scheme,
            step=step,
            solver_tolerance=1e-13,
            loads=[load],
            **initial,
        )

    probe = simulation(engine.Newmark(), 1e-4)
    free = np.flatnonzero(~fixed.ravel())
    n = fixed.size
    mass, stiffness, viscosity = (
        csr_array(m, shape=(n, n))[free][:, free] for m in (probe.mass, probe.stiffness, probe.viscosity)
    )
    force = np.asarray(probe.state()["load"])[free]
    w = 2 * np.pi * FREQUENCY
    z = spsolve((stiffness + 1j * w * viscosity - w**2 * mass).tocsc(), force)

    def field(values: np.ndarray) -> np.ndarray:
        full = np.zeros(n)
        full[free] = values
        return full.reshape(-1, 3)

    print("| scheme | step (us) | displacement | order | velocity | order | acceleration | order |")
    print("|" + " --- |" * 8)
    for name, scheme in SCHEMES.items():
        before = np.full(3, np.nan)
        for steps in (30, 60, 120, 240, 480):
            sim = simulation(
                scheme, END / steps, displacement=field(z.real), velocity=field((1j * w * z).real)
            )
            sim.advance(steps)
            exact = z * np.exp(1j * w * END)
            errors = np.array(
                [
                    np.linalg.norm(np.asarray(value).ravel()[free] - ((1j * w) ** k * exact).real)
                    / np.linalg.norm(w**k * z)
                    for k, value in enumerate((sim.displacement, sim.velocity, sim.acceleration))
                ]
            )
            orders = np.log2(before / errors)
            before = errors
            cells = " | ".join(f"{e:.2e} | {o:.2f}" for e, o in zip(errors, orders, strict=True))
            print(f"| {name} | {1e6 * END / steps:.0f} | {cells.replace('nan', '')} |", flush=True)


if __name__ == "__main__":
    main()
