"""All cautions of a run: what to check before trusting its numbers.

Cautions of the scene, which are known before it runs, come first (their bounds are in
scene/plausibility.py). Those of the run are the functions in `CHECKS`: each makes one check and has
the name of its caution. the page of cautions lists all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.measures.caution import Caution
from plica.measures.contour import medial_surface
from plica.measures.record import Array, Floats
from plica.measures.run.folds import inferior_lag, rest_width, vertical_phase
from plica.measures.run.glottal import open_area, several_summits
from plica.measures.run.inversion import inverted_cells, linear_error
from plica.measures.run.measure import driving, fold_length, risen
from plica.measures.run.overlap import overlapping_folds
from plica.measures.run.run_data import RunData, reached
from plica.measures.scene_text import scene_table, scene_tables
from plica.units import two_digits

__all__ = ["CHECKS", "cautions", "one_sided_errors"]

largest_unconverged_share = 0.01  # of the steps with contact; each gap is within ten tolerances, tens of nm
largest_pressure_error = (
    0.1  # of the subglottal pressure; flow is then off by 14 % or more (docs/extremes.md)
)
largest_slide = 0.25  # mean edges; at 0.3 a node beside the rim has been missed
largest_energy_gain = 0.05  # by contact or scheme, of the largest energy or work of the loads
largest_strain_error = 0.1  # about how well tissue moduli are known (docs/theory/tissue.md, "Large strains")
smallest_pressure_change = 1e-3  # of the pressure; frequencies then change by less than they scatter
largest_flow = 3e-3  # m^3/s; shouting, 10 kPa through 20 mm^2 of glottis, is 2.6e-3
largest_motion = 0.25  # of the folds' length; a tenth in phonation, and linear tissue needs small strain
one_sided_errors = {"mortar": (4, 60), "volume_penalty": (0.5, 5), "penalty": (1, 8)}
"""[%] Error of flow and of the collision impulse of a quarter of a small larynx, compared with the whole
larynx, with a penalty of 50 N/m."""


def cautions(run: RunData) -> tuple[Caution, ...]:
    """The cautions of a run, with advice.

    Parameters
    ----------
    run : RunData
        Finished, interrupted or failed; the computed steps are checked.

    Returns
    -------
    tuple of Caution
        Those of the scene, then those of the run, each kind once; ``str(caution)`` is the text.
    """
    if not np.size(run.time):
        return tuple(run.scene_cautions)
    return (*run.scene_cautions, *(found for check in CHECKS if (found := check(run)) is not None))


def nothing_moved(run: RunData) -> Caution | None:
    """The tissue has no energy in any step: nothing drives it."""
    time, waveforms = reached(run)
    energies = [waveforms[name] for name in ("kinetic_energy", "elastic_energy") if name in waveforms]
    if not energies or np.any(energies):
        return None
    return Caution(
        "nothing_moved",
        f"Nothing moved in {time.size} steps.",
        "Is [airflow], [[loads]], gravity or [initial] missing? Does the flow separate at the lowest "
        "section, so that no pressure acts on the tissue?",
    )


def unsteady_voice(run: RunData) -> Caution | None:
    """The measured cycles are not steady: the vibration changes, decays, is irregular or subharmonic."""
    cycles = run.cycles
    if "minimum_area" not in run.waveforms or cycles.verdict in ("steady", "none"):
        return None
    if cycles.verdict == "ambiguous":
        return Caution(
            "unsteady_voice",
            f"Nothing was measured per cycle: {cycles.note}.",
            "Look at the waveforms: run longer (time.duration), or change the voice until its pulses repeat.",
        )
    if cycles.verdict == "decaying":
        return Caution(
            "unsteady_voice",
            f"There is no voice: {cycles.note}.",
            "Use a higher subglottal pressure, a narrower glottis or softer tissue.",
        )
    low, high = 1e3 * cycles.periods.min(), 1e3 * cycles.periods.max()
    if cycles.verdict == "subharmonic":
        return Caution(
            "unsteady_voice",
            f"{cycles.count} cycles were measured, {low:.3g} to {high:.3g} ms long; {cycles.note}.",
            "Frequency and quotients are those of the pulses, which differ in turns; less pressure, or "
            "stiffer tissue, may give a voice of one period.",
        )
    return Caution(
        "unsteady_voice",
        f"{cycles.count} cycles were measured, {low:.3g} to {high:.3g} ms long; {cycles.note}.",
        "Run longer (time.duration), or use the numbers only for these cycles.",
    )


def moving_pressure(run: RunData) -> Caution | None:
    """The subglottal pressure moves within the cycles that were measured (airflow.course)."""
    time, waveforms = reached(run)
    pressure = driving(waveforms)
    cycles = run.cycles
    if not pressure.size or "minimum_area" not in waveforms or not cycles.count:
        return None
    seen = pressure[cycles.extent(time)]
    moved = float(np.ptp(seen) / seen.max())
    if moved < smallest_pressure_change:
        return None
    return Caution(
        "moving_pressure",
        f"The subglottal pressure moves by {100 * moved:.2g} % within the {cycles.count} cycles that were "
        "measured: their means are of no single pressure.",
        "Measure a part in which it stays (Run.between), or let airflow.course stay at a pressure.",
    )


def unlike_modal_voice(run: RunData) -> Caution | None:
    """Half of the pulses or more have several summits, or the inferior edge of the medial surface lags the
    superior one: a modal voice does neither.
    """
    time, waveforms = reached(run)
    cycles = run.cycles
    if "minimum_area" not in waveforms or not cycles.count or cycles.verdict == "decaying":
        return None
    height = np.asarray(run.section_height, dtype=float)
    phase = vertical_phase(time, waveforms, cycles, medial_surface(rest_width(run), height), height)
    found = [*several_summits(open_area(waveforms), time, cycles), *inferior_lag(phase)]
    if not found:
        return None
    seen = "; ".join(found)
    return Caution(
        "unlike_modal_voice",
        f"{seen[0].upper()}{seen[1:]}.",
        "Look at the glottal area and the coronal sections. Do not compare its measures with those of a "
        "modal voice; a lower subglottal pressure may give one.",
    )


def flow_beyond_voice(run: RunData) -> Caution | None:
    """The flow is above 3 l/s; shouting, 10 kPa through 20 mm2 of glottis, is 2.6 l/s."""
    flow = np.asarray(reached(run)[1].get("flow", []), dtype=float)
    if not flow.size or flow.max() <= largest_flow:
        return None
    return Caution(
        "flow_beyond_voice",
        f"The flow reached {1e3 * flow.max():.3g} l/s. In phonation it is below {1e3 * largest_flow:g} l/s.",
        "Is mesh.unit right? Is the glottis too wide? Is the pressure right?",
    )


def motion_beyond_voice(run: RunData) -> Caution | None:
    """A fold moves by more than a quarter of its length; in phonation it is a tenth."""
    waveforms, length = reached(run)[1], fold_length(run)
    if "coronal_right" not in waveforms or not length:
        return None
    paths = [np.asarray(waveforms[f"coronal_{side}"], dtype=float) for side in ("right", "left")]
    if all(_farthest(path) <= largest_motion * length for path in paths):
        return None
    moves = [path - path[0] for path in paths]
    moved = max(float(np.sqrt(np.einsum("tsc,tsc->ts", move, move).max())) for move in moves)
    if moved <= largest_motion * length:
        return None
    linear = (
        ", and the linear tissue model holds only for small strains"
        if "nonlinear_loss" not in waveforms
        else ""
    )
    return Caution(
        "motion_beyond_voice",
        f"A fold moved by {1e3 * moved:.3g} mm, {moved / length:.2g} of its length of {1e3 * length:.3g} mm. "
        f"In phonation it is a tenth{linear}.",
        "Are there supports? Are E, the pressure and the initial velocity right?",
    )


def _farthest(path: Floats) -> float:
    """A bound on how far points (k, s, 3) move from where they begin: by components' largest moves."""
    far = np.maximum(path.max(axis=0) - path[0], path[0] - path.min(axis=0))
    return float(np.sqrt((far * far).sum(axis=-1).max()))


