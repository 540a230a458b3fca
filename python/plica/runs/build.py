"""Build the engine's simulation of a scene: only the parts that the scene has are constructed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError, SolveFailed, nearest, one_of
from plica.runs.basis_file import read_basis
from plica.runs.flow_equilibrium import (
    EquilibriumBranch,
    FlowEquilibrium,
    require_steady,
)
from plica.runs.materials import located, materials_of, place_text
from plica.runs.options import engine_options
from plica.runs.scene_mesh import require_isotropic_across, required_posture, scene_mesh
from plica.runs.stretched_branch import StretchedBranch
from plica.runs.tubes import tubes_of
from plica.scene.held import fixed_components, places_at_rest
from plica.scene.initial import initial_fields
from plica.scene.mesh.folds_apart import require_apart
from plica.scene.mesh.parts import MeshFile
from plica.scene.mesh.surface_fault import airway_fault, contact_fault, selecting
from plica.scene.parts import Airflow, Contact
from plica.scene.scene import Scene
from plica.units import quantity_within

__all__ = [
    "build_simulation",
    "contact_sides",
    "equilibrium",
    "equilibrium_branch",
    "fixed_components",
    "flow_equilibrium",
    "probe_nodes",
    "whole_tissue",
]


def build_simulation(
    scene: Scene,
    mesh: _engine.TetMesh | None = None,
    displacement: NDArray[np.float64] | None = None,
    velocity: NDArray[np.float64] | None = None,
    basis: NDArray[np.float64] | None = None,
    last_basis: _engine.LastBasis | None = None,
) -> _engine.Simulation:
    """The simulation of a scene at t = 0, to be advanced by the caller.

    Parameters
    ----------
    scene : Scene
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.
    displacement, velocity : (n, 3) m and m/s, optional
        Initial values instead of those of the scene; zero at fixed nodes.
    basis : (3 n, any), optional
        The vectors whose combinations are the displacements, instead of those in the file of the scene's
        reduction.
    last_basis : LastBasis, optional
        Of reduced scenes that are built one after another, each with the same one: where basis, supports and
        mass are those of the scene before, to the bit, they are not made orthonormal again.

    Returns
    -------
    Simulation
        ``advance(steps)`` returns all waveforms of these steps (docs/scene.md), ``advance(steps, ["flow",
        "minimum_area"])`` only these, which is faster; if a step has no solution it raises
        `plica.StepFailed`, which carries those of the previous steps. ``set_external_force(force)`` adds a
        nodal force (n, 3) N to the loads until it is replaced; it acts at t + (1 + alpha) h of a step from
        t to t + h (with Newmark, alpha = 0, at its end). ``displacement``, ``velocity`` and ``acceleration``
        are (n, 3); ``mass``, ``stiffness`` and ``viscosity`` (None where no material is viscous) are
        (3 n, 3 n), as (values, columns, row starts) of ``scipy.sparse.csr_array``, without supports: all are
        of all nodes n, with a symmetry, too. ``state()`` is of what is solved for: with a symmetry of the
        part's nodes ``images[0]`` (p), whose vectors are (3 p). ``images`` (copies, p) has the node that each
        is mirrored to; bit k of the copy stands for the plane x_k = 0, where component k changes its sign.
        Without symmetry it is None.

    Raises
    ------
    SceneError
        If the scene names something that its mesh does not have.
    SolveFailed
        If it begins in an equilibrium with the flow that is not there.
    """
    mesh = scene_mesh(scene) if mesh is None else required_posture(scene, mesh)
    body = _body(scene, mesh)
    if isinstance(scene.mesh, MeshFile) and scene.mesh.mirror is not None:
        airway = None if scene.airflow is None else scene.airflow.surface
        require_apart(mesh, body["fixed"], airway, scene.source)
    if basis is None and scene.reduction is not None:
        basis = read_basis(scene.reduction.basis, scene, mesh)
    if displacement is None and velocity is None:
        displacement, velocity = _start(scene, mesh, body, basis)
    parts: dict[str, Any] = {}
    if scene.airflow is not None:
        parts["airflow"] = _airflow(scene, scene.airflow, mesh)
    if scene.contact is not None:
        parts["contact"] = _contact(scene, scene.contact, mesh)
    if displacement is not None:
        parts["displacement"] = displacement
    if velocity is not None:
        parts["velocity"] = velocity
    if scene.output.probes:
        parts["probes"] = probe_nodes(scene, mesh)
    if scene.symmetry is not None:
        parts["symmetry"] = scene.symmetry
    if scene.strain is not None:
        parts["strain"] = engine_options(scene.strain.choice)
    if basis is not None:
        given = (
            {}
            if scene.reduction is None
            else scene.reduction.model_dump(include={"watch_every", "damping_ratio"})
        )
        parts["reduction"] = _engine.Reduction(basis=basis, **given)
        parts["last_basis"] = last_basis
    try:
        return _engine.Simulation(
            **body,
            scheme=engine_options(scene.time.scheme.choice),
            step=scene.time.step,
            solver_tolerance=scene.solver.tolerance,
            solver=engine_options(scene.solver.method.choice),
            lumped_mass=scene.time.lumped_mass,
            **parts,
        )
    except InvalidInput as error:
        raise _airway_located(scene, mesh, error) from None


def equilibrium(scene: Scene) -> NDArray[np.float64]:
    """The displacement (n, 3) m at rest under gravity and the loads at t = 0, K u = f, or f(u) = f.

    f(u) is the force of tissue at finite strain. Airflow, contact and initial values are ignored. Raises
    SceneError if the supports allow a rigid motion, or the scene names something that its mesh does not have;
    SolveFailed if tissue at finite strain buckles under the loads, or is turned inside out.
    """
    return _at_rest(scene, _body(scene, scene_mesh(scene)))


def flow_equilibrium(
    scene: Scene, pressure: float | str | None = None, mesh: _engine.TetMesh | None = None
) -> FlowEquilibrium:
    """Tissue at rest under the steady flow through it, K u = f + B p(A u), without contact; at finite strain
    f(u) stands for K u.

    Parameters
    ----------
    scene : Scene
        With an airflow whose load acts on the surface at rest; loads must be constant. Contact, initial
        values, reduction, symmetry and the pressure's rise are ignored.
    pressure : float or str, optional
        [Pa] Instead of the scene's subglottal pressure.
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.

    Returns
    -------
    FlowEquilibrium
        That of the branch that begins with the tissue at rest without flow, followed as the pressure rises.

    Raises
    ------
    InvalidInput
        If the scene is none of these, or its folds overlap at rest.
    SolveFailed
        If the branch ends below this pressure, or the folds touch there.
    """
    require_steady(scene)
    assert scene.airflow is not None
    wanted = scene.airflow.subglottal_pressure
    if pressure is not None:
        wanted = quantity_within("flow_equilibrium", "pressure", pressure, "Pa", 1e-3, 1e6)
    return equilibrium_branch(scene, mesh).at(wanted)


def equilibrium_branch(
    scene: Scene,
    mesh: _engine.TetMesh | None = None,
    simulation: _engine.Simulation | None = None,
    basis: NDArray[np.float64] | None = None,
) -> EquilibriumBranch:
    """The branch of equilibria with the flow to which `flow_equilibrium` belongs.

    mesh, simulation: of the scene, and of its `whole_tissue`, if they are already built. basis (3 n, any):
    displacements are its combinations. Raises InvalidInput as `flow_equilibrium`.
    """
    require_steady(scene)
    mesh = scene_mesh(scene) if mesh is None else mesh
    body = _body(scene, mesh)
    at_rest = np.zeros_like(mesh.points)
    if scene.gravity is not None or scene.loads:
        at_rest = _at_rest(scene, body)
    if simulation is None:
        simulation = build_simulation(whole_tissue(scene), mesh)
    if scene.strain is None:
        return EquilibriumBranch(scene, mesh, simulation, at_rest, basis)
    try:
        statics = _engine.StretchedStatics(**body)
    except InvalidInput as error:
        raise located(scene, error) from None
    return StretchedBranch(scene, mesh, simulation, at_rest, statics)


def whole_tissue(scene: Scene) -> Scene:
    """The scene without symmetry, and without what neither its matrices nor its flow depend on."""
    changes: dict[str, Any] = {"reduction": None, "symmetry": None, "initial": None, "strain": None}
    if scene.contact is not None and scene.contact.surface_mass == "kept":
        changes["contact"] = None
    return scene.replace(changes)


def _start(
    scene: Scene, mesh: _engine.TetMesh, body: dict[str, Any], basis: NDArray[np.float64] | None
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
    """Displacement m and velocity m/s at t = 0, (n, 3) each, or None if zero."""
    displacement, velocity = initial_fields(scene, mesh, body["fixed"])
    if scene.initial is None or scene.initial.equilibrium is False:
        return displacement, velocity
    if scene.initial.equilibrium == "flow":
        assert scene.airflow is not None  # as the scene requires
        branch = equilibrium_branch(scene, mesh, basis=basis)
        rest = branch.at(scene.airflow.pressure_at_start).displacement
    else:
        rest = _at_rest(scene, body)
    return rest if displacement is None else rest + displacement, velocity


def _at_rest(scene: Scene, body: dict[str, Any]) -> NDArray[np.float64]:
    try:
        return _engine.equilibrium(**body, finite_strain=scene.strain is not None)
    except InvalidInput as error:
        raise located(scene, error) from None
    except SolveFailed as error:
        raise SolveFailed(f"{scene.source}: {str(error).removeprefix('Scene: ')}") from None


def _body(scene: Scene, mesh: _engine.TetMesh) -> dict[str, Any]:
    """Arguments that do not depend on airflow and contact: mesh, tissue, supports, loads, gravity."""
    if scene.strain is not None:
        require_isotropic_across(scene, "strain")
    materials, names, cell_material = materials_of(scene, mesh)
    return {
        "mesh": mesh,
        "materials": materials,
        "material_names": names,
        "cell_material": cell_material,
        "fixed": fixed_components(scene, mesh),
        "loads": _loads(scene, mesh),
        "gravity": scene.gravity,
    }


def _airway_located(scene: Scene, mesh: _engine.TetMesh, error: InvalidInput) -> SceneError:
    """An error that the engine had with the airflow's surface says what is wrong with that surface."""
    text = str(error)
    if mesh.rest is not None and text.startswith(("Airflow: interface", "Airflow: least width")):
        return SceneError(
            f"{scene.source}: posture: the airway is not open all along. {text} At rest it may be: take "
            "less of the posture, a wider glottis, or a smaller posture.contraction."
        )
    if scene.airflow is None or not text.startswith("Airflow: interface"):
        return located(scene, error)
    name = scene.airflow.surface
    found = airway_fault(mesh, name) or f"{text.removeprefix('Airflow: ')} {selecting(name)}"
    return SceneError(f'{scene.source}: airflow.surface = "{name}": {found}')


