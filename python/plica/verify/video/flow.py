"""Optical flow of planted motions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from plica.verify.case import Case, Check, zero
from plica.video.motion import flow as engine_flow

__all__ = ["CASES"]

Array = NDArray[np.float64]

ROWS, COLUMNS, BORDER = 72, 96, 10  # px; what lies nearer to the border leaves the frame or is held by it
SHIFT = (1.4, -0.7)  # px
SLOPES = np.array([[0.02, -0.03], [0.01, -0.015]])  # du/dx, du/dy; dv/dx, dv/dy
SHORTEST = 0.9  # rad/px, of the waves
SPLINE = "cubic interpolation of the shortest wave, k^4 / 384 = 1.7e-3 of its amplitude, some 2e-3 px"


def texture(x: Array, y: Array) -> NDArray[np.float32]:
    """Grey levels at places (px): ten waves of 7 to 50 px in all directions."""
    random = np.random.default_rng(1)
    total = np.zeros(x.shape)
    for k in range(10):
        number, direction, phase = SHORTEST * 0.8**k, *random.uniform(-np.pi, np.pi, 2)
        total += np.sin(number * (np.cos(direction) * x + np.sin(direction) * y) + phase)
    return (128 + 12 * total).astype(np.float32)


def places() -> tuple[Array, Array]:
    y, x = np.mgrid[:ROWS, :COLUMNS].astype(float)
    return x - (COLUMNS - 1) / 2, y - (ROWS - 1) / 2


def found(second: NDArray[np.float32]) -> Array:
    """(h, w, 2) px from the texture at rest, away from the border."""
    motion = engine_flow.flow(texture(*places()), second).flow
    return np.asarray(motion[BORDER:-BORDER, BORDER:-BORDER], float)


def shift() -> Iterator[Check]:
    x, y = places()
    motion = found(texture(x - SHIFT[0], y - SHIFT[1]))
    for k, name in enumerate("uv"):
        yield Check(
            name=name,
            quantity=f"median {name} of a texture that moved by a fraction of a pixel",
            unit="px",
            value=float(np.median(motion[..., k])),
            reference=SHIFT[k],
            tolerance=5e-3,
            because=SPLINE,
            of="unit",
        )
    yield zero(
        name="error",
        quantity="mean endpoint error",
        unit="px",
        value=float(np.hypot(*np.moveaxis(motion - SHIFT, -1, 0)).mean()),
        tolerance=1e-2,
        because=SPLINE,
    )
    still = engine_flow.flow(texture(x, y), texture(x, y)).flow
    yield zero(
        name="still",
        quantity="largest motion between a picture and itself",
        unit="px",
        value=float(np.abs(still).max()),
        tolerance=1e-5,
        because="single precision of grey levels up to 255",
    )


def affine() -> Iterator[Check]:
    """What is at X in the first frame is at X + SLOPES X in the second."""
    x, y = places()
    back = np.linalg.inv(np.eye(2) + SLOPES)
    motion = found(texture(back[0, 0] * x + back[0, 1] * y, back[1, 0] * x + back[1, 1] * y))
    inner = (slice(BORDER, -BORDER), slice(BORDER, -BORDER))
    basis = np.stack([x[inner].ravel(), y[inner].ravel(), np.ones(x[inner].size)], axis=1)
    fitted = np.linalg.lstsq(basis, motion.reshape(-1, 2), rcond=None)[0][:2].T
    exact = np.stack([SLOPES[k, 0] * x[inner] + SLOPES[k, 1] * y[inner] for k in range(2)], axis=-1)
    for name, quantity, value, reference in (
        ("divergence", "divergence", np.trace(fitted), np.trace(SLOPES)),
        ("rotation", "rotation", fitted[1, 0] - fitted[0, 1], SLOPES[1, 0] - SLOPES[0, 1]),
        ("shear", "shear", fitted[1, 0] + fitted[0, 1], SLOPES[1, 0] + SLOPES[0, 1]),
    ):
        yield Check(
            name=name,
            quantity=f"{quantity} of a texture that is stretched, sheared and turned",
            value=float(value),
            reference=float(reference),
            tolerance=5e-3 / (0.5 * ROWS - BORDER),
            because=f"{SPLINE}, over half the height",
            of="unit",
        )
    yield zero(
        name="error",
        quantity="mean endpoint error",
        unit="px",
        value=float(np.hypot(*np.moveaxis(motion - exact, -1, 0)).mean()),
        tolerance=1e-2,
        because=SPLINE,
    )


CASES = (
    Case(
        "shift",
        "The flow of a texture that was shifted by known fractions of a pixel is that shift.",
        "planted motion",
        shift,
    ),
    Case(
        "affine",
        "The flow of a texture that was stretched, sheared and turned has that divergence, shear and "
        "rotation.",
        "planted motion",
        affine,
    ),
)
