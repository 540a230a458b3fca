"""Settings of an identification: estimated parameters, pressures, frames, points and camera."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from plica.errors import InvalidInput, SceneError
from plica.identify.parameters import FIELDS, WIDEST, Prior, TissueParameter
from plica.scene.part import Count, Part, problem
from plica.scene.problems import describe
from plica.scene.scene import Scene
from plica.storage.files import require_file
from plica.units import Length, Number, Time, read_quantity

__all__ = ["Estimated", "Settings"]

Positive = Annotated[Number, Field(gt=0)]
LogSd = Annotated[Number, Field(gt=0, le=WIDEST)]
Share = Annotated[Number, Field(ge=0, le=1)]
Degrees = Annotated[Number, Field(gt=-90, lt=90)]
MOST_POINTS = 400
"""Each point adds two rows to every frame; more points add no independent information."""

MOST_STARTS = 18
"""All available starts: the first, its graduated start, and 16 prior samples."""


def _listed(value: object) -> object:
    return (value,) if isinstance(value, str) else value


Targets = Annotated[tuple[str, ...], BeforeValidator(_listed), Field(min_length=1)]


class Estimated(Part):
    """One positive tissue parameter and its prior: ``"cover.mu_fibre"``, or a table."""

    targets: Targets
    """``"layer.field"`` or ``"layer.side.field"``; several keep the ratios they have in the scene."""
    name: str = ""
    """Default: the first target."""
    median: float | str | None = None
    """Median of the prior, in SI or as text with a unit, ``"10 kPa"``; default: the scene's value."""
    log_sd: LogSd | None = None
    """[-] Prior standard deviation of the logarithm; default: that of the settings."""

    positional: ClassVar[tuple[str, ...]] = ("targets",)

    @model_validator(mode="after")
    def _median_in_si(self) -> Self:
        if self.median is None:
            return self
        field = self.targets[0].rpartition(".")[2]
        try:
            median = read_quantity(self.median, FIELDS.get(field, ""))
        except ValueError as error:
            raise problem(str(error), "median", value=self.median) from None
        if not median > 0:
            raise problem("must be > 0: its logarithm is estimated.", "median", value=self.median)
        object.__setattr__(self, "median", median)
        return self


def _as_table(value: object) -> object:
    return {"targets": value} if isinstance(value, str) else value