def _known_surface(scene: Scene, path: str, name: str, mesh: _engine.TetMesh, sided: bool = False) -> None:
    """Raise unless the mesh has that surface; sided: one of two that a mesh file must name."""
    known = list(mesh.surfaces)
    if name in known or not isinstance(scene.mesh, MeshFile):
        return _known(scene, path, name, known)
    close = nearest(name, known, cutoff=0.9 if sided else 0.8)  # airway is no airway_left
    what = "the faces of one side alone" if sided else "its faces"
    hint = f"Select in mesh.surfaces.{name} {what}, by label, box, plane or facing, or name another surface."
    has = f"one of {', '.join(known)}" if known else "which has none yet"
    raise SceneError(
        f'{scene.source}: {path} = "{name}"; must be a surface of the mesh, {has}.{close} {hint}'
    )


def _known(scene: Scene, path: str, name: str, known: list[str]) -> None:
    """Raise unless the mesh has that name."""
    if name not in known:
        raise SceneError(f'{scene.source}: {path} = "{name}"; must be {one_of(known)}.{nearest(name, known)}')


def probe_nodes(scene: Scene, mesh: _engine.TetMesh) -> NDArray[np.int32]:
    """The node nearest to each probe point, (p)."""
    points = np.asarray(mesh.points)
    wanted = np.asarray(scene.output.probes, dtype=float).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.1 * (high - low)
    for k, point in enumerate(wanted):
        if np.any(point < low - margin) or np.any(point > high + margin):
            raise SceneError(
                f"{scene.source}: output.probes[{k}] = {place_text(point)} m; must be in or near the "
                f"mesh, which extends from {place_text(low)} to {place_text(high)} m."
            )
    return np.array([np.argmin(((points - point) ** 2).sum(axis=1)) for point in wanted], dtype=np.int32)


