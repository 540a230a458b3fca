"""How what cannot be combined is found in a scene, for the table of `plica.scene.composition`.

A fault is the path of the option in a part, and the value that is shown; None where there is none.
"""

from __future__ import annotations

from typing import Any

__all__ = [
    "Fault",
    "begins_with_a_flow",
    "boxes",
    "chink",
    "contact",
    "coupled_once",
    "course_of_a_flow",
    "ellipse_with_a_chink",
    "explicit_between_tubes",
    "given_flow",
    "has_nitsche",
    "in_the_flow",
    "initial_of_glottis",
    "is_explicit",
    "is_mirrored",
    "is_reduced",
    "name_of_mirrored",
    "of_linear_tissue",
    "rises_from_the_flow",
    "shut_off_from_the_flow",
    "side_of_mirrored",
    "sides_of_mirrored",
    "solved",
    "surface_mass_at_posture",
    "swung_in_the_flow",
    "tube_without_airflow",
    "unlike",
    "unlike_multipliers",
]

Fault = tuple[tuple[str | int, ...], object] | None


def contact(scene: Any, value: str, *path: str) -> Fault:
    """Of a scene's contact, an option with this value."""
    contact = scene.contact
    return ((*path,), value) if contact is not None and getattr(contact, path[-1]) == value else None


def solved(scene: Any) -> str | None:
    """The method of a scene's contact if its forces are solved for."""
    names = ("multipliers", "augmented", "nitsche")
    contact = scene.contact
    return (
        None
        if contact is None
        else next((name for name in names if getattr(contact, name) is not None), None)
    )


def is_explicit(scene: Any) -> bool:
    return scene.time.scheme.central_differences is not None


def is_reduced(scene: Any) -> bool:
    return scene.reduction is not None


def is_mirrored(scene: Any) -> bool:
    """Whether contact is with the plane between mirror images."""
    return scene.reduction is not None and scene.symmetry is not None and scene.contact is not None


def has_nitsche(scene: Any) -> bool:
    return scene.contact is not None and scene.contact.nitsche is not None


def boxes(scene: Any) -> str | None:
    name = type(scene.mesh).__name__
    return name.lower() if name in ("Block", "Blocks") else None


def _folds(scene: Any) -> Any:
    return getattr(scene.mesh, "folds", None)


def chink(scene: Any) -> bool:
    folds = _folds(scene)
    return folds is not None and folds.posterior_chink is not None


def unlike(scene: Any) -> bool:
    """Whether left and right differ by the shape or the tissue of the folds."""
    folds = _folds(scene)
    return folds is not None and folds.unlike_sides


def ellipse_with_a_chink(scene: Any) -> Fault:
    folds = _folds(scene)
    if folds is None or scene.airflow is None or scene.airflow.area.elliptic is None:
        return None
    return (("airflow", "area"), "elliptic") if folds.lesions or folds.posterior_chink is not None else None


def initial_of_glottis(scene: Any) -> Fault:
    if scene.initial is None or boxes(scene) is None:
        return None
    for name in ("opening_velocity", "opening_displacement"):
        if getattr(scene.initial, name) is not None:
            return ("initial", name), None
    return None


def sides_of_mirrored(mesh: Any) -> Fault:
    return (("sides",), None) if mesh.mirror is not None and mesh.sides is not None else None


def side_of_mirrored(mesh: Any) -> Fault:
    """A selection of one side in the part that is mirrored."""
    for name, wanted in mesh.surfaces.items() if mesh.mirror is not None else ():
        if getattr(wanted, "side", None) is not None:
            return ("surfaces", name, "side"), wanted.side
    return None


def name_of_mirrored(mesh: Any) -> Fault:
    """A surface whose name is that of one side of a mirrored one."""
    for name in mesh.surfaces if mesh.mirror is not None else ():
        if name.endswith(("_left", "_right")):
            return ("surfaces", name), None
    return None


def unlike_multipliers(scene: Any) -> Fault:
    if not is_mirrored(scene):
        return None
    multipliers = scene.contact.multipliers
    if multipliers is None:
        return (
            "contact",
            next(name for name in type(scene.contact).kinds if getattr(scene.contact, name)),
        ), None
    return (
        None
        if multipliers.position == "end_of_step"
        else (("contact", "multipliers", "position"), "weighted")
    )


def tube_without_airflow(scene: Any) -> Fault:
    given = [name for name in ("tract", "trachea") if getattr(scene, name) is not None]
    return ((given[0],), None) if given and scene.airflow is None else None


def coupled_once(scene: Any) -> Fault:
    """A coupling that does not iterate, of tissue at finite strain."""
    if scene.strain is None or scene.airflow is None or scene.airflow.coupling.iterated is not None:
        return None
    return ("airflow", "coupling"), None


def of_linear_tissue(scene: Any, *path: str) -> Fault:
    """A part, or an option of it, that tissue at finite strain does not go with."""
    part = scene
    for name in path:
        part = None if part is None else getattr(part, name)
    return (path, None) if scene.strain is not None and part else None


def given_flow(scene: Any) -> Fault:
    """What gives a flow at the end of a tube where others hold a pressure."""
    if scene.trachea is not None and scene.trachea.supply.flow is not None:
        return ("trachea", "supply", "flow"), None
    if scene.tract is not None and scene.tract.end.closed is not None:
        return ("tract", "end"), "closed"
    return None


def course_of_a_flow(scene: Any) -> Fault:
    has_course = scene.airflow is not None and scene.airflow.course is not None
    return (("airflow", "course"), None) if has_course and given_flow(scene) else None


def begins_with_a_flow(scene: Any) -> Fault:
    at_once = scene.airflow is not None and scene.airflow.rise == 0
    return (("airflow", "rise"), 0.0) if at_once and given_flow(scene) else None


def in_the_flow(scene: Any) -> bool:
    """Whether it begins in the equilibrium with the flow."""
    return scene.initial is not None and scene.initial.equilibrium == "flow"


def rises_from_the_flow(scene: Any) -> Fault:
    rises = in_the_flow(scene) and scene.airflow is not None and scene.airflow.rise > 0
    return (("airflow", "rise"), scene.airflow.rise) if rises else None


def shut_off_from_the_flow(scene: Any) -> Fault:
    return given_flow(scene) if in_the_flow(scene) else None


def swung_in_the_flow(scene: Any) -> Fault:
    """The first load that varies."""
    if not in_the_flow(scene):
        return None
    return next(
        ((("loads", k, "frequency"), load.frequency) for k, load in enumerate(scene.loads) if load.frequency),
        None,
    )


def explicit_between_tubes(scene: Any) -> Fault:
    if scene.airflow is None or (scene.tract is None and scene.trachea is None) or is_explicit(scene):
        return None
    coupling = scene.airflow.coupling
    return None if coupling.iterated is not None else (("airflow", "coupling"), None)


def surface_mass_at_posture(scene: Any) -> Fault:
    contact = scene.contact
    if scene.posture is None or contact is None or contact.surface_mass == "kept":
        return None
    return ("contact", "surface_mass"), contact.surface_mass
