"""Truth and pictures of the films of `larynx_films.py`.

    python -m benchmarks.video.larynx_renderer

draws each film without tissue, blur and noise and prints by how much the edges read from its pixels, and the
area that these add up to, miss the truth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks.video.larynx_films import Film, issue_films, turn, unseen_films

__all__ = ["Truth", "coverage", "render", "truth"]

Array = NDArray[np.float64]

SUBROWS = 8  # lines of a pixel's row on which it is covered exactly
STILL = 0.25  # px: a fold of less amplitude has no phase
CLOSED = 0.05  # of the largest area of a cycle
TISSUE, HIGHLIGHT, STRAND = 150.0, 320.0, 225.0  # grey levels
GLYPHS = (
    "111101101101111",
    "010110010010111",
    "111001111100111",
    "111001111001111",
    "101101111001001",
    "111100111001111",
    "111100111101111",
    "111001010010010",
    "111101111101111",
    "111101111001111",
)
"""Of the digits, five rows of three dots."""


# ---- the truth


@dataclass(frozen=True)
class Truth:
    """Of a film: edges and area of each frame, measures over the whole cycles of voice that it has."""

    s: Array
    """(rows,) px, a quarter apart: of the part that is seen."""
    edges: Array
    """(n, rows, 2) u of the left and of the right edge, px."""
    area: Array
    """(n,) px^2"""
    measures: dict[str, float | None]
    """Under the names of `plica`; None where a measure has no meaning. The phase is that of the fundamental
    of whole cycles, contact included; that of the crests alone stands beside it."""


def truth(film: Film) -> Truth:
    folds = film.folds
    s = np.linspace(film.top, folds.length / 2, round(4 * (folds.length / 2 - film.top)) + 1)
    edges = np.stack(folds.edges(s, film.time[:, None]), axis=2)
    return Truth(s, edges, _area(s, edges), _measures(film, s))


def _area(s: Array, edges: Array) -> Array:
    return np.asarray(np.trapezoid(edges[..., 1] - edges[..., 0], s, axis=-1))


def _measures(film: Film, s: Array) -> dict[str, float | None]:
    """Of 240 instants a cycle."""
    folds = film.folds
    fine = np.linspace(film.time[0], film.time[-1], 64 * len(film.time))
    turns = folds.phase(fine) / (2 * np.pi)
    spoken = turns[folds.voicing(fine) > 1 - 1e-9]
    first, last = math.ceil(spoken[0]), math.floor(spoken[-1])
    parts = np.linspace(first, last, 240 * (last - first) + 1)
    t = np.interp(parts, turns, fine)
    edges = np.stack(folds.edges(s, t[:, None]), axis=2)
    # Cycles of 241 instants, both ends among them.
    cycles = np.arange(last - first)[:, None] * 240 + np.arange(241)
    area = _area(s, edges)[cycles]
    least, largest = area.min(axis=1), area.max(axis=1)
    middle = np.abs(s - (s[0] + s[-1]) / 2) <= 0.05 * (s[-1] - s[0])
    way = edges[:, middle].mean(axis=1) * [-1, 1]
    left, right = (float(np.ptp(way[cycles, k], axis=1).mean() / 2) for k in (0, 1))
    apart = way.sum(axis=1) > 1e-6
    phases = [_crest(2 * np.pi * parts, way[:, k], apart) for k in (0, 1)]
    still = min(left, right) < STILL
    return {
        "fundamental_frequency": float((last - first) / (t[-1] - t[0])),
        "open_quotient": float(np.mean(area[:, :-1] > CLOSED * largest[:, None])),
        "glottal_area_max": float(largest.mean()),
        "glottal_area_mean": float(area[:, :-1].mean()),
        "glottal_gap_index": float(np.mean(least / largest)),
        "amplitude_left": left,
        "amplitude_right": right,
        "amplitude_ratio": None if left < STILL else right / left,
        "left_right_phase": None if still else float(np.angle(phases[0] / phases[1])),
    }


def _crest(phase: Array, way: Array, apart: NDArray[np.bool_]) -> complex:
    """The complex amplitude c of Re(c exp(i phase)) beside a mean, by least squares: of an edge in the
    farther three quarters of its way, while the folds are apart (the definition of the catalogue)."""
    there = apart & (way > way.min() + 0.25 * np.ptp(way))
    wave = np.exp(1j * phase[there])
    matrix = np.stack([np.ones(wave.size), wave.real, -wave.imag], axis=1)
    found = np.linalg.lstsq(matrix, way[there], rcond=None)[0]
    return complex(found[1], found[2])


# ---- the picture


def render(film: Film) -> NDArray[np.uint8]:
    """(n, h, w) grey levels."""
    rng = np.random.default_rng(film.seed + 1000)
    shot = _Shot.of(film, rng)
    made = np.empty((len(film.time), *film.picture.size), np.uint8)
    for k, t in enumerate(film.time):
        grey = shot.frame(float(t))
        grey += film.picture.noise * rng.standard_normal(grey.shape)
        if film.picture.counter:
            _write(grey, k)
        made[k] = np.clip(np.rint(grey), 0, 255)
    return made


def coverage(film: Film, t: float) -> Array:
    """(h, w) share of each pixel that is glottis."""
    height, width = film.picture.size
    rows = (np.arange(height * SUBROWS) + 0.5) / SUBROWS - height / 2
    left, right = film.borders(rows, t)
    pixel = np.arange(width) - width / 2
    covered = np.minimum(right[:, None], pixel + 1) - np.maximum(left[:, None], pixel)
    return np.asarray(np.clip(covered, 0, 1).reshape(height, SUBROWS, width).mean(axis=1))


@dataclass(frozen=True)
class _Shot:
    """What all frames of a film share."""

    film: Film
    tissue: Array
    """Grey of what moves with the left fold, with the right, and of what is still: one below the other."""
    light: Array
    lines: Array
    """s on which edges are known."""
    rest: Array
    """(2, lines) mean of the edges' ways, from which tissue is displaced."""

    @classmethod
    def of(cls, film: Film, rng: np.random.Generator) -> _Shot:
        height, width = film.picture.size
        half = math.ceil(math.hypot(height, width) / 2) + 8
        tissue = np.concatenate([_tissue(film, half, rng) for _ in range(3)])
        y, x = _pixels(film)
        light = 1 - 0.35 * (x**2 + y**2) / (height**2 + width**2) * 4
        light *= 1 + film.picture.lamp * x / (width / 2)
        lines = np.linspace(-half, half, 8 * half + 1)
        ways = film.folds.edges(lines, film.time[:, None])
        return cls(film, tissue, light, lines, np.array([way.mean(axis=0) for way in ways]))

    def frame(self, t: float) -> Array:
        """Grey levels before noise."""
        film, picture = self.film, self.film.picture
        zoom, right, down = film.view(t)
        y, x = ((part - moved) / zoom for part, moved in zip(_pixels(film), (down, right), strict=True))
        cos, sin = turn(picture.tilt)
        s, u = y * cos - x * sin, x * cos + y * sin
        edges = np.array(film.folds.edges(self.lines, np.array(t)))
        at = np.array([np.interp(s, self.lines, edge) for edge in edges])
        side = (u > at.mean(axis=0)).astype(int)
        own = np.where(side, at[1], at[0])
        moved = np.where(side, *(np.interp(s, self.lines, part) for part in (edges - self.rest)[::-1]))
        fading = np.exp(-np.abs(u - own) / (0.12 * picture.size[1]))
        grey = self._grey(side, s, u - moved * fading)
        covered = coverage(film, t)
        grey += covered * (picture.dark - grey)
        if picture.strand:
            place = s - 4 - 3 * np.sin(2 * np.pi * 23 * t) - 0.25 * u
            seen = np.clip(0.5 + picture.strand / 2 - np.abs(place) / math.hypot(1, 0.25), 0, 1)
            grey += seen * ((at[0] - 3 < u) & (u < at[1] + 3)) * (STRAND - grey)
        if picture.occluded:
            grey += np.clip((film.top - s) * zoom + 0.5, 0, 1) * (0.9 * self._grey(2, s, u) - grey)
        grey *= self.light
        if picture.corners:
            radius = 0.52 * max(picture.size)
            grey *= np.clip(radius - np.hypot(*_pixels(film)) + 0.5, 0.02, 1)
        return np.asarray(ndimage.gaussian_filter(np.minimum(grey, 255), picture.blur))

    def _grey(self, side: NDArray[np.int_] | int, s: Array, u: Array) -> Array:
        size = self.tissue.shape[1]
        places = [np.clip(part + size // 2, 0, size - 1) for part in (s, u)]
        return np.asarray(ndimage.map_coordinates(self.tissue, [places[0] + side * size, places[1]], order=1))


def _pixels(film: Film) -> tuple[Array, Array]:
    """y, x of the pixels' middles from the middle of the picture."""
    height, width = film.picture.size
    y, x = np.mgrid[:height, :width].astype(float)
    return y - (height - 1) / 2, x - (width - 1) / 2


def _tissue(film: Film, half: int, rng: np.random.Generator) -> Array:
    """(2 half + 1)^2 grey levels, with three highlights away from the line."""
    size = 2 * half + 1
    fields = [ndimage.gaussian_filter(rng.standard_normal((size, size)), width) for width in (2.0, 7.0)]
    made = TISSUE * (1 + film.picture.texture * sum(part / part.std() for part in fields) / math.sqrt(2))
    made = np.clip(made, 60, 235)
    y, x = np.mgrid[-half : half + 1, -half : half + 1]
    for _ in range(3):
        place = rng.uniform(-0.35, 0.35) * film.folds.length
        for way in (-1, 1):
            across = way * rng.uniform(0.22, 0.42) * film.picture.size[1]
            spot = np.exp(-0.5 * ((y - place) ** 2 + (x - across) ** 2) / rng.uniform(1.2, 2.2) ** 2)
            made += HIGHLIGHT * spot
    return np.asarray(made)


def _write(grey: Array, number: int) -> None:
    """Four digits in the upper left corner, each pixel of a glyph twice as wide and high."""
    for k, digit in enumerate(f"{number:04d}"):
        glyph = np.array(list(GLYPHS[int(digit)]), float).reshape(5, 3).repeat(2, 0).repeat(2, 1)
        grey[4:14, 4 + 8 * k : 10 + 8 * k] = 235.0 * glyph + 10.0 * (1 - glyph)


# ---- the renderer against the truth


def misses(film: Film) -> tuple[float, float]:
    """Largest errors of eight frames: of edges read from the pixels (px), of the pixels' sum over the area.

    In a row of pixels that has one all in the glottis, the edge is as far from it as what the pixels beyond
    add up to; that is the mean of the edge over the height of the row.
    """
    edge, share = 0.0, 0.0
    height, width = film.picture.size
    s = np.linspace(-film.folds.length / 2, film.folds.length / 2, 20001)
    for t in film.time[:: max(1, len(film.time) // 8)]:
        covered = coverage(film, float(t))
        area = float(_area(s, np.stack(film.folds.edges(s, np.array(t)), axis=-1))) * film.view(t)[0] ** 2
        share = max(share, abs(covered.sum() - area) / max(area, 1.0))
        rows = (np.arange(height * 64) + 0.5) / 64 - height / 2
        true = [part.reshape(height, 64).mean(axis=1) + width / 2 for part in film.borders(rows, float(t))]
        for row in np.flatnonzero(covered.max(axis=1) > 1 - 1e-12):
            full = int(covered[row].argmax())
            read = full - covered[row, :full].sum(), full + covered[row, full:].sum()
            edge = max(edge, *(abs(place - part[row]) for place, part in zip(read, true, strict=True)))
    return edge, share


def main() -> None:
    for film in issue_films() + unseen_films():
        print("{}: edges {:.1e} px, area {:.1e}".format(film.name, *misses(film)))


if __name__ == "__main__":
    main()
