"""Cases that are analyses of recordings, with settings that change."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from plica import _engine
from plica.errors import Damaged, InvalidInput, nearest, one_of
from plica.scene.number_key import NumberKey
from plica.storage.table import write_rows
from plica.sweep.subject import (
    RECORDING,
    Changes,
    ChoiceKey,
    Key,
    OfFiles,
    Outcome,
    file_digest,
    statistics,
)

if TYPE_CHECKING:
    from plica.video.analysis import Analysis
    from plica.video.settings import Settings

__all__ = ["Recordings", "chosen", "in_folder", "recording_list"]

Until = Literal["glottis", "modes"]

_WHOLE = ("first", "last", "modes")
_NUMBERS = {"fps": "Hz", "mm_per_px": "", "rotation": "degrees"}
_LISTS = {"region": True, "midline": False, "kymogram": False}  # whether they are of whole numbers
_WORDS = ("preset", "correct_drift")
_KNOWN = (*_NUMBERS, *_WHOLE, *_WORDS, *(f"{name}[0]" for name in _LISTS))
_OF_ONE = ("label", "recorded", "audio", "egg", "sound_start", "sync")
"""Settings that say something of one recording, or put signals beside it."""
_ENTRY = re.compile(r"(\w+)\[(\d+)\]")


@dataclass(frozen=True, eq=False)
class Recordings(OfFiles):
    """Recordings that are analysed, as by ``plica video``.

    Parameters
    ----------
    files : sequence of path
        As of `plica.video.Recording.open`; a text with ``*`` is a pattern.
    settings : plica.video.Settings, optional
        Those of every case, but for what changes.
    until : {"modes", "glottis"}
        How far each is analysed; ``"glottis"`` leaves out the motion of the tissue, which takes longest.
    where : str
        Prefix of messages.
    base : path
        What files are relative to.
    """

    files: Sequence[str | Path]
    settings: Settings | None = None
    until: Until = "modes"
    where: str = "Recordings"
    base: Path = field(default=Path(), repr=False)
    kind: Literal["recording"] = field(default="recording", init=False)

    def __post_init__(self) -> None:
        if self.until not in ("glottis", "modes"):
            raise InvalidInput(f'{self.where}: until = "{self.until}"; must be glottis or modes.')
        _ = self.paths, self.scale
        for name in _OF_ONE:
            if getattr(self._settings, name) is not None:
                raise InvalidInput(
                    f"{self.where}: {name} is given; must be left out in a sweep: it is of one recording. "
                    "plica video takes it."
                )

    @cached_property
    def _settings(self) -> Settings:
        from plica.video.settings import Settings

        return self.settings or Settings()

    @cached_property
    def scale(self) -> tuple[bool, bool]:
        """Whether the rate of the frames and the size of a pixel are known: by the first recording that can
        be opened, as all must have the same units."""
        told = self._settings
        rate = told.fps is not None or self._camera_rate()
        return rate, told.mm_per_px is not None

    def _camera_rate(self) -> bool:
        """Whether the first recording that can be opened says its rate itself."""
        from plica.video.files.recording import Recording

        for path in self.paths.values():
            try:
                camera = Recording.open(path, dataset=self._settings.dataset, scale=(0.0, 1.0)).camera
            except InvalidInput:
                continue  # it will be refused as a case
            return camera is not None and camera.fps is not None
        return False

    def key(self, key: str, where: str) -> Key:
        """A number of the settings, or an entry of one of their lists; or a preset, or whether drift goes."""
        from plica.video.motion.flow import PRESETS

        words = {"preset": tuple(PRESETS), "correct_drift": ("true", "false")}
        if key in words:
            return ChoiceKey(key, words[key])
        entry = _ENTRY.fullmatch(key)
        if entry is not None and entry[1] in _LISTS:
            values = getattr(self._settings, entry[1]) or ()
            if int(entry[2]) >= len(values):
                raise InvalidInput(
                    f"{where}: {key} is not there: {entry[1]} has {len(values)} entries, from [0]; must be "
                    "given in the settings to vary it."
                )
            return NumberKey(key, "", _LISTS[entry[1]])
        if key not in (*_NUMBERS, *_WHOLE):
            raise InvalidInput(f"{where}: {key}; must be {one_of(_KNOWN)}.{nearest(key, _KNOWN)}")
        if key in ("fps", "mm_per_px") and not self.scale[key == "mm_per_px"]:
            raise InvalidInput(
                f"{where}: {key} is varied, and not given in the settings; must be, so that all cases have "
                "the same units."
            )
        return NumberKey(key, _NUMBERS.get(key, ""), key in _WHOLE)

    def record(self) -> dict[str, Any]:
        """Version, settings, and the recordings by their content."""
        settings = asdict(self._settings)
        files = {}
        if settings["segmenter"] is not None:  # what is in it counts, not where it lies
            files["segmenter"] = file_digest(Path(settings.pop("segmenter")), "an ONNX model")
        told = {name: value for name, value in settings.items() if value is not None}
        return {
            "kind": self.kind,
            "plica_version": str(_engine.build_info()["version"]),
            "settings": {**told, "until": self.until},
            "recordings": self.digests(),
            "files": files,
        }

    def save(self, directory: Path) -> None:
        """Write ``sources.csv``: where each of them lies."""
        recording_list(self.paths, directory)

    def compute(self, changes: Changes, waveforms: tuple[str, ...], folder: Path | None) -> Outcome:
        """An analysis, whose folder is begun or continued if one is given."""
        from plica.storage.files import storage_errors
        from plica.video.analysis import analyse
        from plica.video.tables import write_tables

        path, others = chosen(self.paths, changes)
        settings = self._changed(others)
        try:
            with in_folder(folder) as where, storage_errors(where):
                found = analyse(path, where, settings, until=self.until, progress=False)
                self._require_scale(found)
                if folder is not None:
                    write_tables(found)
                return _outcome(found)
        except Damaged as error:  # of this recording alone
            raise InvalidInput(str(error)) from None

    def _changed(self, changes: Changes) -> Settings:
        values: dict[str, Any] = {}
        for key, value in changes.items():
            entry = _ENTRY.fullmatch(key)
            if entry is None:
                values[key] = value == "true" if key == "correct_drift" else value
                continue
            listed = list(values.get(entry[1]) or getattr(self._settings, entry[1]))
            listed[int(entry[2])] = value
            values[entry[1]] = tuple(listed)
        return replace(self._settings, **values)

    def _require_scale(self, found: Analysis) -> None:
        """The units of the first recording, in which all of them are."""
        known = found.settings.fps is not None, found.settings.mm_per_px is not None
        if known != self.scale:
            there = "known" if self.scale[0] else "not known"
            raise InvalidInput(
                f"the frame rate of {found.source.name} is {'known' if known[0] else 'not known'}, that of "
                f"others {there}; must be alike, so that all cases have the same units. Give fps in the "
                "settings."
            )


def _outcome(found: Analysis) -> Outcome:
    from plica.video.light import light_of
    from plica.video.report.summary import not_to_write_down

    light, doubtful = light_of(found), not_to_write_down(found)
    said = [] if light.colour == "good" else [f"{light.shown}: {light.said}"]
    said += [f"Not to write down: {', '.join(doubtful)}."] if doubtful else []
    measures = found.measures
    return Outcome(
        {name: statistics(item) for name, item in measures.items()},
        {name: item.unit for name, item in measures.items()},
        () if light.colour == "good" else (f"light_{light.shown}",),
        " ".join(said),
    )


def chosen(paths: Mapping[str, Path], changes: Changes) -> tuple[Path, dict[str, float | int | str]]:
    """The recording of a case, and its other changes."""
    others = dict(changes)
    name = others.pop(RECORDING, next(iter(paths)))
    return paths[str(name)], others


@contextmanager
def in_folder(folder: Path | None) -> Iterator[Path]:
    """A folder that is kept, or one that is not."""
    if folder is not None:
        yield folder
        return
    with tempfile.TemporaryDirectory(prefix="plica-sweep-case-") as made:
        yield Path(made)


def recording_list(paths: Mapping[str, Path], directory: Path) -> None:
    """Write where recordings lie (CSV)."""
    rows = [{"recording": name, "path": str(path)} for name, path in paths.items()]
    write_rows(directory / "sources.csv", rows)