def large_strain(run: RunData) -> Caution | None:
    """The strain is too large for the linear tissue model: its error is more than a tenth in the cycles
    that are measured (in the whole run if there are none).
    """
    time, waveforms = reached(run)
    neglected = np.asarray(waveforms.get("strain_neglected", np.zeros(time.size)), dtype=float)
    cycles = run.cycles
    part = cycles.extent(time) if cycles.count else slice(0, time.size)
    worst, k = int(neglected.argmax()), part.start + int(neglected[part].argmax())
    error, before = (linear_error(float(neglected[i])) for i in (k, worst))
    if error <= largest_strain_error:
        return None
    largest = 100 * float(np.max(np.asarray(waveforms.get("strain_999", np.zeros(time.size)))[part]))
    cell = int(waveforms["strain_cell"][k])
    where = f"In the {cycles.count} cycles measured" if cycles.count else "In the whole run"
    seen = (
        f"{where}, the strain of the tissue reached {two_digits(largest)} %, and the error of the linear "
        f"tissue model reached {two_digits(100 * error)} % at {1e3 * time[k]:.3g} ms in "
        f"{_place(run, cell)}"
    )
    if before > largest_strain_error and not part.start <= worst < part.stop:
        seen += f"; outside them it was {two_digits(100 * before)} %, at {1e3 * time[worst]:.3g} ms"
    advice = _against_strain(waveforms, _layer(run, cell))
    return Caution("large_strain", f"{seen}.", advice)


