"""
A benchmark of one's own
========================

How wrong is a number, and what does it cost to be less wrong? A bar whose motion is known on paper.
"""

# %%
# A bar of tissue, held at one end, on which gravity begins to pull along its length at t = 0. Without lateral
# contraction its free end moves as a sum of longitudinal modes, which can be written down.

import time

import matplotlib.pyplot as plt
import numpy as np

import plica

LENGTH, E, DENSITY, GRAVITY = 0.02, 10e3, 1000.0, 9.81  # m, Pa, kg/m^3, m/s^2
SPEED = np.sqrt(E / DENSITY)  # m/s, of longitudinal waves
PERIOD = 4 * LENGTH / SPEED  # s


def exact(t):
    """m, displacement of the free end."""
    mode = np.arange(1000)[:, None]
    size = 16 * GRAVITY * LENGTH**2 / (np.pi**3 * SPEED**2) * (-1.0) ** mode / (2 * mode + 1) ** 3
    return (size * (1 - np.cos((2 * mode + 1) * np.pi * SPEED / (2 * LENGTH) * t))).sum(axis=0)


# %%
# One level of a method: cells, and steps in proportion, so that both errors fall together. The sum is
# checked, too: after half of the period the end must be at twice its place at rest.

at_rest = GRAVITY * DENSITY * LENGTH**2 / (2 * E)
assert abs(exact(np.array([PERIOD / 2]))[0] / (2 * at_rest) - 1) < 1e-6


def scene_of(order, cells, **scheme):
    """The bar with elements of an order; `scheme` as of plica.Stepping."""
    return plica.Scene(
        plica.Block(size=(LENGTH, 2e-3, 2e-3), divisions=(cells, 1, 1), order=order),
        {"body": plica.Tissue(E=E, nu=0.0, density=DENSITY)},
        supports=plica.Supports(fixed=["x_min"]),
        gravity=(GRAVITY, 0, 0),
        time=plica.Stepping(step=PERIOD / (20 * cells), duration=PERIOD, **scheme),
        output=plica.Output(probes=[(LENGTH, 1e-3, 1e-3)]),
    )


def measured(scene):
    """Seconds of the steps, median of five, and the error of the end over a period, of its largest way."""
    seconds = []
    for _ in range(5):
        simulation = plica.build_simulation(scene)
        begun = time.perf_counter()
        found = simulation.advance(scene.time.steps)
        seconds.append(time.perf_counter() - begun)
    off = found["probes"][:, 0, 0] - exact(found["time"])
    return np.median(seconds), np.sqrt(np.mean(off**2)) / (2 * at_rest)


# %%
# Three methods at four levels. An error beside its run time can be compared; either alone cannot.

methods = {
    "linear elements": {"order": 1},
    "quadratic elements": {"order": 2},
    "quadratic, trapezoidal rule": {"order": 2, "scheme": "newmark"},
}
figure, axes = plt.subplots(figsize=(6.5, 4))
for name, method in methods.items():
    rows = [measured(scene_of(cells=cells, **method)) for cells in (4, 8, 16, 32)]
    seconds, errors = np.transpose(rows)
    order = np.log2(errors[:-1] / errors[1:])
    print(f"{name:28} error {errors[0]:.2g} to {errors[-1]:.2g}, order {order.round(1)}")
    axes.loglog(1e3 * seconds, 100 * errors, "o-", label=name)
axes.set_xlabel("run time (ms)")
axes.set_ylabel("error (% of the largest way)")
axes.legend()
figure.tight_layout()

# %%
# Each level to the right has half the cells' length and half the step. What lies lower and farther to the
# left is better. No method has its full order here: a front at which the acceleration jumps runs along the
# bar. With a voice, where there is no closed form, take a finer mesh and a shorter step as the reference
# (:doc:`/uncertainty` does so), and other programs as further lines.
