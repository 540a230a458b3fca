"""
Tissue from a recording
=======================

How stiff is tissue that is seen moving? A block whose stiffness is known is filmed, and asked for it.
"""

# %%
# In the recording a block of soft tissue, held below and at its ends, is shaken by a pressure on one face. A
# block is quick; a larynx is asked in the same way and takes minutes (:doc:`/identification`). The run that
# is filmed has half the step of the model that will explain it.

import tempfile
import warnings
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

import plica
from plica.identify import Settings, identify

warnings.simplefilter("ignore", plica.CautionWarning)  # strains of 12 %: the model is linear, as the run is
folder = Path(tempfile.mkdtemp())


def block(stiffness, viscosity, step, **parts):
    """A block of 4 x 6 x 3 mm."""
    return plica.Scene(
        plica.Block(size=("4 mm", "6 mm", "3 mm"), divisions=(6, 8, 4), order=2),
        {"body": plica.Tissue(E=stiffness, nu=0.4, viscosity=viscosity)},
        supports=plica.Supports(fixed=("z_min", "y_min", "y_max")),
        time=plica.Stepping(step=step, duration="12 ms"),
        **parts,
    )


shaken = block(
    "5 kPa",
    "0.3 Pa s",
    "62.5 us",
    loads=[
        plica.Load(surface="x_max", traction=("150 Pa", 0, 0), frequency="180 Hz", phase=-np.pi / 2),
        plica.Load(surface="x_max", traction=("100 Pa", 0, 0), frequency="410 Hz", phase=-np.pi / 2),
    ],
    output=plica.Output(every="250 us"),
)
run = plica.run(shaken, folder / "run", progress=False)

# %%
# Seen from above at 4000 frames a second. A film has its true motion beside it; here that takes the place of
# ``plica video``, with an error of 0.03 px such as an analysis makes.

camera = plica.Camera(mm_per_px=0.08, width=64, height=96, centre=(2e-3, 3e-3, 3e-3))
plica.write_film(plica.film(run, camera), folder / "clip.npy")
with h5py.File(folder / "clip.truth.h5") as truth:
    kept = {name: truth[name][()] for name in ("flow", "visible", "projection")}
kept["flow"] = kept["flow"] + np.random.default_rng(7).normal(0, 0.03, kept["flow"].shape)
np.savez(folder / "seen.npz", **kept, fps=4000.0)

# %%
# The model knows geometry, supports and density, but neither stiffness, nor viscosity, nor the pressure. The
# first guess is 40 % too stiff, and a third too low in viscosity; the prior allows a factor of four up and
# down. ``identify`` is ``plica identify`` of the command line. It estimates on two meshes, this one and one
# with half of the divisions: how far the estimate moves between them is in the intervals, which are wide for
# that.

guess = block("7 kPa", "0.2 Pa s", "125 us")
settings = Settings(
    surface="x_max",  # where pressures act, at two heights
    heights=("0 mm", "3 mm"),
    seen="z_max",
    from_rest=True,
    spacing=10,
    closed_below=0,  # there is no glottis that closes
)
found = identify(folder / "seen.npz", guess, folder / "tissue", settings, progress=False)
print(found.table)

# %%
# Read the warnings before the table.

for warning in found.warnings:
    print("-", warning)
print(f"The model follows {100 * found.picture.explained:.1f} % of the motion's variance.")

# %%
# One point of the tissue, seen and as the model has it; and what prior and recording say of the stiffness.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5))
picture, posterior = found.picture, found.posterior
point = int(np.argmax(np.nanstd(picture.observed[:, :, 0], axis=0)))
left.plot(1e3 * picture.time, picture.observed[:, point, 0], "k.", label="seen")
left.plot(1e3 * picture.time, picture.predicted[:, point, 0], label="model")
left.set_xlabel("time (ms)")
left.set_ylabel("motion to the right (px a frame)")
left.legend()
for row, (name, true) in enumerate((("body.E", 5e3), ("viscosity", 0.3))):
    place = posterior.names.index(name)
    prior, known = posterior.prior_interval()[place], posterior.interval()[place]
    right.hlines(row - 0.1, *(prior / true), color="silver", lw=6, label="prior, 95 %" if row == 0 else None)
    right.hlines(row + 0.1, *(known / true), color="C0", lw=6, label="estimate, 95 %" if row == 0 else None)
right.axvline(1, color="k", lw=0.8)
right.set_xscale("log")
right.minorticks_off()
right.set_xticks((0.25, 0.5, 1, 2, 4), ("1/4", "1/2", "1", "2", "4"))
right.set_yticks((0, 1), ("stiffness", "viscosity"))
right.set_ylim(-0.6, 1.6)
right.set_xlabel("value over the truth")
right.legend()
figure.tight_layout()

# %%
# **A voice makes the pressures that drive it**, which the estimate takes to be independent: of a voice there
# are medians without intervals (:doc:`/identification`).
