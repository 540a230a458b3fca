"""The iterates of an estimate, stored as they are computed so that an interrupted estimate can continue."""

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
from plica.identify.estimator.scoring import Iteration
from plica.identify.observation.observation import Observation
from plica.identify.settings import Settings
from plica.scene.problems import differences
from plica.scene.scene import Scene
from plica.storage.files import holds_nothing_but
from plica.storage.json_file import read_json, write_json

__all__ = ["EstimateInputs", "Iterates"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class EstimateInputs:
    """The inputs of an estimate, compared when it is resumed."""

    settings: dict[str, Any]
    scene: dict[str, Any]
    coarser: dict[str, Any] | None
    recording: str

    @staticmethod
    def of(
        settings: Settings, scene: Scene, coarser: Scene | None, observation: Observation
    ) -> EstimateInputs:
        """Settings, scenes, and a digest of the observation."""
        points = observation.points
        content = hashlib.sha256()
        for part in (observation.flow, observation.sd, observation.closed, points.nodes, points.weights):
            content.update(np.ascontiguousarray(part).tobytes())
        return EstimateInputs(
            json.loads(settings.model_dump_json(exclude={"voiced"})),  # voiced changes only the warnings
            _table(scene),
            None if coarser is None else _table(coarser),
            content.hexdigest(),
        )


def _table(scene: Scene) -> dict[str, Any]:
    """The scene as read back from JSON."""
    found: dict[str, Any] = json.loads(json.dumps(scene.resolved()))
    return found


@dataclass
class Iterates:
    """``iterates.json``: replaced as a whole after every iteration."""

    path: Path
    inputs: EstimateInputs
    points: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    """By mesh, "coarser" or "scene": ``{"number", "start", "value", "step", "point"}``."""
    ended: dict[str, list[float]] = field(default_factory=dict)
    """By mesh: the posterior mean, if its estimate has finished."""

    @staticmethod
    def open(directory: Path, inputs: EstimateInputs, resume: bool) -> Iterates:
        """The iterates stored in `directory`, or none yet.

        A command that was killed before its first iterate is resumed from the beginning. Raises InvalidInput
        if there are iterates and `resume` is not set, if there is nothing to resume, or if they belong to
        other inputs, which the message names.
        """
        path = directory / "iterates.json"
        if directory.exists() and not directory.is_dir():
            raise InvalidInput(f"{directory}: is a file; must be a directory, or not exist yet.")
        if not path.exists():
            if resume and not holds_nothing_but(directory):
                raise InvalidInput(
                    f"{directory}: there is no identification to continue. Start it without --resume."
                )
            return Iterates(path, inputs)
        if not resume:
            raise InvalidInput(
                f"{directory}: already holds an identification. Continue it with --resume (resume=True), or "
                "use another directory."
            )
        stored = read_json(path, "Use another directory")
        _require_same(directory, EstimateInputs(**stored["marks"]), inputs)
        return Iterates(path, inputs, stored["points"], stored["ended"])

    def last(self, mesh: str) -> dict[int, Floats]:
        """The last point of each start on a mesh."""
        return {kept["start"]: np.array(kept["point"]) for kept in self.points.get(mesh, [])}

    def add(self, mesh: str, at: Iteration) -> None:
        """Store a point, unless it is the one from which its start was resumed."""
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
        """Store the posterior mean of a mesh."""
        self.ended[mesh] = np.asarray(mean).tolist()
        self._write()

    @contextmanager
    def listed_on_interrupt(self) -> Iterator[None]:
        """On KeyboardInterrupt the message lists the points and starts that are kept for each mesh."""
        try:
            yield
        except KeyboardInterrupt:
            if not self.points:
                raise
            kept = "; ".join(map(self._summary, self.points))
            raise KeyboardInterrupt(f"stopped. Kept in {self.path}: {kept}") from None

    def _summary(self, mesh: str) -> str:
        points = sum(point["start"] > 0 for point in self.points[mesh])
        starts = len(self.last(mesh).keys() - {0})
        where = "the coarser mesh" if mesh == "coarser" else "the scene's mesh"
        counts = f"{_counted(points, 'point')} of {_counted(starts, 'start')} on {where}"
        return f"{counts}, which has finished" if mesh in self.ended else counts

    def _write(self) -> None:
        content = {"marks": vars(self.inputs), "points": self.points, "ended": self.ended}
        write_json(content, self.path, guarded=True)


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"


def _require_same(directory: Path, stored: EstimateInputs, inputs: EstimateInputs) -> None:
    changes = []
    for part in ("settings", "scene", "coarser"):
        before, now = getattr(stored, part), getattr(inputs, part)
        if before != now and isinstance(before, dict) and isinstance(now, dict):
            prefix = "" if part == "settings" else f"{_PART_NAMES[part]}: "
            changes += [
                f"{prefix}{key} = {old or 'none'}, now {new or 'none'}"
                for key, old, new in differences(before, now)
            ]
        elif before != now:
            changes.append(f"another {_PART_NAMES[part]}")
    if stored.recording != inputs.recording and not changes:  # other changes may change the observation
        changes.append("another recording")
    if changes:
        raise InvalidInput(
            f"{directory}: was started with {'; '.join(changes)}; must be the same to continue. Use another "
            "directory."
        )


_PART_NAMES = {"settings": "settings", "scene": "scene", "coarser": "coarser scene"}
