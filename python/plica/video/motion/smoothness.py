"""lambda by three criteria that need no truth, beside the preset's: of a recording's own frames.

For every lambda of a ladder the flow of some pairs of frames is found, and of the pixels that show tissue its
residual r (grey levels) and the roughness of the flow, the root mean square of its differences between
neighbours. The three choose by

- discrepancy (Morozov 1966): the lambda with which r is as large as the frames' noise makes it;
- L-curve (Hansen 1992): the corner of log roughness over log r, where its curvature is largest;
- generalised cross-validation (Golub, Heath, Wahba 1979): the least mean r^2 / (1 - tr A / N)^2, A what the
  fit makes of the first frame's grey levels, its trace from one more flow, of a frame with white noise added
  (Girard 1989).

None knows the truth: none is used for anything. docs/verification/recorded_flow.md has how near they come.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.errors import InvalidInput, nearest, one_of
from plica.video.motion.flow import PRESETS, PairFlow, flow
from plica.video.motion.fold_edges import Folds

__all__ = ["CRITERIA", "LambdaReport", "SmoothnessPair", "lambda_report", "noise_level"]

Floats = npt.NDArray[np.float64]
Frame = npt.NDArray[np.floating]
Mask = npt.NDArray[np.bool_]

CRITERIA = ("discrepancy", "L-curve", "cross-validation")
_LADDER = 2.0 ** np.arange(-5, 6)  # of the preset's lambda
_FEWEST = 5  # lambdas that a curve can be read from
_SEED = 11
_SHAKEN = 0.5  # of the noise, standard deviation of what is added for the trace
_LEAST_NOISE = 0.1  # grey levels; rounding to 8 bits is more
_NORMAL = 1.4826  # standard deviation over the median distance of a normal distribution


@dataclass(frozen=True)
class SmoothnessPair:
    """Two frames of a recording and what the flow between them is told.

    Attributes
    ----------
    first, second : (h, w) grey levels of a range of 255
    told : (h, w) bool
        The data term's pixels.
    counted : (h, w) bool
        Tissue, whose residual is looked at.
    folds : Folds, optional
    noise : float
        Standard deviation (grey levels) of the noise of a frame as the camera made it.
    seen : function, optional
        What the way from the camera to these frames makes of two fields of white noise; none: nothing.
    """

    first: Frame
    second: Frame
    told: Mask
    counted: Mask
    noise: float
    folds: Folds | None = None
    seen: Callable[[Frame, Frame], tuple[Frame, Frame]] | None = None


@dataclass(frozen=True)
class LambdaReport:
    """What the criteria say, and the curves that they are read from.

    Attributes
    ----------
    preset : str
    used : float, its lambda
    smoothness : (n,)
        The ladder of lambda, rising.
    residual, expected, roughness, validation : (n,)
        Scale of the residual and what noise alone makes it (grey levels); roughness (px per px); the
        function of cross-validation (grey levels squared).
    chosen : dict of criterion to float, or None
        None where its curve has no such point within the ladder.
    noise : float, grey levels
    """

    preset: str
    used: float
    smoothness: Floats
    residual: Floats
    expected: Floats
    roughness: Floats
    validation: Floats
    chosen: dict[str, float | None]
    noise: float

    def __str__(self) -> str:
        rows = [f"lambda by three criteria; the flow was found with {self.used:g}, that of {self.preset}"]
        for name in CRITERIA:
            value = self.chosen[name]
            rows.append(f"{name:17} {'no such lambda in the ladder' if value is None else f'{value:.3g}'}")
        rows += [f"noise             {self.noise:.2f} grey levels", ""]
        rows.append("  lambda  residual  by noise  roughness  cross-validation")
        columns = (self.smoothness, self.residual, self.expected, self.roughness, self.validation)
        rows += [
            f"{a:8.4g} {b:9.3f} {c:9.3f} {d:10.4f} {e:17.3f}" for a, b, c, d, e in zip(*columns, strict=True)
        ]
        return "\n".join(rows)

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        curves = ("smoothness", "residual", "expected", "roughness", "validation")
        return {
            "preset": self.preset,
            "used": self.used,
            "chosen": self.chosen,
            "noise": self.noise,
            "curves": {name: getattr(self, name).tolist() for name in curves},
        }


def lambda_report(
    pairs: Iterable[SmoothnessPair], preset: str = "video", ladder: Sequence[float] | None = None
) -> LambdaReport:
    """What the three criteria choose for these pairs, with all else as the preset has it.

    Parameters
    ----------
    pairs : SmoothnessPair
    preset : str
        A name of `PRESETS`.
    ladder : floats, optional
        Rising lambdas, five or more; the default is the preset's times 1/32 to 32 by factors of 2.

    Raises
    ------
    InvalidInput
        Without a pair, for a pair without tissue, for an unknown preset, and for a ladder that is none.
    """
    if preset not in PRESETS:
        raise InvalidInput(
            f'lambda_report: preset = "{preset}"; must be {one_of(PRESETS)}.{nearest(preset, PRESETS)}'
        )
    given = list(pairs)
    blind = sum(not pair.counted.any() for pair in given)
    if not given or blind:
        raise InvalidInput(
            f"lambda_report: {len(given)} pairs of frames, {blind} without tissue; must be one or more, all "
            "with tissue."
        )
    used = PRESETS[preset].smoothness
    steps = np.asarray(used * _LADDER if ladder is None else ladder, dtype=float)
    if steps.ndim != 1 or steps.size < _FEWEST or not (np.diff(steps) > 0).all() or not steps[0] > 0:
        raise InvalidInput(
            f"lambda_report: ladder = {steps.tolist()}; must be {_FEWEST} or more numbers above 0 that rise."
        )
    curves = np.array([np.mean([_at(pair, preset, value) for pair in given], axis=0) for value in steps])
    residual, expected, roughness = np.sqrt(curves[:, :3]).T
    validation = curves[:, 3]
    chosen = {
        "discrepancy": _crossing(steps, residual / expected),
        "L-curve": _corner(steps, residual, roughness),
        "cross-validation": _lowest(steps, validation),
    }
    noise = float(np.sqrt(np.mean([pair.noise**2 for pair in given])))
    return LambdaReport(preset, used, steps, residual, expected, roughness, validation, chosen, noise)


def noise_level(frame: Frame) -> float:
    """Standard deviation (grey levels) of white noise in a frame: median answer to a mask (Immerkaer 1996)
    to which planes do not answer; its mean would count edges."""
    from scipy import ndimage

    once = np.array([1.0, -2.0, 1.0])
    answer = ndimage.correlate(np.asarray(frame, float), np.outer(once, once))[1:-1, 1:-1]
    return max(float(_NORMAL * np.median(np.abs(answer)) / 6), _LEAST_NOISE)


def _at(pair: SmoothnessPair, preset: str, smoothness: float) -> Floats:
    """(4) of a pair: squares of residual, expected residual, roughness; the function of cross-validation."""
    random = np.random.default_rng(_SEED)
    shape = pair.first.shape

    def found(first: Frame) -> PairFlow:
        return flow(
            np.asarray(first, np.float32),
            np.asarray(pair.second, np.float32),
            preset=preset,
            mask=pair.told,
            intensity=(0.0, 255.0),
            folds=pair.folds,
            smoothness=smoothness,
        )

    there = found(pair.first)
    added = _SHAKEN * pair.noise * random.standard_normal(shape)
    shaken = found(pair.first + added)
    white = random.standard_normal(shape), random.standard_normal(shape)
    one, two = white if pair.seen is None else pair.seen(*white)
    unit = _residual(one, two, there.flow)
    counted = pair.counted & np.isfinite(there.residual) & np.isfinite(shaken.residual) & np.isfinite(unit)
    left = there.residual[counted].astype(float)
    # The residual answers to what is added by A - 1: its share along the noise is tr A / N - 1.
    along = added[counted] @ (shaken.residual[counted] - left) / (added[counted] @ added[counted])
    steps = [np.square(np.diff(there.flow[..., k], axis=axis)).mean() for k in (0, 1) for axis in (0, 1)]
    return np.array(
        [
            _scale(left) ** 2,
            (pair.noise * _scale(unit[counted])) ** 2,
            float(np.mean(steps)),
            _scale(left) ** 2 / max(along**2, 1e-6),
        ]
    )


def _residual(one: Frame, two: Frame, motion: npt.NDArray[np.float32]) -> Frame:
    """two(x + u) - one(x), not a number where x + u is outside."""
    from plica import _engine as engine

    return engine.flow_residual(np.asarray(one, np.float32), np.asarray(two, np.float32), motion)


def _scale(values: Frame) -> float:
    """Standard deviation of what is normal among them: what is hidden or in another light is not."""
    return float(_NORMAL * np.median(np.abs(values - np.median(values))))


def _crossing(steps: Floats, ratio: Floats) -> float | None:
    """Where a ratio that rises with lambda passes 1 for the last time."""
    below = np.flatnonzero((ratio[:-1] <= 1) & (ratio[1:] > 1))
    if not below.size:
        return None
    k = int(below[-1])
    share = (1 - ratio[k]) / (ratio[k + 1] - ratio[k])
    return float(np.exp(np.log(steps[k]) + share * np.log(steps[k + 1] / steps[k])))


def _corner(steps: Floats, residual: Floats, roughness: Floats) -> float | None:
    """Of the curve log roughness over log residual: where it turns most sharply towards more residual."""
    if not (residual > 0).all() or not (roughness > 0).all():
        return None
    at = np.log(steps)
    x, y = np.log(residual), np.log(roughness)
    dx, dy = np.gradient(x, at), np.gradient(y, at)
    bend = dx * np.gradient(dy, at) - dy * np.gradient(dx, at)
    curvature = (bend / np.maximum(dx**2 + dy**2, 1e-12) ** 1.5)[1:-1]
    k = int(np.argmax(curvature))
    return float(steps[1 + k]) if curvature[k] > 0 else None


def _lowest(steps: Floats, values: Floats) -> float | None:
    """The least, by a parabola through it and its neighbours; none at an end of the ladder."""
    k = int(np.argmin(values))
    if k in (0, steps.size - 1):
        return None
    at, value = np.log(steps[k - 1 : k + 2]), values[k - 1 : k + 2]
    a, b, _ = np.polyfit(at - at[1], value, 2)
    return float(np.exp(at[1] + np.clip(-b / (2 * a), at[0] - at[1], at[2] - at[1])))
