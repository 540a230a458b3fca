"""A clip's frames and truth as files."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica._engine import build_info, threads
from plica.errors import InvalidInput, library
from plica.films.clip import Clip
from plica.storage.files import refuse_overwriting, replaced, storage_errors
from plica.storage.hdf5 import create, lay_out, put, put_row, set_text
from plica.storage.stopping import stop_on_signal
from plica.units import clock

__all__ = ["FORMATS", "write_film"]

FORMATS = (".avi", ".npy", ".h5", ".hdf5")
_PLAYBACK_RATE = 25  # /s, of players; the true rate is in the truth file

Picture = NDArray[np.uint8]
Add = Callable[[int, Picture], None]


def write_film(
    clip: Clip, path: str | Path, *, overwrite: bool = False, progress: bool = False
) -> list[Path]:
    """Write frames and truth: an AVI or NPY file and ``.truth.h5`` beside it, or both in one HDF5 file.

    Parameters
    ----------
    clip : Clip
        Made by `plica.film`.
    path : str or Path
        Ends in .avi (lossless), .npy, .h5 or .hdf5. Each file appears complete or not at all.
    overwrite : bool
        Replace an existing clip or truth file.
    progress : bool
        Print the number of frames and the expected time, and show a bar, on standard error.

    Returns
    -------
    list of Path
        Files written.

    Raises
    ------
    InvalidInput
        For another file name extension, and if a file exists and `overwrite` is False.
    StorageFailed
        If a file cannot be written.
    KeyboardInterrupt
        Stopped by Ctrl-C or SIGTERM; no file is left.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise InvalidInput(f"Film: {path.name}; must end in one of {', '.join(FORMATS)}.")
    if path.is_dir() or not path.parent.is_dir():
        problem = f"{path} is a directory" if path.is_dir() else f"{path.parent} is not a directory"
        raise InvalidInput(f"Film: {problem}; must be a file in an existing directory.")
    whole, truth = suffix in (".h5", ".hdf5"), path.with_name(path.stem + ".truth.h5")
    refuse_overwriting([path] if whole else [path, truth], overwrite)
    if progress:
        what = f"{clip.count} frames, about {clock(_expected_seconds(clip))}; --from and --to film a part."
        print(f"plica: {what}", file=sys.stderr, flush=True)
    if whole:
        replaced(path, lambda draft: _write_both(clip, draft, None, progress))
        return [path]
    opened = _video if suffix == ".avi" else _array

    def write_frames_and_truth(draft: Path) -> None:
        with storage_errors(path), opened(draft, clip) as add:
            replaced(truth, lambda other: _write_both(clip, other, add, progress))

    replaced(path, write_frames_and_truth)
    return [path, truth]


@dataclass(frozen=True)
class _Shot:
    """A frame and its truth; no flow of the last."""

    picture: Picture
    glottis: NDArray[np.bool_]
    area: float
    flow: tuple[NDArray[np.float32], NDArray[np.bool_]] | None


def _shot(clip: Clip, k: int) -> _Shot:
    flow = clip.flow(k) if k + 1 < clip.count else None
    return _Shot(clip.frame(k), clip.glottis(k), clip.area(k), flow)


def _shots(clip: Clip, count: int) -> Generator[_Shot, None, None]:
    """The first frames in order, each made by one of the threads of `plica.set_threads`."""
    with ThreadPoolExecutor(threads()) as pool:
        coming: deque[Future[_Shot]] = deque()
        try:
            for k in range(count):
                coming.append(pool.submit(_shot, clip, k))
                if len(coming) > threads():
                    yield coming.popleft().result()
            while coming:
                yield coming.popleft().result()
        finally:
            for one in coming:
                one.cancel()


def _expected_seconds(clip: Clip) -> float:
    """Of all frames, by some of them; the first prepares what all of them use."""
    _shot(clip, 0)
    tried = min(2 * threads(), clip.count)
    begin = time.perf_counter()
    for _ in _shots(clip, tried):
        pass
    return clip.count * (time.perf_counter() - begin) / tried


