"""``plica flow``: the motion between two picture files, in words and as a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plica.errors import InvalidInput, StorageFailed
from plica.video.files.grey import to_grey
from plica.video.files.image_file import read_image, read_pixels
from plica.video.motion.flow import PairFlow, endpoint_error, flow
from plica.video.motion.flow_file import read_flow, write_flow

__all__ = ["flow_of_files"]

_SAME_LIGHT = 0.5  # share of A's brightness; light that changes by more is another picture's
_CLOSES = 1.0  # px; what misses by more on the way there and back was not followed


def flow_of_files(
    first: Path, second: Path, output: Path, *, preset: str, truth: Path | None, mask: Path | None
) -> tuple[str, str]:
    """Write the flow between two pictures to `output`; what to say about it, and a caution or nothing."""
    if output.suffix.lower() != ".flo":
        raise InvalidInput(f"flow: output = {output}; must end in .flo, Middlebury's format.")
    if not output.absolute().parent.is_dir():
        raise StorageFailed(f"flow: {output} cannot be written: its directory does not exist.")
    one, two = read_pixels(first), read_pixels(second)
    known = None if truth is None else read_flow(truth)
    if known is not None and known.shape[:2] != one.shape[:2]:
        raise InvalidInput(
            f"flow: {truth} is {known.shape[1]} x {known.shape[0]} px; "
            f"must be {one.shape[1]} x {one.shape[0]} px like {first}."
        )
    used = None if mask is None else read_image(mask) > 0
    found = flow(one, two, preset=preset, mask=used, round_trip=True)
    write_flow(output, found.flow)
    lines = _summary(found, to_grey(two) - to_grey(one), used)
    if known is not None:
        share = float(np.isfinite(known).all(axis=-1).mean())
        error = endpoint_error(found.flow, known)
        lines.append(f"error     {error:.4f} px from {truth}, known on {100 * share:.1f} % of the pixels")
    return "\n".join([*lines, f"written: {output}"]), _caution(found, used)


def _caution(found: PairFlow, used: np.ndarray | None) -> str:
    """Where most of what counts does not come back, or the light is another, what was found is no motion."""
    assert found.mismatch is not None
    change = found.light.change
    if not abs(change) <= _SAME_LIGHT:
        return (
            f"caution: B is {100 * abs(change):.0f} % {'brighter' if change > 0 else 'darker'} than A: this "
            "flow is not to be trusted. Do both show one thing, at the same scale of brightness?"
        )
    missed = found.mismatch if used is None else found.mismatch[used]
    returns = float((missed < _CLOSES).mean())  # what leaves the picture does not
    if returns >= 0.5:
        return ""
    return (
        f"caution: {100 * (1 - returns):.0f} % of the pixels do not come back to within {_CLOSES:g} px "
        "from A to B and back: this flow is not to be trusted. Do both show one thing, in the same light, "
        "at the same scale of brightness?"
    )


def _summary(found: PairFlow, without: np.ndarray, used: np.ndarray | None) -> list[str]:
    counted = np.ones(without.shape, bool) if used is None else used
    speed = np.hypot(found.flow[..., 0], found.flow[..., 1])[counted]
    inside = counted & np.isfinite(found.residual)
    lines = [f"motion    {np.median(speed):.3f} px median, {speed.max():.3f} px largest"]
    if not inside.any():
        return [*lines, "residual  -          every pixel leaves the picture"]

    def rms(values: np.ndarray) -> float:
        return float(np.sqrt(np.mean(np.square(values[inside], dtype=float))))

    low, high = found.intensity
    left, before = rms(found.residual), rms(without)
    lines.append(f"residual  {left:.3g} of {high - low:g} grey levels; {before:.3g} without motion")
    lines.append(f"light     {100 * found.light.change:+.1f} % from A to B, taken out")
    if found.mismatch is not None:
        missed = found.mismatch[inside]
        lines.append(
            f"mismatch  {np.median(missed):.3f} px median, {np.percentile(missed, 95):.3f} px 95th percentile"
        )
    if not inside[counted].all():
        lines.append(f"          {100 * (1 - inside[counted].mean()):.1f} % of the pixels leave the picture")
    return lines
