"""Every caution that a run can give: what is to be known before its numbers are believed.

The cautions of the scene, which are known before it runs, come first (phonation/scene/plausibility.py has
their bounds). Those of the run are the functions in `CHECKS`: each looks for one thing and has its name.
docs/cautions.md lists all of them, made by .ci/cautions.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.measures.caution import Caution
from plica.measures.record import Array, Floats
from plica.phonation.measures.measure import fold_length, steady_cycles
from plica.phonation.measures.run_data import RunData, reached

__all__ = ["CHECKS", "cautions", "one_sided_errors"]

unsettled_passes = 0.01  # of the steps with contact: more is said; each is within ten tolerances, tens of nm
pressures_off = (
    0.1  # of the subglottal one: more is said (flow is then off by 14 % and more, docs/extremes.md)
)
slides = 0.25  # edges: more is said (a node beside the rim has been missed at 0.3)
makes = 0.05  # of the largest energy or work of the loads, made by contact or scheme: more is said
largest_error_of_strain = (
    0.1  # as well as moduli of tissue are known at best; docs/theory/tissue.md, "Large strains"
)
largest_flow = 3e-3  # m^3/s: shouting, 10 kPa through 20 mm^2 of glottis, is 2.6e-3
largest_motion = (
    0.25  # of the folds' length: a voice moves them by a tenth; linear tissue takes strain as small
)
one_sided_errors = {"mortar": (4, 60), "volume_penalty": (0.5, 5), "penalty": (1, 8)}
"""%, of flow and of the impulse of collisions: how far a quarter of a small larynx was from all of it, with a
penalty of 50 N/m."""


def cautions(run: RunData) -> tuple[Caution, ...]:
    """What of a run is to be doubted, and what to do about it.

    Parameters
    ----------
    run : RunData
        Finished, interrupted or failed; the steps that were computed are looked at.

    Returns
    -------
    tuple of Caution
        Of the scene, then of the run, each kind once; ``str(caution)`` is its sentence.
    """
    if not np.size(run.time):
        return tuple(run.scene_cautions)
    return (*run.scene_cautions, *(found for check in CHECKS if (found := check(run)) is not None))


def nothing_moved(run: RunData) -> Caution | None:
    """The tissue has no energy in any step: nothing sets it in motion."""
    time, waveforms = reached(run)
    energies = [waveforms[name] for name in ("kinetic_energy", "elastic_energy") if name in waveforms]
    if not energies or np.any(energies):
        return None
    return Caution(
        "nothing_moved",
        f"Nothing moved in {time.size} steps.",
        "Is [airflow], [[loads]], gravity or [initial] missing? Does the air leave at its lowest section, so "
        "that it presses on nothing?",
    )


def unsteady_voice(run: RunData) -> Caution | None:
    """The cycles that were measured are not those of a steady voice: it still changes, or is irregular."""
    cycles = steady_cycles(run)
    if "minimum_area" not in run.waveforms or not cycles.count or cycles.settled:
        return None
    low, high = 1e3 * cycles.periods.min(), 1e3 * cycles.periods.max()
    return Caution(
        "unsteady_voice",
        f"{cycles.count} cycles were measured, {low:.3g} to {high:.3g} ms long; {cycles.note}.",
        "Run longer (time.duration), or take the numbers as those of these cycles alone.",
    )


def flow_beyond_voice(run: RunData) -> Caution | None:
    """The flow is above 3 l/s; shouting, 10 kPa through 20 mm2 of glottis, is 2.6 l/s."""
    flow = np.asarray(reached(run)[1].get("flow", []), dtype=float)
    if not flow.size or flow.max() <= largest_flow:
        return None
    return Caution(
        "flow_beyond_voice",
        f"The flow reached {1e3 * flow.max():.3g} l/s. A voice stays below {1e3 * largest_flow:g} l/s.",
        "Is the mesh in the right unit (mesh.unit), is the glottis too wide, is the pressure right?",
    )


def motion_beyond_voice(run: RunData) -> Caution | None:
    """A fold moves by more than a quarter of its length, where a voice moves it by a tenth."""
    waveforms, length = reached(run)[1], fold_length(run)
    if "coronal_right" not in waveforms or not length:
        return None
    paths = [np.asarray(waveforms[f"coronal_{side}"], dtype=float) for side in ("right", "left")]
    moved = max(float(np.linalg.norm(path - path[0], axis=2).max()) for path in paths)
    if moved <= largest_motion * length:
        return None
    return Caution(
        "motion_beyond_voice",
        f"A fold moved by {1e3 * moved:.3g} mm, {moved / length:.2g} of its length of {1e3 * length:.3g} mm. "
        "In a voice it is a tenth, and linear tissue holds for small strains only.",
        "Is the tissue held (supports)? Are E, the pressure and the initial velocity right?",
    )


def large_strain(run: RunData) -> Caution | None:
    """Tissue deforms by more than linear tissue is a fair model of: it is off by more than a tenth there."""
    time, waveforms = reached(run)
    left_out = np.asarray(waveforms.get("strain_neglected", np.zeros(time.size)), dtype=float)
    folded = int(np.max(waveforms.get("inverted_tissue", 0), initial=0))
    k = int(left_out.argmax())
    largest = 100 * float(np.max(waveforms.get("strain_999", 0), initial=0))
    off = float(np.sqrt(left_out[k] / 2))  # |E - eps| over |grad u|
    if off <= largest_error_of_strain and not folded:
        return None
    cells = f", and {folded} of its cells {'was' if folded == 1 else 'were'} folded over" if folded else ""
    return Caution(
        "large_strain",
        f"Tissue strained by up to {largest:.2g} %, and linear tissue, which is for small strains, is off by "
        f"{100 * off:.2g} % at {1e3 * time[k]:.3g} ms in "
        f"{_place(run, int(waveforms['strain_cell'][k]))}{cells}.",
        "The error is in proportion to the motion: take less subglottal pressure, less initial velocity or "
        "stiffer tissue.",
    )


def _place(run: RunData, cell: int) -> str:
    """The layer of a cell and where it is."""
    x, y, z = 1e3 * np.asarray(run.mesh.points)[np.asarray(run.mesh.cells)[cell, :4]].mean(axis=0)
    layer = run.mesh.layer_names[int(np.asarray(run.mesh.cell_layer)[cell])]
    return f"the {layer} at ({x:.2g}, {y:.2g}, {z:.2g}) mm"


def unconverged_coupling(run: RunData) -> Caution | None:
    """Airflow and tissue were not brought into agreement within a step: sweeps ran out, or a coupling without
    sweeps took pressures that were off by more than 10 % of the subglottal one (root mean square).
    """
    time, waveforms = reached(run)
    converged = np.asarray(waveforms.get("coupling_converged", [])) != 0
    if converged.all():
        return _pressures_off(waveforms)
    short = np.flatnonzero(~converged)
    left = float(np.nanmax(np.asarray(waveforms["coupling_residual"], dtype=float)[short]))
    return Caution(
        "unconverged_coupling",
        f"In {short.size} of {converged.size} steps, first at {1e3 * time[short[0]]:.3g} ms, the coupling of "
        f"airflow and tissue did not converge: pressures still changed by {left:.2g} of the subglottal one.",
        "Take a smaller time.step, or more sweeps (airflow.coupling.iterated.max_sweeps).",
    )


def _pressures_off(waveforms: Mapping[str, Array]) -> Caution | None:
    """Of a coupling without sweeps, whose step is too long for it; sweeps leave much less."""
    residual = np.asarray(waveforms.get("coupling_residual", []), dtype=float)
    residual = residual[np.isfinite(residual)]  # runs of older versions have none
    off = float(np.sqrt(np.mean(residual**2))) if residual.size else 0.0
    if off <= pressures_off:
        return None
    return Caution(
        "unconverged_coupling",
        f"The coupling took pressures of the air that were off by {100 * off:.2g} % of the subglottal one "
        "(root mean square) from those of where the folds came to in the same step.",
        'Take a smaller time.step, or airflow.coupling = "iterated".',
    )


def unconverged_contact(run: RunData) -> Caution | None:
    """Contact left gap errors above its tolerance: where augmentations ran out in any step, or where passes,
    which end within ten tolerances, ran out in more than 1 % of the steps with contact.
    """
    waveforms = reached(run)[1]
    unsettled = np.asarray(waveforms.get("contact_converged", [])) == 0
    if not unsettled.any():
        return None
    augmented = "augmented" in (_table_of(run.scene_text, "contact") or {})
    count, steps = int(unsettled.sum()), int(np.sum(unsettled | (np.asarray(waveforms["contact_rows"]) > 0)))
    if not augmented and count <= unsettled_passes * steps:
        return None
    error = float(np.asarray(waveforms["contact_gap_error"], dtype=float)[unsettled].max())
    return Caution(
        "unconverged_contact",
        f"In {count} of {steps} steps with contact it did not settle within its tolerance: gap errors of up "
        f"to {1e3 * error:.2g} mm were left.",
        "Take a smaller time.step, more augmentations (contact.augmented.max_augmentations), a larger "
        "stiffness, or contact.multipliers."
        if augmented
        else "Take a smaller time.step or a larger contact.tolerance.",
    )


def _table_of(scene_text: str, name: str) -> dict[str, Any] | None:
    """A table of the scene, None where it has none or the text is no scene."""
    table = _scene_of(scene_text).get(name)
    return table if isinstance(table, dict) else None


def _scene_of(scene_text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(scene_text)
    except tomllib.TOMLDecodeError:
        return {}


def one_sided_contact(run: RunData) -> Caution | None:
    """Contact with a slave side (a penalty, mortar faces) in a scene with a symmetry: all of its
    tissue would lean to that side, the part that is solved for cannot.
    """
    waveforms, contact = reached(run)[1], _table_of(run.scene_text, "contact") or {}
    sided = [name for name in one_sided_errors if name in contact or name == contact.get("faces")]
    if "symmetry" not in _scene_of(run.scene_text) or not sided or not np.any(waveforms["contact_rows"]):
        return None
    flow, impulse = one_sided_errors[sided[0]]
    return Caution(
        "one_sided_contact",
        f"The contact has a slave side ({sided[0]}): all of the tissue would lean to it, the part that is "
        f"solved for cannot. Of a small larynx flow came out {flow:g} % off, the impulse of collisions "
        f"{impulse:g} %; softer penalties are worse.",
        "Leave symmetry out, or take contact.multipliers at nodes.",
    )


def weak_collisions(run: RunData) -> Caution | None:
    """Collisions of a voice whose contact surfaces have no mass, on a larynx coarser than ``fine``, be it in
    size, growth, lines around or order: they are too weak (docs/phonation.md, of an adult's larynx).
    """
    waveforms = reached(run)[1]
    airflow, contact, mesh = (
        _table_of(run.scene_text, name) or {} for name in ("airflow", "contact", "mesh")
    )
    larynx = mesh.get("options", {})
    massless = contact.get("surface_mass") == "redistributed"
    if not airflow or not massless or "size" not in larynx or not np.any(waveforms["contact_rows"]):
        return None
    fine = _engine.larynx_preset("fine")
    small = all(larynx[name] <= fine[name] for name in ("size", "growth"))
    if small and larynx["around"] >= fine["around"] and mesh.get("order") == 2:
        return None
    return Caution(
        "weak_collisions",
        'The contact surfaces have no mass, and the larynx is coarser than "fine" with order = 2: collisions '
        'are too weak. On "fine" the impulse of a voice was 9 % below that on "finest", on "demo" 51 %.',
        'Take larynx = "finest" with order = 2.',
    )


def sliding_surfaces(run: RunData) -> Caution | None:
    """Surfaces in contact slid by more than 0.25 mean edges, which a matched airway does not follow."""
    slid = float(np.max(reached(run)[1].get("contact_slide", 0.0), initial=0.0))
    if slid <= slides:
        return None
    follows = 'Take contact.airway = "triangulated", which follows'
    if "meshing" in _engine.build_info()["absent"]:
        follows += "; this build has none, it needs one with PLICA_GPL=ON (see plica info)"
    return Caution(
        "sliding_surfaces",
        f"The surfaces slid along each other by {slid:.2g} mean edges while they touched. A matched airway "
        "does not follow: nodes beside their rims may be missed.",
        f"{follows}.",
    )


def energy_from_contact(run: RunData) -> Caution | None:
    """Contact made energy, as surfaces with mass do at impacts: above 5 % of the largest there was."""
    waveforms = reached(run)[1]
    if "contact_work" not in waveforms:
        return None
    touching = _touching(waveforms)
    # The work of contact without that of friction, less what the time scheme took in the same steps.
    work = _growth(waveforms, "contact_work")
    work += np.asarray(waveforms.get("friction_loss", 0.0), dtype=float)
    work -= np.maximum(_growth(waveforms, "numerical_loss"), 0.0)
    begins = np.flatnonzero(np.diff(touching, prepend=False) & touching)
    if not begins.size:
        return None
    made = float(np.maximum(np.add.reduceat(np.where(touching, work, 0.0), begins), 0.0).sum())
    largest = _largest_energy(waveforms)
    if made <= makes * largest:
        return None
    return Caution(
        "energy_from_contact",
        f"Contact made energy, {100 * made / largest:.3g} % of the largest energy or work of the loads "
        f"({1e6 * made:.2g} of {1e6 * largest:.2g} uJ), as surfaces with mass do at impacts.",
        'Take contact.surface_mass = "redistributed", with mesh.order = 2; of a voice, on larynx = "finest".',
    )


def energy_from_scheme(run: RunData) -> Caution | None:
    """The time scheme made energy, above 5 % of the largest there was: the motion overshoots."""
    waveforms = reached(run)[1]
    if "numerical_loss" not in waveforms:
        return None
    growth = _growth(waveforms, "numerical_loss")
    if "contact_work" in waveforms:  # what contact took in the same steps is no gain where it is given back
        growth += np.where(_touching(waveforms), np.maximum(-_growth(waveforms, "contact_work"), 0.0), 0.0)
    lost = np.cumsum(growth)
    made = float((np.maximum.accumulate(np.maximum(lost, 0.0)) - lost).max())
    # Of the whole run: in a part the loads do little, and the scheme gives back what it took before.
    largest = _largest_energy(reached(run.whole)[1])
    if made <= makes * largest:
        return None
    return Caution(
        "energy_from_scheme",
        f"The time scheme made energy, {100 * made / largest:.3g} % of the largest energy or work of the "
        f"loads ({1e6 * made:.2g} of {1e6 * largest:.2g} uJ): the motion overshoots.",
        "Take a smaller time.step until this is gone.",
    )


def reduced_motion(run: RunData) -> Caution | None:
    """The tissue moved in a basis of displacements, whose error no number of the run shows."""
    reduction = _table_of(run.scene_text, "reduction")
    if reduction is None:
        return None
    seen = (
        "The tissue moved in a basis of displacements ([reduction]). How far its numbers are from those of "
        "all displacements is not known; strains are looked at every reduction.watch_every steps alone. "
    )
    if "full_run" in reduction:
        return Caution(
            "reduced_motion",
            seen
            + "With a basis of another voice's motion settled cycles came out within 4 %, the start of a "
            "voice not: impulses there were off by 60 %.",
            "Measure settled cycles alone, and compare one such scene with its full run.",
        )
    return Caution(
        "reduced_motion",
        seen + "Without full_run, open quotient and impulse were off by up to 0.05 and 42 %.",
        "Run one such scene in full, take the vectors from it (reduction.full_run), and compare another.",
    )


def _growth(waveforms: Mapping[str, Array], name: str) -> Floats:
    """What a sum since t = 0 grew by in each step."""
    return np.diff(np.asarray(waveforms[name], dtype=float), prepend=0.0)


def _touching(waveforms: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Steps with contact, and those after one: half of a force's work is done in the step that follows."""
    rows = np.asarray(waveforms["contact_rows"]) > 0
    return rows | np.concatenate(([False], rows[:-1]))


def _largest_energy(waveforms: Mapping[str, Array]) -> float:
    """J, the largest energy of the tissue or work of the loads."""
    energy = np.asarray(waveforms["kinetic_energy"]) + np.asarray(waveforms["elastic_energy"])
    return max(float(energy.max()), float(np.max(waveforms["load_work"])))


CHECKS: tuple[Callable[[RunData], Caution | None], ...] = (
    nothing_moved,
    unsteady_voice,
    flow_beyond_voice,
    motion_beyond_voice,
    large_strain,
    unconverged_coupling,
    unconverged_contact,
    sliding_surfaces,
    one_sided_contact,
    weak_collisions,
    energy_from_contact,
    energy_from_scheme,
    reduced_motion,
)
