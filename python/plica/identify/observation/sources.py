"""Read motion in pixels from a ``plica video`` analysis, a film's ground truth or a file of flow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.camera.pose import Camera
from plica.errors import InvalidInput
from plica.storage.hdf5 import CHECKSUMS
from plica.storage.npz import read_npz
from plica.storage.stored import Stored
from plica.video.analysis import Analysis
from plica.video.analysis import load as load_analysis

__all__ = ["PixelMotion", "open_motion"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Glottis = tuple[tuple[float, float], tuple[float, float]]

_FIELDS = ("flow", "visible", "sd", "glottal_area", "glottis", "projection", "fps", "mm_per_px")

_AGAIN = "Copy it again from where it is whole"
TRUSTED = 0.5
"""[px] Flow with a larger forward-backward error is treated as missing."""


@dataclass(frozen=True)
class PixelMotion:
    """The motion of every pixel from frame to frame, right and down, with metadata of the recording."""

    name: str
    kind: str
    """Description for the report."""
    pairs: int
    """Number of frame pairs: one fewer than frames."""
    shape: tuple[int, int]
    """[px] Height and width."""
    flow: Callable[[int], NDArray[Any]]
    """(h, w, 2) px of a pair; nan where unknown."""
    visible: Callable[[int], Mask]
    """(h, w) Where the flow of a pair is that of the tissue."""
    error: Callable[[int], Floats] | None = None
    """(h, w, 2) px of a pair, nan where unknown: the trust map, a lower bound of the error; None: no map."""
    sd: Callable[[int], Floats] | None = None
    """(h, w) px of a pair: the sd of the flow stated in the file; None: not stated."""
    fps: float | None = None
    mm_per_px: float | None = None
    camera: Camera | None = None
    """None: unknown."""
    area: Floats | None = None
    """(pairs + 1) Glottal area, in any unit; nan where unknown."""
    glottis: Glottis | None = None
    """[px] The anterior and the posterior end of the midline (column, row)."""
    preset: str | None = None
    """Preset of the flow, if `plica.video` computed it."""
    notes: tuple[str, ...] = ()
    """Assumptions that were made."""


def open_motion(path: str | Path) -> PixelMotion:
    """Open the directory of a ``plica video`` analysis, or a file of flow (HDF5 or NPZ).

    A file has ``flow`` (n, h, w, 2) px, and may have ``visible`` (n, h, w), ``sd`` (n, h, w) px,
    ``glottal_area`` (n + 1) or ``glottis`` (n + 1, h, w), ``projection`` (3, 4), ``fps`` and ``mm_per_px``,
    the last two as attributes or data sets. The ground truth of ``plica film`` is such a file.

    Raises
    ------
    InvalidInput
        If it is none of these, or its shapes do not fit.
    """
    path = Path(path)
    if not path.exists():
        raise InvalidInput(f"{path}: there is no such file or directory.")
    if path.is_dir():
        return _of_analysis(load_analysis(path, needs="modes"))
    if path.suffix == ".npz":
        return _of_arrays(path, read_npz(path, _FIELDS), {})
    if path.suffix not in (".h5", ".hdf5"):
        raise InvalidInput(
            f"{path}: must be the directory of a plica video analysis, or a file of flow (.h5, .hdf5, .npz). "
            "Run plica video first to analyse images."
        )
    file = Stored(path, hint=_AGAIN, verified=False)  # stays open while the flow is read
    if CHECKSUMS in file or file.attribute("/", "plica_version") is not None:
        file.close()
        file = Stored(path, hint=_AGAIN)
    return _of_arrays(path, {name: file.rows(name) for name in _FIELDS if name in file}, file.attributes("/"))


def _of_analysis(found: Analysis) -> PixelMotion:
    settings, midline = found.settings, found.midline
    ends = (tuple(map(float, midline.upper)), tuple(map(float, midline.lower)))
    notes: tuple[str, ...] = ()
    if settings.anterior is None:
        notes = (
            "The anterior end of the glottis is not specified; the upper end in the image is assumed. "
            "Specify it with plica video --anterior.",
        )
    if settings.anterior == "lower":
        ends = ends[::-1]

    def visible(pair: int) -> Mask:
        errors = np.hypot(*np.moveaxis(found.round_trip(pair), -1, 0))
        return np.asarray(errors < TRUSTED)  # false where nan: glottis, highlights, lost frames

    return PixelMotion(
        name=found.directory.name,
        kind="flow computed from a recording, with its trust map",
        pairs=found.count - 1,
        shape=(len(found.mask(0)), found.mask(0).shape[1]),
        flow=found.flow,
        visible=visible,
        error=lambda pair: np.asarray(found.round_trip(pair), dtype=float),
        fps=settings.fps,
        mm_per_px=settings.mm_per_px,
        area=np.asarray(found.area.total, dtype=float),
        glottis=ends,  # type: ignore[arg-type]
        preset=settings.preset,
        notes=notes,
    )


def _of_arrays(path: Path, data: Mapping[str, Any], attributes: Mapping[str, Any]) -> PixelMotion:
    if "flow" not in data:
        raise InvalidInput(f'{path}: has no "flow"; must have it, (frames - 1, height, width, 2) px.')
    flow = data["flow"]
    if flow.ndim != 4 or flow.shape[3] != 2 or 0 in flow.shape:
        raise InvalidInput(
            f"{path}: flow has shape {tuple(flow.shape)}; must be (frames - 1, height, width, 2)."
        )
    if flow.dtype.kind not in "iuf":
        raise InvalidInput(f"{path}: flow has type {flow.dtype}; must be real numbers in px.")
    pairs, *size = flow.shape[:3]

    def checked(name: str, shape: tuple[int, ...]) -> Any:
        if name not in data:
            return None
        if tuple(data[name].shape) != shape:
            raise InvalidInput(
                f"{path}: {name} has shape {tuple(data[name].shape)}; must be {shape}, to fit flow."
            )
        if data[name].dtype.kind not in "biuf":
            raise InvalidInput(f"{path}: {name} has type {data[name].dtype}; must be real numbers.")
        return data[name]

    def number(name: str) -> float | None:
        value = attributes.get(name, data.get(name))
        if value is None:
            return None
        found = np.asarray(value)
        if found.size != 1 or found.dtype.kind not in "iuf" or not 0 < found.item() < np.inf:
            shown = found.item() if found.size == 1 else f"{found.size} numbers"
            raise InvalidInput(f"{path}: {name} = {shown}; must be one number > 0.")
        return float(found.item())

    visible, sd = checked("visible", (pairs, *size)), checked("sd", (pairs, *size))
    area, glottis = checked("glottal_area", (pairs + 1,)), checked("glottis", (pairs + 1, *size))
    projection = checked("projection", (3, 4))
    if area is None and glottis is not None:
        area = [float(np.count_nonzero(glottis[k])) for k in range(pairs + 1)]

    def seen(pair: int) -> Mask:
        known = np.isfinite(flow[pair]).all(axis=-1)
        return np.asarray(known if visible is None else known & np.asarray(visible[pair], dtype=bool))

    return PixelMotion(
        name=path.name,
        kind="ground truth of a film" if projection is not None and visible is not None else "flow of a file",
        pairs=pairs,
        shape=(size[0], size[1]),
        flow=lambda pair: np.asarray(flow[pair]),
        visible=seen,
        sd=None if sd is None else lambda pair: np.asarray(sd[pair], dtype=float),
        fps=number("fps"),
        mm_per_px=number("mm_per_px"),
        camera=None if projection is None else _camera(path, np.asarray(projection), (size[0], size[1])),
        area=None if area is None else np.asarray(area, dtype=float),
    )


def _camera(path: Path, projection: Floats, shape: tuple[int, int]) -> Camera:
    """The camera of a projection; errors name the file."""
    try:
        return Camera.of_projection(projection, shape)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {str(error).removeprefix('Camera: ')}") from None
