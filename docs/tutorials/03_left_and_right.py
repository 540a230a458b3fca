"""
A stiffer left fold
===================

One fold under more tension than the other: which one leads, and by how much.
"""

# %%
# What differs on one side is written under ``left`` or ``right`` of a layer. The scene is no longer
# symmetric, so all of the larynx is solved.

import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plica

warnings.simplefilter("ignore", plica.CautionWarning)
folder = Path(tempfile.mkdtemp())
normal = plica.TISSUE_PRESETS["thesis_corrected"]
tissue = {layer: normal[layer] for layer in ("body", "ligament", "cover")}
for layer in ("ligament", "cover"):
    stiffer = {"E_fibre": 1.4 * normal[layer].E_fibre, "mu_fibre": 1.4 * normal[layer].mu_fibre}
    tissue[layer] = normal[layer].replace({"left": plica.TissueSide(**stiffer)})
scene = plica.Scene(
    plica.Larynx(larynx="coarse", order=2),
    tissue,
    airflow=plica.Airflow(subglottal_pressure="0.8 kPa", rise="5 ms"),
    contact=plica.Multipliers(),
    initial=plica.Initial(opening_velocity="0.1 m/s"),
    time=plica.Stepping(step="50 us", duration="0.08 s"),
)
run = plica.run(scene, folder / "stiffer_left", progress=False)

# %%
# Left and right are the patient's.

for name in ("fundamental_frequency", "amplitude_left", "amplitude_right", "left_right_phase"):
    measure = run.measures[name]
    print(
        f"{name:22} {measure.value:10.4g} {measure.unit}"
        if measure.value is not None
        else f"{name}: {measure.note}"
    )

# %%
late = run.between("60 ms", None)
figure, axes = plt.subplots(figsize=(7, 3.5))
edge = int(np.argmin(run["section_area"].mean(axis=0)))  # the narrowest section
for side, sign in (("left", -1), ("right", 1)):
    axes.plot(1e3 * late.time, 1e3 * sign * late[f"coronal_{side}"][:, edge, 0], label=side)
axes.set_xlabel("time (ms)")
axes.set_ylabel("edge from the midplane (mm)")
axes.legend()
figure.tight_layout()
