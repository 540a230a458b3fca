"""results.h5 of an analysis: a group for each step that is done, replaced as a whole when one is added."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from plica.storage.files import replaced
from plica.storage.stored import check_result_file
from plica.video.dated import file_date
from plica.video.errors import VideoError
from plica.video.network import fingerprint
from plica.video.recording import Recording
from plica.video.settings import Settings

__all__ = ["Results", "fill"]

Mask = npt.NDArray[np.bool_]

_CHANGES = {
    "fps": (),
    "mm_per_px": (),
    "anterior": (),
    "patient_left": (),
    "label": (),
    "recorded": (),
    "kymogram": ("sides", "waves"),
    "midline": ("sides", "flow", "trust", "paths", "modes", "waves"),
    "modes": ("modes",),
}
"""Settings that may change, each with the groups to be made again."""

_UNITS = {
    "drift/motion": "px to the right, px down, rad clockwise",
    "glottis/least": "px^2",
    "glottis/largest": "px^2",
    "glottis/blur": "px, standard deviation",
    "sides/left": "px^2",
    "sides/right": "px^2",
    "sides/left_edge": "px",
    "sides/right_edge": "px",
    "sides/inner_left": "px^2",
    "sides/inner_right": "px^2",
    "sides/inner_left_edge": "px",
    "sides/inner_right_edge": "px",
    "sides/lost_left": "px^2",
    "sides/lost_right": "px^2",
    "sides/lost_left_edge": "px",
    "sides/lost_right_edge": "px",
    "sides/inner_lost_left": "px^2",
    "sides/inner_lost_right": "px^2",
    "sides/inner_lost_left_edge": "px",
    "sides/inner_lost_right_edge": "px",
    "sides/lost_most": "px^2",
    "sides/blur_band": "px^2",
    "sides/midline": "px: x, y of the upper end, x, y of the lower",
    "sides/blur": "px, standard deviation",
    "sides/kymogram": "grey levels",
    "trust/mismatch": "px",
    "paths/places": "px: x, y",
    "paths/closing": "px",
    "modes/mean": "px: to the right, down",
    "modes/coefficients": "px",
    "modes/round_trip": "px",
    "modes/variance": "px^2",
    "waves/displacement": "px: real and imaginary part; to the right, down",
    "waves/kymogram": "px to the right across the midline, to the next frame",
    "waves/strain": "1: real and imaginary part; across the midline, along it, shear",
}  # others are pure numbers


class Results:
    """The file, read and written in one piece: a kill at any moment leaves the old one or the new one."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __contains__(self, name: str) -> bool:
        with h5py.File(self.path, "r") as file:
            return name in file

    def merged(self, source: Path, recording: Recording, settings: Settings) -> Settings:
        """The settings with those given before, where one that may change is not given now.

        VideoError where the results are of another recording, or of settings on which everything stands.
        """
        if not self.path.exists():
            return settings
        check_result_file(self.path)
        with h5py.File(self.path, "r") as file:
            there = {name: str(file.attrs.get(name, "")) for name in ("recording", "settings", "segmenter")}
        if not there["settings"]:
            raise VideoError(
                f"Video: {self.path} is no analysis of a recording; must be, or not be there. Choose "
                "another directory."
            )
        old = Settings.from_json(there["settings"])
        kept = {name: getattr(old, name) for name in _CHANGES if getattr(settings, name) is None}
        new = replace(settings, **kept)
        if _print(new) and _print(new) == there["segmenter"]:
            old = replace(old, segmenter=new.segmenter)  # the same model, wherever it lies
        elif new.segmenter and old.segmenter:
            raise VideoError(
                f"Video: {new.segmenter} is another model than when the analysis in {self.path.parent} "
                "began; must be the same, as all of it stands on it. Choose another directory."
            )
        for name, value in asdict(new).items():
            if name not in _CHANGES and value != getattr(old, name):
                raise VideoError(
                    f"Video: {name} is {_shown(value)}; must be {_shown(getattr(old, name))}, as in the "
                    f"analysis in {self.path.parent}, all of which stands on it. Choose another directory."
                )
        if there["recording"] != _described(recording):
            raise VideoError(
                f"Video: {source} has {_described(recording)}; must have {there['recording']}, like the "
                f"recording whose analysis is in {self.path.parent}. Choose another directory."
            )
        return new

    def claim(self, source: Path, recording: Recording, settings: Settings) -> None:
        """Mark them as of this recording and these `merged` settings; what stands on others is dropped."""
        marks = {
            "source": str(source.resolve()),
            "recording": _described(recording),
            "settings": settings.as_json(),
            "segmenter": _print(settings),
            "camera": json.dumps(None if recording.camera is None else asdict(recording.camera)),
        }
        stale: set[str] = set()
        if self.path.exists():
            with h5py.File(self.path, "r") as file:
                there = {name: str(file.attrs.get(name, "")) for name in marks}
            if there == marks:
                return
            old = Settings.from_json(there["settings"])
            changed = [name for name in _CHANGES if getattr(old, name) != getattr(settings, name)]
            stale = {group for name in changed for group in _CHANGES[name]}
        else:
            self.path.with_name("flow.h5").unlink(missing_ok=True)  # of another analysis
        said = file_date(source, recording.camera) or ("", "")
        further = {"scale": recording.scale, "file_date": list(said)}
        self.change(lambda file: file.attrs.update({**marks, **further}), without=stale)

    def correct(self, drawn: Mapping[int, Mask]) -> None:
        """Keep these masks as drawn by hand, and drop what stands on others: all but the drift."""

        def add(file: h5py.File) -> None:
            if drawn:
                fill(
                    file.create_group("drawn"),
                    frames=np.array(sorted(drawn)),
                    masks=np.array([drawn[k] for k in sorted(drawn)]),
                )

        self.change(add, without=("drawn", "glottis", *_CHANGES["midline"]))

    def read(self, *names: str) -> list[Any]:
        """Data sets by their names."""
        with h5py.File(self.path, "r") as file:
            return [file[name][()] for name in names]

    def shape(self, name: str) -> tuple[int, ...]:
        """Of a data set."""
        with h5py.File(self.path, "r") as file:
            return tuple(file[name].shape)

    def drawn(self) -> dict[int, Mask]:
        """Masks drawn by hand, by their frames."""
        with h5py.File(self.path, "r") as file:
            if "drawn" not in file:
                return {}
            masks = file["drawn/masks"][()].astype(bool)
            return dict(zip(file["drawn/frames"][()].tolist(), masks, strict=True))

    def masks(self, begin: int = 0, name: str = "mask") -> Iterator[Mask]:
        """The glottis of each frame from this one on, or its "inner" part."""
        with h5py.File(self.path, "r") as file:
            kept = file[f"glottis/{name}"]
            for index in range(begin, len(kept)):
                yield kept[index].astype(bool)

    def change(self, add: Callable[[h5py.File], None], without: Iterable[str] = ()) -> None:
        """The file but for these groups, and with what is added, takes the place of the one that is there."""
        # Made in memory: HDF5 does not survive a full disk.
        with h5py.File("results", "w", driver="core", backing_store=False) as file:
            if self.path.exists():
                with h5py.File(self.path, "r") as old:
                    file.attrs.update(old.attrs)
                    for name in set(old) - set(without):
                        link = old.get(name, getlink=True)
                        if isinstance(link, h5py.ExternalLink):
                            file[name] = link
                        else:
                            old.copy(name, file)
            add(file)
            file.flush()
            image = file.id.get_file_image()

        def write(draft: Path) -> None:
            draft.write_bytes(image)

        replaced(self.path, write)

    def store(self, name: str, **arrays: Any) -> None:
        """Add a group."""
        self.change(lambda file: fill(file.create_group(name), **arrays))


def fill(group: h5py.Group, **arrays: Any) -> None:
    """Add data sets, the larger ones packed, truth values as 0 and 1, each with its unit."""
    for name, value in arrays.items():
        value = np.asarray(value) if not hasattr(value, "dtype") else value
        value = value.astype(np.uint8) if value.dtype == bool else value
        packed = {"compression": "gzip", "compression_opts": 1} if value.size > 10_000 else {}
        data = group.create_dataset(name, data=value, **packed)
        data.attrs["units"] = _UNITS.get(f"{group.name.strip('/')}/{name}", "1")


def _print(settings: Settings) -> str:
    return fingerprint(settings.segmenter) if settings.segmenter else ""


def _described(recording: Recording) -> str:
    """What tells a recording from others, wherever it lies."""
    height, width = recording.shape
    low, high = recording.scale
    return f"{recording.count} frames of {width} x {height} px, grey {low:g} to {high:g}"


def _shown(value: Any) -> str:
    if value is None:
        return "not given"
    return ",".join(f"{part:g}" for part in value) if isinstance(value, tuple) else f"{value}"
