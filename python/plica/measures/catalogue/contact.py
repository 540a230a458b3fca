"""Contact of the folds."""

from __future__ import annotations

from functools import partial

from plica.measures.catalogue.quantity import Quantity
from plica.measures.thresholds import bridged_of_record, bridged_share, contact_share, pressure_window

__all__ = ["ROWS"]

_WITHOUT = "or, if there are no cycles, in the whole run (in its last third where pulses are no periods)"
_COLLISION = "over the collisions of the steady cycles or, if there are none, of the whole run"
_LARGEST = f"largest in each cycle {_WITHOUT}"
_STEP_PRESSURE = "largest nodal pressure of each step"

_contact = partial(Quantity, group="Contact", source="run")

ROWS = (
    _contact(
        "collisions",
        "Collisions",
        "1",
        "complete ones in the whole run; "
        f"in contact above {100 * contact_share:g} % of the peak force, losses of contact below "
        f"{bridged_share:g} of the period (of the record {bridged_of_record:g} without cycles) bridged",
    ),
    _contact("contact_impulse", "Impulse per collision", "N s", f"on the left fold, {_COLLISION}"),
    _contact("contact_duration", "Duration of a collision", "s", _COLLISION),
    _contact(
        "contact_force_left_peak",
        "Peak force, left fold",
        "N",
        f"of a single step, {_COLLISION}",
        side="left",
    ),
    _contact(
        "contact_force_right_peak",
        "Peak force, right fold",
        "N",
        f"of a single step, {_COLLISION}",
        side="right",
    ),
    _contact(
        "contact_force_left_mean",
        "Mean force, left fold",
        "N",
        f"impulse over duration, {_COLLISION}",
        side="left",
    ),
    _contact(
        "contact_force_right_mean",
        "Mean force, right fold",
        "N",
        f"impulse over duration, {_COLLISION}",
        side="right",
    ),
    _contact(
        "contact_area_max",
        "Largest contact area",
        "m^2",
        f"of the loaded nodes (by over 1e-3 of the largest force), mean of both sides; {_LARGEST}",
    ),
    _contact(
        "contact_length_max",
        "Largest contact length",
        "m",
        "anteroposterior, of the deformed fold; a loaded node stands for half the way to its neighbours; "
        f"{_LARGEST}",
    ),
    _contact(
        "contact_length_fraction",
        "Contact length over fold length",
        "1",
        "length in contact of the deformed fold over the length of the fold at rest, so that it may pass "
        f"1; {_LARGEST}",
    ),
    _contact(
        "peak_contact_pressure",
        f"Peak contact pressure, mean over {1e3 * pressure_window:g} ms",
        "Pa",
        f"moving mean over {1e3 * pressure_window:g} ms of the {_STEP_PRESSURE} (an upper bound of any one "
        f"node's mean); {_LARGEST}",
        no_limit="surfaces with mass: it grows as the step falls and has no limit; use the impulse, the "
        'duration and the mean force, or contact.surface_mass = "redistributed", with which it converges',
        no_limit_of="surfaces with mass",
    ),
    _contact(
        "peak_contact_pressure_step",
        "Peak contact pressure of a single step",
        "Pa",
        f"{_STEP_PRESSURE}; {_LARGEST}",
        no_limit="pressure of single steps: it grows as the step falls and is no physical figure; use the "
        "impulse, the duration and the mean force",
    ),
)
