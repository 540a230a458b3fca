"""What a recording is identified with: what is estimated, which pressures act, where the camera stands."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from plica.errors import InvalidInput, SceneError
from plica.identify.parameters import FIELDS, WIDEST, Prior, TissueParameter
from plica.phonation.scene.part import Count, Part, problem
from plica.phonation.scene.problems import describe
from plica.phonation.scene.scene import Scene
from plica.units import Length, Number, Time, read_quantity

__all__ = ["Estimated", "Settings"]

Positive = Annotated[Number, Field(gt=0)]
LogSd = Annotated[Number, Field(gt=0, le=WIDEST)]
Share = Annotated[Number, Field(ge=0, le=1)]
Degrees = Annotated[Number, Field(gt=-90, lt=90)]
MOST_POINTS = 400
"""Each point costs two rows of every frame; beyond it they say the same again."""

MOST_STARTS = 18
"""As many as there are: the first, that again by parts of the recording, and 16 tissues of the prior."""


def _listed(value: object) -> object:
    return (value,) if isinstance(value, str) else value


Targets = Annotated[tuple[str, ...], BeforeValidator(_listed), Field(min_length=1)]


class Estimated(Part):
    """One positive number of the tissue and what was believed of it: ``"cover.mu_fibre"``, or a table."""

    targets: Targets
    """``"layer.field"`` or ``"layer.side.field"``; of several, all keep their ratio in the scene."""
    name: str = ""
    """Left out: the first target."""
    median: float | str | None = None
    """Of the prior, in SI or as text with a unit, ``"10 kPa"``; left out: the scene's value."""
    log_sd: LogSd | None = None
    """[-] Prior standard deviation of the logarithm; left out: that of the settings."""

    positional: ClassVar[tuple[str, ...]] = ("targets",)

    @model_validator(mode="after")
    def _a_number_of_its_unit(self) -> Self:
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
    """What a recording is identified with; the table ``[identify]`` of a settings file.

    Nothing of it is random: the same input gives the same estimate.
    """

    parameters: tuple[Annotated[Estimated, BeforeValidator(_as_table)], ...] = ()
    """What is estimated; left out: the viscosity of all layers together, ``mu_fibre`` and ``E_fibre`` of each
    layer with fibres, ``E`` of each without."""
    log_sd: LogSd = 0.7
    """[-] Prior standard deviation of log theta where a parameter has none of its own: 0.7 is a factor of
    four up or down, with 95 % probability."""

    surface: str | None = None
    """On which the pressures act; left out: that of the scene's airflow, or ``airway``."""
    seen: str | None = None
    """Surface that the camera sees; left out: `surface`."""
    heights: Annotated[tuple[Length, ...], Field(min_length=2)] | None = None
    """[m] z of the pressures, upward; each falls linearly to zero at the next ones. Left out: three, over the
    medial part of a larynx, over all of another surface."""
    drive: Path | None = None
    """CSV of the pressures that are known up to a factor: a column of times (s, 0 at the recording's first
    frame), then one a height (Pa). Left out: the unknown pressures do everything."""
    gain_sd: Annotated[Number, Field(ge=0)] = 0.3
    """[-] Prior standard deviation of the logarithm of that factor."""
    voiced: bool | None = None
    """Whether the folds' own motion makes the pressures that move them, as in a voice. Sd and intervals are
    then refused, as unknown pressures are taken for independent of the motion and from frame to frame. Left
    out: yes of a scene with an airflow, and of a larynx without `drive`."""
    closed_below: Share = 0.05
    """[-] Frames whose glottal area is less than this times the largest are closed: there unknown forces push
    apart what touches. 0: none."""

    first: Annotated[int, Field(ge=0)] = 0
    """First frame that is used."""
    last: Annotated[int, Field(ge=1)] | None = None
    """Last one; left out: the recording's."""
    from_rest: bool = False
    """Whether the first frame shows the tissue at rest. If not, points are placed by the mean of their paths,
    and unknown pressures bring the model into motion before the first frame."""
    lead: Annotated[Time, Field(gt=0, le=1)] = 0.005
    """[s] For how long, at least 16 frames, where the recording does not begin at rest. Nothing is believed
    of the size of these pressures: the longer, the more states they can make, and the less of the recording
    is left for the tissue."""

    spacing: Annotated[Number, Field(ge=1)] | None = None
    """[px] Between points; left out: as far as the flow's error is correlated, at least 8."""
    most_points: Annotated[int, Field(ge=1, le=MOST_POINTS)] = 120
    """Points are farther apart if there would be more."""
    points: Annotated[tuple[tuple[Number, Number], ...], Field(min_length=1)] | None = None
    """[px] Column and row in the first frame, instead of a grid."""
    sd: Positive | None = None
    """[px] Of the flow's error; left out: the recording's trust times `trust_factor`, else 0.1."""
    trust_factor: Annotated[Number, Field(ge=1)] = 10.0
    """[-] Trust maps are lower bounds of the error, six to fifteen times too small on synthetic folds."""

    fps: Positive | None = None
    """[Hz] Frame rate; left out: the recording's."""
    mm_per_px: Positive | None = None
    """[mm] Size of a pixel; left out: the recording's."""
    centre: tuple[Length, Length, Length] | None = None
    """[m] Place in the mesh that is in the middle of the picture; left out: the recording's, or so that the
    glottis of the picture lies on that of the mesh."""
    tilt: Degrees | None = None
    """[degrees] Camera towards +y."""
    lean: Degrees | None = None
    """[degrees] Camera towards +x."""
    roll: Annotated[Number, Field(ge=-360, le=360)] | None = None
    """[degrees] Turn of the picture, anticlockwise as seen; left out: so that the glottis is along y."""
    tilt_sd: Annotated[Number, Field(ge=0, lt=45)] | None = None
    """[degrees] Prior standard deviation of tilt and lean, which are then estimated; left out: 6, or 0 where
    the recording says where the camera stood."""

    coarser: str = "auto"
    """Scene file with a coarser mesh for the shift under refinement; ``"auto"``: made from the scene's where
    it can be (a block with half the divisions, a larynx of a coarser preset); ``"none"``: one mesh only,
    which a warning says."""
    max_iterations: Count = 40
    """Of Fisher scoring."""
    starts: Annotated[Count, Field(le=MOST_STARTS)] = 3
    """At most so many on the first mesh that is estimated. Where the residuals fail their test, which a false
    maximum's do, the estimate is begun again: on the first quarter of the recording, then on more of it, and
    after that likewise from other tissues of the prior, until two starts end at one place. 1: it never is."""

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
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise InvalidInput(f"{path}: cannot be read: {error.strerror}.") from None
        except ValueError as error:
            raise InvalidInput(f"{path.name}: not TOML: {error}.") from None
        if set(data) != {"identify"} or not isinstance(data["identify"], dict):
            raise InvalidInput(f"{path.name}: must have the table [identify], and nothing else.")
        table: dict[str, Any] = dict(data["identify"])
        if isinstance(table.get("drive"), str):
            table["drive"] = str((path.parent / table["drive"]).resolve())
        if isinstance(table.get("coarser"), str) and table["coarser"] not in ("auto", "none"):
            table["coarser"] = str((path.parent / table["coarser"]).resolve())
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise SceneError(describe(error, path.name, ("identify",))) from None

    def tissue_parameters(self, scene: Scene) -> list[TissueParameter]:
        """Those that are estimated, with their priors; the scene's values are the medians left out."""
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
    """One viscosity; shear and stretch along the fibre of each layer that has it, else its stiffness."""
    layers = list(scene.tissue)
    found = [Estimated(targets=tuple(f"{name}.viscosity" for name in layers), name="viscosity")]
    if not all((scene_value(scene, f"{name}.viscosity") or 0) > 0 for name in layers):
        found = []
    fibrous = [name for name in layers if scene_value(scene, f"{name}.mu_fibre")]
    found += [Estimated(targets=(f"{name}.mu_fibre",)) for name in fibrous]
    found += [Estimated(targets=(f"{name}.E_fibre",)) for name in fibrous]
    return found + [Estimated(targets=(f"{name}.E",)) for name in layers if name not in fibrous]


def scene_value(scene: Scene, target: str) -> float | None:
    """The scene's number at ``layer.field`` or ``layer.side.field``; None where there is none, which the
    estimator says better."""
    layer, _, field = target.rpartition(".")
    name, _, side = layer.partition(".")
    tissue: Any = scene.tissue.get(name)
    holder = getattr(tissue, side, None) if side else None
    value = getattr(holder, field, None)
    if value is None:
        value = getattr(tissue, "mu_transverse" if field == "mu" else field, None)
    return float(value) if isinstance(value, int | float) and value > 0 else None
