"""What of a scene cannot be combined, and why: the one table that refusals and documentation come from."""

from __future__ import annotations

from typing import Any

from plica.scene.combination import PARTS, Choice, Combination, Fault, at, each, key
from plica.scene.part import problem

__all__ = ["COMBINATIONS", "require_combinable"]


def require_combinable(part: Any) -> None:
    """Raise for the first combination of a scene, or of a part alone, that is refused."""
    for combination in COMBINATIONS:
        for option, other in combination.pairs:
            if other.found(part) is not None and (fault := option.found(part)) is not None:
                path, value = fault
                shown = {} if value is None else {"value": value}
                inside = path[1:] if type(part).__name__ in PARTS else path
                raise problem(combination.relation(option, other), *inside, **shown)


def _boxes(scene: Any) -> Fault:
    return ((), None) if type(at(scene, "mesh")).__name__ in ("Block", "Blocks") else None


def _no_airflow(scene: Any) -> Fault:
    return ((), None) if at(scene, "airflow") is None else None


def _turned_direction(part: Any) -> Fault:
    """Another direction than the default, which a scene that is stored has."""
    contact = at(part, "contact")
    if contact is None or contact.direction == type(contact).model_fields["direction"].default:
        return None
    return ("contact", "direction"), list(contact.direction)


def _varying_load(scene: Any) -> Fault:
    """The first load that varies."""
    loads = enumerate(at(scene, "loads") or ())
    return next(((("loads", k, "frequency"), load.frequency) for k, load in loads if load.frequency), None)


def _unlike_sides(scene: Any) -> Fault:
    return ((), None) if at(scene, "mesh.folds.unlike_sides") else None


def _labelled_sides(part: Any) -> Fault:
    sides = at(part, "mesh.sides")
    return None if sides is None or isinstance(sides, str) else (("mesh", "sides"), None)


def _selected_side(part: Any) -> Fault:
    """A selection of one side."""
    for name, wanted in (at(part, "mesh.surfaces") or {}).items():
        if (side := getattr(wanted, "side", None)) is not None:
            return ("mesh", "surfaces", name, "side"), side
    return None


def _named_side(part: Any) -> Fault:
    names = (name for name in at(part, "mesh.surfaces") or {} if name.endswith(("_left", "_right")))
    return next(((("mesh", "surfaces", name), None) for name in names), None)


def _other_than_multipliers(scene: Any) -> Fault:
    if (contact := at(scene, "contact")) is None:
        return None
    if contact.multipliers is None:
        return ("contact", contact.chosen), None
    position = contact.multipliers.position
    return None if position == "end_of_step" else (("contact", "multipliers", "position"), position)


def _rises(scene: Any) -> Fault:
    rise = at(scene, "airflow.rise")
    return (("airflow", "rise"), rise) if rise else None


def _not_iterated(scene: Any) -> Fault:
    """A coupling that foretells what an implicit step leads to; an explicit one knows it."""
    coupling = at(scene, "airflow.coupling")
    if coupling is None or coupling.chosen == "iterated" or at(scene, "time.scheme.central_differences"):
        return None
    return ("airflow", "coupling"), coupling.chosen


def _mirrored_reduction(scene: Any) -> Fault:
    return _REDUCTION.found(scene) if at(scene, "symmetry") else None


_NO_AIRFLOW = Choice("no airflow", _no_airflow)
_TUBES = [key(name, hint="Nothing flows there. Add [airflow].") for name in ("tract", "trachea")]
_COURSE = key("airflow.course", hint="The pressure follows from the flow.")
_RISES = Choice("airflow.rise > 0", _rises, "must be 0 s")
_AT_ONCE = key(
    "airflow.rise", 0, must="must be > 0 s", hint="Give the time over which the pressure rises, such as 5 ms."
)
_SUPPLIED_FLOW = key("trachea.supply.flow", must="must be a supply of pressure")
_CLOSED = key("tract.end", "closed", must='must be "open" or "reflecting"')
_NOT_ITERATED = Choice('airflow.coupling = "lagged" or "extrapolated"', _not_iterated, 'must be "iterated"')
_CURRENT_SHAPE = key("airflow.load_shape", "current", must='must be "reference"')
_ELLIPTIC = key(
    "airflow.area",
    "elliptic",
    must='must be "cut"',
    hint="A glottis with a chink, or in which a lesion stands, is no ellipse.",
)

_IN_THE_FLOW = key(
    "initial.equilibrium",
    "flow",
    must="must be true or false",
    hint="There is no flow to be in equilibrium with; true is the one under gravity and loads.",
)
_OPENINGS = [
    key(f"initial.opening_{name}", hint="A block has no glottis. Use initial.velocity or displacement.")
    for name in ("velocity", "displacement")
]
_VARYING_LOAD = Choice("loads.frequency > 0", _varying_load, "must be 0 Hz")

_BOXES = Choice(
    "mesh.block or mesh.blocks",
    _boxes,
    hint="All boxes are divided along the same diagonals. Use a larynx, or a symmetric mesh file.",
)
_UNLIKE_SIDES = Choice(
    "mesh.folds.lesions, mesh.folds.left_gap, mesh.folds.right_gap",
    _unlike_sides,
    hint='Left and right differ. With voice: without = ["symmetry"].',
)
_LESIONS, _CHINK = key("mesh.folds.lesions"), key("mesh.folds.posterior_chink")
_MIRROR = key("mesh.mirror")
_LABELLED_SIDES = Choice("mesh.sides of labels", _labelled_sides, 'must be "x" or left out')
_SELECTED_SIDE = Choice("mesh.surfaces.NAME.side", _selected_side, "must be left out")
_NAMED_SIDE = Choice(
    "mesh.surfaces.NAME_left, mesh.surfaces.NAME_right",
    _named_side,
    "must be named without the side",
    "The surface NAME becomes NAME_left and NAME_right.",
)

