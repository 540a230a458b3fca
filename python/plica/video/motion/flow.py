"""Dense motion between two frames (docs/imaging.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica import _engine as engine
from plica.errors import InvalidInput, nearest, one_of
from plica.video.files.grey import depth, to_grey
from plica.video.motion.fold_edges import Folds

__all__ = [
    "PRESETS",
    "FlowOptions",
    "LightChange",
    "PairFlow",
    "WarpError",
    "endpoint_error",
    "flow",
    "warp_error",
]

FlowOptions = engine.FlowOptions

_GRADIENT: dict[str, Any] = {
    "data_scale": 0.01,
    "smooth_scale": 0.001,
    "data_penalty": "charbonnier",
    "smooth_penalty": "charbonnier",
    "fine_levels": 4,
}  # not brightness but its gradient stays as things move

PRESETS: Mapping[str, FlowOptions] = MappingProxyType(
    {
        "robust": FlowOptions(),
        "reference": FlowOptions(sweeps=40, light="none"),
        "video": FlowOptions(**_GRADIENT, smoothness=0.1, gradient_noise=1.0, warps=4),
        "thesis": FlowOptions(smoothness=0.5, sweeps=40, light="none"),
        "fast": FlowOptions(stages=2, warps=3),
        "gradient": FlowOptions(**_GRADIENT, smoothness=0.1, gradient_noise=0.3, spacing=1.5, warps=3),
    }
)
"""Named options. ``robust``: the default. ``reference``: Sun, Roth and Black's, solved to rest. ``video``:
for recordings, whose default it is, chosen on the synthetic glottis (docs/verification/recorded_flow.md): not
brightness but its gradient stays as things move. ``gradient``: the same for sharp pictures, whose finer grey
levels it follows (docs/imaging.md). ``thesis``: ``reference`` with the lambda of Paper C. ``fast``: one stage
of graduation and seven warps a level less. For ``reference`` and ``thesis``, as published, the light is
constant; for the others it may change."""


@dataclass(frozen=True)
class LightChange:
    """How the light changed from one frame to the next, docs/imaging.md, "Light that changes".

    What has the grey level I in the first frame has low + gain(x) (I - low) + offset in the second, with low
    the grey level that was stretched to 0.

    Attributes
    ----------
    gain : (rows, columns) float32
    offset : float
        Grey levels.
    change : float
        Mean of what the light adds to the frame where it counts, over its mean above `low`: 0.06 for
        a second frame that is 6 % brighter.
    """

    gain: NDArray[np.float32]
    offset: float
    change: float


@dataclass(frozen=True)
class PairFlow:
    """Motion from one frame to the next.

    Attributes
    ----------
    flow : (rows, columns, 2) float32
        (u, v) in px, u to the right and v downwards: what is at (x, y) in the first frame is at
        (x + u, y + v) in the second.
    residual : (rows, columns) float32
        second(x + u, y + v) - first(x, y) in the frames' grey levels, both in the light of the first; not a
        number where (x + u, y + v) lies outside the frame.
    round_trip : (rows, columns, 2) float32, or None
        Where (px) one lands from the start after going there and back again, f(x) + b(x + f(x)) with b the
        flow from the second frame to the first; not a number where x + f(x) lies outside the frame.
    intensity : (float, float)
        The grey levels that were stretched to 0 and 255.
    light : LightChange
    """

    flow: NDArray[np.float32]
    residual: NDArray[np.float32]
    round_trip: NDArray[np.float32] | None
    intensity: tuple[float, float]
    light: LightChange

    @property
    def mismatch(self) -> NDArray[np.float32] | None:
        """(rows, columns) px, length of the round trip's miss; None without one."""
        return None if self.round_trip is None else np.hypot(self.round_trip[..., 0], self.round_trip[..., 1])


