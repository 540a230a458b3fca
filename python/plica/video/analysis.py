"""A recording through the whole chain: drift, glottis, flow, modes, paths; kept as it comes, and resumed.

results.h5 holds what each step found, under the step's name; a step that is there is not done again, and the
flow goes on with the pair after the last one stored. The settings are stored with it: other settings, or
another recording, need another directory.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
import numpy.typing as npt

from plica.phonation.cycles import Cycles
from plica.phonation.measure import Measure
from plica.phonation.measures import write_measures
from plica.video.drift import drift, still_region, without_drift
from plica.video.errors import VideoError
from plica.video.flow import PRESETS, flow
from plica.video.modes import modes
from plica.video.recording import Recording, Region, spread
from plica.video.trajectories import follow
from plica.video.waveforms import (
    GlottalArea,
    Midline,
    areas,
    find_midline,
    kymogram,
    masks,
    measures,
    phases,
)

__all__ = ["Analysis", "Settings", "analyse", "load", "write_tables"]

Floats = npt.NDArray[np.float64]
T = TypeVar("T")

_BRIGHT = 250.0  # grey: a highlight, which moves with the light and not with the tissue
_GRID = 12  # px between the points whose paths are followed


@dataclass(frozen=True)
class Settings:
    """What a recording is analysed with; None is unknown, or found."""

    fps: float | None = None
    """True frames per second; None: times in frames."""
    mm_per_px: float | None = None
    """Millimetres a pixel; None: lengths in pixels."""
    rotation: float = 0.0
    """Degrees, anticlockwise as seen."""
    region: tuple[int, int, int, int] | None = None
    """x, y, width, height in px of the turned frames."""
    dataset: str | None = None
    """Of an HDF5 file that holds several."""
    midline: tuple[float, float, float, float] | None = None
    """x, y of the anterior end and of the posterior one, px of the region; None: found, anterior end up."""
    preset: str = "video"
    """Of the flow."""
    correct_drift: bool = True
    """Take the endoscope's motion out."""
    modes: int = 6


@dataclass(frozen=True)
class Analysis:
    """What was found in a recording, read from the directory of :func:`analyse`.

    Attributes
    ----------
    directory : Path
    settings : Settings
    area : GlottalArea
        (frames) px^2.
    midline : Midline
    cycles : Cycles
        Of the total area; times in s, or frames.
    measures : dict of str to Measure
    time : (frames) s, or frames
    phase : list of str
        Of each frame: "closed", "opening", "open", "closing", "" outside the cycles.
    flags : list of str
        Of each frame: what speaks against it, by commas; "" where nothing does.
    """

    directory: Path
    settings: Settings
    area: GlottalArea
    midline: Midline
    cycles: Cycles
    measures: dict[str, Measure]
    time: Floats
    phase: list[str]
    flags: list[str]

    @property
    def file(self) -> Path:
        """results.h5."""
        return self.directory / "results.h5"


def analyse(
    source: str | Path,
    directory: str | Path,
    settings: Settings | None = None,
    *,
    until: str = "modes",
    progress: bool = True,
) -> Analysis:
    """Analyse a recording and store the results in `directory` as they come; goes on where it was stopped.

    `until` is the last step to do: "glottis" (masks, area, kymogram) or "modes", everything.

    Raises
    ------
    VideoError
        For a recording or settings that cannot be used, and where `directory` holds another analysis.
    """
    chosen = settings or Settings()
    if chosen.preset not in PRESETS:
        raise VideoError(f'Video: preset = "{chosen.preset}"; must be one of {", ".join(PRESETS)}.')
    region = None if chosen.region is None else Region(*chosen.region)
    recording = Recording.open(
        source,
        fps=chosen.fps,
        mm_per_px=chosen.mm_per_px,
        rotation=chosen.rotation,
        region=region,
        dataset=chosen.dataset,
    )
    where = Path(directory)
    where.mkdir(parents=True, exist_ok=True)
    with h5py.File(where / "results.h5", "a") as file:
        _claim(file, where, source, chosen)
        _Chain(file, recording, chosen, progress).run(until)
    return load(where)


