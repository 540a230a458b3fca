"""Cases that are identifications: the tissue of a scene from recordings, under assumptions that change."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from plica import _engine
from plica.errors import Damaged, InvalidInput
from plica.scene.number_key import NumberKey, number_key
from plica.scene.scene import Scene
from plica.sweep.recording_cases import chosen, in_folder, recording_list
from plica.sweep.subject import (
    RESERVED,
    Changes,
    Key,
    OfFiles,
    Outcome,
    file_digest,
    loaded,
    scene_files,
    statistics,
)

if TYPE_CHECKING:
    from plica.identify.results import Identification
    from plica.identify.settings import Settings

__all__ = ["Identifications"]

_SETTINGS = "identify."
"""Keys of the settings begin so; others are of the scene."""
_EXPLAINED = "motion_explained"
_NO_FILE = ("auto", "none")  # coarser


@dataclass(frozen=True, eq=False)
class Identifications(OfFiles):
    """Recordings that are asked for the tissue of a scene, as by ``plica identify``.

    Parameters
    ----------
    files : sequence of path
        Analyses or files of flow, as of `plica.identify.open_motion`; a text with ``*`` is a pattern.
    scene : Scene or path
    settings : plica.identify.Settings, optional
        Those of every case, but for what changes.
    where : str
        Prefix of messages.
    base : path
        What files are relative to.
    """

    files: Sequence[str | Path]
    scene: Scene | str | Path
    settings: Settings | None = None
    where: str = "Identifications"
    base: Path = field(default=Path(), repr=False)
    kind: Literal["identification"] = field(default="identification", init=False)

    def __post_init__(self) -> None:
        _ = self.paths, self._scene
        for one in self._settings.parameters:
            if one.name in (*RESERVED, _EXPLAINED):
                raise InvalidInput(
                    f'{self.where}: a parameter is called "{one.name}"; must have another name: a column of '
                    "sweeps has it."
                )

    @cached_property
    def _scene(self) -> Scene:
        return loaded(self.scene)

    @cached_property
    def _settings(self) -> Settings:
        from plica.identify.settings import Settings

        return self.settings or Settings()

    def key(self, key: str, where: str) -> Key:
        """A number of the settings, ``identify.log_sd``, or of the scene."""
        if not key.startswith(_SETTINGS):
            return number_key(self._scene, key, where)
        found = number_key(self._settings, key.removeprefix(_SETTINGS), where)
        return NumberKey(key, found.unit, found.whole)

    def record(self) -> dict[str, Any]:
        """Version, scene, settings, and all files by their content."""
        scene = self._scene.resolved()
        files = scene_files(scene)
        settings = self._settings.model_dump(mode="json", exclude_none=True)
        if self._settings.drive is not None:
            files["drive"] = file_digest(Path(settings.pop("drive")), "that of the settings")
        if self._settings.coarser not in _NO_FILE:
            coarser = Scene.load(settings.pop("coarser")).resolved()
            files |= {f"coarser.{name}": found for name, found in scene_files(coarser).items()}
            settings["coarser"] = coarser
        return {
            "kind": self.kind,
            "plica_version": str(_engine.build_info()["version"]),
            "scene": scene,
            "settings": settings,
            "recordings": self.digests(),
            "files": files,
        }

    def save(self, directory: Path) -> None:
        """Write ``scene.toml`` and ``sources.csv``: where each of them lies."""
        self._scene.save(directory / "scene.toml")
        recording_list(self.paths, directory)

    def compute(self, changes: Changes, waveforms: tuple[str, ...], folder: Path | None) -> Outcome:
        """An identification, begun in a folder if one is given: one that is continued has other iterates, and
        would end elsewhere by some of its last digits."""
        from plica.identify.identification import identify

        path, others = chosen(self.paths, changes)
        of_settings = {
            key.removeprefix(_SETTINGS): value for key, value in others.items() if key.startswith(_SETTINGS)
        }
        of_scene = {key: value for key, value in others.items() if not key.startswith(_SETTINGS)}
        settings = self._settings.replace(of_settings) if of_settings else self._settings
        scene = self._scene.replace(of_scene) if of_scene else self._scene
        try:
            with in_folder(folder) as where:
                if folder is not None:
                    shutil.rmtree(folder, ignore_errors=True)
                return _outcome(identify(path, scene, where, settings, progress=False))
        except Damaged as error:  # of this recording alone
            raise InvalidInput(str(error)) from None


def _outcome(found: Identification) -> Outcome:
    posterior = found.posterior
    names = {
        "motion_not_followed": not posterior.carried,
        "pressures_of_the_motion": posterior.fed_back,
        "interval_refused": not posterior.answered,
        "residual_test_failed": not posterior.residuals.passed,
        "not_gaussian": not posterior.gaussian,
        "one_mesh": posterior.mesh_shift is None,
        "outside_prior": bool(posterior.outside_prior.any()),
    }
    measures = {name: statistics(item) for name, item in found.measures.items()}
    units = {name: item.unit for name, item in found.measures.items()}
    measures[_EXPLAINED], units[_EXPLAINED] = (found.picture.explained, None, None), "1"
    return Outcome(
        measures,
        units,
        tuple(name for name, holds in names.items() if holds),
        " ".join(found.warnings),
    )