def flow(
    first: ArrayLike,
    second: ArrayLike,
    *,
    preset: str = "robust",
    mask: ArrayLike | None = None,
    intensity: tuple[float, float] | None = None,
    round_trip: bool = False,
    folds: Folds | None = None,
    **options: Any,
) -> PairFlow:
    """Motion from `first` to `second`: Algorithm 1 of Paper C, completed and corrected (docs/imaging.md).

    Parameters
    ----------
    first, second : array
        Frames of one size with sides of at least 8 px: grey (rows, columns), or RGB(A) with a third axis. Of
        one depth: whole numbers of one type, or both floating-point.
    preset : str
        A name of `PRESETS`.
    mask : (rows, columns) bool, optional
        True where the frames say something: what is dark, saturated or a highlight is left out of the data
        term, and smoothness alone fills the flow in. On the grid of the first frame; taken for the way back
        too, so leave out what is useless in either.
    intensity : (low, high), optional
        Grey levels that are stretched to 0 and 255, the scale on which tau_D and lambda act. The default is
        the pair's own least and greatest; for the frames of one recording give one pair of levels for all.
    round_trip : bool
        Also find the way back, which takes as long again, and how well the two agree.
    folds : Folds, optional
        The glottis of both frames and its midline: where it opens from closed, or closes, the edges' motion
        enters the flow, and nothing is smooth across the midline.
    **options
        Fields of `FlowOptions` that differ from the preset's, such as ``smoothness=0.1``.

    Raises
    ------
    InvalidInput
        On sizes or depths that differ, sizes that are too small, values that are not finite, a mask without a
        pixel, a frame without contrast, and options out of range.
    SolveFailed
        Where `intensity` is so narrow that single precision overflows.
    """
    one, two = _grey_pair(first, second)
    chosen = _options(preset, options)
    _check_folds(folds, one)
    used = None if mask is None else _used(mask, one)
    low, high = _levels(one, two, intensity)
    _check_contrast(one, two, used)
    scale = np.float32(255 / (high - low))
    one, two = (one - np.float32(low)) * scale, (two - np.float32(low)) * scale
    there, terms, offset = _found(one, two, chosen, used, folds)
    gain = engine.light_gains(terms, *one.shape)
    light = LightChange(gain, offset / float(scale), _change(one, gain, offset, used))
    missed = None
    if round_trip:
        back, _, _ = _found(two, one, chosen, used, None if folds is None else folds.back)
        missed = engine.round_trip(there, back)
    residual = engine.flow_residual(one, (two - np.float32(offset)) / gain, there)
    return PairFlow(there, residual / scale, missed, (low, high), light)


def _found(
    one: NDArray[np.float32],
    two: NDArray[np.float32],
    options: FlowOptions,
    used: NDArray[np.float32] | None,
    folds: Folds | None,
) -> tuple[NDArray[np.float32], list[float], float]:
    """The flow, and the light's gain and offset, of grey levels that were stretched."""
    parting = None if folds is None else folds.parting(one, two)
    if parting is None:
        return engine.dense_flow(one, two, options, used)
    kept = ~parting.gone if used is None else (used > 0) & ~parting.gone
    return engine.dense_flow(
        one,
        two,
        options,
        kept.astype(np.float32),
        parting.sides,
        parting.measured,
        parting.displacement,
        parting.across,
    )


def _change(
    one: NDArray[np.float32], gain: NDArray[np.float32], offset: float, used: NDArray[np.float32] | None
) -> float:
    """What the light adds to the mean of the first frame, over that mean; 0 where the frame is black."""
    weight = np.ones_like(one) if used is None else used
    mean = float((weight * one).sum(dtype=float))
    added = float((weight * ((gain - 1) * one + np.float32(offset))).sum(dtype=float))
    return added / mean if mean > 0 else 0.0


def endpoint_error(found: ArrayLike, truth: ArrayLike) -> float:
    """Mean distance (px) of two (rows, columns, 2) flows over the pixels where `truth` is a number.

    Raises
    ------
    InvalidInput
        Where the sizes differ or `truth` knows no pixel.
    """
    one, other = np.asarray(found, float), np.asarray(truth, float)
    if one.shape != other.shape:
        raise InvalidInput(
            f"endpoint_error: the true flow is {_size(other)}; must be {_size(one)} like the flow found."
        )
    distance = np.hypot(*np.moveaxis(one - other, -1, 0))
    known = np.isfinite(other).all(axis=-1)
    if not known.any():
        raise InvalidInput("endpoint_error: the true flow is known at 0 pixels; must be at least 1.")
    return float(distance[known].mean())


@dataclass(frozen=True)
class WarpError:
    """Paper C's measure of a flow; it misleads: see :func:`warp_error`.

    Attributes
    ----------
    rms : float
        Root mean square over the centred 97 % of each side (94 % of the area), grey levels; Eq. (16).
    percent : (rows, columns)
        Of the second frame's grey level; Eq. (17); not a number where that is 0.
    """

    rms: float
    percent: NDArray[np.float64]


