"""A larynx for a scene from one picture of its folds (docs/image_mesh.md).

A prephonatory frame, its glottal contour, the cross-sectional geometry of Paper D, Fig. 1, and the parametric
larynx fitted to it, with the camera that ties its nodes to pixels::

    from plica import larynx_fit

    fitted = larynx_fit.fit_larynx(frame, mask, mm_per_px=0.06, l_occ="1 mm")
    print(fitted.error, fitted.quality)
    column_row = fitted.seen.pixels      # of the nodes fitted.seen.superior
    text = fitted.scene_text()           # the mesh of a scene
"""

from __future__ import annotations

from plica.larynx_fit.contour import Contour, glottal_contour
from plica.larynx_fit.cross_section import CrossSection, Rays
from plica.larynx_fit.distances import ContourError, contour_error
from plica.larynx_fit.edge import MeshSeen, glottal_edge
from plica.larynx_fit.fit import LarynxFit, MeshQuality, fit_larynx, larynx_of
from plica.larynx_fit.overlay import overlay
from plica.larynx_fit.section_fit import fit_cross_section
from plica.larynx_fit.settings import FitSettings

__all__ = [
    "Contour",
    "ContourError",
    "CrossSection",
    "FitSettings",
    "LarynxFit",
    "MeshQuality",
    "MeshSeen",
    "Rays",
    "contour_error",
    "fit_cross_section",
    "fit_larynx",
    "glottal_contour",
    "glottal_edge",
    "larynx_of",
    "overlay",
]