_MOTION = "The error is proportional to the motion"


def _against_strain(waveforms: Mapping[str, Array], layer: str) -> str:
    """What lowers the strain, of the cycles too; what lowers that of the start alone (docs/phonation.md)."""
    if "minimum_area" not in waveforms:
        return f"{_MOTION}: use a lower initial velocity or load, or a stiffer {layer}."
    motion = f"{_MOTION}: use a lower subglottal pressure or a stiffer {layer}."
    if risen(waveforms):
        return motion
    return (
        f"{motion} A pressure that rises within a period of the slowest mode (airflow.rise) strains the "
        "start less, but does not change a steady voice."
    )


def _layer(run: RunData, cell: int) -> str:
    return f'layer "{run.mesh.layer_names[int(np.asarray(run.mesh.cell_layer)[cell])]}"'


def _place(run: RunData, cell: int) -> str:
    """The layer and position of a cell, as text."""
    x, y, z = 1e3 * np.asarray(run.mesh.points)[np.asarray(run.mesh.cells)[cell, :4]].mean(axis=0)
    return f"{_layer(run, cell)} at ({x:.2g}, {y:.2g}, {z:.2g}) mm"


def unconverged_coupling(run: RunData) -> Caution | None:
    """The coupling of airflow and tissue did not converge within a step: the number of sweeps reached its
    limit, or the pressures of a coupling without sweeps were off by more than 10 % of the subglottal
    pressure (root mean square).
    """
    time, waveforms = reached(run)
    converged = np.asarray(waveforms.get("coupling_converged", [])) != 0
    if converged.all():
        return _pressure_error(waveforms)
    failed = np.flatnonzero(~converged)
    left = float(np.nanmax(np.asarray(waveforms["coupling_residual"], dtype=float)[failed]))
    return Caution(
        "unconverged_coupling",
        f"In {failed.size} of {converged.size} steps, first at {1e3 * time[failed[0]]:.3g} ms, the "
        f"coupling of airflow and tissue did not converge: pressures still changed by {left:.2g} of the "
        "subglottal pressure.",
        "Use a smaller time.step, or more sweeps (airflow.coupling.iterated.max_sweeps).",
    )


def _pressure_error(waveforms: Mapping[str, Array]) -> Caution | None:
    """The caution for a coupling without sweeps whose step is too long; with sweeps the error is much
    smaller."""
    residual = np.asarray(waveforms.get("coupling_residual", []), dtype=float)
    residual = residual[np.isfinite(residual)]
    error = float(np.sqrt(np.mean(residual**2))) if residual.size else 0.0
    if error <= largest_pressure_error:
        return None
    return Caution(
        "unconverged_coupling",
        f"The air pressures of the coupling differed by {100 * error:.2g} % of the subglottal pressure (root "
        "mean square) from those at the final position of the folds in the same step.",
        'Use a smaller time.step, or airflow.coupling = "iterated".',
    )


