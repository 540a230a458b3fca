"""The glottis: area of a drawn ellipse, and what is measured of filmed and of analytic folds."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from math import pi, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica.measures.cycles import find_cycles
from plica.measures.glottal import frequency_measures, quotient_measures
from plica.measures.measure import Measure
from plica.measures.sides import side_measures
from plica.measures.thresholds import closed_share
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.verify.case import Case, Check
from plica.video.files.recording import Recording
from plica.video.glottis.frame_segmentation import segment
from plica.video.glottis.glottal_area import areas
from plica.video.glottis.midline import find_midline
from plica.video.glottis.segmenter import masks
from plica.video.measures.waveforms import measures

__all__ = ["CASES"]

Array = NDArray[np.float64]

FPS = 4000.0  # frames/s
PITCH, RATE, SECONDS = 213.7, 8000.0, 0.1  # Hz, samples/s, s of the analytic record
UP, DOWN = 0.36, 0.24  # of the period
LAG = 0.6  # rad
EDGE = 0.5  # px
PLACED = "masks are of whole pixels: edges are placed within half a pixel"
SAMPLED_EXTREMES = "1 - cos(omega h / 2): extremes are sampled"


def number(measure: Measure) -> float:
    """Its value; not a number where it has none."""
    return float("nan") if measure.value is None else float(measure.value)


def checks(
    found: Iterable[Measure], rows: Iterable[tuple[str, str, str, float, float, str]]
) -> Iterator[Check]:
    """Of measures: the check's name, the measure's, unit, reference, tolerance and its reason."""
    by_name = {measure.name: measure for measure in found}
    for name, key, unit, reference, tolerance, because in rows:
        yield Check(
            name=name,
            quantity=key.replace("_", " "),
            unit=unit,
            value=number(by_name[key]),
            reference=reference,
            tolerance=tolerance,
            because=because,
        )


def ellipse() -> Iterator[Check]:
    """Drawn by the share of each pixel that it covers, in uneven light, and blurred by a pixel."""
    from scipy import ndimage

    size, fine = 160, 8
    a, b, lean = 11.3, 41.7, 0.15  # px, rad
    y, x = (np.mgrid[: size * fine, : size * fine] + 0.5) / fine - size / 2
    across, along = np.cos(lean) * x + np.sin(lean) * y, np.cos(lean) * y - np.sin(lean) * x
    covered = ((across / a) ** 2 + (along / b) ** 2 < 1).reshape(size, fine, size, fine).mean(axis=(1, 3))
    light = 1 - 0.2 * (np.arange(size)[:, None] / size)
    picture = ndimage.gaussian_filter((150 - 130 * covered) * light, 1.0)
    mask = segment(picture).mask
    # Ramanujan's first formula; exact to 1e-5 at this eccentricity.
    perimeter = pi * (3 * (a + b) - sqrt((3 * a + b) * (a + 3 * b)))
    yield Check(
        name="area",
        quantity="area of an ellipse in a picture",
        unit="px^2",
        value=float(mask.sum()),
        reference=pi * a * b,
        tolerance=EDGE * perimeter / (pi * a * b),
        because=f"{PLACED}, all along the outline",
    )
    inside = np.argwhere(mask) - (size - 1) / 2
    axes = np.sort(np.sqrt(np.linalg.eigvalsh(4 * np.cov(inside.T))))
    for name, quantity, value, reference in (
        ("minor", "half its minor axis, from the mask's second moments", axes[0], a),
        ("major", "half its major axis, likewise", axes[1], b),
    ):
        yield Check(
            name=name,
            quantity=quantity,
            unit="px",
            value=float(value),
            reference=reference,
            tolerance=EDGE,
            because=PLACED,
            of="unit",
        )


def open_share(options: Synthetic) -> float:
    """Of a cycle, by brute force: where both openings sum to more than what counts as closed."""
    angle = 2 * pi * (np.arange(100_000) + 0.5) / 100_000
    widths = [
        np.maximum(0.0, options.opening[side] + options.amplitude[side] * np.sin(angle + options.phase[side]))
        for side in (0, 1)
    ]
    width = widths[0] + widths[1]
    return float(np.mean(width > closed_share * width.max()))


def filmed() -> Iterator[Check]:
    """A synthetic glottis of 96 px with noise, blur and highlights; the right fold leads."""
    options = Synthetic(
        height=96, width=96, frames=160, frequency=0.0473, amplitude=(6, 6), opening=(2, 2), phase=(0.0, LAG)
    )
    glottis = SyntheticGlottis(options)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "glottis.npy"
        np.save(path, glottis.stack())
        seen = list(masks(Recording.open(path)))
    midline = find_midline(seen)
    area = areas(seen, midline)
    exact = np.array([sum(glottis.area(t)) for t in range(options.frames)])
    found, _ = measures(area, fps=FPS)
    pitch, share = FPS * options.frequency, open_share(options)
    outline = 2 * 0.7 * options.height * share  # px, of both folds' edges, a mean over the cycle
    for name, quantity, unit, value, reference, tolerance, because in (
        (
            "midline",
            "column of the midline, mean of its ends",
            "px",
            0.5 * (midline.upper[0] + midline.lower[0]),
            glottis.midline,
            EDGE,
            PLACED,
        ),
        ("area", "mean glottal area", "px^2", area.total.mean(), exact.mean(), EDGE * outline, PLACED),
        (
            "pitch",
            "fundamental frequency",
            "Hz",
            number(found["fundamental_frequency"]),
            pitch,
            pitch / options.frames,
            "one frame of the record",
        ),
        (
            "open-quotient",
            "open quotient",
            "1",
            number(found["open_quotient"]),
            share,
            options.frequency,
            "one frame of a cycle: half a frame at either end",
        ),
        (
            "phase",
            "lag of the right fold behind the left",
            "rad",
            number(found["left_right_phase"]),
            -LAG,
            EDGE / options.amplitude[0],
            f"{PLACED}, over the amplitude",
        ),
    ):
        yield Check(
            name=name,
            quantity=quantity,
            unit=unit,
            value=float(value),
            reference=float(reference),
            tolerance=tolerance,
            because=because,
            of="unit",
        )


def pulses() -> Iterator[Check]:
    """Areas that rise over 0.36 of the period, fall over 0.24 and are closed for the rest."""
    time = np.arange(1, round(SECONDS * RATE)) / RATE
    phase = (PITCH * time + 0.1) % 1
    area = np.clip(np.minimum(phase / UP, (UP + DOWN - phase) / DOWN), 0.0, None)
    cycles = find_cycles(time, area, name="glottal area")
    found = (*frequency_measures(time, area, cycles), *quotient_measures(time, area, cycles))
    level = closed_share * PITCH / RATE / (2 * DOWN)
    linear = "linear flanks are interpolated exactly"
    sampled = "the level is 5 % of the largest sample, which lies up to half a sample beside the top"
    rows = (
        ("pitch", "fundamental_frequency", "Hz", PITCH, 1e-9, linear),
        ("open-quotient", "open_quotient", "1", (1 - closed_share) * (UP + DOWN), level, sampled),
        ("speed-quotient", "speed_quotient", "1", UP / DOWN, 1e-9, linear),
        ("closing-quotient", "closing_quotient", "1", (1 - closed_share) * DOWN, level, sampled),
    )
    yield from checks(found, rows)


def sides() -> Iterator[Check]:
    """Edges that swing as cosines, the right one later and less."""
    time = np.arange(1, round(SECONDS * RATE)) / RATE
    left = 1e-3 * (2.0 + 1.5 * np.cos(2 * pi * PITCH * time))
    right = 1e-3 * (2.0 + 0.9 * np.cos(2 * pi * PITCH * time - LAG))
    cycles = find_cycles(time, left + right, name="glottal area")
    found = side_measures(time, left, right, cycles)
    step = 2 * pi * PITCH / RATE
    rows = (
        (
            "phase",
            "left_right_phase",
            "rad",
            LAG,
            step**2 / 8,
            "(omega h)^2 / 8: cycles begin between samples",
        ),
        ("amplitude-left", "amplitude_left", "m", 1.5e-3, step**2 / 8, SAMPLED_EXTREMES),
        ("amplitude-right", "amplitude_right", "m", 0.9e-3, step**2 / 8, SAMPLED_EXTREMES),
    )
    yield from checks(found, rows)


CASES = (
    Case(
        "ellipse",
        "The glottis drawn as an ellipse in uneven light is found with its area and its axes.",
        "pi a b",
        ellipse,
    ),
    Case(
        "filmed",
        "From frames of a glottis that moves as a formula says come its midline, area, pitch, open "
        "quotient and phase.",
        "the formula of the motion",
        filmed,
    ),
    Case(
        "pulses",
        "Pitch and quotients of triangular pulses are those of their flanks.",
        "0.36 of the period up, 0.24 down, above 5 % of the largest area",
        pulses,
    ),
    Case(
        "sides",
        "Phase and amplitudes of two folds that swing as cosines are those of the cosines.",
        "A cos(omega t - lag)",
        sides,
    ),
)
