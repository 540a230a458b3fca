"""Finer and coarser meshes of the same body, as similar as a scene's mesh allows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from plica import _engine
from plica.errors import InvalidInput, SceneError
from plica.runs.scene_mesh import at_posture, scene_mesh
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.parts import Block, Blocks, Larynx, Mesh, MeshFile
from plica.scene.scene import Scene
from plica.uncertainty.uniform import refined

__all__ = ["OtherMesh", "coarser", "finer", "given"]

_LEAST_LINES = 8  # around the airway, limit of the engine


@dataclass(frozen=True)
class OtherMesh:
    """A mesh that differs from the scene's only in edge length, with a corresponding number of airflow
    sections.

    Attributes
    ----------
    name : str
        Name of its level.
    factor : float
        Refinement factor of the edges; below 1 they are longer.
    scene : Scene
        The scene with this mesh; for a refined file, with the original mesh. The number of cut sections of
        the airflow is multiplied by `factor`, within the limits of a scene.
    build : callable
        Builds it.
    """

    name: str
    factor: float
    scene: Scene
    build: Callable[[], _engine.TetMesh]


def finer(scene: Scene) -> OtherMesh | None:
    """The smallest refinement of the scene's mesh, by 1.25 or more, that keeps its shape."""
    mesh = scene.mesh
    if isinstance(mesh, MeshFile):
        at_rest = build_mesh(mesh, scene.source)
        return OtherMesh("mesh-2", 2.0, _sectioned(scene, 2.0), lambda: at_posture(scene, refined(at_rest)))
    if isinstance(mesh, Larynx):
        return _larynx(scene, mesh, 1.25)
    return _divided(scene, 1.5 if _halvable(mesh) else 2.0)


def coarser(scene: Scene) -> OtherMesh | None:
    """The smallest coarsening, with edges 1.25 times as long or more, that keeps the mesh's shape; or
    None."""
    mesh = scene.mesh
    if isinstance(mesh, MeshFile):
        return None
    if isinstance(mesh, Larynx):
        return _larynx(scene, mesh, 1 / 1.25)
    return _divided(scene, 0.5) if _halvable(mesh) else None


def given(scene: Scene, other: Scene) -> OtherMesh:
    """The mesh of another scene, which may differ only in mesh, time, output and solver."""
    ours, theirs = scene.resolved(), other.resolved()
    for name in sorted((ours.keys() | theirs.keys()) - {"mesh", "time", "output", "solver"}):
        if ours.get(name) != theirs.get(name):
            raise InvalidInput(
                f"{other.source}: {name} differs from that of the run; must be the same: only the mesh may "
                "differ."
            )
    replaced = Scene.model_validate({**scene.resolved(), "mesh": theirs["mesh"]})
    built = at_posture(replaced, build_mesh(replaced.mesh, other.source))
    ratio = (len(built.cells) / len(scene_mesh(scene).cells)) ** (1 / 3)
    if 1 / 1.1 < ratio < 1.1:
        raise InvalidInput(
            f"{other.source}: its edges are {1 / ratio:.3g} times as long as those of the run; must be "
            "shorter or longer by a factor of 1.1 or more. Otherwise the difference means nothing."
        )
    return OtherMesh(f"mesh-{replaced.digest()[:8]}", ratio, _sectioned(replaced, ratio), lambda: built)


def _larynx(scene: Scene, larynx: Larynx, factor: float) -> OtherMesh | None:
    fields = larynx.all_options()
    found = _triangulated(fields, factor) if "size" in fields else _in_levels(fields, factor)
    if found is None or found[1]["around"] < _LEAST_LINES:
        return None
    exact, changes = found
    return _changed(scene, exact, {f"mesh.options.{name}": value for name, value in changes.items()})


def _triangulated(fields: dict[str, Any], factor: float) -> tuple[float, dict[str, Any]]:
    """Lines around the airway are multiples of four: the next multiple sets the factor."""
    around, step = int(fields["around"]), 4 if factor > 1 else -4
    lines = around + step
    while lines > 0 and max(lines / around, around / lines) < max(factor, 1 / factor):
        lines += step
    exact = max(lines, 1) / around
    return exact, {"around": lines, "size": fields["size"] / exact, "growth": fields["growth"] / exact}


def _in_levels(fields: dict[str, Any], factor: float) -> tuple[float, dict[str, Any]] | None:
    """Numbers of levels, lines and rings are all doubled, or halved if possible."""
    exact = 2.0 if factor > 1 else 0.5
    counts = {name: int(fields[name]) for name in ("around", "cover_rings", "ligament_rings", "body_rings")}
    levels = [int(n) for n in fields["levels"]]
    if exact < 1 and (counts["around"] % 8 or any(n % 2 for n in (*counts.values(), *levels))):
        return None
    changes: dict[str, Any] = {name: int(n * exact) for name, n in counts.items()}
    return exact, changes | {"levels": tuple(int(n * exact) for n in levels)}


def _halvable(mesh: Mesh) -> bool:
    return all(n % 2 == 0 for block in _blocks(mesh).values() for n in block.divisions)


def _blocks(mesh: Mesh) -> dict[str, Block]:
    if isinstance(mesh, Blocks):
        return {f"mesh.blocks.{name}": block for name, block in mesh.blocks.items()}
    return {"mesh": mesh} if isinstance(mesh, Block) else {}


def _divided(scene: Scene, factor: float) -> OtherMesh | None:
    changes = {
        f"{path}.divisions": tuple(round(n * factor) for n in block.divisions)
        for path, block in _blocks(scene.mesh).items()
    }
    return _changed(scene, factor, changes)


def _changed(scene: Scene, factor: float, changes: dict[str, Any]) -> OtherMesh | None:
    try:
        other = _sectioned(scene.replace(changes), factor)
    except SceneError:
        return None  # beyond the limits of such a mesh
    return OtherMesh(f"mesh-{factor:.3g}", factor, other, lambda: scene_mesh(other))


def _sectioned(scene: Scene, factor: float) -> Scene:
    """The scene with `factor` times as many cut sections of its airflow, if it has any."""
    cut = scene.airflow.area.cut if scene.airflow is not None else None
    if cut is None:
        return scene
    return scene.replace({"airflow.area.cut.sections": min(max(round(cut.sections * factor), 2), 1000)})
