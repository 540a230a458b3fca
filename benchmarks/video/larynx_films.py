"""Films of a larynx from above whose folds move as said: what `larynx_judge.py` judges `plica video` by.

`larynx_renderer.py` draws them and has their truth. Neither shares anything with `plica`.

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

__all__ = ["Film", "Folds", "Picture", "drawn_films", "issue_films", "turn", "unseen_films"]

Array = NDArray[np.float64]
Pair = tuple[float, float]  # left, right in the image

ABDUCTED = 9.0  # px, of either fold from the line before and after the voice


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
        cos, sin = turn(self.picture.tilt)
        y = (rows - down) / zoom
        found = []
        for k in (0, 1):
            x = np.zeros_like(y)
            for _ in range(16):
                x = (self.folds.edges(y * cos - x * sin, np.array(t))[k] - y * sin) / cos
            found.append(x * zoom + right)
        return found[0], found[1]


def turn(degrees: float) -> tuple[float, float]:
    """Cosine and sine."""
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))


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
