"""The mesh of a scene at its posture."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError, SolveFailed, nearest, one_of
from plica.measures.contour import narrowest_gap
from plica.measures.mesh_data import flat_faces
from plica.runs.materials import materials_of
from plica.scene.held import fixed_components
from plica.scene.mesh.build import build_mesh
from plica.scene.posture import Posture
from plica.scene.scene import Scene
from plica.scene.tissue import Tissue

__all__ = ["at_posture", "held_at", "require_isotropic_across", "required_posture", "scene_mesh"]

Floats = NDArray[np.float64]

_MOST_STIFFENED = 6.0  # exponent; 400 times as stiff
_LEAST_HELD = 0.9
_PLANES = 40  # evenly apart, and as many through the nodes that are nearest to the other fold


def scene_mesh(scene: Scene) -> _engine.TetMesh:
    """The mesh of a scene, at its posture if it has one: what airflow, contact and motion see.

    Returns
    -------
    TetMesh
        `points` (n, 3) m and, with a posture, `rest` (n, 3) m, those of the scene's mesh.

    Raises
    ------
    SceneError, SolveFailed
        As `build_mesh` and `at_posture`.
    """
    return at_posture(scene, build_mesh(scene.mesh, scene.source))


def required_posture(scene: Scene, mesh: _engine.TetMesh) -> _engine.TetMesh:
    """The mesh, unless it is at rest where the scene has a posture, or stretched where it has none."""
    if _stretches(scene.posture) != (mesh.rest is not None):
        state = "at rest" if mesh.rest is None else "at a posture"
        raise InvalidInput(
            f"{scene.source}: the mesh given is {state}; must be that of the scene, plica.scene_mesh(scene)."
        )
    return mesh


def at_posture(scene: Scene, mesh: _engine.TetMesh) -> _engine.TetMesh:
    """A mesh of the scene at rest, brought to its posture.

    Raises
    ------
    SceneError
        If the scene's tissue or supports cannot have it.
    SolveFailed
        If the tissue has no equilibrium there: it buckles, or a cell is inverted.
    """
    posture = scene.posture
    if posture is None:
        return mesh
    _check_layers(scene, posture, mesh.layer_names)
    if not _stretches(posture):
        return mesh
    fixed = fixed_components(scene, mesh)
    _check_length(scene, posture, np.asarray(mesh.points), fixed)
    held = held_at(posture, np.asarray(mesh.points), fixed)
    try:
        found: _engine.TetMesh = _engine.stretched(
            mesh, *materials_of(scene, mesh), fixed=fixed, held=held
        ).mesh
    except SolveFailed as error:
        text = str(error).removeprefix("Posture: ")
        raise SolveFailed(f"{scene.source}: {_given(posture)}: {text}") from None
    except SceneError:
        raise
    except InvalidInput as error:
        raise SceneError(f"{scene.source}: {str(error).replace('Posture:', 'posture:')}") from None
    _require_open(scene, posture, found)
    return found


def _require_open(scene: Scene, posture: Posture, mesh: _engine.TetMesh) -> None:
    """Raise SceneError where the folds, apart at rest, cross at the posture."""
    airway = mesh.surfaces.get("airway")
    if airway is None:
        return
    faces = flat_faces(airway).reshape(-1, 3)  # mid-side nodes may cross, too
    share = np.linspace(0.0, 1.0, _PLANES + 2)[1:-1]
    shapes = [np.asarray(points, dtype=float) for points in (mesh.rest, mesh.points)]
    nodes = np.unique(faces)
    aside = nodes[np.abs(shapes[0][nodes, 0]) > 1e-9]  # m; not where both folds meet in front and behind
    near = aside[np.argsort(np.sign(shapes[0][aside, 0]) * shapes[1][aside, 0])[:_PLANES]]
    places = [
        np.concatenate((y[nodes].min() + share * np.ptp(y[nodes]), y[near]))
        for y in (points[:, 1] for points in shapes)
    ]
    rest, now = (
        np.array([narrowest_gap(points, faces, at) for at in own])
        for points, own in zip(shapes, places, strict=True)
    )
    crossed = (rest > 0) & (now <= 0)
    if crossed.any():
        k = np.where(crossed, now, np.inf).argmin()
        raise SceneError(
            f"{scene.source}: {_given(posture)} with posture.contraction = {posture.contraction:g}: the "
            f"folds are {1e3 * now[k]:.3g} mm apart at y = {1e3 * places[1][k]:.3g} mm (at rest "
            f"{1e3 * rest[k]:.3g} mm); must be > 0. "
            "What holds the tissue contracts more than the tissue does: take a smaller posture.contraction, "
            "or less of the posture."
        )


def _stretches(posture: Posture | None) -> bool:
    return posture is not None and (posture.stretch != 0 or any(posture.active_stress.values()))


def _check_layers(scene: Scene, posture: Posture, layers: list[str]) -> None:
    for layer in posture.active_stress:
        if layer not in layers:
            raise SceneError(
                f"{scene.source}: posture.active_stress.{layer} is not a layer of the mesh; must be "
                f"{one_of(layers)}.{nearest(layer, layers)}"
            )
    require_isotropic_across(scene, "a posture")
    strain = max(posture.stretch + 0.5 * posture.stretch**2, 0.0)
    for path, own in _tissues(scene):
        if (exponent := 4 * own.stiffening * strain**2) > _MOST_STIFFENED:
            raise SceneError(
                f"{scene.source}: {path}.stiffening = {own.stiffening:g} with {_stretch(posture)}: fibres "
                f"would bear exp({exponent:.3g}) times as much; must be at most exp({_MOST_STIFFENED:g}). "
                "Take less of either."
            )


def require_isotropic_across(scene: Scene, what: str) -> None:
    """Raise SceneError for tissue that the law of stretched tissue does not have; `what` needs that law."""
    for path, own in _tissues(scene):
        transverse = own.E / (2 * (1 + own.nu))
        if own.mu_transverse is not None and not np.isclose(own.mu_transverse, transverse, rtol=1e-9):
            raise SceneError(
                f"{scene.source}: {path}.mu_transverse = {own.mu_transverse:g} Pa; must be left out, or "
                f"{transverse:g} Pa, with {what}: stretched tissue is isotropic across its fibre."
            )


def _tissues(scene: Scene) -> Iterator[tuple[str, Tissue]]:
    """The tissue of each layer and side, and its key."""
    for layer, tissue in scene.tissue.items():
        yield f"tissue.{layer}", tissue.on("none")
        if tissue.left is not None:
            yield f"tissue.{layer}.left", tissue.on("left")
        if tissue.right is not None:
            yield f"tissue.{layer}.right", tissue.on("right")


def _stretch(posture: Posture) -> str:
    """What sets the elongation, and to what."""
    if posture.muscles is None:
        return f"posture.elongation = {posture.stretch:g}"
    given = posture.muscles.model_dump(exclude_defaults=True)
    muscles = ", ".join(f"posture.muscles.{name} = {value:g}" for name, value in given.items())
    return f"{muscles} (elongation {posture.stretch:g})"


def _given(posture: Posture) -> str:
    """What stretches the tissue."""
    stretch = [_stretch(posture)] if posture.stretch != 0 else []
    pulls = {layer: stress for layer, stress in posture.active_stress.items() if stress != 0}
    return ", ".join(
        stretch + [f"posture.active_stress.{layer} = {stress:g} Pa" for layer, stress in pulls.items()]
    )


def _check_length(scene: Scene, posture: Posture, points: Floats, fixed: NDArray[np.bool_]) -> None:
    along = points[fixed[:, 1], 1]
    share = np.ptp(along) / np.ptp(points[:, 1]) if along.size else 0.0
    if posture.stretch != 0 and share < _LEAST_HELD:
        raise SceneError(
            f"{scene.source}: {_stretch(posture)}: what is held spans {100 * share:.3g} % of the length "
            f"along y; must span {100 * _LEAST_HELD:g} % or more, as the tissue is stretched between its "
            "ends. Hold both in supports."
        )


def held_at(posture: Posture, points: Floats, fixed: NDArray[np.bool_]) -> Callable[[float], Floats]:
    """(n, 3) m, from rest: where what is held goes, at a share of the elongation."""
    from_middle = points - 0.5 * (points.min(axis=0) + points.max(axis=0))

    def at(share: float) -> Floats:
        stretch = 1 + share * posture.stretch
        aside = stretch**-posture.contraction
        return np.where(fixed, from_middle * (np.array((aside, stretch, aside)) - 1), 0.0)

    return at
