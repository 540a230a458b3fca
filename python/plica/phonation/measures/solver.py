"""Energies at the end of a run and how hard its steps were."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from plica.measures.measure import Measure, absent, whole
from plica.measures.record import Array, Floats, time_step

slides = 0.25  # edges: more is said (a node beside the rim has been missed at 0.3)
contact_makes = 0.05  # of the largest energy or work of the loads: more is said


def energy_measures(waveforms: Mapping[str, Array]) -> list[Measure]:
    """Energies and works at the end, and the largest ledger error over the largest energy of the run."""
    terms = (
        "kinetic_energy",
        "elastic_energy",
        "load_work",
        "viscous_loss",
        "numerical_loss",
        "contact_work",
    )
    found = [whole(name, float(waveforms[name][-1])) for name in terms if name in waveforms]
    if "friction_loss" in waveforms:
        found.append(whole("friction_loss", float(np.sum(waveforms["friction_loss"]))))
    if {"kinetic_energy", "elastic_energy", "ledger_error"} <= waveforms.keys():
        energy = np.asarray(waveforms["kinetic_energy"]) + np.asarray(waveforms["elastic_energy"])
        error = float(np.abs(waveforms["ledger_error"]).max())
        largest = float(energy.max())
        name = "ledger_error"
        found.append(whole(name, error / largest) if largest > 0 else absent(name, "no energy"))
    return found


def solver_measures(time: Floats, waveforms: Mapping[str, Array]) -> list[Measure]:
    """Steps, time step and duration; iterations, coupling sweeps and steps with a frozen coupling."""
    table: tuple[tuple[str, str, Callable[[Floats], float]], ...] = (
        ("mean_iterations", "iterations", np.mean),
        ("largest_iterations", "iterations", np.max),
        ("mean_coupling_sweeps", "coupling_sweeps", np.mean),
        ("coupling_frozen_fraction", "coupling_frozen", np.mean),
        ("coupling_converged_fraction", "coupling_converged", np.mean),
        ("inverted_tissue_max", "inverted_tissue", np.max),
    )
    return [
        whole("steps", time.size),
        whole("time_step", time_step(time)),
        whole("duration", time.size * time_step(time)),
        *(
            whole(name, reduce(np.asarray(waveforms[key], dtype=float)))
            for name, key, reduce in table
            if key in waveforms
        ),
    ]


def _made_by_contact(waveforms: Mapping[str, Array]) -> float:
    """Energy that contact made, over the largest energy or work of the loads; 0 up to what is of no concern.

    Summed over the stretches of steps with contact: the work of contact without that of friction, less what
    the time scheme took in the same steps.
    """
    if "contact_work" not in waveforms:
        return 0.0
    touching = np.asarray(waveforms["contact_rows"]) > 0
    work = np.diff(np.asarray(waveforms["contact_work"], dtype=float), prepend=0.0)
    work += np.asarray(waveforms.get("friction_loss", 0.0), dtype=float)
    work -= np.maximum(np.diff(np.asarray(waveforms["numerical_loss"], dtype=float), prepend=0.0), 0.0)
    begins = np.flatnonzero(np.diff(touching, prepend=False) & touching)
    if not begins.size:
        return 0.0
    made = np.maximum(np.add.reduceat(np.where(touching, work, 0.0), begins), 0.0).sum()
    energy = np.asarray(waveforms["kinetic_energy"]) + np.asarray(waveforms["elastic_energy"])
    largest = max(float(energy.max()), float(np.max(waveforms["load_work"])))
    return float(made / largest) if made > contact_makes * largest else 0.0


def doubts(waveforms: Mapping[str, Array]) -> str:
    """One sentence on what is not to be trusted; empty where there is nothing."""
    found = []
    if "coupling_converged" in waveforms:
        converged = np.asarray(waveforms["coupling_converged"]) != 0
        if not converged.all():
            found.append(
                f"in {np.sum(~converged)} of {converged.size} steps the coupling of airflow and tissue did "
                "not converge"
            )
    if "contact_converged" in waveforms:
        converged = np.asarray(waveforms["contact_converged"]) != 0
        if not converged.all():
            error = np.asarray(waveforms["contact_gap_error"], dtype=float).max()
            found.append(
                f"in {np.sum(~converged)} of {converged.size} steps augmented multipliers ran out of "
                f"augmentations, with gap errors up to {error:.2g} m"
            )
    slid = float(np.max(waveforms.get("contact_slide", 0.0), initial=0.0))
    if slid > slides:
        found.append(
            f"the surfaces slid along each other by {slid:.2g} edges; a matched airway does not follow: "
            'nodes beside their rims may be missed (contact.airway = "triangulated" follows)'
        )
    if made := _made_by_contact(waveforms):
        found.append(
            f"contact made energy, {100 * made:.2g} % of the largest energy or work of the loads, as "
            'surfaces with mass do at impacts (contact.surface_mass = "redistributed")'
        )
    inverted = np.asarray(waveforms.get("inverted_tissue", []))
    if inverted.any():
        found.append(
            f"in {np.count_nonzero(inverted)} of {inverted.size} steps tissue cells were inverted, "
            f"{inverted.max()} at most"
        )
    return f"Caution: {', and '.join(found)}." if found else ""
