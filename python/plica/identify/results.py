"""Write and read the results of an identification: posterior.h5 and posterior.csv."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica._engine import build_info
from plica.errors import InvalidInput, Named
from plica.identify.estimator.iterates import Iterates
from plica.identify.estimator.posterior import FOLLOWED, Posterior
from plica.identify.estimator.wording import posterior_table, posterior_warnings
from plica.identify.likelihood.noise_levels import Noise
from plica.identify.likelihood.residuals import ResidualTest
from plica.scene.scene import Scene
from plica.storage.files import replaced, storage_errors
from plica.storage.hdf5 import create, put, put_text, set_text
from plica.storage.stored import Stored

__all__ = ["Identification", "Identified", "Picture", "load", "store"]

Floats = NDArray[np.float64]

_HINT = "Copy it again from where it is whole, or make it again (plica identify --resume)"
_UNITS = {
    "posterior/mean": "log of the unit, or the unit",
    "posterior/prior_mean": "log of the unit, or the unit",
    "posterior/derived/median": "each the one of posterior/units",
    "posterior/derived/interval": "each the one of posterior/units",
    "recording/start": "px: column, row",
    "recording/place": "m",
    "recording/observed": "px: right, down",
    "recording/predicted": "px: right, down",
    "recording/sd": "px",
    "recording/pressures": "Pa",
    "recording/heights": "m",
}  # other quantities are dimensionless


@dataclass(frozen=True)
class Picture:
    """The observed motion of the tissue and the model's prediction of it."""

    name: str
    kind: str
    frame_rate: float
    """[Hz]"""
    first: int
    """Index of the first frame of the recording that is used."""
    lead: int
    """Number of missing frames before it."""
    spacing: float
    """[px] between points"""
    correlation: float | None
    """[px] over which the flow's error is correlated; None: unknown"""
    start: Floats
    """(r, 2) px: column and row in the first frame"""
    place: Floats
    """(r, 3) m in the mesh at rest"""
    observed: Floats
    """(N, r, 2) px a frame, right and down; nan where missing"""
    predicted: Floats
    """(N, r, 2) px a frame, at the last point of the iteration, with the expected unknown pressures"""
    whitened: Floats
    """(N, r, 2) residuals that are independent and of variance 1 if the model holds"""
    sd: Floats
    """(N, r) px, as stated"""
    closed: NDArray[np.bool_]
    """(N)"""
    pressures: Floats
    """(N, q) Pa, expected values of the unknown pressures; those of collisions last"""
    heights: Floats
    """(q) m"""
    known_drive: bool

    @property
    def time(self) -> Floats:
        """(N) s from the first frame used to the end of each frame's motion."""
        return (np.arange(len(self.observed)) + 1 - self.lead) / self.frame_rate

    @property
    def explained(self) -> float:
        """1 - mean square of observed - predicted over that of observed."""
        left = np.nansum((self.observed - self.predicted) ** 2)
        return float(1 - left / np.nansum(self.observed**2))

    @property
    def carried(self) -> bool:
        """Whether the model explains half of the motion or more; else the data support no estimate."""
        return self.explained >= FOLLOWED


@dataclass(frozen=True)
class Identified:
    """A parameter's posterior (a `plica.measures.measured.Measured`).

    Attributes
    ----------
    name : str
    value : float
        Median, in `unit`.
    unit : str
    interval : (float, float) or None
        95 %; None where the recording does not answer.
    cautions : tuple of str
        Warnings of this parameter, and of all.
    """

    name: str
    value: float
    unit: str
    interval: tuple[float, float] | None
    cautions: tuple[str, ...]
    spread: None = None

    @property
    def uncertainty(self) -> float | None:
        """Half of the interval; None without one."""
        return None if self.interval is None else 0.5 * (self.interval[1] - self.interval[0])

    @property
    def uncertainty_source(self) -> str:
        """What the uncertainty is of; empty without one."""
        return (
            "" if self.interval is None else "95 % interval of the posterior, with the shift between meshes"
        )


@dataclass(frozen=True)
class Identification:
    """The results in the directory of an identification."""

    directory: Path
    posterior: Posterior
    picture: Picture
    iterations: Floats
    """(i, 2) log posterior density and step (posterior sd) of each point of the scene's mesh; densities of
    start 0 use the learned error of the flow"""
    starts: NDArray[np.int_]
    """(i) start number of each of these; 0: the estimate with the learned error of the flow"""
    settings: dict[str, Any]
    scene_text: str

    @cached_property
    def measures(self) -> Mapping[str, Identified]:
        """By name: each parameter's median, its 95 % interval and what speaks against it."""
        posterior, warnings = self.posterior, self.warnings
        found = {}
        for name, unit, value, ends in zip(
            posterior.names, posterior.units, posterior.median, posterior.interval(), strict=True
        ):
            others = [f'"{other}"' for other in posterior.names if other != name]
            own = tuple(
                text for text in warnings if f'"{name}"' in text or not any(other in text for other in others)
            )
            interval = (float(ends[0]), float(ends[1])) if posterior.answered else None
            found[name] = Identified(name, float(value), unit, interval, own)
        return Named("Identification.measures", found.items())

    @property
    def table(self) -> str:
        """The posterior's table as text, one line per parameter."""
        return posterior_table(self.posterior)

    @property
    def warnings(self) -> list[str]:
        """What to know before trusting the table."""
        return posterior_warnings(self.posterior)


