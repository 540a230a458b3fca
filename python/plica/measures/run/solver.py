"""Energies at the end of a run and the effort of its steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from plica.measures.measure import Measure, absent, whole
from plica.measures.record import Array, Floats, time_step


def energy_measures(waveforms: Mapping[str, Array]) -> list[Measure]:
    """Energies and works at the end, and the largest error of their balance over the largest energy."""
    terms = (
        "kinetic_energy",
        "elastic_energy",
        "load_work",
        "flow_work",
        "viscous_loss",
        "numerical_loss",
        "contact_work",
        "air_supplied_energy",
        "air_viscous_energy",
        "air_inertial_energy",
    )
    found = [whole(name, float(waveforms[name][-1])) for name in terms if name in waveforms]
    if "friction_loss" in waveforms:
        found.append(whole("friction_loss", float(np.sum(waveforms["friction_loss"]))))
    if {"kinetic_energy", "elastic_energy", "energy_balance_error"} <= waveforms.keys():
        energy = np.asarray(waveforms["kinetic_energy"]) + np.asarray(waveforms["elastic_energy"])
        error = float(np.abs(waveforms["energy_balance_error"]).max())
        largest = float(energy.max())
        name = "energy_balance_error"
        found.append(whole(name, error / largest) if largest > 0 else absent(name, "no energy"))
    return found


def solver_measures(time: Floats, waveforms: Mapping[str, Array], cells: int) -> list[Measure]:
    """Steps, time step and duration; iterations, coupling sweeps, steps with a frozen coupling, and how many
    of the mesh's `cells` were inverted."""
    table: tuple[tuple[str, str, Callable[[Floats], float]], ...] = (
        ("mean_iterations", "iterations", np.mean),
        ("largest_iterations", "iterations", np.max),
        ("mean_coupling_sweeps", "coupling_sweeps", np.mean),
        ("coupling_frozen_fraction", "coupling_frozen", np.mean),
        ("coupling_converged_fraction", "coupling_converged", np.mean),
    )
    inverted = []
    if "inverted_tissue" in waveforms:
        most = int(np.max(waveforms["inverted_tissue"]))
        inverted.append(whole("inverted_tissue_max", most, f"of {cells} cells"))
    return [
        whole("steps", time.size),
        whole("time_step", time_step(time)),
        whole("duration", time.size * time_step(time)),
        *(
            whole(name, reduce(np.asarray(waveforms[key], dtype=float)))
            for name, key, reduce in table
            if key in waveforms
        ),
        *inverted,
    ]