def load(directory: str | Path) -> Analysis:
    """Read the analysis in a directory. Raises VideoError where there is none, or an unfinished one."""
    where = Path(directory)
    path = where / "results.h5"
    if not path.exists():
        raise VideoError(f"Video: {where} has no results.h5; must be the directory of an analysis.")
    with h5py.File(path, "r") as file:
        if "glottis" not in file or ("flow" in file and "modes" not in file):
            raise VideoError(f"Video: the analysis in {where} is not finished. Start it again: it goes on.")
        stored = json.loads(file.attrs["settings"])
        settings = Settings(**{name: _tuple(value) for name, value in stored.items()})
        parts = ("left", "right", "left_edge", "right_edge")
        area = GlottalArea(*(file[f"glottis/{name}"][:] for name in parts))
        ends = file["glottis/midline"][:]
        midline = Midline((float(ends[0]), float(ends[1])), (float(ends[2]), float(ends[3])))
        told = "trust" in file
        flags = [str(text) for text in file["trust/flags"].asstr()[:]] if told else [""] * area.total.size
    found, cycles = measures(area, settings.fps)
    time = np.arange(area.total.size) / (settings.fps or 1.0)
    return Analysis(where, settings, area, midline, cycles, found, time, phases(area, cycles, time), flags)


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _claim(file: h5py.File, where: Path, source: str | Path, settings: Settings) -> None:
    """Mark the file as of this recording and settings, or refuse one that is not."""
    path = Path(source).resolve()
    asked = {"source": str(path), "settings": json.dumps(asdict(settings))}
    for name, text in asked.items():
        there = file.attrs.get(name)
        if there is not None and there != text:
            raise VideoError(
                f"Video: {where} holds an analysis with another {name}, {there}; must be {text}. "
                "Choose another directory."
            )
        file.attrs[name] = text


