"""Is the posterior of the tissue Gaussian? The same one by its Gaussian and by sampling.

    python identify_sampling.py          # 400 draws, 24 frames: under a minute
    python identify_sampling.py 200 12   # draws, frames

`MarginalLikelihood.value_and_gradient` is the log posterior density of log theta and its gradient: scipy's
optimisers and any sampler can call it. Here are BFGS for its maximum and Hamiltonian Monte Carlo in twenty
lines, beside `estimate`, on a small layered block seen from above.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
from scipy import optimize

import plica
from plica import identify
from plica.identify import Forcing, MarginalLikelihood, MotionModel, Observation, Prior, TissueParameter

FRAME_RATE, STEP, FLOW_SD, PRESSURE_SD = 4000.0, 125e-6, 0.1, 20.0
CAMERA = plica.Camera(mm_per_px=0.05, centre=(2e-3, 3e-3, 3e-3))
SCENE = plica.Scene(
    plica.Block(size=(4e-3, 6e-3, 3e-3), divisions=(1, 2, 2), order=2),
    {"body": plica.Tissue(E=5e3, nu=0.4, viscosity=0.3)},
    time=plica.Stepping(step=STEP, duration=STEP),
    supports=plica.Supports(fixed=("z_min", "y_min", "y_max")),
)
TRUTH = np.log([5e3, 0.3])


def recording(frames: int, seed: int) -> MarginalLikelihood:
    """Noisy flow of nine points of a block; a known wave of unknown size and unknown pressures push it."""
    rng = np.random.default_rng(seed)
    mesh = plica.build_mesh(SCENE.mesh)
    x, y = np.meshgrid([1e-3, 2e-3, 3e-3], [1.5e-3, 3e-3, 4.5e-3])
    shown = CAMERA.project(np.column_stack([x.ravel(), y.ravel(), np.full(9, 3e-3)]))[:, :2]
    points = identify.SurfacePoints.seen(mesh, "z_max", CAMERA, shown)
    times = STEP * (np.arange(2 * frames) + 0.7)
    wave = 200 * np.sin(2 * np.pi * 180 * times)[:, None]
    pattern = np.ascontiguousarray(Forcing.on_surface(mesh, "x_max", [0, 3e-3])[:, 1:])
    named = [
        TissueParameter(("body.E",), Prior(7e3, 0.7)),
        TissueParameter(("body.viscosity",), Prior(0.2, 0.7)),
    ]
    forcing = Forcing(pattern, wave, gain_sd=0.3)
    model = MotionModel(
        SCENE, named, Observation(points, CAMERA, np.ones((frames, 9, 2))), forcing, mesh=mesh
    )
    seen = model.responses(TRUTH, derivatives=False)
    pressure = rng.normal(0, PRESSURE_SD, frames)
    flow = seen.mean[0] + rng.normal(0, FLOW_SD, seen.mean[0].shape)
    for k in range(frames):  # a pressure held through frame k is seen from frame k on
        flow[k:] += pressure[k] * seen.lags[0][: frames - k, :, 0]
    return MarginalLikelihood(model.seeing(flow.reshape(frames, 9, 2)))


Density = Callable[[np.ndarray], tuple[float, np.ndarray]]


def hamiltonian(density: Density, start: np.ndarray, scale: np.ndarray, draws: int, seed: int) -> np.ndarray:
    """Draws (n, p) of a density by Hamiltonian Monte Carlo (Neal 2011).

    scale (p, p), with scale @ scale.T near the covariance, makes it round.
    """
    rng = np.random.default_rng(seed)
    x, (value, gradient) = start, density(start)
    kept = []
    for _ in range(draws):
        momentum = rng.normal(size=x.shape)
        step, there, now, slope = rng.uniform(0.4, 0.8), x, value, gradient
        energy = value - 0.5 * momentum @ momentum
        for _ in range(3):  # leapfrog
            momentum = momentum + 0.5 * step * scale.T @ slope
            there = there + step * scale @ momentum
            now, slope = density(there)
            if not np.isfinite(now):
                break
            momentum = momentum + 0.5 * step * scale.T @ slope
        if np.isfinite(now) and np.log(rng.uniform()) < now - 0.5 * momentum @ momentum - energy:
            x, value, gradient = there, now, slope
        kept.append(x)
    return np.array(kept)


def main(draws: int = 400, frames: int = 24) -> None:
    """Print both posteriors."""
    likelihood = recording(frames, seed=1)
    density = likelihood.value_and_gradient
    found = identify.estimate(likelihood)
    mode = optimize.minimize(
        lambda x: tuple(-part for part in density(x)), likelihood.prior_mean, jac=True, method="BFGS"
    )
    apart = np.abs(mode.x - found.mean) / found.sd
    print(f"scipy's maximum is {apart.max():.3f} sd from the estimate's, after {mode.nfev} evaluations")
    began = time.perf_counter()
    scale = np.linalg.cholesky(found.statistical_covariance)
    samples = hamiltonian(density, found.mean, scale, draws, seed=2)[draws // 10 :]
    moved = np.mean(np.any(np.diff(samples, axis=0) != 0, axis=1))
    print(f"{draws} draws in {time.perf_counter() - began:.0f} s, {100 * moved:.0f} % accepted\n")
    low, median, high = np.exp(np.quantile(samples, [0.025, 0.5, 0.975], axis=0))
    print(f"{'':16}{'truth':>9}{'Gaussian: median, 95 % interval':>38}{'sampled: median, 95 % interval':>38}")
    for j, name in enumerate(found.names):
        a, b = found.interval()[j]
        gaussian = f"{found.median[j]:.4g}  {a:.4g} - {b:.4g}"
        sampled = f"{median[j]:.4g}  {low[j]:.4g} - {high[j]:.4g}"
        print(f"{name:16}{np.exp(np.append(TRUTH, 0))[j]:9.4g}{gaussian:>38}{sampled:>38}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
