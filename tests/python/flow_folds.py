"""Small scenes with an airflow for the tests of equilibria and of small oscillations."""

from __future__ import annotations

from typing import Any

import numpy as np

import plica
from conftest import TINY_LARYNX
from plica.scene.tissue_presets import TISSUE_PRESETS

__all__ = ["folds", "grown", "stepped"]


def folds(gap: float = 0.0, stiffness: float = 1.0, viscosity: float = 1.0, **changes: Any) -> plica.Scene:
    """A very coarse larynx that is wider by `gap` (m) on each side at every height, of scaled tissue."""
    preset = plica.Larynx(larynx="thesis_coarse", options=plica.LarynxOptions(**TINY_LARYNX))
    sections = [(z, minor + gap) for z, minor in preset.all_options()["sections"]]
    options = plica.LarynxOptions(**TINY_LARYNX, sections=sections)
    tissue = {}
    for name, layer in TISSUE_PRESETS["thesis_corrected"].items():
        fields = {key: value for key, value in layer.model_dump().items() if value is not None}
        for key in ("E", "E_fibre", "mu_fibre"):
            fields[key] *= stiffness
        fields["viscosity"] *= viscosity
        tissue[name] = plica.Tissue(**fields)
    return plica.Scene(
        plica.Larynx(larynx="thesis_coarse", options=options),
        tissue,
        time=plica.Stepping(step=2e-5, duration=1e-3),
        airflow=plica.Airflow(
            subglottal_pressure=800.0,
            area=plica.Cut(sections=40),
            coupling=plica.Coupling(iterated=plica.Iterated(tolerance=1e-8)),
        ),
    ).replace(changes)


def stepped(
    scene: plica.Scene, pressure: float, start: Any, steps: int, basis: Any = None, mesh: Any = None
) -> np.ndarray:
    """(steps, s) m^2, areas of the sections in time steps from displacement and velocity."""
    driven = scene.replace({"airflow.subglottal_pressure": pressure, "airflow.rise": 0.0})
    simulation = plica.build_simulation(driven, mesh, start[0], start[1], basis)
    return np.asarray(simulation.advance(steps, ["section_area"])["section_area"])


def grown(signals: np.ndarray, step: float, skip: float = 0.3) -> complex:
    """[1/s] s of signals (steps, k), each Re(A exp(s t)), from instants a sixth of a period apart."""
    scale = np.abs(signals).max(axis=0)
    signals = signals[int(skip * len(signals)) :, scale > 0.1 * scale.max()]
    spectrum = np.abs(np.fft.rfft(signals * np.hanning(len(signals))[:, None], axis=0)).sum(axis=1)
    period = len(signals) / max(int(np.argmax(spectrum[1:])) + 1, 1)
    lag = max(int(period / 6), 1)
    before, here, after = signals[: -2 * lag], signals[lag:-lag], signals[2 * lag :]
    a, b = np.linalg.lstsq(np.column_stack((here.ravel(), before.ravel())), after.ravel(), rcond=None)[0]
    root = np.roots([1, -a, -b])[0]
    return complex(np.log(root if root.imag > 0 else np.conj(root)) / (lag * step))
