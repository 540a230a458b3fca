"""results.h5 of an analysis: a group for each step that is done, replaced as a whole when one is added."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from plica.phonation.storage import replaced
from plica.video.errors import VideoError
from plica.video.recording import Recording
from plica.video.settings import Settings

__all__ = ["Results", "fill"]

Mask = npt.NDArray[np.bool_]


class Results:
    """The file, read and written in one piece: a kill at any moment leaves the old one or the new one."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __contains__(self, name: str) -> bool:
        with h5py.File(self.path, "r") as file:
            return name in file

    def claim(self, source: Path, recording: Recording, settings: Settings) -> None:
        """Mark them as of this recording and these settings; VideoError where they are of others."""
        size = f"{recording.shape[1]} x {recording.shape[0]}"
        low, high = recording.scale
        asked = {
            "source": str(source.resolve()),
            "recording": f"{recording.count} frames of {size} px, grey {low:g} to {high:g}",
            "settings": settings.as_json(),
        }
        if self.path.exists():
            with h5py.File(self.path, "r") as file:
                there = {name: str(file.attrs.get(name, "")) for name in asked}
            if there == asked:
                return
            self._compare(there, asked)
        self.change(lambda file: file.attrs.update({**asked, "scale": recording.scale}))

    def _compare(self, there: Mapping[str, str], asked: Mapping[str, str]) -> None:
        where = self.path.parent
        if there["source"] != asked["source"]:
            raise VideoError(
                f"Video: {where} holds an analysis of {there['source'] or 'something else'}; must be of "
                f"{asked['source']}. Choose another directory."
            )
        old, new = (Settings.from_json(texts["settings"]).computing() for texts in (there, asked))
        for name, value in new.items():
            if old[name] != value:
                raise VideoError(
                    f"Video: {where} holds an analysis with {name} = {old[name]}; must be {value}. Choose "
                    "another directory."
                )
        if there["recording"] != asked["recording"]:
            raise VideoError(
                f"Video: {asked['source']} has {asked['recording']}; must have {there['recording']}, as when "
                f"its analysis in {where} began. Choose another directory."
            )

    def correct(self, drawn: Mapping[int, Mask]) -> None:
        """Take these masks for their frames, and drop what stands on others: all but the drift."""
        there = self.drawn()
        if there.keys() == drawn.keys() and all(np.array_equal(there[k], drawn[k]) for k in drawn):
            return

        def add(file: h5py.File) -> None:
            file["drawn/frames"] = np.array(sorted(drawn))
            masks = np.array([drawn[k] for k in sorted(drawn)])
            file.create_dataset("drawn/masks", data=masks, compression="gzip", compression_opts=1)

        self.change(add, only=("drift",))

    def read(self, *names: str) -> list[Any]:
        """Data sets by their names."""
        with h5py.File(self.path, "r") as file:
            return [file[name][()] for name in names]

    def drawn(self) -> dict[int, Mask]:
        """Masks drawn by hand, by their frames."""
        with h5py.File(self.path, "r") as file:
            if "drawn" not in file:
                return {}
            return dict(zip(map(int, file["drawn/frames"][()]), file["drawn/masks"][()], strict=True))

    def masks(self, begin: int = 0) -> Iterator[Mask]:
        """The glottis of each frame from this one on."""
        with h5py.File(self.path, "r") as file:
            kept = file["glottis/mask"]
            for index in range(begin, len(kept)):
                yield kept[index]

    def change(self, add: Callable[[h5py.File], None], only: tuple[str, ...] | None = None) -> None:
        """The file with what is added, and of what is there all or only these groups, takes its place."""

        def write(draft: Path) -> None:
            with h5py.File(draft, "w") as file:
                if self.path.exists():
                    with h5py.File(self.path, "r") as old:
                        file.attrs.update(old.attrs)
                        for name in old if only is None else set(old) & set(only):
                            link = old.get(name, getlink=True)
                            if isinstance(link, h5py.ExternalLink):
                                file[name] = link
                            else:
                                old.copy(name, file)
                add(file)

        replaced(self.path, write)

    def store(self, name: str, **arrays: Any) -> None:
        """Add a group."""
        self.change(lambda file: fill(file.create_group(name), **arrays))


def fill(group: h5py.Group, **arrays: Any) -> None:
    """Add data sets, the larger ones packed."""
    for name, value in arrays.items():
        packed = isinstance(value, np.ndarray) and value.size > 10_000
        group.create_dataset(
            name, data=value, **({"compression": "gzip", "compression_opts": 1} if packed else {})
        )
