"""Plausible ranges of the quantities of a larynx, for scenes with an airflow.

Values outside these bounds are not refused: a caution shows the value, the range of a larynx, and the unit
that may have been meant. A scene without airflow need not be a larynx, and is only asked for the unit of a
mesh file, how its bodies are held and where they are (`body_cautions`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from plica._engine import DEEPEST_LAYER
from plica.measures.caution import Caution
from plica.scene.body_cautions import body_cautions
from plica.scene.bounds import ADULT_LENGTH, BOUNDS, LENGTHS, shown
from plica.scene.held import MeshArrays, places_at_rest
from plica.scene.mesh.parts import Larynx, MeshFile

if TYPE_CHECKING:
    from plica.scene.scene import Scene

__all__ = ["scene_cautions", "tube_cautions"]


def scene_cautions(scene: Scene, mesh: MeshArrays) -> tuple[Caution, ...]:
    """Cautions on a scene, one per kind: with an airflow on quantities that no larynx has; on its bodies.

    Parameters
    ----------
    scene : Scene
    mesh : TetMesh or RunMesh
        The scene's mesh, built.

    Returns
    -------
    tuple of Caution
    """
    bodies = body_cautions(scene, mesh)
    if scene.airflow is None:
        return (*_file_caution(scene, mesh), *_beyond_the_end(scene), *bodies)
    return (
        *_implausible(list(_quantities(scene))),
        *_gravity_caution(scene),
        *_layer_caution(scene, mesh),
        *_posture_caution(scene),
        *_beyond_the_end(scene),
        *_mesh_caution(scene, scene.airflow.surface, mesh),
        *bodies,
    )


def tube_cautions(scene: Scene) -> tuple[Caution, ...]:
    """Those of `scene_cautions` on trachea and tract."""
    return tuple(_implausible(list(_tube_quantities(scene))))


def _implausible(quantities: list[tuple[str, str, float]]) -> Iterator[Caution]:
    """One for each kind, of kind, path and value."""
    for name, bound in BOUNDS.items():
        beyond = [
            (path, value) for kind, path, value in quantities if kind == name and not bound.holds(value)
        ]
        if beyond:
            path, value = beyond[0]
            rest = f" (and {', '.join(path for path, _ in beyond[1:])})" if beyond[1:] else ""
            seen = f"{path} = {value:g} {bound.unit}{rest}. {bound.whose} {bound.span()}."
            yield Caution(name, seen, bound.question(value))


def _gravity_caution(scene: Scene) -> Iterator[Caution]:
    if scene.gravity is not None and scene.gravity[2] > 0:
        x, y, z = scene.gravity
        seen = f"gravity = [{x:g}, {y:g}, {z:g}] m/s^2 points upward, from the lungs to the mouth."
        yield Caution("gravity", seen, "Is the sign of z right?")


def _layer_caution(scene: Scene, mesh: MeshArrays) -> Iterator[Caution]:
    """A caution if a layer of a parametric larynx is thinner than in the scene."""
    given = dict(_layer_thicknesses(scene.mesh)) if isinstance(scene.mesh, Larynx) else {}
    most = DEEPEST_LAYER * 0.5 * float(np.ptp(places_at_rest(mesh)[:, 0]))
    deep = {key: value for key, value in given.items() if most < value <= BOUNDS["layer_thickness"].high}
    if deep:
        key, value = next(iter(deep.items()))
        seen = (
            f"{key} = {shown(value, 'm')}. The tissue is so thin that cover and "
            f"ligament are limited to {DEEPEST_LAYER:g} of its depth, {shown(most, 'm')} or less."
        )
        size = "mesh.folds.depth" if key.startswith("mesh.folds") else "mesh.options.radius"
        yield Caution("layer_thickness", seen, f"Use thinner layers, or a larger {size}.")


def _layer_thicknesses(larynx: Larynx) -> Iterator[tuple[str, float]]:
    """Key and value, m, of those that are given."""
    if larynx.folds is not None:
        yield "mesh.folds.cover", larynx.folds.cover
        yield "mesh.folds.ligament", larynx.folds.ligament
    for name in ("layer_thickness", "ligament_thickness"):
        value = getattr(larynx.options, name)
        if value is not None:
            yield f"mesh.options.{name}", value


def _beyond_the_end(scene: Scene) -> Iterator[Caution]:
    """A caution if the run ends before the pressure has risen, or before fields are stored."""
    duration, output = scene.time.duration, scene.output
    seen, advice = [], []
    if scene.airflow is not None and scene.airflow.rise > duration:
        seen.append(f"airflow.rise = {scene.airflow.rise:g} s; the run ends before that, with less pressure.")
        advice.append("let the pressure rise faster")
    course = None if scene.airflow is None else scene.airflow.course
    if course is not None and course.time[-1] > duration * (1 + 1e-9):
        seen.append(f"airflow.course goes on to {course.time[-1]:g} s; the run ends before that.")
        advice.append("let the pressure change faster")
    if output.every is not None and output.start > duration * (1 + 1e-9):
        seen.append(f"output.start = {output.start:g} s; the run ends before that, and no field is stored.")
        advice.append("store fields from an earlier time on")
    if seen:
        text = f"time.duration = {duration:g} s. {' '.join(seen)}"
        yield Caution("duration", text, f"Run longer, or {' and '.join(advice)}.")


def _posture_caution(scene: Scene) -> Iterator[Caution]:
    """A caution if the folds of a parametric larynx are longer or higher than its preset's, or less so.

    Both are of tissue at rest: nothing is stretched or contracted, as in another posture of one larynx. Folds
    of given sizes (`mesh.folds`) are a larynx of their own.
    """
    if not isinstance(scene.mesh, Larynx) or scene.posture is not None or scene.mesh.folds is not None:
        return
    own, preset = (_fold_sizes(larynx) for larynx in (scene.mesh, Larynx(larynx=scene.mesh.larynx)))
    if not BOUNDS["fold_length"].holds(2 * own["mesh.options.major"]):
        return  # which is said already
    changed = [
        f"{key} = {shown(size, 'm')}, {100 * (size / preset[key] - 1):+.3g} % of the preset's"
        for key, size in own.items()
        if not math.isclose(size, preset[key], rel_tol=1e-9)
    ]
    if changed:
        seen = (
            f"{'; '.join(changed)}. This is tissue at rest: a longer or thinner fold is not a stretched one. "
            "It has no tension, and its pitch falls with length, where that of a stretched one rises."
        )
        yield Caution(
            "fold_length", seen, "Another posture of one larynx is posture.elongation, of a mesh at rest."
        )


def _fold_sizes(larynx: Larynx) -> dict[str, float]:
    """m, by key: half the length of the folds, and the height of their layers, unless sections are others."""
    fields = larynx.all_options()
    usual = Larynx(larynx=larynx.larynx).all_options()
    z = [section[0] for section in fields["sections"]]
    found = {"mesh.options.major": float(fields["major"])}
    if len(z) == len(usual["sections"]):
        height = z[fields["layers_to_section"]] - z[fields["layers_from_section"]]
        found["height of the folds (mesh.options.sections)"] = height
    return found


def _tube_quantities(scene: Scene) -> Iterator[tuple[str, str, float]]:
    assert scene.airflow is not None
    if scene.trachea is not None or scene.tract is not None:
        yield "sound_speed", "airflow.sound_speed", scene.airflow.sound_speed
    for name, tube in (("trachea", scene.trachea), ("tract", scene.tract)):
        if tube is None:
            continue
        length, area = tube.profile
        yield "tube_length", f"length of the {name}", sum(length)
        for extreme in {min(area), max(area)}:
            yield "tube_area", f"area of the {name}", extreme
    if scene.trachea is None:
        return
    supply = scene.trachea.supply
    if supply.flow is not None:
        yield "supplied_flow", "trachea.supply.flow.flow", supply.flow.flow
        yield "supply_volume", "trachea.supply.flow.volume", supply.flow.volume
    if supply.pressure is not None:
        yield "supply_volume", "trachea.supply.pressure.volume", supply.pressure.volume


def _quantities(scene: Scene) -> Iterator[tuple[str, str, float]]:
    """Kind, path and value of the quantities of the scene, without its mesh."""
    assert scene.airflow is not None
    yield "subglottal_pressure", "airflow.subglottal_pressure", scene.airflow.subglottal_pressure
    yield "air_density", "airflow.air_density", scene.airflow.air_density
    yield from _tube_quantities(scene)
    model = scene.airflow.model
    if model.air_viscosity is not None:
        yield "air_viscosity", f"airflow.model.{model.chosen}.air_viscosity", model.air_viscosity
    kinds = dict.fromkeys(("E", "E_fibre", "mu_fibre", "mu_transverse"), "stiffness")
    kinds |= {"density": "tissue_density", "viscosity": "viscosity"}
    for layer, tissue in scene.tissue.items():
        for path, part in (
            (f"tissue.{layer}", tissue),
            (f"tissue.{layer}.left", tissue.left),
            (f"tissue.{layer}.right", tissue.right),
        ):
            for field, kind in kinds.items():
                value = getattr(part, field, None)
                if value is not None:
                    yield kind, f"{path}.{field}", value
    yield "time_step", "time.step", scene.time.step
    yield "duration", "time.duration", scene.time.duration
    if isinstance(scene.mesh, Larynx):
        for key, value in _layer_thicknesses(scene.mesh):
            yield "layer_thickness", key, value
        for k, lesion in enumerate(scene.mesh.folds.lesions if scene.mesh.folds else ()):
            if lesion.density is not None:
                yield "tissue_density", f"mesh.folds.lesions[{k}].density", lesion.density
    for layer, stress in scene.posture.active_stress.items() if scene.posture else ():
        yield "active_stress", f"posture.active_stress.{layer}", stress
    if scene.gravity is not None:
        yield "gravity", "gravity", math.hypot(*scene.gravity)
    for k, load in enumerate(scene.loads):
        yield "load", f"loads[{k}].traction", math.hypot(*load.traction)
        yield "load_frequency", f"loads[{k}].frequency", load.frequency
    if scene.initial is not None:
        for name in ("velocity", "displacement"):
            size = getattr(scene.initial, f"opening_{name}")
            if size is not None:
                yield f"initial_{name}", f"initial.opening_{name}", size
            for layer, vector in getattr(scene.initial, name).items():
                yield f"initial_{name}", f"initial.{name}.{layer}", math.hypot(*vector)


def _mesh_caution(scene: Scene, surface: str, mesh: MeshArrays) -> Iterator[Caution]:
    """A caution on the length of the folds or, if that is plausible, on the size of the mesh."""
    points, faces = np.asarray(mesh.points), mesh.surfaces.get(surface)
    across = float(np.ptp(points, axis=0).max())
    length = across if faces is None else float(np.ptp(points[np.unique(faces), 1]))
    for name, size, what in (
        ("fold_length", length, "The airway is {:.3g} m from front to back."),
        ("mesh_size", across, "The mesh is {:.3g} m from end to end."),
    ):
        bound = BOUNDS[name]
        if not bound.holds(size):
            seen = f"{what.format(size)} {bound.whose} {bound.span()}."
            yield Caution(name, seen, _about_lengths(scene, length, across))
            return


def _file_caution(scene: Scene, mesh: MeshArrays) -> Iterator[Caution]:
    """A caution on a mesh file larger than any larynx whose unit is 1 m, as if the scene has none."""
    if not isinstance(scene.mesh, MeshFile) or scene.mesh.unit != 1.0:
        return
    across = float(np.ptp(np.asarray(mesh.points), axis=0).max())
    bound = BOUNDS["mesh_size"]
    if across > bound.high:
        seen = (
            f"mesh.unit = 1 m, and the mesh is {across:.3g} m from end to end. {bound.whose} {bound.span()}."
        )
        yield Caution("mesh_size", seen, _about_lengths(scene, across / 3, across))


def _about_lengths(scene: Scene, length: float, across: float) -> str:
    if isinstance(scene.mesh, Larynx):
        return "Are the lengths in mesh.options right?"
    if not isinstance(scene.mesh, MeshFile):
        return "Are the lengths in mesh right?"
    fits = {
        abs(math.log(length * size / scene.mesh.unit / ADULT_LENGTH)): unit
        for unit, size in LENGTHS.items()
        if BOUNDS["fold_length"].holds(length * size / scene.mesh.unit)
        and BOUNDS["mesh_size"].holds(across * size / scene.mesh.unit)
    }
    if fits:
        unit = fits[min(fits)]
        return f'Is one unit of the file 1 {unit}? Then set mesh.unit = "1 {unit}".'
    return f"Is mesh.unit = {scene.mesh.unit:g} m right?"
