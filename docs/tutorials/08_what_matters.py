"""
What matters in a voice
=======================

Which of five numbers of a scene decide pitch, flow and collision: Sobol's indices, with reduced voices.
"""

# %%
# A reduced voice (:doc:`/reduction`) of the example's folds, and the ranges of five of its numbers. They are
# taken as evenly likely: an index is of these ranges, and of the model. The basis is smaller than usual,
# which makes a voice twice as quick: against the full voice at 0.88 kPa pitch, open quotient and peak flow
# are off by up to 0.2 %, the impulse of collisions by 12 %.

import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plica
from plica import sweep

warnings.simplefilter("ignore", plica.CautionWarning)
folder = Path(tempfile.mkdtemp())
scene = plica.Scene(
    plica.Larynx(larynx="coarse", order=2),
    "thesis_corrected",
    airflow=plica.Airflow(subglottal_pressure="0.8 kPa", rise="5 ms"),
    contact=plica.Multipliers(),
    symmetry="quarter",
    initial=plica.Initial(opening_velocity="0.1 m/s"),
    time=plica.Stepping(step="100 us", duration="80 ms"),
)
plica.reduce(scene, folder / "basis.h5", modes=100, contact_vectors=60)
scene.replace({"reduction": {"basis": str(folder / "basis.h5")}}).save(folder / "voice.toml")

(folder / "study.toml").write_text(
    """
scene = "voice.toml"
design = "sobol"
samples = 16

[vary]
airflow.subglottal_pressure = "0.72:0.88 kPa"
tissue.body.mu_fibre = "27:33 kPa"
tissue.cover.mu_fibre = "9:11 kPa"
tissue.cover.E = "0.9:1.1 kPa"
tissue.cover.viscosity = "0.126:0.154 Pa s"
"""
)

# %%
# Sixteen samples of Saltelli's design are 16 (5 + 2) voices. From a shell this is ``plica sweep study.toml -o
# study``, which a cluster can share (:doc:`/sweeps`).

plica_sweep = [Path(sys.executable).with_name("plica"), "sweep"]
subprocess.run([*plica_sweep, folder / "study.toml", "-o", folder / "study", "--quiet"], check=True)
found = sweep.Sweep.load(folder / "study")
print(len(found), "voices:", found.counts)

# %%
# The total index is the share of a measure's variance that goes if a number is fixed. With so few samples the
# intervals (95 %) are wide: they fall with the root of ``samples``, and where they overlap, numbers cannot be
# ranked.

measures = ("fundamental_frequency", "open_quotient", "peak_flow", "contact_impulse")
figure, panels = plt.subplots(1, 4, figsize=(9, 3), sharey=True)
for axes, name in zip(panels, measures, strict=True):
    of = sweep.indices(found, name)
    total = [index for index in of.found if index.kind == "total"]
    values = np.array([index.value for index in total])
    ends = np.array([index.interval for index in total])
    axes.barh(range(len(total)), values, xerr=np.abs(ends.T - values), color="tab:blue", capsize=2)
    axes.set_title(name.replace("_", " "), fontsize=9)
    axes.set_xlim(0, 1.3)
panels[0].set_yticks(range(len(found.keys)), [key.partition(".")[2] for key in found.keys], fontsize=8)
figure.supxlabel("total index")
figure.tight_layout()
