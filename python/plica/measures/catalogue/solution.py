"""Energies, accuracy of the solution, and effort."""

from __future__ import annotations

from functools import partial

from plica.measures.catalogue.quantity import Quantity

__all__ = ["ROWS"]

_energy = partial(Quantity, group="Energy", source="run")
_accuracy = partial(Quantity, group="Accuracy of the solution", source="run", diagnostic=True)
_solver = partial(Quantity, group="Solver", source="run", diagnostic=True)

ROWS = (
    _energy("kinetic_energy", "Kinetic energy", "J", "at the end of the run"),
    _energy("elastic_energy", "Elastic energy", "J", "at the end of the run"),
    _energy("load_work", "Work of the loads", "J", "at the end of the run, the airflow's included"),
    _energy("flow_work", "Work of the airflow", "J", "on the tissue, at the end of the run"),
    _energy("viscous_loss", "Viscous loss", "J", "at the end of the run"),
    _energy("contact_work", "Work of the contact", "J", "at the end of the run"),
    _energy("friction_loss", "Friction loss", "J", "minus the work of friction, over the run"),
    _energy(
        "air_supplied_energy",
        "Energy supplied to the air",
        "J",
        "by the pressure difference along the glottis, over the run",
    ),
    _energy("air_viscous_energy", "Air's viscous loss", "J", "of the energy supplied, over the run"),
    _energy("air_inertial_energy", "Work that accelerates the air", "J", "in the glottis, over the run"),
    _accuracy(
        "contact_force_balance",
        "Imbalance of the forces",
        "1",
        "largest magnitude of the sum of both forces over the largest force",
    ),
    _accuracy(
        "deepest_gap", "Deepest gap", "m", "of the whole run, at a node; negative is overlap", shown="um"
    ),
    _accuracy("overlap_volume_max", "Largest overlap", "m^3", "of the whole run, confirmed at nodes"),
    _accuracy(
        "edge_overlap_volume_max",
        "Largest overlap, edge to edge",
        "m^3",
        "of the whole run, between crossed edges, where no node meets the facing surface",
    ),
    _accuracy(
        "largest_multiplier",
        "Largest pull of a contact force",
        "N",
        "of the whole run, at one node; contact can only push, so that a pull (> 0) is an error",
        shown="uN",
    ),
    _accuracy("numerical_loss", "Numerical loss", "J", "at the end of the run"),
    _accuracy(
        "energy_balance_error",
        "Energy balance error",
        "1",
        "largest of what does not balance, over the largest energy of the run",
    ),
    _solver("steps", "Steps", "1", "computed"),
    _solver("time_step", "Time step", "s", shown="us"),
    _solver("duration", "Time simulated", "s"),
    _solver("mean_iterations", "Iterations per step", "1", "mean over all steps"),
    _solver("largest_iterations", "Iterations per step, at most", "1"),
    _solver(
        "mean_coupling_sweeps",
        "Coupling sweeps per step",
        "1",
        "mean over all steps: how often the air pressure was computed from the position of the folds",
    ),
    _solver(
        "coupling_frozen_fraction",
        "Steps with held flow separation",
        "1",
        "share of all steps: where the jet separates, and whether contact stops the flow, were held in the "
        "last sweeps, as they went to and fro",
    ),
    _solver(
        "coupling_converged_fraction",
        "Steps with a converged coupling",
        "1",
        "share of all steps: air pressure and position of the folds agree",
    ),
    _solver(
        "mean_contact_passes",
        "Contact passes per step",
        "1",
        "mean over all steps: how often it was found anew which nodes touch the facing surface",
    ),
    _solver("inverted_tissue_max", "Inverted tissue cells, at most", "1"),
)