def store(directory: Path, posterior: Posterior, picture: Picture, iterates: Iterates, scene: Scene) -> None:
    """Write posterior.h5 and posterior.csv, each completely or not at all."""

    def write(draft: Path) -> None:
        with create(draft) as file:
            put_text(file, "plica_version", build_info()["version"])
            put_text(file, "settings", json.dumps(iterates.inputs.settings))
            put_text(file, "scene", scene.text())
            _fill(file, "posterior", _plain(posterior))
            derived = {
                "median": posterior.median,
                "interval": np.where(posterior.answered, posterior.interval(), np.nan),
                "sd": np.where(posterior.refused, np.nan, posterior.sd),
                "correlation": posterior.correlation,
                "covariance": posterior.covariance,
                "information_eigenvalues": posterior.information_eigenvalues,
                "weakest_direction": posterior.weakest_direction,
                "warnings": posterior_warnings(posterior),
            }
            _fill(file, "posterior/derived", derived)
            _fill(file, "recording", {f.name: getattr(picture, f.name) for f in fields(picture)})
            points = iterates.points["scene"]
            history = {
                "value_and_step": np.array([(p["value"], p["step"]) for p in points]),
                "start": np.array([p["start"] for p in points]),
            }
            _fill(file, "iterations", history)

    replaced(directory / "posterior.h5", write)
    replaced(directory / "posterior.csv", lambda draft: _write_csv(draft, posterior))


def load(directory: str | Path) -> Identification:
    """The identification in a directory; raises InvalidInput if there is none, or it has not finished."""
    where = Path(directory)
    path = where / "posterior.h5"
    if not path.exists():
        resumed = (where / "iterates.json").exists()
        raise InvalidInput(
            f"{where}: the identification has not finished. Continue it with --resume."
            if resumed
            else f"{where}: has no posterior.h5; must be the directory of an identification."
        )
    with storage_errors(path, "read"), Stored(path, hint=_HINT) as file:
        if not (file.is_group("posterior") and file.is_group("recording")):
            raise InvalidInput(f"{path}: is not a result of plica identify; must be one.")
        settings, scene = json.loads(file.text("settings")), file.text("scene")
        points = _read(file, "iterations")
        return Identification(
            where,
            _posterior(_read(file, "posterior")),
            Picture(**{"correlation": None, **_read(file, "recording")}),
            points["value_and_step"],
            points["start"],
            settings,
            scene,
        )


def _plain(posterior: Posterior) -> dict[str, Any]:
    found = {f.name: getattr(posterior, f.name) for f in fields(posterior)}
    return found | {"noise": asdict(posterior.noise), "residuals": asdict(posterior.residuals)}


def _posterior(stored: dict[str, Any]) -> Posterior:
    stored = {f.name: stored[f.name] for f in fields(Posterior) if f.name in stored}
    for name in ("names", "units", "notes"):
        stored[name] = tuple(stored.get(name, ()))
    noise: dict[str, Any] = stored["noise"]
    noise |= {name: tuple(noise.get(name, ())) for name in ("at_least", "at_most")}
    stored["noise"], stored["residuals"] = Noise(**noise), ResidualTest(**stored["residuals"])
    stored["fed_back"] = bool(stored["fed_back"])
    return Posterior(**stored)


def _fill(file: Any, group: str, values: dict[str, Any]) -> None:
    """Write numbers and strings as attributes, lists of strings and arrays as data sets; None is omitted."""
    owner = file.require_group(group)
    for name, value in values.items():
        path = f"{group}/{name}"
        if value is None:
            continue
        if isinstance(value, dict):
            _fill(file, path, value)
        elif isinstance(value, str):
            set_text(owner, name, value)
        elif isinstance(value, bool | int | float):
            owner.attrs[name] = value
        else:
            put(file, path, value, _UNITS.get(path, "1"))


def _read(file: Stored, group: str) -> dict[str, Any]:
    """What `_fill` wrote, without what is derived of it."""
    found: dict[str, Any] = {
        name: value.item() if hasattr(value, "item") else value
        for name, value in file.attributes(group).items()
    }
    for name in file.names(group):
        path = f"{group}/{name}"
        if name == "derived":
            continue
        if file.is_group(path):
            found[name] = _read(file, path)
        elif file.data(path).dtype.kind == "S":
            found[name] = file.texts(path)
        else:
            found[name] = file.read(path)
    return found


_COLUMNS = (
    "parameter",
    "unit",
    "median",
    "sd_log",
    "low_95",
    "high_95",
    "prior_low_95",
    "prior_high_95",
    "sd_over_prior_sd",
    "mesh_shift_in_sd",
)


def _write_csv(path: Path, posterior: Posterior) -> None:
    """One row per parameter, in its unit; sd_log is the sd of the logarithm, or of an angle itself. A refused
    sd is an empty cell, and so is an interval that is not `answered`."""
    prior, interval, shift = posterior.prior_interval(), posterior.interval(), posterior.shift_in_sd
    share = posterior.sd / posterior.prior_sd
    with path.open("w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out)
        rows.writerow(_COLUMNS)
        for j, name in enumerate(posterior.names):
            sd = "" if posterior.refused[j] else float(posterior.sd[j])
            numbers = [float(value) for value in (*interval[j], *prior[j], share[j])]
            cells = numbers if posterior.answered else ["", "", *numbers[2:]]
            moved = "" if shift is None else float(shift[j])
            row = [name, posterior.units[j], float(posterior.median[j]), sd, *cells, moved]
            rows.writerow(row)
