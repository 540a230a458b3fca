"""Make the basis of reduced scenes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError
from plica.runs.basis_file import write_basis
from plica.runs.build import build_simulation, contact_sides
from plica.runs.results import Run
from plica.runs.scene_mesh import scene_mesh
from plica.scene.changes import changed
from plica.scene.held import fixed_components
from plica.scene.scene import Scene
from plica.storage.files import refuse_overwriting
from plica.units import quantity_within

__all__ = ["CONTACT_REACH", "basis_of", "reduce"]

CONTACT_REACH = 6e-3  # m


def reduce(
    source: Run | Scene | str | Path,
    path: str | Path,
    *,
    scene: Scene | str | Path | None = None,
    components: int | None = None,
    modes: int | None = None,
    contact_vectors: int | None = None,
    contact_reach: float | str = CONTACT_REACH,
    overwrite: bool = False,
    progress: bool = False,
) -> int:
    """Make a basis for reduced scenes, ``reduction.basis``, and store it.

    Parameters
    ----------
    source : Run, Scene or path
        A finished run without reduction, or its directory, that stored displacements of some steady cycles:
        their principal components are the basis. Or a scene, or its file: the basis is of modes and contact
        vectors, which is less accurate (docs/reduction.md).
    path : path
        The file.
    scene : Scene or path, optional
        A scene that the basis is for, with the mesh and the supports of a run's: its symmetry, its contact
        and its airflow count. Default: that of the source.
    components : int, optional
        Number of principal components of a run, those with the most elastic energy. Default: 150, or as many
        as it has frames.
    modes, contact_vectors : int, optional
        Numbers of vibration modes of lowest frequency, and of static responses to normal forces on contact
        nodes, those combinations with the most elastic energy. Default: of a run none, of a scene 200 and
        100, or as many as there are.
    contact_reach : float or str
        [m] Contact has vectors where the surfaces are within this distance at rest.
    overwrite : bool
        Replace the file if it exists.
    progress : bool
        Call what is computed by name on standard error.

    Returns
    -------
    int
        Number of vectors: these, and 40 responses to the pressures of a scene's airflow.

    Raises
    ------
    InvalidInput
        If the run does not fit the scene, the scene cannot be reduced, or more vectors are asked for than
        there are.
    """
    path = Path(path)
    reach = quantity_within("reduce", "contact_reach", contact_reach, "m", 1e-9, 1.0)
    refuse_overwriting([path], overwrite)
    run, own = _source(source)
    chosen = own if scene is None else scene if isinstance(scene, Scene) else Scene.load(scene)
    if run is None and components is not None:
        raise InvalidInput(
            f"reduce: components = {components}; must be left out with a scene: they are of a run's motion."
        )
    try:
        changed(chosen, {"reduction": {"basis": path}}, f"{chosen.source}: it cannot be reduced")
    except SceneError as error:
        raise InvalidInput(f"{error} Or give the scene that it is for: scene (--scene).") from None
    mesh = scene_mesh(chosen)
    basis = basis_of(
        chosen,
        mesh,
        run,
        components=components,
        modes=modes,
        contact_vectors=contact_vectors,
        contact_reach=reach,
        on_start=_print_notice if progress else None,
    )
    write_basis(path, chosen, mesh, basis)
    return int(basis.shape[1])


def basis_of(
    scene: Scene,
    mesh: _engine.TetMesh,
    run: Run | None = None,
    *,
    components: int | None = None,
    modes: int | None = None,
    contact_vectors: int | None = None,
    contact_reach: float = CONTACT_REACH,
    on_start: Callable[[], None] | None = None,
) -> NDArray[np.float64]:
    """The vectors (3 n, any) m that `reduce` stores; `on_start` is called before they are computed."""
    from plica.runs.basis import reduction_basis  # needs SciPy, which no run does

    return reduction_basis(
        build_simulation(scene.replace({"reduction": None, "symmetry": None, "initial": None}), mesh),
        mesh,
        fixed_components(scene, mesh),
        motion=None if run is None else _motion(scene, run, mesh),
        components=components,
        modes=modes,
        contact_vectors=0 if scene.contact is None else contact_vectors,
        surface=None if scene.airflow is None else scene.airflow.surface,
        sides=None if scene.contact is None else contact_sides(scene.contact, mesh),
        reach=contact_reach,
        symmetry=scene.symmetry,
        on_start=on_start,
    )


def _source(source: Run | Scene | str | Path) -> tuple[Run | None, Scene]:
    if isinstance(source, Scene):
        return None, source
    if isinstance(source, str | Path):
        if Path(source).is_file():
            return None, Scene.load(source)
        source = Run.load(source)
    return source, source.scene


def _motion(scene: Scene, run: Run, mesh: _engine.TetMesh) -> NDArray[Any]:
    """The displacements (frames, n, 3) m of a full run; raises InvalidInput if it does not fit the scene."""
    motion = _stored_motion(run, mesh)
    if not np.array_equal(fixed_components(run.scene, mesh), fixed_components(scene, mesh)):
        raise InvalidInput(f"{run.directory} has other fixed nodes; must have the scene's supports.")
    if run.scene.symmetry not in (None, scene.symmetry):
        own = "none" if scene.symmetry is None else f'none or "{scene.symmetry}"'
        raise InvalidInput(
            f'{run.directory} has symmetry = "{run.scene.symmetry}"; must have {own}, like the scene: its '
            "displacements contain no motion outside its symmetry."
        )
    return motion


def _print_notice() -> None:
    import sys

    print("plica: computing the basis", file=sys.stderr, flush=True)


def _stored_motion(run: Run, mesh: _engine.TetMesh) -> NDArray[np.float32]:
    """The stored displacements (frames, n, 3) m of a run on this mesh.

    Raises InvalidInput for a run that is itself reduced, not finished, without frames or on another mesh.
    """
    key = run.directory
    if run.scene.reduction is not None:
        raise InvalidInput(f"{key} is itself reduced; must be a run without reduction.")
    if run.status != "finished":
        raise InvalidInput(
            f"{key} is {run.status} after {run.steps} of {run.steps_asked} steps; must be finished. Continue "
            f"it with: plica run {run.directory / 'scene.toml'} -o {run.directory} --resume"
        )
    if not (np.array_equal(run.mesh.points, mesh.points) and np.array_equal(run.mesh.cells, mesh.cells)):
        raise InvalidInput(
            f"{key} is on another mesh, of {len(run.mesh.points)} nodes; must be on the scene's."
        )
    if not len(run.fields.get("displacement", ())):
        raise InvalidInput(
            f"{key} has no stored displacements; must have some steady cycles. Set its output.every."
        )
    return np.asarray(run.displacement)
