"""
Three vowels
============

The same folds under three vocal tracts: /a/, /i/ and /u/, as sound, with their formants.
"""

# %%
# The woman's voice between lungs and lips (:doc:`/voices`), on a coarse mesh and with linear tissue,
# which are quick. Only the shape of the tract differs; its resonances act back on the folds.

import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt

import plica

warnings.simplefilter("ignore", plica.CautionWarning)
folder = Path(tempfile.mkdtemp())
speech = plica.Scene.of_voice("female").replace(
    {"mesh.larynx": "coarse", "strain": None, "time": {"step": "50 us", "duration": "0.2 s"}}
)
runs = {
    vowel: plica.run(speech.replace({"tract.vowel.name": vowel}), folder / vowel, progress=False)
    for vowel in ("a", "i", "u")
}

# %%
# ``save`` writes WAV files of one full scale, so that their loudness can be compared: listen to them.

for vowel, run in runs.items():
    run.sound().save(folder / f"{vowel}.wav", full_scale="5 Pa")
    names = ("fundamental_frequency", "sound_pressure_level", "flow_h1_h2", "formant_1", "formant_2")
    found = [run.measures[name] for name in names]
    told = (
        f"{item.quantity.label}: {item.value:.4g} {item.unit}" for item in found if item.value is not None
    )
    print(f"/{vowel}/", ", ".join(told))

# %%
# The formants of the model are the bands in which harmonics are strong, whatever the folds do.

figure, panels = plt.subplots(1, 3, figsize=(9, 3.2), sharey=True)
for axes, (vowel, run) in zip(panels, runs.items(), strict=True):
    heard = run.sound()
    axes.specgram(heard.pressure, NFFT=1024, Fs=heard.rate, noverlap=896, vmin=-120, cmap="magma")
    for number in (1, 2, 3):
        axes.axhline(run.measures[f"formant_{number}"].value, color="white", lw=0.6, ls="--")
    axes.set_ylim(0, 4500)
    axes.set_title(f"/{vowel}/")
    axes.set_xlabel("time (s)")
panels[0].set_ylabel("frequency (Hz)")
figure.tight_layout()
