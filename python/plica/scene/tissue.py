"""Tissue of one layer, and values that differ on one side."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from plica.scene.part import Part, engine_default, problem
from plica.units import Density, Number, Pressure, Viscosity

__all__ = ["Tissue", "TissueSide"]

_FIBRE_FIELDS = ("nu_fibre", "mu_fibre", "mu_transverse", "fibre")


class TissueSide(Part):
    """Values that differ on one side; fields as in `Tissue`."""

    E: Annotated[Pressure, Field(gt=0)] | None = None
    nu: Number | None = None
    E_fibre: Annotated[Pressure, Field(gt=0)] | None = None
    nu_fibre: Number | None = None
    mu_fibre: Annotated[Pressure, Field(gt=0)] | None = None
    mu_transverse: Annotated[Pressure, Field(gt=0)] | None = None
    fibre: tuple[Number, Number, Number] | None = None
    stiffening: Annotated[Number, Field(ge=0, le=100)] | None = None
    matrix_stiffening: Annotated[Number, Field(ge=0, le=100)] | None = None
    density: Annotated[Density, Field(gt=0)] | None = None
    viscosity: Annotated[Viscosity, Field(ge=0)] | None = None


class Tissue(Part):
    """Elastic tissue with Kelvin-Voigt viscosity; transversely isotropic if `E_fibre` is given. Without
    `posture` and `strain` it is linear.

    A layer of a scene may use the tissue of a preset, ``cover = "thesis_corrected"``, or change some of its
    values, ``cover = {preset = "thesis_corrected", viscosity = "0.2 Pa s"}``; the presets are
    "thesis_corrected" and "thesis".
    """

    E: Annotated[Pressure, Field(gt=0)]
    """[Pa] Young's modulus, across the fibre."""
    nu: Number
    """[-] Poisson's ratio, across the fibre."""
    E_fibre: Annotated[Pressure, Field(gt=0)] | None = None
    """[Pa] Young's modulus along the fibre (E')."""
    nu_fibre: Number | None = None
    """[-] Poisson's ratio along the fibre (nu')."""
    mu_fibre: Annotated[Pressure, Field(gt=0)] | None = None
    """[Pa] Shear modulus along the fibre (mu')."""
    mu_transverse: Annotated[Pressure, Field(gt=0)] | None = None
    """[Pa] Shear modulus across the fibre; default: E / (2 (1 + nu)), for isotropy in that plane."""
    fibre: tuple[Number, Number, Number] | None = None
    """[-] Direction, of any length; default: y, anteroposterior. Of the part in the file, if `mesh.mirror` is
    given."""
    stiffening: Annotated[Number, Field(ge=0, le=100)] = 0.0
    """[-] How fast fibres stiffen as a posture, or motion at finite strain, stretches them: what `E_fibre`
    bears along them rises by exp(stiffening (lambda^2 - 1)^2), lambda their stretch. Without `posture` and
    `strain` it does nothing."""
    matrix_stiffening: Annotated[Number, Field(ge=0, le=100)] = 0.0
    """[-] How fast what lies between the fibres stiffens, in all directions, at a posture or in motion at
    finite strain: its stress rises by a factor of 1 + matrix_stiffening w, w half the square of a shear, or
    of a stretch lambda at constant volume (lambda^2 + 2 / lambda - 3) / 2. Without `posture` and `strain` it
    does nothing."""
    density: Annotated[Density, Field(gt=0)] = Field(default_factory=engine_default("Material", "density"))
    """[kg/m^3] Mass per volume."""
    viscosity: Annotated[Viscosity, Field(ge=0)] = Field(
        default_factory=engine_default("Material", "viscosity")
    )
    """[Pa s] The viscous stress is this times the strain-rate tensor."""
    left: TissueSide | None = None
    """Values that differ on the left fold, in a larynx x < 0."""
    right: TissueSide | None = None
    """Values that differ on the right fold, in a larynx x > 0."""

    def on(self, side: Literal["none", "left", "right"]) -> Tissue:
        """The tissue of one side, without overrides."""
        own: dict[str, Any] = self.model_dump(exclude={"left", "right"}, exclude_none=True)
        override = getattr(self, side) if side != "none" else None
        if override is not None:
            own |= override.model_dump(exclude_none=True)
        return Tissue(**own)

    @model_validator(mode="after")
    def _is_positive_definite(self) -> Self:
        """The bounds of both material laws; Paper A, Eq. (6): E'(1 - nu) - 2 nu'^2 E > 0."""
        if self.left is None and self.right is None:
            _check(self)
        else:
            for side in ("none", "left", "right"):
                own = self.model_dump(exclude={"left", "right"}, exclude_none=True)
                override = getattr(self, side, None)
                changed = override.model_dump(exclude_none=True) if override is not None else {}
                _check(Tissue.model_construct(**(own | changed)), () if side == "none" else (side,), changed)
        return self


def _check(tissue: Tissue, path: tuple[str, ...] = (), changed: dict[str, Any] | None = None) -> None:
    """Raise unless the tissue is positive definite; `changed` are the fields of the side at `path`."""

    def fail(field: str, value: object, relation: str) -> Exception:
        return problem(relation, *(path if changed and field in changed else ()), field, value=value)

    if not -1 < tissue.nu < 1:
        raise fail("nu", tissue.nu, "must be > -1 and < 1 (isotropic tissue: < 0.5).")
    if tissue.E_fibre is None:
        for field in _FIBRE_FIELDS:
            if getattr(tissue, field) is not None:
                raise fail(
                    field, getattr(tissue, field), "must be left out without E_fibre (isotropic tissue)."
                )
        if tissue.stiffening:
            raise fail(
                "stiffening",
                tissue.stiffening,
                "must be 0 without E_fibre: its fibres are what stiffens. Use matrix_stiffening.",
            )
        if tissue.nu >= 0.5:
            raise fail(
                "nu",
                tissue.nu,
                "must be < 0.5 in isotropic tissue. Give E_fibre if the tissue has fibres.",
            )
        return
    for field in ("nu_fibre", "mu_fibre"):
        if getattr(tissue, field) is None:
            raise problem(f"{field} is missing; tissue with E_fibre needs it.", *path)
    if tissue.fibre is not None and not any(tissue.fibre):
        raise fail("fibre", list(tissue.fibre), "must not be zero.")
    assert tissue.nu_fibre is not None
    bound = 1 - 2 * tissue.nu_fibre**2 * tissue.E / tissue.E_fibre
    if tissue.nu >= bound:
        raise fail(
            "nu",
            tissue.nu,
            f"must be < {bound:.4g} = 1 - 2 nu_fibre^2 E / E_fibre, for a positive definite stiffness, with "
            f"nu_fibre = {tissue.nu_fibre:g}, E = {tissue.E:g} Pa and E_fibre = {tissue.E_fibre:g} Pa.",
        )
