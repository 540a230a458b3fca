"""A stored run: finished, interrupted, failed, killed or still running."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, Named, library
from plica.measures.caution import Caution
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.measure import Measures
from plica.measures.scene_text import airway_name
from plica.measures.thresholds import usual_distance
from plica.measures.uncertainty import Bound, Uncertainty, read_uncertainty
from plica.measures.waveforms import STORED
from plica.runs import store
from plica.runs.example_bounds import example_bounds
from plica.runs.part import RunPart, part_of
from plica.runs.progress_record import ProgressRecord
from plica.scene.plausibility import scene_cautions
from plica.scene.scene import Scene
from plica.sound.far_field import audio_rate
from plica.sound.voice import Sound, sound
from plica.storage.files import being_written, storage_errors
from plica.storage.stored import Stored

if TYPE_CHECKING:
    import xarray

__all__ = ["Field", "Run", "RunMesh"]

Item = TypeVar("Item")

_STATUS = {
    store.RUNNING: "running",
    store.FINISHED: "finished",
    store.FAILED: "failed",
    store.INTERRUPTED: "interrupted",
}


@dataclass(frozen=True)
class RunMesh:
    """The mesh of a run in its reference position.

    Attributes
    ----------
    points : (n, 3) m
    cells : (m, 4) or (m, 10)
    cell_layer : (m) positions in `layer_names`
    cell_side : (m) 0 none, 1 left, 2 right
    layer_names : list of str
    surfaces : dict of (f, 3) or (f, 6)
    node_sets : dict of (k)
    rest : (n, 3) m, before the posture; None without one
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int32]
    cell_layer: NDArray[np.int32]
    cell_side: NDArray[np.int32]
    layer_names: list[str]
    surfaces: dict[str, NDArray[np.int32]]
    node_sets: dict[str, NDArray[np.int32]]
    rest: NDArray[np.float64] | None = None


class Field:
    """Frames of a nodal field, read from the file on access.

    ``field[-1]`` is the last frame, ``field[::10, node]`` every tenth at one node, ``np.asarray(field)`` all.

    Attributes
    ----------
    shape : tuple of int
        (frames, n, 3) or (frames, n).
    dtype : dtype
    """

    def __init__(self, path: Path, name: str, frames: int) -> None:
        self._path, self._name = path, f"fields/{name}"
        with Stored(path, hint=store.HINT) as file:
            data = file.data(self._name)
            self.shape: tuple[int, ...] = (frames, *data.shape[1:])
            self.dtype: np.dtype[Any] = data.dtype

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> NDArray[Any]:
        first, *rest = self._whole(key)
        frames = np.arange(len(self))[first]
        if np.ndim(frames) and any(isinstance(part, list | np.ndarray) for part in rest):
            raise InvalidInput(
                "Field: frames and nodes by arrays at once; must be one of both. Take the frames first."
            )
        with Stored(self._path, hint=store.HINT) as file:
            if np.ndim(frames) == 0:
                return np.asarray(file.row(self._name, int(frames))[tuple(rest)])
            rows = file.rows(self._name)
            chosen = [rows[int(frame)][tuple(rest)] for frame in frames]
        return (
            np.asarray(chosen) if chosen else np.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *rest)]
        )

    def _whole(self, key: Any) -> tuple[Any, ...]:
        """What is asked for of the frames, and of each of them: with "..." written out."""
        parts = key if isinstance(key, tuple) else (key,)
        if any(part is None for part in parts):
            raise InvalidInput(
                "Field: an index is None; must be frames, nodes and components. Add axes later."
            )
        at = [k for k, part in enumerate(parts) if part is Ellipsis]
        if len(at) > 1:
            raise InvalidInput("Field: an index has two ellipses; must have one.")
        if at:
            missing = len(self.shape) - (len(parts) - 1)
            parts = (*parts[: at[0]], *[slice(None)] * missing, *parts[at[0] + 1 :])
        return parts or (slice(None),)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return (self[frame] for frame in range(len(self)))

    @property
    def checksums(self) -> NDArray[np.uint32]:
        """(frames) CRC-32 of each frame, as stored: a frame that is not what it says raises when it is
        read."""
        with Stored(self._path, hint=store.HINT) as file:
            return file.checksums(self._name)[: len(self)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self[:], dtype=dtype)


