"""results.h5 of an analysis: a group for each step that is done, replaced as a whole when one is added.

The group of the flow only says that it is done: its data are in flow.h5.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from plica.errors import InvalidInput
from plica.storage.files import refuse_sweep
from plica.storage.hdf5 import put, set_text, write_image
from plica.storage.stored import Stored
from plica.video.errors import VideoError
from plica.video.files.recording import Recording
from plica.video.files.recording_date import file_date
from plica.video.glottis.coverage import from_stored
from plica.video.glottis.network import fingerprint
from plica.video.settings import Settings

__all__ = ["HINT", "Results", "fill"]

HINT = "Copy it again from where it is whole, or analyse the recording again in another directory"
"""What to do with a file that is damaged."""

Mask = npt.NDArray[np.bool_]

_CHANGES = {
    "fps": ("signals",),
    "mm_per_px": (),
    "anterior": (),
    "patient_left": (),
    "label": (),
    "recorded": (),
    "audio": ("signals",),
    "egg": ("signals",),
    "sound_start": ("signals",),
    "sync": ("signals",),
    "kymogram": ("sides", "waves"),
    "midline": ("sides", "flow", "trust", "paths", "modes", "waves"),
    "modes": ("modes",),
}
"""Settings that may change, each with the groups to be made again."""

_UNITS = {
    "drift/motion": "px to the right, px down, rad clockwise, logarithm of its size over the first frame's",
    "glottis/least": "px^2",
    "glottis/largest": "px^2",
    "glottis/blur": "px, standard deviation",
    "glottis/border_off": "px: left, right border in the image",
    "sides/left": "px^2",
    "sides/right": "px^2",
    "sides/left_edge": "px",
    "sides/right_edge": "px",
    "sides/contact": "px to the right: how far the line of contact may be off",
    "sides/inner_contact": "px to the right: how far the line of contact may be off",
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
    "sides/midline": "px: x, y of the upper end, x, y of the lower, its bow to the right from end to end",
    "sides/meeting": "px: the same of the line in which the folds meet",
    "sides/blur": "px, standard deviation",
    "sides/brightness": "grey levels",
    "sides/kymogram": "grey levels",
    "trust/mismatch": "px",
    "paths/places": "px: x, y",
    "paths/closing": "px",
    "modes/mean": "px: to the right, down",
    "modes/coefficients": "px",
    "modes/round_trip": "px",
    "modes/variance": "px^2",
    "signals/audio": "1: of full scale, or as in the file",
    "signals/audio_rate": "Hz",
    "signals/audio_begin": "s, from the first frame on",
    "signals/egg": "1: of full scale, or as in the file",
    "signals/egg_rate": "Hz",
    "signals/egg_begin": "s, from the first frame on",
    "waves/displacement": "px: real and imaginary part; to the right, down",
    "waves/kymogram": "px to the right across the midline, to the next frame",
    "waves/strain": "1: real and imaginary part; across the midline, along it, shear",
}  # others are pure numbers


class Results:
    """The file, read and written in one piece: a kill at any moment leaves the old one or the new one."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __contains__(self, name: str) -> bool:
        with Stored(self.path, hint=HINT) as file:
            if not name.startswith("flow/") or "flow" not in file:
                return name in file
        with self._holding(name) as (flows, inner):
            return inner in flows

    def marks_of_today(self) -> dict[str, Any]:
        """What the file says of itself. VideoError where an earlier version wrote it, or a part of it."""
        with Stored(self.path, hint=HINT) as file:
            marks: dict[str, Any] = file.attributes("/")
        earlier = f"Video: {self.path} is from an earlier version of plica; must be of this one. "
        if "scale" not in marks or "file_date" not in marks:
            raise VideoError(earlier + "Analyse the recording again in another directory.")
        if self.outdated():
            raise VideoError(
                earlier
                + "Give its recording and its directory to the command again: masks drawn by hand are "
                "kept, the rest is found again."
            )
        return marks

    def outdated(self) -> set[str]:
        """Groups of an earlier version, which :meth:`claim` drops, and all that stands on them: of one in
        which drift had no change of size, or outlines were of whole pixels."""
        if "drift" in self and self.shape("drift/motion")[1] < 4:
            return {"drift", "glottis", *_CHANGES["midline"]}
        whole = "glottis" in self and "glottis/coverage" not in self
        return {"glottis", *_CHANGES["midline"]} if whole else set()

    @property
    def signals_of(self) -> str:
        """What the stored signals are of; empty without any."""
        return self._marks("signals")["signals"] if "signals" in self else ""

    @property
    def flows(self) -> Path:
        """The file of the flow."""
        return self.path.with_name("flow.h5")

    @contextmanager
    def _holding(self, name: str) -> Iterator[tuple[Stored, str]]:
        """The file that has a data set, and its name there."""
        of_flow = name.startswith("flow/")
        with Stored(self.flows if of_flow else self.path, hint=HINT) as file:
            yield file, name.removeprefix("flow/") if of_flow else name

    def merged(self, source: Path, recording: Recording, settings: Settings) -> Settings:
        """The settings with those given before, where one that may change is not given now.

        VideoError where the results are of another recording, or of settings on which everything stands.
        """
        if not self.path.exists():
            try:
                refuse_sweep(self.path.parent)
            except InvalidInput as error:
                raise VideoError(f"Video: {error}") from None
            return settings
        there = self._marks("recording", "settings", "segmenter")
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
            there = self._marks(*marks)
            outdated = self.outdated()
            if there == marks and not outdated:
                return
            old = Settings.from_json(there["settings"])
            changed = [name for name in _CHANGES if getattr(old, name) != getattr(settings, name)]
            stale = outdated | {group for name in changed for group in _CHANGES[name]}
        else:
            self.flows.unlink(missing_ok=True)  # of another analysis
        marks["file_date"] = json.dumps(list(file_date(source, recording.camera) or ("", "")))

        def mark(file: h5py.File) -> None:
            for name, text in marks.items():
                set_text(file, name, text)
            file.attrs["scale"] = recording.scale

        self.change(mark, without=stale)

    def _marks(self, *names: str) -> dict[str, str]:
        """Texts that say of what they are; empty where there is none."""
        with Stored(self.path, hint=HINT) as file:
            return {name: str(file.attribute("/", name) or "") for name in names}

    def correct(self, drawn: Mapping[int, Mask]) -> None:
        """Keep these masks as drawn by hand, and drop what stands on others: all but the drift."""

        def add(file: h5py.File) -> None:
            if drawn:
                fill(
                    file,
                    "drawn",
                    frames=np.array(sorted(drawn)),
                    masks=np.array([drawn[k] for k in sorted(drawn)]),
                )

        self.change(add, without=("drawn", "glottis", *_CHANGES["midline"]))

    def read(self, *names: str) -> list[Any]:
        """Data sets by their names."""
        found = []
        for name in names:
            with self._holding(name) as (file, inner):
                found.append(file.read(inner))
        return found

    def row(self, name: str, index: int) -> Any:
        """One index of the first axis of a data set that is stored so: masks, the flow and its way back."""
        with self._holding(name) as (file, inner):
            return file.row(inner, index)

    def shape(self, name: str) -> tuple[int, ...]:
        """Of a data set."""
        with self._holding(name) as (file, inner):
            return tuple(file.data(inner).shape)

    def drawn(self) -> dict[int, Mask]:
        """Masks drawn by hand, by their frames."""
        with Stored(self.path, hint=HINT) as file:
            if "drawn" not in file:
                return {}
            masks = file.read("drawn/masks").astype(bool)
            return dict(zip(file.read("drawn/frames").tolist(), masks, strict=True))

    def masks(self, begin: int = 0) -> Iterator[Mask]:
        """The glottis of each frame from this one on."""
        with Stored(self.path, hint=HINT) as file:
            kept = file.rows("glottis/mask")
            for index in range(begin, len(kept)):
                yield kept[index].astype(bool)

    def coverages(self, name: str = "coverage") -> Iterator[npt.NDArray[np.float64]]:
        """(h, w) how much of each pixel is glottis, of each frame; or its "inner" part."""
        with Stored(self.path, hint=HINT) as file:
            kept = file.rows(f"glottis/{name}")
            for index in range(len(kept)):
                yield from_stored(kept[index])

    def change(self, add: Callable[[h5py.File], None], without: Iterable[str] = ()) -> None:
        """The file but for these groups, and with what is added, takes the place of the one that is there."""

        def make(file: h5py.File) -> None:
            if self.path.exists():
                with Stored(self.path, hint=HINT) as old:
                    old.copy_into(file, set(without))
            add(file)

        write_image(self.path, make)

    def store(self, name: str, **arrays: Any) -> None:
        """Add a group."""
        self.change(lambda file: fill(file, name, **arrays))


def fill(file: h5py.File, group: str, **arrays: Any) -> None:
    """Add data sets, the larger ones packed, truth values as 0 and 1, each with its unit."""
    for name, value in arrays.items():
        path, array = f"{group}/{name}", np.asarray(value)
        array = array.astype(np.uint8) if array.dtype == bool else array
        put(file, path, array, _UNITS.get(path, "1"), packed=array.size > 10_000)


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