def _write_both(clip: Clip, path: Path, add: Add | None, progress: bool) -> None:
    """Write frames and truth, frame by frame; the frames into the truth's file if `add` is None."""
    with create(path) as file:
        _describe(file, clip)
        if add is None:
            _packed(file, "frames", (clip.count, *clip.camera.shape), np.uint8, "1", "Grey levels.")
            add = partial(put_row, file, "frames")
        with stop_on_signal() as stop, closing(_shots(clip, clip.count)) as shots:
            for k, shot in zip(_frame_numbers(clip.count, progress), shots, strict=True):
                if stop.signal is not None:
                    raise KeyboardInterrupt(f"stopped after {k} of {clip.count} frames; no film was written")
                add(k, shot.picture)
                put_row(file, "glottis", k, shot.glottis)
                put_row(file, "glottal_area", k, shot.area)
                if shot.flow is not None:
                    flow, visible = shot.flow
                    put_row(file, "flow", k, flow)
                    put_row(file, "visible", k, visible)


def _describe(file: Any, clip: Clip) -> None:
    """Write attributes, times and camera, and create the data sets."""
    set_text(file, "plica_version", build_info()["version"])
    file.attrs["fps"] = clip.fps
    file.attrs["mm_per_px"] = clip.camera.mm_per_px
    for name, fields in (("camera", asdict(clip.camera)), ("film", asdict(clip.options))):
        group = file.create_group(name)
        for key, value in fields.items():
            if isinstance(value, str):
                set_text(group, key, value)
            elif value is not None:
                group.attrs[key] = value
    put(file, "time", clip.time, "s", "(n) middles of the exposures.")
    put(
        file,
        "projection",
        clip.camera.projection,
        "px, px, m",
        "(3, 4) P (x, 1), x in m: column, row (downwards), height towards the camera.",
    )
    shape, pairs = clip.camera.shape, clip.count - 1
    _packed(file, "glottis", (clip.count, *shape), bool, "1", "(n, h, w) looks through between the folds.")
    meaning = "(n) of glottis, across the line of sight."
    lay_out(file, "glottal_area", (clip.count,), np.float64, "m^2", np.nan, meaning)
    _packed(
        file,
        "flow",
        (pairs, *shape, 2),
        np.float32,
        "px",
        "(n - 1, h, w, 2) motion (right, down) from frame k to k + 1 of what a pixel shows; NaN: no tissue.",
    )
    _packed(file, "visible", (pairs, *shape), bool, "1", "(n - 1, h, w) seen in frame k + 1 too.")


def _packed(file: Any, name: str, shape: tuple[int, ...], kind: Any, unit: str, meaning: str) -> None:
    lay_out(file, name, shape, kind, unit, None, meaning, packed=True)


@contextmanager
def _video(path: Path, clip: Clip) -> Iterator[Add]:
    """Adds frames to an AVI file, uncompressed 8-bit grey."""
    av = library("av", "video", path.name)
    with av.open(str(path), "w", format="avi") as container:
        stream: Any = container.add_stream("rawvideo", rate=_PLAYBACK_RATE)
        stream.height, stream.width = clip.camera.shape
        stream.pix_fmt = "gray"

        def add(_: int, picture: Picture) -> None:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="gray")))

        yield add
        container.mux(stream.encode(None))


@contextmanager
def _array(path: Path, clip: Clip) -> Iterator[Add]:
    """Adds frames to an NPY file (n, h, w)."""
    frames = np.lib.format.open_memmap(path, "w+", np.uint8, (clip.count, *clip.camera.shape))
    yield frames.__setitem__
    frames.flush()


def _frame_numbers(count: int, shown: bool) -> Iterator[int]:
    """0 to count - 1, with a bar on standard error if shown."""
    if not shown:
        yield from range(count)
        return
    from tqdm import tqdm

    often = 0.5 if sys.stderr.isatty() else 10.0  # s
    yield from tqdm(range(count), unit=" frames", mininterval=often, miniters=1, file=sys.stderr)
