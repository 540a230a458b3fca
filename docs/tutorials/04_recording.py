"""
A recording
===========

A high-speed recording of a larynx, whose truth is known because it is drawn, measured.
"""

# %%
# In place of ``frames`` any recording can be read: AVI, TIFF, MP4, pictures, DICOM and camera files
# (:doc:`/recording_files`). Here the left fold moves farther than the right one and lags behind it.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from plica import synthetic, video

FPS, MM_PER_PX = 4000, 0.05
folder = Path(tempfile.mkdtemp())
drawn = synthetic.SyntheticGlottis(
    synthetic.Synthetic(
        height=160, width=160, frames=200, frequency=0.0473, amplitude=(7, 5), phase=(0.0, 0.6)
    )
)
np.save(folder / "glottis.npy", drawn.stack())

# %%
# ``until="glottis"`` leaves the motion of the tissue out, which takes longest. The same from the command
# line: ``plica glottis glottis.npy --fps 4000 --mm-per-px 0.05 -o analysis``.

settings = video.Settings(fps=FPS, mm_per_px=MM_PER_PX)
found = video.analyse(folder / "glottis.npy", folder / "analysis", settings, until="glottis", progress=False)

# %%
# Each measure of a recording has a 95 % interval, which holds the errors of the outline too.

truth = {"fundamental_frequency": FPS * 0.0473, "left_right_phase": -0.6}
for name in (
    "fundamental_frequency",
    "open_quotient",
    "amplitude_left",
    "amplitude_right",
    "left_right_phase",
):
    measure = found.measures[name]
    low, high = measure.interval or (float("nan"), float("nan"))
    true = f"   true {truth[name]:.4g}" if name in truth else ""
    print(f"{name:22} {measure.value:10.4g} [{low:.4g}, {high:.4g}] {measure.unit}{true}")

# %%
# A frame with its outline, and the area over time.

frame = int(np.argmax(found.area.total))
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5))
left.imshow(np.load(folder / "glottis.npy")[frame], cmap="gray")
left.contour(found.mask(frame), [0.5], colors="tab:orange")
left.set_axis_off()
right.plot(1e3 * found.time, MM_PER_PX**2 * found.area.total)
right.set_xlabel("time (ms)")
right.set_ylabel("glottal area (mm²)")
figure.tight_layout()