class _Chain:
    """The steps, each stored when it is done."""

    def __init__(self, file: h5py.File, recording: Recording, settings: Settings, shown: bool) -> None:
        self._file, self._recording, self._settings, self._shown = file, recording, settings, shown

    def run(self, until: str) -> None:
        for name, step in (
            ("frames", self._frames),
            ("glottis", self._glottis),
            ("flow", self._flow),
            ("trust", self._trust),
            ("paths", self._paths),
            ("modes", self._modes),
        ):
            if name == "flow" or name not in self._file:
                step()
                self._file.flush()
            if name == until:
                return

    def _store(self, name: str, **arrays: Any) -> None:
        """A group, complete or not there."""
        draft = f"{name}.part"
        if draft in self._file:
            del self._file[draft]
        group = self._file.create_group(draft)
        for key, value in arrays.items():
            big = isinstance(value, np.ndarray) and value.size > 10_000
            group.create_dataset(
                key, data=value, **({"compression": "gzip", "compression_opts": 1} if big else {})
            )
        self._file.move(draft, name)

    def _watched(self, what: str, items: Iterable[T], total: int, done: int = 0) -> Iterator[T]:
        """The items, with a bar on standard error."""
        if not self._shown:
            yield from items
            return
        from tqdm import tqdm

        yield from tqdm(items, desc=what, total=total, initial=done, unit=" frames", mininterval=0.5)

    def _steady(self, begin: int = 0) -> Iterator[npt.NDArray[np.float32]]:
        """Frames from this one on, without the endoscope's motion."""
        motion = self._file["frames/drift"][begin:]
        return without_drift(self._recording.frames(begin), motion)

    def _frames(self) -> None:
        recording = self._recording
        motion = np.zeros((recording.count, 3))
        if self._settings.correct_drift:
            still = still_region(spread(recording.frames()), 0.5)
            first = drift(self._watched("drift", recording.frames(), recording.count), still)
            still = still_region(spread(without_drift(recording.frames(), first)), 0.3)
            motion = drift(self._watched("drift again", recording.frames(), recording.count), still)
        sharp, bright = [], []
        for frame in recording.frames():
            sharp.append(float(np.mean(np.square(np.diff(frame, axis=1), dtype=float))))
            bright.append(float(np.mean(frame >= _BRIGHT)))
        self._store("frames", drift=motion, sharpness=np.array(sharp), saturated=np.array(bright))

    def _glottis(self) -> None:
        steady = _Replayed(self._recording, self._steady)
        count, shape = steady.count, steady.shape
        if "glottis.masks" in self._file:
            del self._file["glottis.masks"]
        kept = self._file.create_dataset(
            "glottis.masks", (count, *shape), bool, chunks=(1, *shape), compression="gzip", compression_opts=1
        )
        for index, mask in enumerate(self._watched("glottis", masks(steady), count)):
            kept[index] = mask
        chosen = self._settings.midline
        midline = find_midline(_each(kept)) if chosen is None else Midline(chosen[:2], chosen[2:])
        area = areas(_each(kept), midline)
        tissue = np.ones(shape, dtype=bool)
        for mask in _each(kept):
            tissue &= ~mask
        self._store(
            "glottis",
            left=area.left,
            right=area.right,
            left_edge=area.left_edge,
            right_edge=area.right_edge,
            tissue=tissue,
            midline=np.array([*midline.anterior, *midline.posterior]),
            kymogram=kymogram(steady, midline, half_width=0.25 * min(shape)).astype(np.float32),
        )
        self._file.move("glottis.masks", "glottis/mask")

    def _flow(self) -> None:
        pairs, (height, width) = self._recording.count - 1, self._recording.shape
        if "flow" not in self._file:
            group = self._file.create_group("flow")
            for name, shape in (("uv", (height, width, 2)), ("mismatch", (height, width))):
                chunk = (1, *shape)
                group.create_dataset(name, (pairs, *shape), "f4", chunks=chunk, compression="lzf")
            group.create_dataset("residual", (pairs,), "f8", fillvalue=np.nan)
            group.attrs["done"] = 0
        group = self._file["flow"]
        done = int(group.attrs["done"])
        if done == pairs:
            return
        frames = self._steady(done)
        before = next(frames)
        inside = self._file["glottis/mask"]
        for index, frame in enumerate(self._watched("flow", frames, pairs, done), start=done):
            used = _telling(before, inside[index]) & _telling(frame, inside[index + 1])
            pair = flow(
                before, frame, preset=self._settings.preset, mask=used, intensity=(0.0, 255.0), mismatch=True
            )
            group["uv"][index] = pair.flow
            group["mismatch"][index] = pair.mismatch
            left = pair.residual[used & np.isfinite(pair.residual)]
            group["residual"][index] = np.sqrt(np.mean(np.square(left, dtype=float)))
            group.attrs["done"] = index + 1
            self._file.flush()
            before = frame

    def _trust(self) -> None:
        file, count = self._file, self._recording.count
        tissue = file["glottis/tissue"][:]
        mismatch = np.array([np.nanmedian(file["flow/mismatch"][k][tissue]) for k in range(count - 1)])
        residual = file["flow/residual"][:]
        total = file["glottis/left"][:] + file["glottis/right"][:]
        sharp, bright = file["frames/sharpness"][:], file["frames/saturated"][:]
        moved = np.linalg.norm(np.diff(file["frames/drift"][:, :2], axis=0, prepend=0.0), axis=1)
        shut = total <= 0.02 * total.max()
        flags: list[list[str]] = [[] for _ in range(count)]
        for name, wrong in (
            ("collision", shut & (np.diff(total, prepend=total[0]) < 0)),
            ("blur", sharp < 0.5 * np.median(sharp)),
            ("saturation", bright > 0.05),
            ("drift", moved > 1.0),
            ("residual", np.append(residual > 3 * np.median(residual), False)),
        ):
            for k in np.flatnonzero(wrong):
                flags[k].append(name)
        per_pixel = np.nanmedian(file["flow/mismatch"][:: max(1, (count - 1) // 100)], axis=0)
        self._store(
            "trust",
            mismatch=mismatch,
            per_pixel=per_pixel.astype(np.float32),
            flags=np.array([", ".join(flag) for flag in flags], dtype=h5py.string_dtype()),
        )

    def _paths(self) -> None:
        file = self._file
        height, width = self._recording.shape
        y, x = np.mgrid[_GRID : height - _GRID : _GRID, _GRID : width - _GRID : _GRID]
        points = np.stack([x.ravel(), y.ravel()], axis=1).astype(float)
        points = points[~file["glottis/mask"][0][points[:, 1].astype(int), points[:, 0].astype(int)]]
        uv = file["flow/uv"]
        self._store("paths", places=follow((uv[k] for k in range(uv.shape[0])), points).places)

    def _modes(self) -> None:
        file = self._file
        tissue = file["glottis/tissue"][:]
        ends = file["glottis/midline"][:]
        midline = float(0.5 * (ends[0] + ends[2]))
        count = min(self._settings.modes, self._recording.count - 2)
        found = modes(file["flow/uv"], count, tissue, midline)
        self._store(
            "modes",
            mean=found.mean.astype(np.float32),
            patterns=found.patterns.astype(np.float32),
            coefficients=found.coefficients,
            share=found.share,
            symmetry=found.symmetry(midline),
            variance=np.array(found.variance),
        )


def _each(dataset: h5py.Dataset) -> Iterator[npt.NDArray[np.bool_]]:
    """Its entries, one at a time."""
    return (dataset[k] for k in range(dataset.shape[0]))


class _Replayed:
    """A recording whose frames come from elsewhere."""

    def __init__(
        self, recording: Recording, frames: Callable[[int], Iterator[npt.NDArray[np.float32]]]
    ) -> None:
        self.count, self.shape, self._frames = recording.count, recording.shape, frames

    def frames(self) -> Iterator[npt.NDArray[np.float32]]:
        return self._frames(0)

    def frame(self, index: int) -> npt.NDArray[np.float32]:
        return next(self._frames(index))


def _telling(frame: npt.NDArray[np.float32], glottis: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Where a frame shows tissue: neither glottis nor highlight, nor two pixels about both."""
    from scipy import ndimage

    return np.asarray(~ndimage.binary_dilation(glottis | (frame >= _BRIGHT), iterations=2))


def write_tables(found: Analysis) -> None:
    """waveforms.csv, a row a frame, of the flow and the modes as far as they are done; measures.json."""
    unit = "s" if found.settings.fps else "frames"
    columns: dict[str, Any] = {
        f"time ({unit})": found.time,
        "area left (px^2)": found.area.left,
        "area right (px^2)": found.area.right,
        "edge left (px)": found.area.left_edge,
        "edge right (px)": found.area.right_edge,
        "phase": found.phase,
        "flags": found.flags,
    }
    with h5py.File(found.file, "r") as file:
        for name, values in zip(
            ("right (px)", "down (px)", "turn (rad)"), file["frames/drift"][:].T, strict=True
        ):
            columns[f"drift {name}"] = values
        if "modes" in file:
            columns["residual (grey)"] = file["flow/residual"][:]
            columns["mismatch (px)"] = file["trust/mismatch"][:]
            for k, values in enumerate(file["modes/coefficients"][:].T, start=1):
                columns[f"mode {k} (px)"] = values
    with (found.directory / "waveforms.csv").open("w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out)
        rows.writerow(columns)
        rows.writerows(zip_longest(*columns.values(), fillvalue=""))  # the last frame has no flow
    write_measures(found.measures, found.directory / "measures.json")