_DIRECTION = Choice(
    "contact.direction", _turned_direction, "must be left out", "A triangulated airway has no direction."
)
_TRIANGULATED = key("contact.airway", "triangulated", must='must be "matched"')
_MORTAR = key("contact.faces", "mortar", must='must be "nodes"')
_PENALTY, _VOLUME_PENALTY = key("contact.penalty"), key("contact.volume_penalty")
_NITSCHE = key("contact.nitsche", must="must be another method", hint="Use contact.multipliers.")
_SOLVED = [
    key(f"contact.{name}", hint="Use contact.penalty or contact.volume_penalty.")
    for name in ("multipliers", "augmented", "nitsche")
]
_REDISTRIBUTED = key("contact.surface_mass", "redistributed", must='must be "kept"')
_FRICTION = key(
    "contact.friction", hint='Use contact.multipliers (solver "auto" or "condensed") or contact.augmented.'
)
_UNCONDENSED = key("contact.multipliers.solver", "saddle", "gmres")
_OTHER_THAN_MULTIPLIERS = Choice(
    "contact other than multipliers at the end of the step",
    _other_than_multipliers,
    "must be by multipliers, gaps closed at the end of the step",
    "Mirror images meet in their plane, which needs no other.",
)

_CONSISTENT = key("time.mass", "consistent", must='must be "lumped"')
_EXPLICIT = key("time.scheme.central_differences")
_SYMMETRY, _POSTURE, _REDUCTION = key("symmetry"), key("posture"), key("reduction")
_QUARTER = key("symmetry", "quarter", must='must be "half", or left out', hint="Front and back differ.")
_MIRRORED_REDUCTION = Choice("reduction and symmetry", _mirrored_reduction)
_STRAIN = key("strain", hint='With voice: without = ["strain"], softer tissue with another pitch.')

COMBINATIONS = (
    Combination(
        "it would act on nothing.",
        "physics",
        (
            *each([*_TUBES, _IN_THE_FLOW], [_NO_AIRFLOW]),
            *each(_OPENINGS, [_BOXES]),
            (_COURSE, _SUPPLIED_FLOW),
            (_DIRECTION, _TRIANGULATED),
            (_MORTAR.saying("The volumes are of airway tetrahedra, not of faces."), _VOLUME_PENALTY),
        ),
    ),
    Combination(
        "the equilibrium is the one under a steady pressure that is whole from the start.",
        "physics",
        each([_RISES, _SUPPLIED_FLOW, _CLOSED, _VARYING_LOAD], [_IN_THE_FLOW.saying("")]),
    ),
    Combination(
        "a flow begins in still air.",
        "physics",
        each([_AT_ONCE], [_SUPPLIED_FLOW, _CLOSED]),
    ),
    Combination(
        "pressures at the folds follow their motion within the step; with those foretold it is not stable.",
        "physics",
        each([_NOT_ITERATED], [tube.saying("") for tube in _TUBES]),
    ),
    Combination(
        "the mesh is not of that shape.",
        "physics",
        (
            *each([_SYMMETRY], [_BOXES, _UNLIKE_SIDES]),
            (_QUARTER, _CHINK),
            *each([_ELLIPTIC], [_CHINK, _LESIONS]),
        ),
    ),
    Combination(
        "the file has one fold, of which mirroring makes left, x < 0, and right, x > 0.",
        "physics",
        each([_LABELLED_SIDES, _SELECTED_SIDE, _NAMED_SIDE], [_MIRROR]),
    ),
    Combination(
        "an explicit step solves for nothing: it divides known forces by the mass of each node.",
        "physics",
        each(
            [
                _CONSISTENT,
                *_SOLVED,
                _REDISTRIBUTED,
                _REDUCTION.saying("The implicit step of few coordinates costs no more and has no limit."),
            ],
            [_EXPLICIT],
        ),
    ),
    Combination(
        "it is solved for with the normal forces.",
        "construction",
        each([_FRICTION], [_PENALTY, _VOLUME_PENALTY, _NITSCHE, _UNCONDENSED]),
    ),
    Combination(
        "it takes the stress of all tissue, at nodes, linear and about the shape at rest.",
        "construction",
        each([_NITSCHE], [_POSTURE, _STRAIN, _SYMMETRY, _REDUCTION, _MORTAR]),
    ),
    Combination(
        "nodes without mass follow those behind them as linear tissue at rest does, each on its own.",
        "construction",
        each([_REDISTRIBUTED], [_POSTURE, _STRAIN.saying(""), _REDUCTION]),
    ),
    Combination(
        "that is for small motion about one shape, where loads do not turn and the same nodes meet.",
        "construction",
        (
            (_REDUCTION, _STRAIN),
            *each([_MORTAR, _TRIANGULATED, _CURRENT_SHAPE], [_REDUCTION]),
            (_CURRENT_SHAPE, _IN_THE_FLOW.saying("")),
            (_OTHER_THAN_MULTIPLIERS, _MIRRORED_REDUCTION),
        ),
    ),
)
"""In the order of the documentation: what physics forbids, then what could be built."""
