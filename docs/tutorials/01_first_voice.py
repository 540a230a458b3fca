"""
A first voice
=============

A woman's voice, from lungs to lips, on a coarse mesh: computed, measured and looked at.
"""

# %%
# A scene is one voice and what you change of it. ``plica.Scene.of_voice`` takes ``"male"``, ``"female"``
# or ``"child"``; :doc:`every key of a scene </scene>` can be changed by its path, and a quantity is a
# text with a unit. A coarse mesh makes this tutorial quick; the numbers of the mesh ``demo`` are in
# :doc:`/voices`.

import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plica

warnings.simplefilter("ignore", plica.CautionWarning)  # they are printed at the end
folder = Path(tempfile.mkdtemp())
scene = plica.Scene.of_voice("female").replace(
    {"mesh.larynx": "coarse", "time.duration": "0.18 s", "output.start": "0.16 s"}
)
run = plica.run(scene, folder / "female", progress=False)

# %%
# A run is a mapping of its waveforms, in SI units, and has measures of the settled cycles. ``spread`` is
# the scatter between cycles: it says nothing of the model.

for name in ("fundamental_frequency", "open_quotient", "peak_flow", "sound_pressure_level"):
    measure = run.measures[name]
    print(f"{name:22} {measure.value:10.4g} {measure.unit:6} scatter {measure.spread:.2g}")

# %%
# What speaks against these numbers is said, too.

for caution in run.cautions:
    print("-", caution)

# %%
# Flow and least area of the glottis over the last cycles, and the sound at 0.3 m from the lips.

sound = run.sound()
late = run.between("0.15 s", None)
figure, (top, middle, bottom) = plt.subplots(3, 1, sharex=True, figsize=(7, 6))
top.plot(1e3 * late.time, 1e6 * late["minimum_area"])
top.set_ylabel("least area (mm²)")
middle.plot(1e3 * late.time, 1e6 * late["flow"])
middle.set_ylabel("flow (ml/s)")
time = np.arange(sound.pressure.size) / sound.rate
heard = time >= 0.15
bottom.plot(1e3 * time[heard], sound.pressure[heard])
bottom.set_ylabel("sound at 0.3 m (Pa)")
bottom.set_xlabel("time (ms)")
figure.tight_layout()

# %%
# ``sound.save("female.wav")`` writes it; ``plica report`` makes a page of the run with more pictures, and
# a player.