def warp_error(first: ArrayLike, second: ArrayLike, flow: ArrayLike) -> WarpError:
    """second(x) - first(x - u(x)): Paper C, Eqs. (15)-(17), by cubic splines.

    Given so that figures can be compared with the thesis's. It takes u, which belongs to x in the first
    frame, at x in the second, so it rewards smooth flow: the true flow may score worse than a wrong one.
    `PairFlow.residual` has not this fault. **Corrected**: Eq. (16) prints the first frame's time.

    Parameters
    ----------
    first, second : (rows, columns)
    flow : (rows, columns, 2) px
    """
    from scipy import ndimage

    one, two = (frame.astype(float) for frame in _grey_pair(first, second))
    u, v = np.moveaxis(np.asarray(flow, dtype=float), -1, 0)
    y, x = np.mgrid[0 : one.shape[0], 0 : one.shape[1]].astype(float)
    off = two - ndimage.map_coordinates(one, [y - v, x - u], order=3, mode="mirror")
    top, side = (round(0.015 * size) for size in one.shape)
    centre = off[top : one.shape[0] - top, side : one.shape[1] - side]
    percent = np.full(off.shape, np.nan)
    np.divide(100 * off, two, out=percent, where=two != 0)
    return WarpError(float(np.sqrt(np.mean(np.square(centre)))), percent)


def _grey_pair(first: ArrayLike, second: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Both in grey; InvalidInput where they cannot be two frames of one recording."""
    one, two = to_grey(first, name="first"), to_grey(second, name="second")
    if one.shape != two.shape:
        raise InvalidInput(
            f"flow: second is {_size(two)}; must be {_size(one)} like first. "
            "Frames of different recordings, or a region cut from one of them?"
        )
    if depth(first) != depth(second):
        raise InvalidInput(
            f"flow: second has {depth(second)}; must have {depth(first)} like first, or the same grey level "
            "means another brightness in each. Bring both to one scale."
        )
    for name, frame in (("first", one), ("second", two)):
        bad = np.argwhere(~np.isfinite(frame))
        if bad.size:
            row, column = bad[0]
            raise InvalidInput(
                f"flow: {name} has {frame[row, column]} at row {row}, column {column} "
                f"({len(bad)} such pixels); must be finite."
            )
    return one, two


def _check_contrast(
    one: NDArray[np.float32], two: NDArray[np.float32], used: NDArray[np.float32] | None
) -> None:
    """InvalidInput for a frame that says nothing of motion: one that is the same everywhere."""
    for name, frame in (("first", one), ("second", two)):
        seen = frame if used is None else frame[used > 0]
        if seen.min() == seen.max():
            where = "" if used is None else " that the mask leaves"
            raise InvalidInput(
                f"flow: every pixel of {name}{where} is {seen.flat[0]:g}; must differ somewhere. Is it blank?"
            )


def _options(preset: str, options: Mapping[str, Any]) -> FlowOptions:
    if preset not in PRESETS:
        raise InvalidInput(
            f'flow: preset = "{preset}"; must be {one_of(PRESETS)}.{nearest(str(preset), PRESETS)}'
        )
    fields = [name for name in dir(FlowOptions) if not name.startswith("_")]
    for name in options:
        if name not in fields:
            raise InvalidInput(
                f"flow: option {name} is unknown; must be {one_of(fields)}.{nearest(name, fields)}"
            )
    values = {name: getattr(PRESETS[preset], name) for name in fields} | dict(options)
    try:
        return FlowOptions(**values)
    except TypeError:
        wrong = ", ".join(f"{name} = {value!r}" for name, value in options.items())
        raise InvalidInput(f"flow: {wrong}; must be numbers, and names for the penalties.") from None


def _levels(
    one: NDArray[np.float32], two: NDArray[np.float32], intensity: tuple[float, float] | None
) -> tuple[float, float]:
    if intensity is None:
        return float(min(one.min(), two.min())), float(max(one.max(), two.max()))
    low, high = (float(level) for level in intensity)
    if not (np.isfinite([low, high]).all() and low < high):
        raise InvalidInput(f"flow: intensity = ({low:g}, {high:g}); must be (low, high) with low < high.")
    return low, high


def _used(mask: ArrayLike, frame: NDArray[np.float32]) -> NDArray[np.float32]:
    array = np.asarray(mask)
    if array.shape != frame.shape:
        raise InvalidInput(f"flow: mask has shape {array.shape}; must be {frame.shape} like the frames.")
    if array.dtype != np.bool_:
        raise InvalidInput(f"flow: mask has type {array.dtype}; must be bool, True where a pixel counts.")
    if not array.any():
        raise InvalidInput("flow: mask leaves 0 pixels; must leave at least 1.")
    return array.astype(np.float32)


def _check_folds(folds: Folds | None, frame: NDArray[np.float32]) -> None:
    if folds is None:
        return
    for name, mask in (("first", folds.first), ("second", folds.second)):
        if mask.shape != frame.shape or mask.dtype != np.bool_:
            raise InvalidInput(
                f"flow: the glottis of the {name} frame is {mask.dtype} of shape {mask.shape}; must be bool "
                f"of {frame.shape} like the frames."
            )


def _size(array: NDArray[Any]) -> str:
    return f"{array.shape[1]} x {array.shape[0]} px" if array.ndim >= 2 else f"of shape {array.shape}"
