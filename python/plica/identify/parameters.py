"""The estimated tissue parameters: positive numbers, their priors, and their effect on the stiffness."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, nearest, one_of

__all__ = ["Prior", "TissueParameter", "TissueParameters"]

FIELDS = {
    "E": "Pa",
    "nu": "",
    "E_fibre": "Pa",
    "nu_fibre": "",
    "mu_fibre": "Pa",
    "mu_transverse": "Pa",
    "viscosity": "Pa s",
}
"""Fields of a scene's tissue that may be estimated, and their units."""
_OF_ENGINE = {"mu_transverse": "mu"}
"""Fields that `plica._engine.TransverselyIsotropic` calls otherwise."""
WIDEST = 10.0
"""Largest log_sd of a prior: a 95 % range of a factor of 3e8 up or down."""


@dataclass(frozen=True)
class Prior:
    """A log-normal prior: log theta is Gaussian with mean ``log(median)`` and standard deviation `log_sd`."""

    median: float
    """In the parameter's unit, > 0."""
    log_sd: float = 1.0
    """[-] > 0; 0.7 means within a factor of four with 95 % probability."""

    def __post_init__(self) -> None:
        for name, value in (("median", self.median), ("log_sd", self.log_sd)):
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"Prior: {name} = {value:g}; must be > 0 and finite.")
        if self.log_sd > WIDEST:
            raise InvalidInput(f"Prior: log_sd = {self.log_sd:g}; must be <= {WIDEST:g}.")


@dataclass(frozen=True)
class TissueParameter:
    """One positive parameter, and the fields of the tissue that it sets."""

    targets: tuple[str, ...]
    """``"layer.field"`` or ``"layer.side.field"``. The parameter is the value of the first; the others keep
    their ratio to it in the scene. A layer without a side means both sides."""
    prior: Prior | None = None
    """Default: the scene's value as median, and a `log_sd` of 1."""
    name: str = ""
    """Default: the first target."""

    def __post_init__(self) -> None:
        if not self.targets:
            raise InvalidInput("TissueParameter: number of targets = 0; must be >= 1.")
        for target in self.targets:
            layer, _, field = target.rpartition(".")
            if not layer or field not in FIELDS:
                hint = nearest(target, [f"{layer}.{known}" for known in FIELDS]) if layer else ""
                if field == "density":
                    hint = (
                        " Scaling mass and stiffness together changes no motion, so it cannot be estimated."
                    )
                if layer and field == "mu":
                    hint = f' Did you mean "{layer}.mu_transverse", as in scenes?'
                raise InvalidInput(
                    f'TissueParameter: target = "{target}"; must be a layer and a field, "cover.E", with a '
                    f"field of {', '.join(FIELDS)}.{hint}"
                )
        if not self.name:
            object.__setattr__(self, "name", self.targets[0])

    @property
    def unit(self) -> str:
        """Unit of the parameter."""
        return FIELDS[self.targets[0].rpartition(".")[2]]


@dataclass(frozen=True)
class _Setting:
    """One field of one material that is set to ratio times the value of a parameter."""

    parameter: int
    material: int
    field: str
    ratio: float


