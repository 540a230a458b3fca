"""Build the engine's mesh from the mesh part of a scene."""

from __future__ import annotations

from plica import _engine
from plica.errors import InvalidInput, SceneError
from plica.scene.mesh.changed import changed_mesh
from plica.scene.mesh.folds import Folds
from plica.scene.mesh.moved import moved_mesh
from plica.scene.mesh.parts import Block, Blocks, Larynx, Mesh, MeshFile

__all__ = ["build_mesh"]

_BISECTIONS = 8  # to 0.4 % of what is possible


def build_mesh(mesh: Mesh, where: str = "Scene") -> _engine.TetMesh:
    """Build, or read, and check the mesh of a scene.

    Parameters
    ----------
    mesh : Larynx, MeshFile, Block or Blocks
    where : str
        Prefix of messages.

    Returns
    -------
    TetMesh
        `points` (n, 3) m, `cells` (m, 4) or (m, 10) and their labels.
    """
    try:
        built = _build(mesh, where)
        if mesh.order == 2 and built.order == 1:
            built = _engine.to_quadratic(built)
        _engine.check_mesh(built)
    except SceneError:
        raise
    except InvalidInput as error:
        raise SceneError(f"{where}: mesh: {error}") from None
    return built


def _build(mesh: Mesh, where: str) -> _engine.TetMesh:
    match mesh:
        case Larynx():
            built = _engine.larynx_mesh(order=mesh.order, **mesh.all_options())
            return built if mesh.folds is None or not mesh.folds.moved else _moved(mesh.folds, built, where)
        case Block():
            return _block(mesh)
        case Blocks():
            (first, a), (second, b) = mesh.blocks.items()
            both = _engine.combine(_block(a), _block(b), f"{first}.", f"{second}.")
            return changed_mesh(both, layer_names=[first, second])
        case MeshFile():
            from plica.scene.mesh.file import read_mesh

            return read_mesh(mesh, where)


def _moved(folds: Folds, like: _engine.TetMesh, where: str) -> _engine.TetMesh:
    """A mesh of like folds, brought to the surface of these."""
    surface = folds.surface()

    def checked(share: float) -> _engine.TetMesh:
        found = moved_mesh(like, lambda points: surface.moved(points, share))
        _engine.check_mesh(found)
        return found

    try:
        return checked(1.0)
    except InvalidInput as error:
        fault = str(error).removeprefix("TetMesh: ").partition(";")[0]
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        share = 0.5 * (low + high)
        try:
            checked(share)
            low = share
        except InvalidInput:
            high = share
    raise SceneError(
        f"{where}: mesh.folds: left_gap, right_gap, posterior_chink and protrusions move the mesh until "
        f"{fault}; must be at most {low:.2f} of what they are. Or take more depth, larger lesions, or "
        "another mesh.larynx."
    )


def _block(block: Block) -> _engine.TetMesh:
    return _engine.block_mesh(corner=block.corner, size=block.size, divisions=block.divisions)
