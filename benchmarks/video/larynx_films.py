"""Films of a larynx from above whose folds move as said: what `larynx_judge.py` judges `plica video` by.

    python -m benchmarks.video.larynx_films

draws each film without tissue, blur and noise and prints by how much the edges read from its pixels, and the
area that these add up to, miss the truth. It shares nothing with `plica`.

Lengths are in px of the first frame. A place in the glottis has s along its length, downward, and u across
it, to the right of the image; both are 0 in the middle of the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

__all__ = [
    "Film",
    "Folds",
    "Picture",
    "Truth",
    "drawn_films",
    "issue_films",
    "render",
    "truth",
    "unseen_films",
]

Array = NDArray[np.float64]
Pair = tuple[float, float]  # left, right in the image

SUBROWS = 8  # lines of a pixel's row on which it is covered exactly
ABDUCTED = 9.0  # px, of either fold from the line before and after the voice
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


@dataclass(frozen=True)
class Folds:
    """How the folds move; where they would overlap they touch, halfway between or at one that is still."""

    pitch: float = 180.0  # Hz
    length: float = 110.0  # px
    amplitude: Pair = (8.0, 8.0)  # px, in the middle; 0: a fold that is still
    offset: Pair = (1.0, 1.0)  # px outward of the line, in the middle: the mean of the way
    lag: float = 0.0  # rad, of the right behind the left
    zipper: float = 0.0  # rad, of the lower end before the upper
    bow: float = 0.0  # px to the right: the line in which the folds meet
    bump: Pair = (0.0, 0.0)  # px inward: a polyp in the middle of a fold
    chink: float = 0.0  # px: half of the width of an opening at the lower end
    skew: float = -0.2  # negative: folds part slower than they close
    vibrato: float = 0.0  # of the pitch, five times a second
    voiced: Pair = (-math.inf, math.inf)  # s; folds come together within two cycles, and part so

    def phase(self, t: Array) -> Array:
        """Of the voice, rad."""
        return 2 * np.pi * self.pitch * (t - self.vibrato * np.cos(10 * np.pi * t) / (10 * np.pi))

    def voicing(self, t: Array) -> Array:
        """0: still and apart; 1: voice."""
        ramp = np.minimum(t - self.voiced[0], self.voiced[1] - t) * self.pitch / 2
        share = np.clip(ramp, 0, 1)
        return np.asarray(share**2 * (3 - 2 * share))

    def edges(self, s: Array, t: Array) -> tuple[Array, Array]:
        """u of the left and of the right edge at s and t, which are broadcast."""
        profile = np.clip(1 - (2 * s / self.length) ** 2, 0, None)
        polyp = np.exp(-0.5 * (s / (0.09 * self.length)) ** 2)
        chink = self.chink * np.sin(np.pi * np.clip((s / self.length - 0.2) / 0.3, 0, 1)) ** 2
        voice = self.voicing(t)
        ways = []
        for k in (0, 1):
            phase = self.phase(t) + self.zipper * s / self.length - k * self.lag
            wave = np.sin(phase + self.skew * np.sin(phase))
            spoken = self.offset[k] + self.amplitude[k] * wave
            ways.append(profile * (voice * spoken + (1 - voice) * ABDUCTED) + chink - polyp * self.bump[k])
        left, right = -ways[0], ways[1]
        meeting = (left + right) / 2
        if self.amplitude[0] == 0.0:
            meeting = left
        elif self.amplitude[1] == 0.0:
            meeting = right
        touch, line = left > right, self.bow * profile
        return np.where(touch, meeting, left) + line, np.where(touch, meeting, right) + line


@dataclass(frozen=True)
class Picture:
    """What the camera sees of it."""

    size: tuple[int, int] = (200, 160)  # px, height and width
    tilt: float = 0.0  # deg, of the glottis
    blur: float = 0.8  # px, standard deviation
    noise: float = 2.0  # grey levels
    texture: float = 0.08  # of the tissue's grey
    dark: float = 22.0  # grey level of the glottis
    lamp: float = 0.0  # of the light: more on the right than in the middle, as much less on the left
    zoom: float = 1.0  # at the end, about the middle of the picture
    drift: Pair = (0.0, 0.0)  # px to the end
    occluded: float = 0.0  # of the length, from the upper end
    strand: float = 0.0  # px: width of a strand of mucus
    corners: bool = False  # of a round endoscope
    counter: bool = False  # of frames, burnt in


@dataclass(frozen=True)
class Film:
    """One film of one voice."""

    name: str
    folds: Folds = field(default_factory=Folds)
    picture: Picture = field(default_factory=Picture)
    fps: float = 4000.0
    count: int = 240
    seed: int = 0
    taken: Literal["all", "dropped", "repeated"] = "all"  # 5 % of the frames

    @cached_property
    def time(self) -> Array:
        """When each frame was taken, s."""
        of_each = np.arange(self.count)
        rng = np.random.default_rng(self.seed)
        if self.taken != "all":
            chosen = np.sort(rng.choice(of_each[1:-1], self.count // 20, replace=False))
            kept = np.delete(of_each, chosen)
            of_each = kept if self.taken == "dropped" else np.sort(np.concatenate([of_each, chosen]))
        return np.asarray(of_each / self.fps)

    @property
    def moves(self) -> bool:
        return self.picture.zoom != 1.0 or self.picture.drift != (0.0, 0.0)

    @property
    def top(self) -> float:
        """s from which the glottis is seen."""
        return (self.picture.occluded - 0.5) * self.folds.length

    def view(self, t: float) -> tuple[float, float, float]:
        """Magnification, and where the middle of the first frame is: x, y from the middle of the picture."""
        share, (right, down) = t * self.fps / self.count, self.picture.drift
        return 1 + (self.picture.zoom - 1) * share, right * share, down * share

    def borders(self, rows: Array, t: float) -> tuple[Array, Array]:
        """x, from the middle of the picture, of both edges on rows y from its middle.

        The solution of u = edge(s) with u = x cos + y sin, s = y cos - x sin, by fixed point: it contracts by
        tan(tilt) times the edge's slope.
        """
        zoom, right, down = self.view(t)
        cos, sin = _turn(self.picture.tilt)
        y = (rows - down) / zoom
        found = []
        for k in (0, 1):
            x = np.zeros_like(y)
            for _ in range(16):
                x = (self.folds.edges(y * cos - x * sin, np.array(t))[k] - y * sin) / cos
            found.append(x * zoom + right)
        return found[0], found[1]


def _turn(degrees: float) -> tuple[float, float]:
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))


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
        cos, sin = _turn(picture.tilt)
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


# ---- scenes


def still_fold(lateral: float, gap: float = -3.0, amplitude: float = 7.0, side: int = 0) -> Folds:
    """One fold is still, `lateral` px beside the line; the other comes within `gap` px of it, or meets it."""
    offset, moves = [lateral, lateral], [0.0, 0.0]
    offset[1 - side] = gap - lateral + amplitude
    moves[1 - side] = amplitude
    return Folds(offset=(offset[0], offset[1]), amplitude=(moves[0], moves[1]))


def polyp(size: float = 7.0, side: int = 1, offset: float = 7.0) -> Folds:
    """Folds that meet at a swelling of one; elsewhere if `offset` is less than the amplitude, 6."""
    bump = (size, 0.0) if side == 0 else (0.0, size)
    return Folds(amplitude=(6.0, 6.0), offset=(offset, offset), bump=bump)


def parted(gap: float, amplitude: float = 6.0) -> Folds:
    """Folds that stay `gap` px apart in the middle."""
    return Folds(amplitude=(amplitude, amplitude), offset=(amplitude + gap / 2, amplitude + gap / 2))


def issue_films() -> list[Film]:
    """What a clinic asks about first."""
    quarter = math.pi / 4
    films = [
        Film("symmetric"),
        Film("amplitudes 9 and 4", Folds(amplitude=(9.0, 4.0), offset=(1.5, 1.5))),
        Film("phase 0.5 rad", Folds(lag=0.5)),
        Film("phase 40 deg", Folds(lag=math.radians(40), offset=(2.0, 2.0))),
        Film("phase 90 deg", Folds(lag=math.pi / 2, offset=(2.0, 2.0))),
        *(Film(f"still fold at {lateral} px", still_fold(lateral)) for lateral in (2, 4, 6)),
        Film("still fold at 8 px, gap 1 px", still_fold(8, 1.0, 6.0)),
        Film("polyp 7 px, gaps beside it", polyp()),
        *(Film(f"meet on a bow of {bow} px", Folds(bow=bow)) for bow in (3, 5, 8)),
        Film("gap 2 px all along", parted(2.0)),
        Film("strand", picture=Picture(strand=2.0)),
        Film("chink", Folds(chink=4.0)),
        Film("zipper 60 deg", Folds(zipper=quarter * 4 / 3)),
    ]
    return [replace(film, seed=k) for k, film in enumerate(films)]


def unseen_films() -> list[Film]:
    """Others, with all that pictures are."""
    degree, many = math.pi / 180, Folds(pitch=290.0)
    small = Folds(length=52.0, amplitude=(4.0, 4.0), offset=(0.5, 0.5), pitch=120.0)
    large = Folds(length=300.0, amplitude=(24.0, 20.0), offset=(3.0, 3.0), pitch=140.0)
    lagging = Folds(lag=-0.5, amplitude=(7.0, 9.0), vibrato=0.01)
    films = [
        Film("90 px", small, Picture(size=(90, 90))),
        Film("512 px", large, Picture(size=(512, 400), tilt=5.0), count=160),
        Film("2000 frames/s, 90 Hz", Folds(pitch=90.0), Picture(tilt=-4.0), fps=2000.0),
        Film("8000 frames/s, 300 Hz", replace(many, pitch=300.0), Picture(tilt=6.0), fps=8000.0, count=300),
        Film("4000 frames/s, 290 Hz", replace(many, lag=0.4), count=200),
        Film("tilt 15 deg, left lags 0.5", lagging, Picture(tilt=15.0, size=(220, 190))),
        Film("tilt -12 deg, still right fold at 5 px", still_fold(5, side=1), Picture(tilt=-12.0)),
        Film("still right fold at 3 px, lamp", still_fold(3, side=1), Picture(lamp=0.3)),
        Film("still fold at 7 px, gap 1.5 px", still_fold(7, 1.5, 7.0), Picture(tilt=3.0)),
        Film("still fold in the line", still_fold(0), Picture(texture=0.15)),
        Film("amplitude 2 px", Folds(amplitude=(2.0, 2.0), offset=(0.6, 0.6))),
        Film("amplitudes 8 and 2", Folds(amplitude=(8.0, 2.0), offset=(1.5, 1.5)), Picture(tilt=8.0)),
        Film("blur 1.5 px", Folds(lag=0.3), Picture(blur=1.5)),
        Film("noise 8", Folds(lag=-0.35), Picture(noise=8.0)),
        Film("lamp", Folds(amplitude=(7.0, 8.0)), Picture(lamp=0.4)),
        Film("phase -70 deg", Folds(lag=-70 * degree, offset=(2.5, 2.5)), Picture(tilt=5.0)),
        Film("phase 25 deg, gap", replace(parted(3.0), lag=25 * degree)),
        Film("phase 120 deg", Folds(lag=120 * degree, offset=(3.0, 3.0))),
        Film("left polyp 5 px", polyp(5.0, 0, 4.0), Picture(tilt=-5.0)),
        Film("bow of -6 px, tilt", Folds(bow=-6.0, lag=0.4), Picture(tilt=10.0)),
        Film("gap 1 px all along", parted(1.0)),
        Film("gap 3 px, noise 5", parted(3.0), Picture(noise=5.0)),
        Film("chink 6 px, tilt", Folds(chink=6.0, lag=0.3), Picture(tilt=7.0)),
        Film("zipper 90 deg", Folds(zipper=90 * degree), Picture(tilt=-3.0)),
        Film("zipper -45 deg, phase 30 deg", Folds(zipper=-45 * degree, lag=30 * degree)),
        Film("strand 3 px, lag", Folds(lag=0.5), Picture(strand=3.0, tilt=4.0)),
        Film("occluded 20 %", Folds(lag=0.3), Picture(occluded=0.2)),
        Film("occluded 35 %, tilt", Folds(amplitude=(6.0, 9.0)), Picture(occluded=0.35, tilt=8.0)),
        Film("zoom 1.3", Folds(length=90.0), Picture(zoom=1.3, size=(210, 180)), count=360),
        Film("drift", Folds(lag=0.3), Picture(drift=(7.0, -5.0), size=(220, 180))),
        Film("frames dropped", Folds(pitch=150.0), taken="dropped", count=320),
        Film("frames repeated", Folds(pitch=150.0), taken="repeated", count=320),
        Film("counter", Folds(amplitude=(9.0, 7.0)), Picture(counter=True)),
        Film("black corners", Folds(lag=0.3), Picture(corners=True, size=(200, 200))),
        Film("onset", Folds(lag=0.3, voiced=(0.03, math.inf)), count=320),
        Film("abduction", Folds(amplitude=(9.0, 7.0), voiced=(-math.inf, 0.055)), count=320),
    ]
    return [replace(film, seed=100 + k) for k, film in enumerate(films)]


def drawn_films(count: int, seed: int) -> list[Film]:
    """Others, all of whose features are drawn at random: what nobody has looked at."""
    return [_drawn(k, np.random.default_rng([seed, k])) for k in range(count)]


def _drawn(number: int, rng: np.random.Generator) -> Film:
    def between(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    def often(share: float) -> bool:
        return bool(rng.random() < share)

    larger = between(4, 10)
    amplitude = (larger, larger * between(0.5, 1.0))
    folds = Folds(
        pitch=between(110, 260),
        length=between(80, 130),
        amplitude=amplitude if often(0.5) else amplitude[::-1],
        offset=(between(0.5, 2.5), between(0.5, 2.5)),
        lag=between(-1.2, 1.2) if often(0.5) else 0.0,
        zipper=between(-1.2, 1.2) if often(0.3) else 0.0,
        bow=between(-7, 7) if often(0.3) else 0.0,
        chink=between(3, 6) if often(0.2) else 0.0,
        skew=between(-0.5, 0.2),
        vibrato=0.01 if often(0.2) else 0.0,
    )
    kind = rng.choice(["plain", "plain", "still", "gap", "polyp"])
    if kind == "still":
        still = still_fold(between(0, 7), between(-4, 3), between(5, 8), int(rng.integers(2)))
        folds = replace(folds, amplitude=still.amplitude, offset=still.offset, lag=0.0, bow=0.0)
    elif kind == "gap":
        wide = between(1.0, 5.0) / 2
        offset = (folds.amplitude[0] + wide, folds.amplitude[1] + wide)
        folds = replace(folds, offset=offset, bow=0.0)
    elif kind == "polyp":
        swollen = polyp(between(3, 7), int(rng.integers(2)), between(4, 7))
        folds = replace(folds, amplitude=(6.0, 6.0), offset=swollen.offset, bump=swollen.bump)
    picture = Picture(
        size=(210, 180),
        tilt=between(-14, 14) if often(0.6) else 0.0,
        blur=between(0.6, 1.3),
        noise=between(1, 6),
        texture=between(0.04, 0.14),
        dark=between(15, 40),
        lamp=between(-0.35, 0.35) if often(0.2) else 0.0,
        strand=between(1.5, 3.5) if often(0.15) else 0.0,
        drift=(between(-5, 5), between(-5, 5)) if often(0.2) else (0.0, 0.0),
        corners=often(0.15),
        counter=often(0.15),
    )
    taken: Literal["all", "dropped", "repeated"] = "all"
    if often(0.1):
        taken = "dropped" if often(0.5) else "repeated"
    fps, seed = between(3000, 6000), int(rng.integers(10**6))
    return Film(f"drawn {number}: {kind}", folds, picture, fps, 240, seed, taken)


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
