"""
A sweep of pressure
===================

How pitch and flow follow the lung pressure, with voices of few coordinates, which are quick.
"""

# %%
# A *reduced* voice moves as a combination of a few hundred vectors. Making them costs as much as some
# hundred steps, and they serve every pressure (:doc:`/reduction`).

import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt

import plica

warnings.simplefilter("ignore", plica.CautionWarning)
folder = Path(tempfile.mkdtemp())
scene = plica.Scene(
    plica.Larynx(larynx="coarse", order=2),
    "thesis_corrected",
    airflow=plica.Airflow(subglottal_pressure="0.8 kPa", rise="5 ms"),
    contact=plica.Multipliers(),
    symmetry="quarter",
    initial=plica.Initial(opening_velocity="0.1 m/s"),
    time=plica.Stepping(step="50 us", duration="0.1 s"),
)
plica.reduce(scene, folder / "basis.h5")
scene = scene.replace({"reduction": {"basis": str(folder / "basis.h5")}})

# %%
# One run a pressure. Folders are kept, so that a script that is run again continues where it stopped.

pressures = (200, 400, 600, 800, 1000, 1200)  # Pa
runs = [
    plica.run(scene.replace({"airflow.subglottal_pressure": p}), folder / str(p), progress=False)
    for p in pressures
]

# %%
# A measure without a value says why: below onset, for instance, there are no cycles.

for pressure, run in zip(pressures, runs, strict=True):
    pitch = run.measures["fundamental_frequency"]
    print(pressure, "Pa:", f"{pitch.value:.1f} Hz" if pitch.value is not None else pitch.note)

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5))
for axes, name, factor, label in (
    (left, "fundamental_frequency", 1, "f0 (Hz)"),
    (right, "peak_flow", 1e6, "peak flow (ml/s)"),
):
    found = [run.measures[name] for run in runs]
    shown = [(p, factor * m.value) for p, m in zip(pressures, found, strict=True) if m.value is not None]
    axes.plot(*zip(*shown, strict=True), "o-")
    axes.set_xlabel("lung pressure (Pa)")
    axes.set_ylabel(label)
figure.tight_layout()

# %%
# For studies of more than a few runs there is ``plica sweep``.