def _airflow(scene: Scene, airflow: Airflow, mesh: _engine.TetMesh) -> _engine.Airflow:
    _known_surface(scene, "airflow.surface", airflow.surface, mesh)
    tubes: dict[str, Any] = {"trachea": None, "tract": None} | tubes_of(scene)
    made: _engine.Airflow = engine_options(airflow, **tubes)
    return made


def _contact(scene: Scene, contact: Contact, mesh: _engine.TetMesh) -> _engine.Contact:
    for side in ("first", "second"):
        _known_surface(scene, f"contact.{side}", getattr(contact, side), mesh, sided=True)
    surfaces = [mesh.surfaces[name] for name in (contact.first, contact.second)]
    first, second = contact_sides(contact, mesh)
    points = np.asarray(mesh.points)
    try:
        if contact.airway == "matched":
            # partners are partners at any posture
            airway = _engine.matched_airway(places_at_rest(mesh), first, second, contact.direction)
        else:
            airway = _engine.triangulated_airway(points, first, second)
    except InvalidInput as error:
        matched = contact.airway == "matched"
        if matched or "meshing" not in _engine.build_info()["absent"]:
            direction = contact.direction if matched else None
            if fault := contact_fault(mesh, (contact.first, contact.second), direction):
                raise SceneError(f"{scene.source}: contact.{fault}") from None
        hint = ' Between other meshes: airway = "triangulated".' if matched else ""
        raise SceneError(f"{scene.source}: contact: {error}{hint}") from None
    made: _engine.Contact = engine_options(
        contact,
        airway=airway,
        enforcement=engine_options(contact.choice),
        faces=_engine.Mortar(*surfaces) if contact.faces == "mortar" else _engine.AtNodes(),
    )
    return made


def contact_sides(contact: Contact, mesh: _engine.TetMesh) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The flat triangles (f, 3) of both surfaces."""
    first, second = (_engine.flat_triangles(mesh.surfaces[name]) for name in (contact.first, contact.second))
    return first, second


def _loads(scene: Scene, mesh: _engine.TetMesh) -> list[_engine.Load]:
    for k, load in enumerate(scene.loads):
        _known_surface(scene, f"loads[{k}].surface", load.surface, mesh)
    return [_engine.Load(**load.model_dump()) for load in scene.loads]
