"""From a prephonatory frame to the larynx of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.camera.pose import Camera
from plica.errors import InvalidInput
from plica.larynx_fit.contour import Contour, glottal_contour
from plica.larynx_fit.cross_section import CrossSection
from plica.larynx_fit.distances import ContourError, contour_error
from plica.larynx_fit.edge import MeshSeen, glottal_edge
from plica.larynx_fit.section_fit import fit_cross_section
from plica.larynx_fit.settings import FitSettings
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.parts import Larynx, LarynxOptions
from plica.scene.mesh.summary import dihedral_angles, quality
from plica.scene.toml_text import toml_line

__all__ = ["LarynxFit", "MeshQuality", "fit_larynx", "larynx_of"]

Floats = NDArray[np.float64]
_LARGEST_EDGE_ERROR = 0.5  # of the half-width, beyond which there is a warning


@dataclass(frozen=True)
class MeshQuality:
    """The worst cells of a mesh, as `plica mesh` prints them."""

    tetrahedra: int
    nodes: int
    least_dihedral: float
    """Degrees, of the corners."""
    least_mean_ratio: float
    """1: regular."""
    least_jacobian: float
    """Smallest det dx/dxi, relative to the straight cell's; 1 for linear tetrahedra."""


@dataclass(frozen=True)
class LarynxFit:
    """A larynx fitted to a frame.

    Attributes
    ----------
    frame : (h, w) grey, or None
    contour : Contour
    section : CrossSection
        The geometry of Paper D, Fig. 1, and the camera.
    larynx : Larynx
        The mesh's part of a scene.
    edge : (k, 2) px
        Edge of the opening that the camera sees through the mesh.
    error : ContourError
        Between `edge` and the contour.
    """

    frame: Floats | None
    contour: Contour
    section: CrossSection
    larynx: Larynx
    seen: MeshSeen
    edge: Floats
    error: ContourError

    @property
    def mesh(self) -> _engine.TetMesh:
        """Nodes in m: x towards the right fold, y to anterior, z up, O at (0, 0)."""
        return self.seen.mesh

    @property
    def camera(self) -> Camera:
        """The camera of the frame."""
        return self.section.camera

    @cached_property
    def quality(self) -> MeshQuality:
        """Quality of the mesh."""
        points, cells = np.asarray(self.mesh.points), np.asarray(self.mesh.cells)
        ratios = _engine.least_jacobian_ratios(points, cells) if self.mesh.order == 2 else np.ones(1)
        return MeshQuality(
            len(cells),
            len(points),
            float(dihedral_angles(points, cells).min()),
            float(quality(points, cells).min()),
            float(np.min(ratios)),
        )

    @property
    def asymmetry(self) -> float:
        """(right - left) / (right + left) of the contour's areas beside the midline; 0 for the larynx. Unless
        the commissures are given the midline is fitted, and this is close to 0 for any folds."""
        return self.section.asymmetry(self.contour.points)

    @property
    def missed_width(self) -> float:
        """The 95th percentile of the contour error over the half-width, both in px."""
        return self.error.percentile_95 * self.camera.pixel / self.section.half_width

    @property
    def warnings(self) -> list[str]:
        """Warnings about the use of the larynx, as sentences."""
        if self.missed_width <= _LARGEST_EDGE_ERROR:
            return []
        return [
            f"The mesh's glottal edge misses the contour by {self.error.percentile_95:.1f} px (95th "
            f"percentile), {100 * self.missed_width:.0f} % of the half-width: this glottis is not elliptic. "
            "The length of the larynx can be used; its width differs from that in the frame, and flow and "
            "contact depend on it."
        ]

    def scene_text(self) -> str:
        """The mesh of a scene file, in SI units: one line at the file's top level."""
        return toml_line("mesh", self.larynx.model_dump(mode="json", exclude_none=True))


def fit_larynx(
    frame: Floats | None,
    mask: NDArray[np.bool_] | None = None,
    settings: FitSettings | None = None,
    /,
    **changed: Any,
) -> LarynxFit:
    """Fit the parametric larynx to the glottis of a prephonatory frame (docs/image_mesh.md).

    Parameters
    ----------
    frame : (h, w) grey, or None
        None: the mask's outline is the contour.
    mask : (h, w) bool, optional
        True in the glottis. None: the frame is segmented.
    settings : FitSettings, optional
    **changed
        Fields of `FitSettings`, instead of `settings`.

    Raises
    ------
    InvalidInput
        If the frame or its mask has no usable glottis (`glottal_contour`), a length is out of range, the
        parametric larynx, symmetric and elliptic, is too far from the contour, or the geometry cannot be
        meshed.

    Examples
    --------
    >>> fitted = fit_larynx(frame, mask, mm_per_px=0.06, l_occ="1 mm")
    >>> fitted.error.mean, fitted.quality.least_dihedral
    >>> scene = plica.Scene(fitted.larynx, tissue)
    """
    if settings is not None and changed:
        raise InvalidInput(
            f"Larynx fit: settings and {', '.join(changed)} are both given; must be one or the other."
        )
    chosen = settings or FitSettings(**changed)
    contour = glottal_contour(frame, mask)
    section = fit_cross_section(contour, chosen, contour.mask.shape)
    larynx = larynx_of(section)
    mesh = build_mesh(larynx, "Larynx fit")
    seen = MeshSeen(mesh, section.camera, chosen.heights[3], chosen.heights[4])
    edge = glottal_edge(seen, section)
    fitted = LarynxFit(
        None if frame is None else np.asarray(frame, dtype=float),
        contour,
        section,
        larynx,
        seen,
        edge,
        contour_error(contour.points, edge),
    )
    _check_error(fitted)
    return fitted


def larynx_of(section: CrossSection) -> Larynx:
    """The parametric larynx of a cross-section; cover and ligament lie along the glottis, z2 to z3."""
    settings = section.settings
    return Larynx(
        larynx=settings.larynx,
        order=settings.order,
        options=LarynxOptions(
            sections=section.sections,
            major=section.r_in,
            radius=section.r_out,
            layer_thickness=settings.metres("layer_thickness"),
            layers_from_section=2,
            layers_to_section=3,
        ),
    )


def _check_error(fitted: LarynxFit) -> None:
    """Raises InvalidInput if the 95th percentile of the contour error exceeds the limit in the settings."""
    ends = fitted.section.commissures
    length = float(np.hypot(*(ends[0] - ends[1])))
    limit = fitted.section.settings.largest_error * length
    if fitted.error.percentile_95 > limit:
        uneven = (
            "" if fitted.section.settings.commissures is None else f" (asymmetry {fitted.asymmetry:+.2f})"
        )
        raise InvalidInput(
            f"Larynx fit: contour error (95th percentile) = {fitted.error.percentile_95:.2f} px; must be <= "
            f"{limit:.2f} px, {fitted.section.settings.largest_error:g} of the visible length. The larynx is "
            f"elliptic and symmetric, and this glottis is not{uneven}. Are the commissures right? "
            "Otherwise use another frame."
        )
