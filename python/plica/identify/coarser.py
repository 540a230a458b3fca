"""A scene's mesh with edges twice as long, by which the shift under refinement is seen."""

from __future__ import annotations

from typing import Any

from plica.errors import InvalidInput
from plica.identify.settings import Settings
from plica.phonation.scene.mesh_parts import Block, Larynx
from plica.phonation.scene.mesh_source import larynx_fields
from plica.phonation.scene.scene import Scene

__all__ = ["coarser_scene"]


def coarser_scene(settings: Settings, scene: Scene) -> tuple[Scene | None, str]:
    """The scene with a coarser mesh, or None and the reason why there is none."""
    if settings.coarser == "none":
        return None, ""
    if settings.coarser == "auto":
        return _made(scene)
    other = Scene.load(settings.coarser)
    differs = [name for name in ("tissue", "supports") if getattr(other, name) != getattr(scene, name)]
    differs += ["time.step"] if other.time.step != scene.time.step else []
    if differs:
        raise InvalidInput(
            f"{other.source}: {differs[0]} differs from that of {scene.source}; must be the same: only "
            "the mesh may be coarser."
        )
    if other.mesh == scene.mesh:
        raise InvalidInput(f"{other.source}: has the mesh of {scene.source}; must have a coarser one.")
    return other, ""


def _made(scene: Scene) -> tuple[Scene | None, str]:
    changes: dict[str, Any] = {}
    if isinstance(scene.mesh, Larynx):
        fields = larynx_fields(scene.mesh)
        if "levels" in fields:
            halved: dict[str, Any] = {"levels": [max(1, n // 2) for n in fields["levels"]]}
            halved |= {f"{k}_rings": max(1, fields[f"{k}_rings"] // 2) for k in ("cover", "ligament", "body")}
            halved["around"] = max(8, fields["around"] // 8 * 4)
            changes = {k: v for k, v in halved.items() if v != fields[k]}
        else:
            changes = {"size": 2 * fields["size"]}
        changes = {f"mesh.options.{name}": value for name, value in changes.items()}
    elif isinstance(scene.mesh, Block):
        divisions = tuple(max(1, n // 2) for n in scene.mesh.divisions)
        changes = {"mesh.divisions": divisions} if divisions != scene.mesh.divisions else {}
    if not changes:
        return None, "A coarser mesh cannot be made of this one: give --coarser SCENE."
    return scene.replace(changes), ""
