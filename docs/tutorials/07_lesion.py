"""
A polyp
=======

A soft bump on the left fold: what it does to the sound, to the phase of the folds and to their contact.
"""

# %%
# A lesion is a patch of a fold with tissue of its own, which may protrude (:doc:`/lesions`). Both larynges
# here have the same gap between the folds, so that the polyp alone differs. The mesh needs more lines around
# the airway than usual: a polyp that falls between nodes is told by a caution.

import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plica

warnings.simplefilter("ignore", plica.CautionWarning)
folder = Path(tempfile.mkdtemp())
healthy = plica.Scene.of_voice("female").replace(
    {
        "symmetry": None,  # left and right differ
        "strain": None,  # linear tissue is quicker
        "mesh.larynx": "coarse",
        "mesh.options.around": 24,
        "mesh.folds.gap": "0.25 mm",
        "time": {"step": "100 us", "duration": "70 ms"},
    }
)
polyp = healthy.replace(
    {
        "mesh.folds.lesions": [
            {
                "fold": "left",
                "below_edge": "0.6 mm",
                "size": ["5 mm", "1.6 mm", "0.8 mm"],
                "stiffness": 0.5,
                "protrusion": "0.2 mm",
            }
        ]
    }
)
runs = {
    name: plica.run(scene, folder / name, progress=False)
    for name, scene in (("healthy", healthy), ("polyp", polyp))
}

# %%
# Left and right are the patient's; the phase is negative where the left fold lags.

names = (
    "fundamental_frequency",
    "open_quotient",
    "sound_pressure_level",
    "left_right_phase",
    "contact_impulse",
    "peak_contact_pressure",
)
print(f"{'':22}" + "".join(f"{name:>12}" for name in runs))
for name in names:
    found = [run.measures[name] for run in runs.values()]
    told = "".join(f"{'-' if one.value is None else format(one.value, '.4g'):>12}" for one in found)
    print(f"{name:22}{told}  {found[0].unit}")

# %%
# Sound, edges of the folds in the middle of the glottis, and the force with which they collide. The polyp
# bulges into the gap, so the folds meet to the right of the midplane, and the left one lags.

figure, panels = plt.subplots(3, 2, sharex="col", sharey="row", figsize=(8, 6))
for column, (name, run) in zip(panels.T, runs.items(), strict=True):
    late = run.between("50 ms", None)
    sound = run.sound()
    time = np.arange(sound.pressure.size) / sound.rate
    heard = (time >= 0.05) & (time <= run.time[-1])
    column[0].set_title(name)
    column[0].plot(1e3 * time[heard], sound.pressure[heard])
    edge = int(np.argmin(run["section_area"].mean(axis=0)))  # the narrowest section
    for side in ("left", "right"):
        column[1].plot(1e3 * late.time, 1e3 * late[f"coronal_{side}"][:, edge, 0], label=side)
    column[2].plot(1e3 * late.time, 1e3 * np.linalg.norm(late["contact_force_first"], axis=1))
    column[2].set_xlabel("time (ms)")
panels[0, 0].set_ylabel("sound at 0.3 m (Pa)")
panels[1, 0].set_ylabel("edges (mm)")
panels[1, 0].legend()
panels[2, 0].set_ylabel("contact force (mN)")
figure.tight_layout()
