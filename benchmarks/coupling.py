"""Order of the three couplings of flow and tissue, where the flow separates at one section throughout.

The folds of the coarse larynx rest in equilibrium with the flow and are then given a small velocity in the
shape of their first symmetric mode. No contact; the first section of the free jet stays the same (asserted),
so the load is a smooth function of the positions. The flow is the thesis's (bernoulli, elliptic sections) or
the one by default (viscous_slit, sections that are cut). Errors of displacement and velocity are taken
against the iterated coupling at an eighth of the finest step, relative to the motion's size, at the end; they
contain the time scheme's own, which is second order.
The last columns show the coupling's alone: the difference to the iterated run of the same step.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from body import Body, held
from scipy.sparse.linalg import eigsh, factorized

from plica import _engine as engine

PRESSURE = 400.0  # Pa
FLOWS = {
    "bernoulli": (engine.Bernoulli(), engine.Elliptic()),
    "viscous_slit": (engine.ViscousSlit(), engine.Cut()),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--milliseconds", type=float, default=4.0)
    parser.add_argument("--flow", choices=FLOWS, default="bernoulli")
    parser.add_argument("--steps", type=int, default=40, help="of the coarsest run; doubled four times")
    options = parser.parse_args()
    end = options.milliseconds * 1e-3

    mesh = engine.larynx_mesh(**engine.larynx_preset("thesis_coarse"))
    material = engine.Material(engine.Isotropic(12e3, 0.45), density=1040.0, viscosity=1.0)
    body = Body(mesh, material, held(mesh, "wall"))

    def simulation(coupling: Any, step: float, **initial: Any) -> Any:
        model, area = FLOWS[options.flow]
        airflow = engine.Airflow(
            surface="airway", subglottal_pressure=PRESSURE, model=model, area=area, coupling=coupling
        )
        return body.simulation(
            scheme=engine.HilberHughesTaylor(alpha=-0.3),
            step=step,
            solver_tolerance=1e-12,
            airflow=airflow,
            **initial,
        )

    probe = simulation(engine.Lagged(), 1e-4)
    mass, stiffness = (body.on_free(m) for m in (probe.mass, probe.stiffness))
    solve = factorized(stiffness)
    u = np.zeros(len(body.free))
    for _ in range(60):  # equilibrium K u = f(u)
        load = simulation(engine.Lagged(), 1e-4, displacement=body.field(u)).state()["load"]
        change = solve(np.asarray(load)[body.free]) - u
        u += change
        if np.abs(change).max() < 1e-13:
            break
    else:
        raise RuntimeError(
            f"the folds find no equilibrium with the flow: last change {np.abs(change).max()} m"
        )
    # First mode that is symmetric: x of the left fold against x of the right.
    values, modes = eigsh(stiffness, k=6, M=mass, sigma=0.0)
    x = np.asarray(mesh.points)
    for value, mode in zip(values, modes.T, strict=True):
        shape, frequency = body.field(mode), np.sqrt(value) / 2 / np.pi
        if abs((np.sign(x[:, 0]) * shape[:, 0]).sum()) > 0.5 * np.abs(shape[:, 0]).sum():
            break
    else:
        raise RuntimeError("none of the first six modes is symmetric")
    shape *= np.sign((np.sign(x[:, 0]) * shape[:, 0]).sum()) / np.abs(shape).max()
    velocity = 0.05 * shape  # m/s, opening
    print(
        f"{options.flow}; mode at {frequency:.1f} Hz, {PRESSURE:g} Pa, "
        f"at rest displaced by {1e3 * np.abs(u).max():.3f} mm"
    )

    def run(coupling: Any, steps: int) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
        sim = simulation(coupling, end / steps, displacement=body.field(u), velocity=velocity)
        result = sim.advance(steps)
        if np.unique(result["separation"]).size != 1 or result["flow_stopped"].any():
            raise RuntimeError(
                f"the flow separates at sections {np.unique(result['separation'])}: choose a smaller motion"
            )
        return np.asarray(sim.displacement), np.asarray(sim.velocity), result

    iterated = engine.Iterated(tolerance=1e-11, max_sweeps=60, freeze_after=50)
    finest = options.steps * 16
    u_exact, v_exact, result = run(iterated, 8 * finest)
    print(
        f"separation at section {result['separation'][0]} throughout; "
        f"flow {1e6 * result['flow'].min():.1f} to {1e6 * result['flow'].max():.1f} cm3/s"
    )
    print(
        "| coupling | step (us) | displacement | order | velocity | order "
        "| coupling alone: u | order | v | order | sweeps |"
    )
    print("|" + " --- |" * 11)
    size_u, size_v = np.linalg.norm(u_exact - body.field(u)), np.linalg.norm(v_exact)
    counts = [options.steps * 2**k for k in range(5)]
    converged = {steps: run(iterated, steps) for steps in counts}
    for name, coupling in {
        "lagged": engine.Lagged(),
        "extrapolated": engine.Extrapolated(),
        "iterated": iterated,
    }.items():
        before = np.full(4, np.nan)
        for steps in counts:
            u_h, v_h, result = converged[steps] if name == "iterated" else run(coupling, steps)
            u_c, v_c, _ = converged[steps]
            errors = np.array(
                [
                    np.linalg.norm(u_h - u_exact) / size_u,
                    np.linalg.norm(v_h - v_exact) / size_v,
                    np.linalg.norm(u_h - u_c) / size_u,
                    np.linalg.norm(v_h - v_c) / size_v,
                ]
            )
            with np.errstate(invalid="ignore"):
                orders, before = np.log2(before / errors), errors
            cells = " | ".join(
                f"{f'{e:.2e}' if e else '0'} | {o:.2f}" for e, o in zip(errors, orders, strict=True)
            )
            print(
                f"| {name} | {1e6 * end / steps:.2f} | {cells.replace('nan', '')} | "
                f"{result['coupling_sweeps'].mean():.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
