"""The points of an estimate as they come, so that one that was stopped goes on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.identify.observation import Observation
from plica.identify.scoring import Iteration
from plica.identify.settings import Settings
from plica.phonation.scene.problems import differences
from plica.phonation.scene.scene import Scene
from plica.storage.json_file import write_json

__all__ = ["Iterates", "Marks"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Marks:
    """What an estimate stands on, told from others."""

    settings: dict[str, Any]
    scene: dict[str, Any]
    coarser: dict[str, Any] | None
    recording: str

    @staticmethod
    def of(settings: Settings, scene: Scene, coarser: Scene | None, observation: Observation) -> Marks:
        """Of these settings and scenes, and a digest of what is seen."""
        points = observation.points
        content = hashlib.sha256()
        for part in (observation.flow, observation.sd, observation.closed, points.nodes, points.weights):
            content.update(np.ascontiguousarray(part).tobytes())
        return Marks(
            json.loads(settings.model_dump_json(exclude={"voiced"})),  # voiced changes what is said alone
            _table(scene),
            None if coarser is None else _table(coarser),
            content.hexdigest(),
        )


def _table(scene: Scene) -> dict[str, Any]:
    """As JSON gives it back."""
    found: dict[str, Any] = json.loads(json.dumps(scene.resolved()))
    return found


@dataclass
class Iterates:
    """``iterates.json``: written after every iteration, replaced as a whole."""

    path: Path
    marks: Marks
    points: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    """By mesh, "coarser" or "scene": ``{"number", "start", "value", "step", "point"}``."""
    ended: dict[str, list[float]] = field(default_factory=dict)
    """By mesh: the mean of its posterior, where its estimate has ended."""

    @staticmethod
    def begun(directory: Path, marks: Marks, resume: bool) -> Iterates:
        """Those in `directory` that stand on the same, or none yet.

        Raises InvalidInput where there are some and `resume` is not set, or where they stand on something
        else, which is named.
        """
        path = directory / "iterates.json"
        if directory.exists() and not directory.is_dir():
            raise InvalidInput(f"{directory}: is a file; must be a directory, or not be there yet.")
        if not path.exists():
            if resume:
                raise InvalidInput(
                    f"{directory}: there is no identification to continue. Start it without --resume."
                )
            return Iterates(path, marks)
        if not resume:
            raise InvalidInput(
                f"{directory}: holds an identification already. Continue it with --resume (resume=True), or "
                "take another directory."
            )
        try:
            stored = json.loads(path.read_text(encoding="utf-8"))
            there = Marks(**stored["marks"])
            found = Iterates(path, marks, stored["points"], stored["ended"])
            for point in (point for points in found.points.values() for point in points):
                point.setdefault("start", 1)  # the only one that was stored before starts were named
        except (ValueError, KeyError, TypeError):
            raise InvalidInput(
                f"{path}: is damaged; must be as it was written. Take another directory."
            ) from None
        _require_same(directory, there, marks)
        return found

    def last(self, mesh: str) -> dict[int, Floats]:
        """The last point of each start on a mesh."""
        return {kept["start"]: np.array(kept["point"]) for kept in self.points.get(mesh, [])}

    def add(self, mesh: str, at: Iteration) -> None:
        """Keep a point, unless it is the one from which its start goes on."""
        last = self.last(mesh).get(at.start)
        if last is not None and np.array_equal(last, at.point):
            return
        kept = self.points.setdefault(mesh, [])
        point = np.asarray(at.point).tolist()
        kept.append(
            {"number": len(kept), "start": at.start, "value": at.value, "step": at.step, "point": point}
        )
        self._write()

    def end(self, mesh: str, mean: Floats) -> None:
        """Keep the end of a mesh."""
        self.ended[mesh] = np.asarray(mean).tolist()
        self._write()

    @contextmanager
    def naming_what_is_kept(self) -> Iterator[None]:
        """An interruption within says what is kept: points and starts of each mesh, whether it has ended."""
        try:
            yield
        except KeyboardInterrupt:
            if not self.points:
                raise
            kept = "; ".join(map(self._kept, self.points))
            raise KeyboardInterrupt(f"stopped. Kept in {self.path}: {kept}") from None

    def _kept(self, mesh: str) -> str:
        points = sum(point["start"] > 0 for point in self.points[mesh])
        starts = len(self.last(mesh).keys() - {0})
        where = "the coarser mesh" if mesh == "coarser" else "the scene's mesh"
        counts = f"{_counted(points, 'point')} of {_counted(starts, 'start')} on {where}"
        return f"{counts}, which has ended" if mesh in self.ended else counts

    def _write(self) -> None:
        write_json({"marks": vars(self.marks), "points": self.points, "ended": self.ended}, self.path)


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"


def _require_same(directory: Path, there: Marks, marks: Marks) -> None:
    told = []
    for whose in ("settings", "scene", "coarser"):
        before, now = getattr(there, whose), getattr(marks, whose)
        if before != now and isinstance(before, dict) and isinstance(now, dict):
            prefix = "" if whose == "settings" else f"{_WORDS[whose]}: "
            told += [
                f"{prefix}{key} = {old or 'none'}, now it is {new or 'none'}"
                for key, old, new in differences(before, now)
            ]
        elif before != now:
            told.append(f"another {_WORDS[whose]}")
    if there.recording != marks.recording and not told:  # what of it is taken follows from the rest
        told.append("another recording")
    if told:
        raise InvalidInput(
            f"{directory}: was begun with {'; '.join(told)}; must be the same to go on. Take another "
            "directory."
        )


_WORDS = {"settings": "settings", "scene": "scene", "coarser": "coarser scene"}
