"""What the cases of a sweep are of: a scene, recordings, or the tissue that recordings are asked for."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, Literal, Protocol

from plica.errors import InvalidInput
from plica.measures.measured import Measured
from plica.measures.record import Array
from plica.scene.number_key import NumberKey
from plica.scene.scene import Scene

__all__ = [
    "RECORDING",
    "RESERVED",
    "Changes",
    "ChoiceKey",
    "Fault",
    "Key",
    "OfFiles",
    "Outcome",
    "Statistics",
    "Subject",
    "file_digest",
    "found_recordings",
    "loaded",
    "scene_files",
    "statistics",
]

RECORDING = "recording"
"""The key whose values are names of recordings."""
RESERVED = (RECORDING, "case", "caution_names", "cautions", "message", "seconds", "status", "time")
"""Columns that are no measures."""

Changes = Mapping[str, float | int | str]
"""What a case changes: numbers in SI, or one of the words of a choice."""
Statistics = tuple[float | None, float | None, float | None]
"""Value, spread and uncertainty of a measure; None where there is none."""


class Fault(Exception):  # noqa: N818 (what it is, as the others)
    """Why a sweep cannot go on at all."""


@dataclass(frozen=True)
class ChoiceKey:
    """A key that takes one of some words.

    Attributes
    ----------
    key : str
    choices : tuple of str
    unit : str
        None.
    """

    key: str
    choices: tuple[str, ...]
    unit: str = ""


Key = NumberKey | ChoiceKey


@dataclass(frozen=True)
class Outcome:
    """What a case that is done gave.

    Attributes
    ----------
    measures : mapping
        Name to value, spread and uncertainty, in SI.
    units : mapping
        Unit of each measure that is not of the catalogue, or is in pixels or frames.
    cautions : tuple of str
        Names.
    message : str
        What the cautions say, where their names are not those of docs/cautions.md.
    waveforms : mapping
    """

    measures: Mapping[str, Statistics]
    units: Mapping[str, str] = field(default_factory=dict)
    cautions: tuple[str, ...] = ()
    message: str = ""
    waveforms: Mapping[str, Array] = field(default_factory=dict)


class Subject(Protocol):
    """One kind of case."""

    @property
    def kind(self) -> Literal["run", "recording", "identification"]:
        """What a case is."""

    @property
    def recordings(self) -> tuple[str, ...]:
        """Names of the recordings, each of which has all cases of the design; empty for a scene alone."""

    def key(self, key: str, where: str) -> Key:
        """What can be varied under a key; raises InvalidInput, beginning with `where`, where nothing can."""

    def record(self) -> dict[str, Any]:
        """All that cases depend on besides their changes, as JSON; files by their content."""

    def save(self, directory: Path) -> None:
        """Write what the cases are of into the directory of a sweep."""

    def compute(self, changes: Changes, waveforms: tuple[str, ...], folder: Path | None) -> Outcome:
        """Compute a case, in a folder that is kept if one is given, and return these waveforms.

        Raises
        ------
        Fault, Damaged, StorageFailed
            No case can be computed.
        InvalidInput
            There is no such case.
        SolveFailed
            It cannot be computed.
        """


class OfFiles:
    """What a kind of case has that is of recordings in files.

    Attributes
    ----------
    files : sequence of path
        A text with ``*`` is a pattern.
    where : str
        Prefix of messages.
    base : path
        What files are relative to.
    """

    files: Sequence[str | Path]
    where: str
    base: Path

    @cached_property
    def paths(self) -> Mapping[str, Path]:
        """The recordings by name."""
        return found_recordings(self.files, self.where, self.base)

    @property
    def recordings(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.paths)

    def digests(self) -> dict[str, str]:
        """SHA-256 of each by its content."""
        return {name: _contents(path) for name, path in self.paths.items()}


def statistics(item: Measured) -> Statistics:
    """Value, spread and uncertainty; None for what is not finite."""
    found = (item.value, item.spread, item.uncertainty)
    value, spread, uncertainty = (None if one is None or not isfinite(one) else float(one) for one in found)
    return value, spread, uncertainty


def scene_files(scene: dict[str, Any]) -> dict[str, str]:
    """Digests of the files that a resolved scene names, whose paths are taken out of it: what is in them
    counts, not where they lie."""
    files = {}
    for part, name in (("mesh", "file"), ("reduction", "basis")):
        if name in scene.get(part, {}):
            files[f"{part}.{name}"] = file_digest(Path(scene[part].pop(name)), "that of the scene")
    return files


def file_digest(path: Path, what: str) -> str:
    """SHA-256 of a file; raises InvalidInput where it is not there, and must be `what`."""
    if not path.is_file():
        raise InvalidInput(f"{path}: there is no such file; must be {what}.")
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _contents(path: Path) -> str:
    """Of all that a recording, or its analysis, consists of."""
    together = hashlib.sha256()
    for part in _parts(path):
        together.update(f"{part.name} {file_digest(part, 'that of a recording')}\n".encode())
    return together.hexdigest()


_ANALYSIS = ("results.h5", "flow.h5")
_PHOTRON = (".mraw", ".cih", ".cihx")


def _parts(path: Path) -> list[Path]:
    if not path.is_dir():
        beside = [path.with_suffix(suffix) for suffix in _PHOTRON if path.suffix.lower() in _PHOTRON]
        return sorted({path, *(part for part in beside if part.is_file())})
    if (path / _ANALYSIS[0]).is_file():
        return [path / name for name in _ANALYSIS if (path / name).is_file()]
    return sorted(part for part in path.iterdir() if part.is_file() and not part.name.startswith("."))


def found_recordings(given: Sequence[str | Path], where: str, base: Path = Path()) -> dict[str, Path]:
    """The paths of recordings by short names: those of their files without suffix, or as they were given.

    Parameters
    ----------
    given : sequence
        Paths; a text with ``*`` or ``?`` is a pattern.
    where : str
        Prefix of messages.
    base : Path
        What they are relative to.

    Raises
    ------
    InvalidInput
        For a path that is not there, a pattern that nothing fits, and a recording that is given twice.
    """
    told: list[str] = []
    for one in map(str, given):
        if not any(sign in one for sign in "*?"):
            told.append(one)
            continue
        anchor = Path(one).anchor
        root = Path(anchor) if anchor else base
        fit = sorted(root.glob(str(Path(one).relative_to(anchor)) if anchor else one))
        if not fit:
            raise InvalidInput(f'{where}: recordings: nothing fits "{one}"; must be one or more.')
        told += [str(path if anchor else path.relative_to(base)) for path in fit]
    if not told:
        raise InvalidInput(f"{where}: recordings is empty; must be one or more.")
    paths = [(base / one).resolve() for one in told]
    for path, one in zip(paths, told, strict=True):
        if not path.exists():
            raise InvalidInput(f"{where}: recordings: {one} does not exist; must be a file or a folder.")
        if paths.count(path) > 1:
            raise InvalidInput(f"{where}: recordings: {one} is given twice; must be once.")
    short = [path.stem if path.is_file() else path.name for path in paths]
    names = short if len(set(short)) == len(short) else told
    return dict(zip(names, paths, strict=True))


def loaded(scene: Scene | str | Path) -> Scene:
    """A scene, or that of a file."""
    return scene if isinstance(scene, Scene) else Scene.load(scene)