class TissueParameters:
    """The map from log theta (p) to the coefficients of stiffness and viscosity, with its derivatives.

    Parameters
    ----------
    materials, names : as `plica.runs.materials.materials_of` gives them
    parameters : sequence of TissueParameter or str
        A string is a parameter with that one target.
    """

    def __init__(
        self,
        materials: Sequence[_engine.Material],
        names: Sequence[str],
        parameters: Sequence[TissueParameter | str],
    ) -> None:
        if not parameters:
            raise InvalidInput("TissueParameters: number of parameters = 0; must be >= 1.")
        self._materials = list(materials)
        self.parameters = tuple(TissueParameter((p,)) if isinstance(p, str) else p for p in parameters)
        self._settings: list[_Setting] = []
        taken: dict[tuple[int, str], str] = {}
        medians = []
        for j, parameter in enumerate(self.parameters):
            base = None
            for target in parameter.targets:
                layer, _, field = target.rpartition(".")
                for i in _materials_of_layer(layer, names):
                    if (i, field) in taken:
                        raise InvalidInput(
                            f'TissueParameters: "{target}" is set by "{taken[i, field]}" and by '
                            f'"{parameter.name}"; must be set by one parameter.'
                        )
                    taken[i, field] = parameter.name
                    value = _field(self._materials[i], field, f"{names[i]}.{field}")
                    base = value if base is None else base
                    self._settings.append(_Setting(j, i, field, value / base))
            assert base is not None
            medians.append(parameter.prior.median if parameter.prior else base)
        repeated = {p.name for p in self.parameters if sum(p.name == q.name for q in self.parameters) > 1}
        if repeated:
            raise InvalidInput(f'TissueParameters: name = "{min(repeated)}" is given twice; must be unique.')
        self.prior_mean = np.log(medians)
        """(p) of log theta."""
        self.prior_sd = np.array([p.prior.log_sd if p.prior else 1.0 for p in self.parameters])
        """(p) of log theta."""

    @property
    def names(self) -> tuple[str, ...]:
        """(p)"""
        return tuple(p.name for p in self.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        """(p)"""
        return tuple(p.unit for p in self.parameters)

    def materials(self, log_theta: NDArray[np.float64]) -> list[_engine.Material]:
        """The materials at log theta; raises InvalidInput if one is not positive definite."""
        theta = np.exp(log_theta)
        changes: dict[int, dict[str, float]] = {}
        for s in self._settings:
            changes.setdefault(s.material, {})[s.field] = s.ratio * float(theta[s.parameter])
        made = [_changed(m, changes.get(i, {})) for i, m in enumerate(self._materials)]
        for i, material in enumerate(made):
            material.validate(f"tissue {i}")
        return made

    def coefficients(
        self, log_theta: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Coefficients of stiffness (g, 6) Pa and viscosity (g) Pa s, and their derivatives with respect to
        log theta, (p, g, 6) and (p, g)."""
        materials = self.materials(log_theta)
        stiffness = np.array([_engine.stiffness_coefficients(m) for m in materials])
        viscosity = np.array([m.viscosity for m in materials])
        d_stiffness = np.zeros((len(self.parameters), *stiffness.shape))
        d_viscosity = np.zeros((len(self.parameters), len(materials)))
        for s in self._settings:
            material = materials[s.material]
            value = _field(material, s.field, s.field)
            if s.field == "viscosity":
                d_viscosity[s.parameter, s.material] += value
            else:
                d_stiffness[s.parameter, s.material] += value * _engine.stiffness_derivative(
                    material, _OF_ENGINE.get(s.field, s.field)
                )
        return stiffness, viscosity, d_stiffness, d_viscosity


def _materials_of_layer(layer: str, names: Sequence[str]) -> list[int]:
    found = [i for i, name in enumerate(names) if name == layer or name.startswith(layer + ".")]
    if not found:
        raise InvalidInput(
            f'TissueParameters: layer = "{layer}"; must be '
            f"{one_of(list(names))}.{nearest(layer, list(names))}"
        )
    return found


def _field(material: _engine.Material, field: str, where: str) -> float:
    holder: Any = material if field == "viscosity" else material.elasticity
    value = getattr(holder, _OF_ENGINE.get(field, field), None)
    if value is None:
        raise InvalidInput(
            f'TissueParameters: "{where}" is not set in the scene; must be a field of its tissue.'
        )
    if not value > 0:
        raise InvalidInput(
            f"TissueParameters: {where} = {value:g}; must be > 0, as its logarithm is estimated."
        )
    return float(value)


def _changed(material: _engine.Material, fields: dict[str, float]) -> _engine.Material:
    if not fields:
        return material
    law = material.elasticity
    own = {name: getattr(law, name) for name in type(law)._defaults}
    own |= {_OF_ENGINE.get(name, name): value for name, value in fields.items() if name != "viscosity"}
    return _engine.Material(
        type(law)(**{name: value for name, value in own.items() if value is not None}),
        density=material.density,
        viscosity=fields.get("viscosity", material.viscosity),
    )