def _no_run(directory: Path) -> str:
    if not directory.exists():
        return f"{directory}: there is no such directory; must be the directory of a run."
    if directory.is_dir():
        return f"{directory}: there is no run in it (no results.h5)."
    hint = (
        f" Use the directory that contains it, {directory.parent}." if directory.name == "results.h5" else ""
    )
    return f"{directory}: a file; must be the directory of a run.{hint}"


class Run(Mapping[str, NDArray[Any]]):
    """The results of a run; as a mapping, its waveforms by name.

    Open with `Run.load`; a run that is still running, or was killed, has the steps stored so far.

    Attributes
    ----------
    directory : Path
    steps, frames : int
        Stored so far.
    status : str
        ``running``, ``killed``, ``finished``, ``failed`` or ``interrupted``, when it was loaded.
    failure : str
        Why it failed; empty if it did not.
    seconds : float
        Wall time of the computation, s.
    """

    def __init__(self, directory: str | Path) -> None:
        self.directory = Path(directory)
        self.path = self.directory / "results.h5"
        with self._open() as file:
            self._record = ProgressRecord.read(file, file.names("waveforms"))
            self.scene_text: str = file.text("scene")
            self._versions = {"plica": file.text("plica_version")}
            if "contact_solver" in file:
                self._versions["contact solver"] = file.text("contact_solver")
        self.steps, self.frames = self._record.steps, self._record.frames
        self.seconds, self.status = self._record.seconds, _STATUS[self._record.status]
        if self._record.status == store.RUNNING and not being_written(self.directory):
            self.status = "killed"
        self.failure: str = self._record.message if self.status == "failed" else ""

    def _open(self) -> Stored:
        return Stored(self.path, hint=store.HINT)

    @classmethod
    def load(cls, directory: str | Path) -> Run:
        """Open the run in `directory`.

        Raises
        ------
        InvalidInput
            If there is none, or its result file is something else; Damaged, which is one, if it is damaged.
            What is read later from the file is verified then, and raises the same.
        StorageFailed
            If its result file cannot be read.
        """
        directory = Path(directory)
        path = directory / "results.h5"
        if not path.is_file():
            raise InvalidInput(_no_run(directory))
        with storage_errors(path, "read"):
            with Stored(path, hint=store.HINT) as file:
                if not all(name in file for name in ("progress", "waveforms", "scene")):
                    raise InvalidInput(
                        f"{path}: is not the result file of a run, or is from an earlier version of plica; "
                        "must be of this version. Use another directory."
                    )
            return cls(directory)

    def __repr__(self) -> str:
        return f"<Run {self.directory}: {self.status}, {self.steps} of {self.steps_asked} steps>"

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.waveforms[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.waveforms)

    def __len__(self) -> int:
        return len(self.waveforms)

    def _named(self, items: Iterable[tuple[str, Item]]) -> dict[str, Item]:
        return Named(f"Run {self.directory}", items)

    @cached_property
    def scene(self) -> Scene:
        """The scene of the run, with every default filled in."""
        return Scene.from_text(self.scene_text, f"{self.directory.name}/results.h5")

    @property
    def steps_asked(self) -> int:
        """Number of steps of the scene."""
        return self.scene.time.steps

    @property
    def whole(self) -> Run:
        """The run itself; `between` returns parts of it."""
        return self

    @cached_property
    def waveforms(self) -> dict[str, NDArray[Any]]:
        """Waveforms by name, stored every step; the leading axis is the step, SI units (see `units`).

        `flow`, `minimum_area`, `separation`, `section_area`, `section_pressure` and `flow_stopped` belong to
        t_{n+1+alpha}, the instant at which the time scheme balances forces (with lagged coupling to t_n); all
        others to the end of the step t_{n+1}, which is `time`. docs/scene.md describes each.
        """
        with self._open() as file:
            return self._named(
                (name, file.first(f"waveforms/{name}", self.steps, total))
                for name, total in self._record.sums.items()
            )

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of each waveform."""
        with self._open() as file:
            return self._named(
                (name, str(file.attribute(f"waveforms/{name}", "units"))) for name in file.names("waveforms")
            )

    @property
    def time(self) -> NDArray[np.float64]:
        """(steps) s."""
        return self.waveforms["time"]

    @cached_property
    def mesh(self) -> RunMesh:
        """The mesh in its reference position, that of the posture if there is one."""
        with self._open() as file:
            arrays: dict[str, Any] = {
                name: file.read(f"mesh/{name}") for name in ("points", "cells", "cell_layer", "cell_side")
            }
            for kind in ("surfaces", "node_sets"):
                names = file.names(f"mesh/{kind}")
                arrays[kind] = {name: file.read(f"mesh/{kind}/{name}") for name in names}
            if "mesh/rest" in file:
                arrays["rest"] = file.read("mesh/rest")
            return RunMesh(layer_names=file.texts("mesh/layer_names"), **arrays)

    @cached_property
    def fields(self) -> dict[str, Any]:
        """Frames: ``time`` (f) s, ``displacement`` (f, n, 3) m, with contact ``contact_pressure`` (f, n) Pa.

        All but the time are read lazily (see `Field`). Empty if the scene stores no fields.
        """
        with self._open() as file:
            if "fields" not in file:
                return self._named(())
            names = [name for name in file.names("fields") if name != "time"]
            rows = file.rows("fields/time")
            time = np.array([rows[frame] for frame in range(self.frames)], dtype=np.float64)
        return self._named([("time", time), *((name, Field(self.path, name, self.frames)) for name in names)])

    @property
    def displacement(self) -> Field:
        """(frames, n, 3) m, float32, read lazily.

        Raises
        ------
        InvalidInput
            If the scene stores no fields.
        """
        if "displacement" not in self.fields:
            raise InvalidInput(f"{self.directory}: no fields were stored. Set output.every in the scene.")
        field: Field = self.fields["displacement"]
        return field

    @cached_property
    def airway(self) -> str:
        """Name of the surface that the airflow is in; ``airway`` without airflow."""
        return airway_name(self.scene_text)

    @cached_property
    def section_height(self) -> NDArray[np.float64]:
        """(s) m, reference height of the airflow's sections; empty without airflow."""
        return self._section("height")

    @cached_property
    def section_major(self) -> NDArray[np.float64]:
        """(s) m, half the anteroposterior extent of the airway at the sections; empty without airflow."""
        return self._section("major")

    def _section(self, name: str) -> NDArray[np.float64]:
        with self._open() as file:
            found: NDArray[np.float64] = file.read(f"sections/{name}") if "sections" in file else np.empty(0)
            return found

    @cached_property
    def vocal_tract(self) -> TractResponse | str | None:
        """What its vocal tract does to the flow that enters it, with its formants; why that is not known;
        None without one."""
        from plica.runs.tubes import known_tract

        return known_tract(self.scene)

    @property
    def versions(self) -> dict[str, str]:
        """The version of Plica that computed the run, and with contact the solver that "auto" selected."""
        return self._versions

    @property
    def measures(self) -> Measures:
        """`Measure` by name, in SI: ``.value``, ``.spread`` (the standard deviation between cycles),
        ``.uncertainty`` (numerical: of `estimate_uncertainty`, else, for a settled voice near the example, of
        that; else None) and ``.cautions``."""
        estimated = self.uncertainty
        return self._measured.bounded(self._example_bounds if estimated is None else estimated.bounds)

    @cached_property
    def cycles(self) -> Cycles:
        """The steady cycles that the measures use."""
        from plica.measures.run.measure import steady_cycles

        return steady_cycles(self)

    @cached_property
    def _measured(self) -> Measures:
        from plica.measures.run.measure import measure

        return measure(self)

    @cached_property
    def _example_bounds(self) -> Mapping[str, Bound]:
        return example_bounds(self.scene, self._measured, self.cycles)

    @property
    def uncertainty(self) -> Uncertainty | None:
        """The numerical uncertainty of its measures, if `plica.estimate_uncertainty` has computed it."""
        return read_uncertainty(self.directory, self.steps)

    def between(self, start: float | str | None = None, end: float | str | None = None) -> RunPart:
        """The part of the run after `start` up to `end`, to measure it separately.

        Parameters
        ----------
        start, end : float or str, optional
            s, or a text with a unit; default: the start and the end of the computed time.

        Returns
        -------
        RunPart
            The steps with start < time <= end. Works and losses count from `start`.

        Raises
        ------
        InvalidInput
            If these are not times of the run that are two steps or more apart.

        Examples
        --------
        ``run.between("0.1 s", "0.3 s").measures["fundamental_frequency"]``
        """
        return part_of(self, start, end)

    @cached_property
    def scene_cautions(self) -> tuple[Caution, ...]:
        """Cautions on quantities of the scene that no larynx has."""
        return scene_cautions(self.scene, self.mesh)

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """The cautions of this run, with advice; docs/cautions.md lists all kinds."""
        from plica.measures.run.cautions import cautions

        return cautions(self)

    def sound(
        self,
        *,
        distance: float | str = usual_distance,
        rate: float | str = int(audio_rate),
        aspiration: bool = False,
        seed: int = 1,
    ) -> Sound:
        """The sound of the run, of the part that is computed; raises as `plica.sound.voice.sound`.

        Parameters
        ----------
        distance : float or str
            m, or a text with a unit: from the lips.
        rate : float or str
            Hz, or a text with a unit.
        aspiration : bool
            Whether the noise of the jet is added, of this `seed`.

        Examples
        --------
        ``run.sound(aspiration=True).save("voice.wav")``
        """
        from plica.measures.run.measure import fold_length

        length = fold_length(self) if aspiration else None
        return sound(self, distance=distance, rate=rate, aspiration=aspiration, length=length, seed=seed)

    def to_xarray(self) -> xarray.Dataset:
        """The waveforms as a data set over ``time`` (and ``section`` height, ``probe``, ``component``).

        Empty waveforms, such as ``probes`` of a scene without probes, are left out: with them
        ``to_dataframe`` would return a table without rows. So are those per layer of the tissue, which would
        multiply its rows.
        """
        labelled = library("xarray", "xarray", "Run.to_xarray")
        coordinates: dict[str, Any] = {"time": ("time", self.time, {"units": "s"})}
        if len(self.section_height):
            coordinates["section"] = ("section", self.section_height, {"units": "m"})
        variables = {}
        for name, values in self.waveforms.items():
            if name != "time" and 0 not in values.shape[1:] and STORED[name].per != "layer":
                variables[name] = (_axes(name, values), values, {"units": self.units[name]})
                if values.ndim > 1 and values.shape[-1] == 3 and "component" in _axes(name, values):
                    coordinates["component"] = ["x", "y", "z"]
        made: xarray.Dataset = labelled.Dataset(
            variables, coordinates, {"scene": self.scene_text, "plica_version": self._versions["plica"]}
        )
        return made


def _axes(name: str, values: NDArray[Any]) -> tuple[str, ...]:
    """The axes of a waveform."""
    per = STORED[name].per
    return ("time", *([] if per == "step" else [per]), "component")[: values.ndim]
