"""A coarser version of a scene's mesh, to measure how the estimate shifts under refinement."""

from __future__ import annotations

from typing import Any

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.settings import Settings
from plica.scene.mesh.parts import Block, Larynx
from plica.scene.scene import Scene

__all__ = ["coarser_scene", "remainder", "require_coarser"]

_COARSER = {
    "finest": "demo",
    "fine": "coarse",
    "demo": "coarse",
    "thesis": "thesis_medium",
    "thesis_medium": "thesis_coarse",
    "thesis_demo": "thesis_coarse",
}
"""The next coarser preset of each larynx preset."""
_LEAST_RATIO = 1.2  # of edge lengths


def coarser_scene(settings: Settings, scene: Scene) -> tuple[Scene | None, str]:
    """The scene with a coarser mesh; or None and the reason why there is none."""
    if settings.coarser == "none":
        return None, ""
    if settings.coarser == "auto":
        coarser = _coarsened(scene)
        return coarser, "" if coarser is not None else _why_not_coarser(scene)
    other = Scene.load(settings.coarser)
    differs = [name for name in ("tissue", "supports") if getattr(other, name) != getattr(scene, name)]
    differs += ["time.step"] if other.time.step != scene.time.step else []
    if differs:
        raise InvalidInput(
            f"{other.source}: {differs[0]} differs from that of {scene.source}; must be the same: only the "
            "mesh may differ."
        )
    return other, ""


def require_coarser(coarser: _engine.TetMesh, mesh: _engine.TetMesh, source: str) -> float:
    """The ratio of edge lengths, from the numbers of nodes. Raises InvalidInput below 1.2."""
    ratio = float((len(mesh.points) / len(coarser.points)) ** (1 / 3))
    if ratio < _LEAST_RATIO:
        raise InvalidInput(
            f"{source}: has edges {ratio:.2g} times as long as the scene's, by its {len(coarser.points)} "
            f"nodes; must be >= {_LEAST_RATIO:g} times. Otherwise the shift between the meshes means nothing."
        )
    return ratio


def remainder(ratio: float) -> float:
    """Upper bound of the error left on the finer mesh, in units of the shift, for an edge length ratio.

    An error proportional to h^2 leaves 1 / (ratio^2 - 1) of the shift; never less than the shift itself.
    """
    return max(1.0, 1.0 / (ratio**2 - 1.0))


def _coarsened(scene: Scene) -> Scene | None:
    changes: dict[str, Any] = {}
    if isinstance(scene.mesh, Larynx) and scene.mesh.larynx in _COARSER:
        changes = {"mesh.larynx": _COARSER[scene.mesh.larynx]}
    elif isinstance(scene.mesh, Block):
        divisions = tuple(max(1, n // 2) for n in scene.mesh.divisions)
        changes = {"mesh.divisions": divisions} if divisions != scene.mesh.divisions else {}
    return scene.replace(changes) if changes else None


def _why_not_coarser(scene: Scene) -> str:
    if isinstance(scene.mesh, Larynx):
        own, finer = scene.mesh.larynx, "fine" if scene.mesh.larynx == "coarse" else "thesis"
        return f'There is no larynx coarser than "{own}": use "{finer}", or give --coarser SCENE.'
    return "A coarser mesh cannot be made from this one: give --coarser SCENE."
