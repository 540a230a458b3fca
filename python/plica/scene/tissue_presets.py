"""Tissue presets: the three layers of the thesis, as printed and as corrected (Paper A, Table III)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from plica.errors import nearest, one_of
from plica.scene.part import problem
from plica.scene.tissue import Tissue, TissueSide

__all__ = ["TISSUE_PRESETS", "by_name"]

_PRINTED: dict[str, dict[str, Any]] = {
    "body": {"E": 20e3, "nu": 0.45, "E_fibre": 40e3, "nu_fibre": 0.45, "mu_fibre": 30e3, "viscosity": 1.0},
    "ligament": {"E": 3e3, "nu": 0.58, "E_fibre": 20e3, "nu_fibre": 0.58, "mu_fibre": 40e3, "viscosity": 1.0},
    "cover": {"E": 1e3, "nu": 0.66, "E_fibre": 10e3, "nu_fibre": 0.66, "mu_fibre": 10e3, "viscosity": 0.4},
}
"""Pa, 1, Pa s."""
_DENSITY = 1020.0  # kg/m^3
_VISCOSITY_PERCENT = 35  # of the printed ones, which with the right mu prevent phonation (docs/phonation.md)


def _as_printed(row: dict[str, Any]) -> Tissue:
    # mu = E / (1 + nu), which is not isotropic across the fibre, as the thesis prints it
    return Tissue(**row, density=_DENSITY, mu_transverse=row["E"] / (1 + row["nu"]))


def _corrected(row: dict[str, Any]) -> Tissue:
    viscosity = _VISCOSITY_PERCENT * row["viscosity"] / 100  # 0.14 as it is written, not 0.35 * 0.4
    return Tissue(**(row | {"viscosity": viscosity}), density=_DENSITY)


TISSUE_PRESETS: Mapping[str, Mapping[str, Tissue]] = {
    "thesis_corrected": {layer: _corrected(row) for layer, row in _PRINTED.items()},
    "thesis": {layer: _as_printed(row) for layer, row in _PRINTED.items()},
}
"""Preset to layer to tissue. "thesis_corrected": Paper A, Table III, with mu = E / (2 (1 + nu)) across the
fibre and 0.35 of the viscosities; "thesis": as printed, where mu_transverse = E / (1 + nu) is a separate
value that does not change with E or nu."""


def by_name(tissue: object) -> object:
    """A scene's tissue with names of presets, of a layer or of all layers, replaced by their tissue."""
    if isinstance(tissue, str):
        return dict(_preset(tissue))
    if not isinstance(tissue, Mapping):
        return tissue
    return {layer: _layer(layer, given) for layer, given in tissue.items()}


def _layer(layer: object, given: object) -> object:
    """A layer's tissue; ``"thesis_corrected"`` is that of the preset, ``{preset =
    "thesis_corrected", E = ...}`` with another E."""
    if isinstance(given, str):
        return _preset_layer(layer, given)
    if isinstance(given, Mapping) and "preset" in given:
        base = _preset_layer(layer, given["preset"], "preset").model_dump(exclude_none=True)
        own = {name: value for name, value in given.items() if name != "preset"}
        if "mu_transverse" in base:
            _check_shear(own, base["mu_transverse"], str(layer))
        return base | own
    return given


def _check_shear(own: Mapping[str, Any], preset: float, *path: str) -> None:
    """Raise if E or nu changes, here or on a side, and the shear modulus that depends on them does not."""
    if ("E" in own or "nu" in own) and "mu_transverse" not in own:
        raise problem(
            f"must be given with E or nu: the preset's {preset:.4g} Pa belongs to its own E and nu "
            "(E / (1 + nu), as printed in the thesis).",
            "tissue",
            *path,
            "mu_transverse",
        )
    for side in ("left", "right"):
        given = own.get(side)
        changed = given.model_dump(exclude_none=True) if isinstance(given, TissueSide) else given
        if isinstance(changed, Mapping):
            _check_shear(changed, own.get("mu_transverse", preset), *path, side)


def _preset_layer(layer: object, name: object, *path: str) -> Tissue:
    layers = _preset(name, str(layer), *path)
    if layer not in layers:
        raise problem(
            f'must be left out: the preset "{name}" has {", ".join(layers)} only.',
            "tissue",
            str(layer),
            *path,
        )
    return layers[str(layer)]


def _preset(name: object, *path: str) -> Mapping[str, Tissue]:
    if not isinstance(name, str) or name not in TISSUE_PRESETS:
        raise problem(
            f"must be {one_of(TISSUE_PRESETS)}.{nearest(str(name), TISSUE_PRESETS)}",
            "tissue",
            *path,
            value=name,
        )
    return TISSUE_PRESETS[name]
