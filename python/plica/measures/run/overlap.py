"""Folds that pass through each other, as they do without contact."""

from __future__ import annotations

import numpy as np

from plica.measures.caution import Caution
from plica.measures.record import Floats
from plica.measures.run.folds import half_widths, midline
from plica.measures.run.run_data import RunData, reached
from plica.units import two_digits

__all__ = ["overlapping_folds"]

_DEEP = (
    1e-3  # of the folds' length, as far as contact holds surfaces apart: of less, lines between points tell
)


def overlapping_folds(run: RunData) -> Caution | None:
    """Without contact, the folds pass through each other in their middle plane, by more than a thousandth of
    their length. The glottal area does not show it: it counts an overlap in one place as closed. Folds that
    overlap only in front of that plane or behind it are not seen.
    """
    time, waveforms = reached(run)
    if "contact_rows" in waveforms or "coronal_right" not in waveforms:
        return None
    deep = _DEEP * 2 * float(np.max(run.section_major, initial=0.0))
    # Points at one height at rest, which may be at others now: those of their steps are looked at in full.
    doubted = np.flatnonzero(np.add(*half_widths(waveforms)).min(axis=1) < -deep)
    right, left = (
        np.asarray(waveforms[f"coronal_{side}"][doubted], dtype=float) for side in ("right", "left")
    )
    toward_right = midline(waveforms)[1]
    depths = np.array([_overlap(*lines, toward_right) for lines in zip(right, left, strict=True)])
    steps = doubted[depths > deep]
    if not steps.size:
        return None
    return Caution(
        "overlapping_folds",
        f"The folds passed through each other in {two_digits(100 * steps.size / time.size)} % of the steps, "
        f"first at {1e3 * time[steps[0]]:.3g} ms, in their middle plane by up to {1e3 * depths.max():.2g} "
        "mm: the scene has no contact.",
        "Add [contact], whose force also sends them back; or let them not meet: a wider glottis, less "
        "pressure.",
    )


def _overlap(right: Floats, left: Floats, toward_right: float) -> float:
    """How far (m) lines (s, 3) of the folds are in each other at most, at one height; < 0: apart."""
    (z, x), (other_z, other_x) = (_by_height(line, toward_right) for line in (right, left))
    beyond = np.interp(z, other_z, other_x, left=-np.inf, right=-np.inf) - x
    before = other_x - np.interp(other_z, z, x, left=np.inf, right=np.inf)
    return float(max(beyond.max(), before.max()))


def _by_height(line: Floats, toward_right: float) -> tuple[Floats, Floats]:
    """Its heights, ascending, and how far to the right (m) it is there."""
    line = line[np.argsort(line[:, 2], kind="stable")]
    return line[:, 2], toward_right * line[:, 0]