def unconverged_contact(run: RunData) -> Caution | None:
    """Gap errors of the contact are above its tolerance: augmentations reached their limit in any step, or
    passes, whose errors are within ten tolerances, in more than 1 % of the steps with contact.
    """
    waveforms = reached(run)[1]
    unconverged = np.asarray(waveforms.get("contact_converged", [])) == 0
    if not unconverged.any():
        return None
    augmented = "augmented" in (scene_table(run.scene_text, "contact") or {})
    count, steps = (
        int(unconverged.sum()),
        int(np.sum(unconverged | (np.asarray(waveforms["contact_rows"]) > 0))),
    )
    if not augmented and count <= largest_unconverged_share * steps:
        return None
    error = float(np.asarray(waveforms["contact_gap_error"], dtype=float)[unconverged].max())
    return Caution(
        "unconverged_contact",
        f"In {count} of {steps} steps with contact it did not converge to its tolerance: gap errors of up to "
        f"{1e3 * error:.2g} mm remain.",
        "Use a smaller time.step, more augmentations (contact.augmented.max_augmentations), a larger "
        "stiffness, or contact.multipliers."
        if augmented
        else "Use a smaller time.step or a larger contact.tolerance.",
    )


def facing_contact(run: RunData) -> Caution | None:
    """In some steps the passes of the contact did not settle, or led one surface through the other, as where
    tissue folds: nodes were held apart from those that they face at rest. Of the mirror images of a scene
    with a symmetry that is exact contact; of others it leaves out how far the surfaces have slid.
    """
    time, waveforms = reached(run)
    facing = np.flatnonzero(np.asarray(waveforms.get("contact_facing", [])))
    if not facing.size:
        return None
    steps = int(
        np.sum((np.asarray(waveforms["contact_rows"]) > 0) | (np.asarray(waveforms["contact_facing"]) > 0))
    )
    if "symmetry" in scene_tables(run.scene_text):
        meaning = "Of mirror images that is exact contact"
    else:
        slid = float(np.max(waveforms["contact_slide"]))
        meaning = f"That leaves out how far they have slid, by up to {slid:.2g} mean edges"
    return Caution(
        "facing_contact",
        f"In {facing.size} of {steps} steps with contact, first at {1e3 * time[facing[0]]:.3g} ms, its "
        "passes did not settle, or led one surface through the other: nodes were held apart from those that "
        "they face at rest.",
        f"{meaning}. Passes fail where tissue folds: use less pressure or stiffer tissue.",
    )


def one_sided_contact(run: RunData) -> Caution | None:
    """Contact with a slave side (a penalty, mortar faces) in a scene with a symmetry: the whole tissue would
    lean to that side, the symmetric part cannot.
    """
    waveforms, contact = reached(run)[1], scene_table(run.scene_text, "contact") or {}
    sided = [name for name in one_sided_errors if name in contact or name == contact.get("faces")]
    if "symmetry" not in scene_tables(run.scene_text) or not sided or not np.any(waveforms["contact_rows"]):
        return None
    flow, impulse = one_sided_errors[sided[0]]
    return Caution(
        "one_sided_contact",
        f"The contact has a slave side ({sided[0]}): the whole tissue would lean to it, the symmetric part "
        f"cannot. For a small larynx the error of the flow was {flow:g} %, that of the collision impulse "
        f"{impulse:g} %; softer penalties are worse.",
        "Leave symmetry out, or use contact.multipliers at nodes.",
    )


def weak_collisions(run: RunData) -> Caution | None:
    """Collisions with massless contact surfaces on a larynx coarser than ``fine`` in size, growth, lines
    around or order: they are too weak (docs/phonation.md, for an adult larynx).
    """
    waveforms = reached(run)[1]
    airflow, contact, mesh = (
        scene_table(run.scene_text, name) or {} for name in ("airflow", "contact", "mesh")
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
        'are too weak. On "fine" the collision impulse was 9 % below that on "finest", on "demo" 51 %.',
        'Use larynx = "finest" with order = 2.',
    )


def sliding_surfaces(run: RunData) -> Caution | None:
    """Surfaces in contact slid by more than 0.25 mean edges, which a matched airway mesh does not follow."""
    slid = float(np.max(reached(run)[1].get("contact_slide", 0.0), initial=0.0))
    if slid <= largest_slide:
        return None
    advice = 'Use contact.airway = "triangulated", which follows'
    if "meshing" in _engine.build_info()["absent"]:
        advice += "; this needs a build with PLICA_GPL=ON (see plica info)"
    return Caution(
        "sliding_surfaces",
        f"The surfaces slid along each other by {slid:.2g} mean edges while they touched. A matched airway "
        "mesh does not follow: contact of nodes near the rims may be missed.",
        f"{advice}.",
    )