class Settings(Part):
    """Settings of an identification; the table ``[identify]`` of a settings file.

    The estimate is deterministic: the same input gives the same result.
    """

    parameters: tuple[Annotated[Estimated, BeforeValidator(_as_table)], ...] = ()
    """The estimated parameters; default: one viscosity of all layers, ``mu_fibre`` and ``E_fibre`` of each
    layer with fibres, ``E`` of each without."""
    log_sd: LogSd = 0.7
    """[-] Prior standard deviation of log theta for parameters without their own: 0.7 is a factor of four up
    or down, with 95 % probability."""

    surface: str | None = None
    """Surface on which the pressures act; default: that of the scene's airflow, or ``airway``."""
    seen: str | None = None
    """Surface that the camera sees; default: `surface`."""
    heights: Annotated[tuple[Length, ...], Field(min_length=2)] | None = None
    """[m] z of the pressures, upward; each decreases linearly to zero at the adjacent ones. Default: three,
    over the medial part of a larynx, or over the whole surface of another mesh."""
    drive: Path | None = None
    """CSV file of pressures that are known up to a factor: a column of times (s, 0 at the recording's first
    frame), then one column per height (Pa). Default: all pressures are unknown."""
    gain_sd: Annotated[Number, Field(ge=0)] = 0.3
    """[-] Prior standard deviation of the logarithm of that factor."""
    voiced: bool | None = None
    """Whether the folds' motion generates the pressures that drive them, as in phonation. Sd and intervals
    are then refused, because the model treats unknown pressures as independent of the motion and between
    frames. Default: true for a scene with an airflow, and for a larynx without `drive`."""
    closed_below: Share = 0.05
    """[-] Frames with a glottal area below this times the largest are closed: unknown contact forces then act
    on the medial surface. 0: none."""

    first: Annotated[int, Field(ge=0)] = 0
    """First frame that is used."""
    last: Annotated[int, Field(ge=1)] | None = None
    """Last frame that is used; default: the recording's last."""
    from_rest: bool = False
    """Whether the first frame shows the tissue at rest. If not, the rest position of a point is the mean of
    its trajectory, and unknown pressures set the model in motion before the first frame."""
    lead: Annotated[Time, Field(gt=0, le=1)] = 0.005
    """[s] Duration of these pressures, at least 16 frames, if the recording does not start at rest. Their
    prior is diffuse: the longer the lead, the more initial states they allow, and the less of the recording
    informs the tissue."""

    spacing: Annotated[Number, Field(ge=1)] | None = None
    """[px] Between points; default: the correlation length of the flow's error, at least 8."""
    most_points: Annotated[int, Field(ge=1, le=MOST_POINTS)] = 120
    """Largest number of points; the spacing is increased if there would be more."""
    points: Annotated[tuple[tuple[Number, Number], ...], Field(min_length=1)] | None = None
    """[px] Column and row in the first frame, instead of a grid."""
    sd: Positive | None = None
    """[px] Sd of the flow's error; default: from the recording's trust map times `trust_factor`, else 0.1."""
    trust_factor: Annotated[Number, Field(ge=1)] = 10.0
    """[-] Factor on trust maps, which are lower bounds of the error: six to fifteen times too small on
    synthetic folds."""

    fps: Positive | None = None
    """[Hz] Frame rate; default: the recording's."""
    mm_per_px: Positive | None = None
    """[mm] Size of a pixel; default: the recording's."""
    centre: tuple[Length, Length, Length] | None = None
    """[m] Point of the mesh at the centre of the image; default: the recording's, or such that the glottis of
    the image is on that of the mesh."""
    tilt: Degrees | None = None
    """[degrees] Inclination of the camera towards +y."""
    lean: Degrees | None = None
    """[degrees] Inclination of the camera towards +x."""
    roll: Annotated[Number, Field(ge=-360, le=360)] | None = None
    """[degrees] Rotation of the image, anticlockwise; default: such that the glottis is along y."""
    tilt_sd: Annotated[Number, Field(ge=0, lt=45)] | None = None
    """[degrees] Prior standard deviation of tilt and lean, which are then estimated; default: 6, or 0 if the
    recording contains the pose of the camera."""

    coarser: str = "auto"
    """Scene file with a coarser mesh, to measure the shift under refinement; ``"auto"``: made from the
    scene's if possible (a block with half the divisions, a larynx of a coarser preset); ``"none"``: one mesh
    only, with a warning."""
    max_iterations: Count = 40
    """Largest number of iterations of Fisher scoring."""
    starts: Annotated[Count, Field(le=MOST_STARTS)] = 3
    """Largest number of starts on the first mesh that is estimated. If the residuals fail their test, as
    they do at a false maximum, the estimate is restarted on the first quarter of the recording, then on more
    of it, and then likewise from prior samples, until two starts end at the same maximum. 1: no restart."""

    @model_validator(mode="after")
    def _fit_together(self) -> Self:
        if self.last is not None and self.last < self.first + 2:
            raise problem(f"must be >= first + 2 = {self.first + 2}.", "last", value=self.last)
        if self.heights is not None and any(
            b <= a for a, b in zip(self.heights, self.heights[1:], strict=False)
        ):
            raise problem("must increase: heights are given upward.", "heights", value=self.heights)
        if self.centre is not None and self.roll is None:
            raise problem("must come with roll: neither is then found from the glottis.", "centre")
        return self

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """The table ``[identify]`` of a TOML file; `drive` and `coarser` are relative to it."""
        path = Path(path)
        require_file(path, str(path))
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise InvalidInput(f"{path}: cannot be read: {error.strerror}.") from None
        except ValueError as error:
            raise InvalidInput(f"{path.name}: not TOML: {error}.") from None
        if set(data) != {"identify"} or not isinstance(data["identify"], dict):
            raise InvalidInput(f"{path.name}: must have the table [identify], and nothing else.")
        return cls.of_table(data["identify"], path, ("identify",))

    @classmethod
    def of_table(cls, given: Mapping[str, Any], path: Path, within: tuple[str, ...]) -> Self:
        """A table of the TOML file at `path`; `drive` and `coarser` are relative to it."""
        table = dict(given)
        if isinstance(table.get("drive"), str):
            table["drive"] = str((path.parent / table["drive"]).resolve())
        if isinstance(table.get("coarser"), str) and table["coarser"] not in ("auto", "none"):
            table["coarser"] = str((path.parent / table["coarser"]).resolve())
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise SceneError(describe(error, path.name, cls, within)) from None

    def tissue_parameters(self, scene: Scene) -> list[TissueParameter]:
        """The estimated parameters with their priors; the default median is the scene's value."""
        return [
            TissueParameter(p.targets, name=p.name, prior=self._prior(p, scene))
            for p in self.parameters or default_parameters(scene)
        ]

    def _prior(self, parameter: Estimated, scene: Scene) -> Prior | None:
        log_sd = parameter.log_sd or self.log_sd
        if parameter.median is not None:
            return Prior(float(parameter.median), log_sd)
        value = scene_value(scene, parameter.targets[0])
        return None if value is None else Prior(value, log_sd)


def default_parameters(scene: Scene) -> list[Estimated]:
    """One viscosity; ``mu_fibre`` and ``E_fibre`` of each layer with fibres, ``E`` of each without."""
    layers = list(scene.tissue)
    found = [Estimated(targets=tuple(f"{name}.viscosity" for name in layers), name="viscosity")]
    if not all((scene_value(scene, f"{name}.viscosity") or 0) > 0 for name in layers):
        found = []
    fibrous = [name for name in layers if scene_value(scene, f"{name}.mu_fibre")]
    found += [Estimated(targets=(f"{name}.mu_fibre",)) for name in fibrous]
    found += [Estimated(targets=(f"{name}.E_fibre",)) for name in fibrous]
    return found + [Estimated(targets=(f"{name}.E",)) for name in layers if name not in fibrous]


def scene_value(scene: Scene, target: str) -> float | None:
    """The scene's value at ``layer.field`` or ``layer.side.field``; None if there is none, for which the
    estimator has the better error message."""
    layer, _, field = target.rpartition(".")
    name, _, side = layer.partition(".")
    tissue: Any = scene.tissue.get(name)
    holder = getattr(tissue, side, None) if side else None
    value = getattr(holder, field, None)
    if value is None:
        value = getattr(tissue, field, None)
    return float(value) if isinstance(value, int | float) and value > 0 else None