def energy_from_contact(run: RunData) -> Caution | None:
    """Contact created more than 5 % of the largest energy, as surfaces with mass do at impacts."""
    waveforms = reached(run)[1]
    if "contact_work" not in waveforms:
        return None
    touching = _touching(waveforms)
    # The work of contact without that of friction, minus the loss of the time scheme in the same steps.
    work = _growth(waveforms, "contact_work")
    work += np.asarray(waveforms.get("friction_loss", 0.0), dtype=float)
    work -= np.maximum(_growth(waveforms, "numerical_loss"), 0.0)
    begins = np.flatnonzero(np.diff(touching, prepend=False) & touching)
    if not begins.size:
        return None
    created = float(np.maximum(np.add.reduceat(np.where(touching, work, 0.0), begins), 0.0).sum())
    largest = _largest_energy(waveforms)
    if created <= largest_energy_gain * largest:
        return None
    return Caution(
        "energy_from_contact",
        f"Contact created energy, {100 * created / largest:.3g} % of the largest energy or work of the loads "
        f"({1e6 * created:.2g} of {1e6 * largest:.2g} uJ), as surfaces with mass do at impacts.",
        'Use contact.surface_mass = "redistributed" with mesh.order = 2, and a larynx = "finest".',
    )


def energy_from_scheme(run: RunData) -> Caution | None:
    """The time scheme created more than 5 % of the largest energy: the motion overshoots."""
    waveforms = reached(run)[1]
    if "numerical_loss" not in waveforms:
        return None
    growth = _growth(waveforms, "numerical_loss")
    if "nonlinear_loss" in waveforms:
        growth += _growth(waveforms, "nonlinear_loss")
    if "contact_work" in waveforms:  # energy that contact took in the same steps may be returned
        growth += np.where(_touching(waveforms), np.maximum(-_growth(waveforms, "contact_work"), 0.0), 0.0)
    lost = np.cumsum(growth)
    created = float((np.maximum.accumulate(np.maximum(lost, 0.0)) - lost).max())
    # Of the whole run: in a part, loads may do little work while the scheme returns energy it took before.
    largest = _largest_energy(reached(run.whole)[1])
    if created <= largest_energy_gain * largest:
        return None
    return Caution(
        "energy_from_scheme",
        f"The time scheme created energy, {100 * created / largest:.3g} % of the largest energy or work of "
        f"the loads ({1e6 * created:.2g} of {1e6 * largest:.2g} uJ): the motion overshoots.",
        "Use a smaller time.step until this caution disappears.",
    )


def reduced_motion(run: RunData) -> Caution | None:
    """The motion is restricted to a basis of displacements; no number of the run shows the error of that."""
    if scene_table(run.scene_text, "reduction") is None:
        return None
    return Caution(
        "reduced_motion",
        "The motion is restricted to a basis of displacements ([reduction]). The error of that is not "
        "known, and strains are computed only every reduction.watch_every steps. With a basis from the "
        "motion of another voice, steady cycles were within 4 %, impulses at the onset off by 60 %; with one "
        "of modes and contact vectors, open quotient and impulse were off by up to 0.05 and 42 %.",
        "Make the basis from a full run (plica reduce RUN), measure steady cycles only, and compare one such "
        "scene with its full run.",
    )


def _growth(waveforms: Mapping[str, Array], name: str) -> Floats:
    """The increase of a cumulative waveform in each step."""
    return np.diff(np.asarray(waveforms[name], dtype=float), prepend=0.0)


def _touching(waveforms: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Steps with contact and the steps after them: half of a force's work is done in the next step."""
    rows = np.asarray(waveforms["contact_rows"]) > 0
    return rows | np.concatenate(([False], rows[:-1]))


def _largest_energy(waveforms: Mapping[str, Array]) -> float:
    """J, the largest energy of the tissue or work of the loads."""
    energy = np.asarray(waveforms["kinetic_energy"]) + np.asarray(waveforms["elastic_energy"])
    return max(float(energy.max()), float(np.max(waveforms["load_work"])))


CHECKS: tuple[Callable[[RunData], Caution | None], ...] = (
    nothing_moved,
    unsteady_voice,
    moving_pressure,
    unlike_modal_voice,
    flow_beyond_voice,
    motion_beyond_voice,
    large_strain,
    inverted_cells,
    overlapping_folds,
    unconverged_coupling,
    unconverged_contact,
    facing_contact,
    sliding_surfaces,
    one_sided_contact,
    weak_collisions,
    energy_from_contact,
    energy_from_scheme,
    reduced_motion,
)
