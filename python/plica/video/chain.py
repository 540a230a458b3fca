"""The steps of an analysis: drift, glottis, sides, flow, trust, paths, modes, waves; kept as they come.

results.h5 has a group for each step that is done (results.py). The flow, which is large, is in flow.h5, laid
out at its full length when it is begun; each pair's entry says with which masks it was found, so that only
those are computed that are not there, or whose masks were corrected.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import astuple
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np
import numpy.typing as npt

from plica.storage.files import replaced, require_space
from plica.storage.hdf5 import CHECKSUMS, create, lay_out, put, put_text, write_row
from plica.storage.stored import Stored
from plica.video.errors import VideoError
from plica.video.files.recording import Grey, Recording, spread
from plica.video.glottis.brightness import dark_level
from plica.video.glottis.coverage import to_stored
from plica.video.glottis.drawn_border import border_off
from plica.video.glottis.edge_blur import EdgeProfiles
from plica.video.glottis.fold_edges import fold_edges
from plica.video.glottis.frame_outline import Finder
from plica.video.glottis.glottal_area import GlottalArea, areas
from plica.video.glottis.hidden_slits import lost_to_blur
from plica.video.glottis.kymogram import kymogram
from plica.video.glottis.midline import Midline, closing_in, find_midline, pixels
from plica.video.glottis.midline_profiles import MidlineGrey
from plica.video.glottis.network import Network
from plica.video.glottis.segmenter import learn
from plica.video.measures.waveforms import area_cycles
from plica.video.motion.drift import Drift, Steadied, drift, still_region, without_drift
from plica.video.motion.edge_agreement import edge_agreement
from plica.video.motion.flow import flow, warp_error
from plica.video.motion.flow_origin import FlowOrigin
from plica.video.motion.fold_edges import Folds
from plica.video.motion.frame_content import Seen, bright, informing
from plica.video.motion.modes import modes
from plica.video.motion.mucosal_wave import fundamental
from plica.video.motion.trajectories import follow, spacing
from plica.video.results import HINT, Results, fill
from plica.video.settings import Settings

__all__ = ["Chain"]

T = TypeVar("T")
Mask = npt.NDArray[np.bool_]

_STEPS = ("drift", "glottis", "sides", "flow", "trust", "paths", "modes", "waves")
"""Each stands on those before it."""
_CLOSES = 0.5  # px; a pixel is trusted in a pair if its way there and back misses by less
_SAME_LINE = 1.0  # px; the flow is not found again for a midline that moves by less
_SAME_DARK = 3.0  # grey levels; nor for a glottis that is darker or brighter by less
_BLIND = 0.01  # share of a frame's pixels; with fewer to look at nothing is said of its motion
_TRUSTED = 0.5  # confidence from which a pixel counts in the modes


class Chain:
    """The analysis of one recording in one directory."""

    def __init__(
        self,
        results: Results,
        recording: Recording,
        settings: Settings,
        network: Network | None,
        *,
        shown: bool,
    ) -> None:
        self._results, self._flows = results, results.flows
        self._recording, self._settings, self._shown = recording, settings, shown
        self._network = network
        self._count, self._shape = recording.count, recording.shape

    def run(self, until: str) -> None:
        """Do what is not done yet, as far as this step."""
        for name in _STEPS[: _STEPS.index(until) + 1]:
            if name not in self._results:
                getattr(self, f"_{name}")()

    def check(self, masks: Mapping[int, Mask] | None = None) -> None:
        """Correct results that are there by these masks, before anything else of them is dropped.

        VideoError, and nothing changed, where they do not tell how the glottis looks, or where the midline
        that was set has no glottis on one of its sides, if that is known.
        """
        if not self._results.path.exists():
            return
        if masks and not self._results.outdated():
            self.correct(masks)
        if self._settings.midline is not None and "glottis" in self._results:
            self._require_both_sides(Midline.between(self._settings.midline))

    def correct(self, masks: Mapping[int, Mask]) -> None:
        """Take these masks for their frames, beside those drawn before; without any, drop all of them.

        VideoError, and nothing changed, where they do not tell how the glottis looks.
        """
        before = self._results.drawn()
        drawn = {**before, **masks} if masks else {}
        if drawn.keys() == before.keys() and all(np.array_equal(before[k], drawn[k]) for k in drawn):
            return
        if "drift" not in self._results:
            self._drift()
        self._finder(drawn)
        self._results.correct(drawn)

    def _drifted(self) -> Drift:
        return Drift(*self._results.read("drift/motion", "drift/likeness"))

    def _steady(self) -> Steadied:
        return Steadied(self._recording, self._drifted().motion)

    def _finder(self, drawn: Mapping[int, Mask]) -> Finder:
        """What finds the glottis: the network, or how it looks in masks that are drawn or in all frames."""
        return self._network or learn(self._steady(), drawn, self._drifted().lost)

    def _require_both_sides(self, line: Midline) -> None:
        """VideoError where one side of a line that was set has no glottis."""
        right = line.place(pixels(self._shape))[..., 1] > 0
        seen = np.zeros(2, dtype=bool)
        for mask in self._results.masks():
            seen |= (mask & ~right).any(), (mask & right).any()
        if not seen.all():
            ends = ", ".join(f"{end:g}" for end in line.ends)
            raise VideoError(f"Midline: {ends} px; must have glottis on both of its sides.")

    def _area(self) -> GlottalArea:
        names = (f"sides/{name}" for name in GlottalArea.names)
        return GlottalArea(*self._results.read(*names))  # as the flow sees it

    def _midline(self) -> Midline:
        return Midline.of(self._results.read("sides/midline")[0])

    def _watched(self, what: str, items: Iterable[T], total: int) -> Iterator[T]:
        """The items, with a bar on standard error."""
        if not self._shown:
            yield from items
            return
        from tqdm import tqdm

        yield from tqdm(items, desc=what, total=total, unit=" frames", mininterval=0.5)

    # ---- Steps -----------------------------------------------------------------------------------

    def _drift(self) -> None:
        recording = self._recording
        if not self._settings.correct_drift:
            found = Drift.none(self._watched("light", recording.frames(), recording.count))
        else:
            still = still_region(spread(recording.frames()), 0.5)
            first = drift(self._watched("drift", recording.frames(), recording.count), still)
            still = still_region(spread(without_drift(recording.frames(), first.motion)), 0.3)
            found = drift(self._watched("drift again", recording.frames(), recording.count), still)
        self._results.store("drift", motion=found.motion, likeness=found.likeness)

    def _glottis(self) -> None:
        drawn, steady, lost = self._results.drawn(), self._steady(), self._drifted().lost
        finder = self._finder(drawn)

        def add(file: h5py.File) -> None:
            shape, rows = (self._count, *self._shape), {}
            for name in ("mask", "coverage", "inner"):
                data = lay_out(file, f"glottis/{name}", shape, np.uint8, "1", packed=True)
                rows[name] = data, file[f"{CHECKSUMS}/glottis/{name}"]
            band, border = np.empty((self._count, 2)), np.zeros(self._count, dtype=bool)
            confined, off = np.zeros(self._count), np.full((self._count, 2), np.nan)
            tissue, always = np.ones((2, *self._shape), dtype=bool)
            for index, frame in enumerate(self._watched("glottis", steady.frames(), self._count)):
                mask, found = drawn.get(index), None
                if mask is not None:
                    band[index], off[index] = mask.sum(), border_off(frame, mask)
                elif lost[index]:
                    mask = np.zeros(self._shape, dtype=bool)
                    band[index] = np.nan
                else:
                    found = finder.outline(frame, index)
                    mask, band[index] = found.mask, (found.least, found.largest)
                write_row(*rows["mask"], index, mask)
                for name in ("coverage", "inner"):
                    covered = mask if found is None else getattr(found, name)
                    write_row(*rows[name], index, to_stored(covered))
                confined[index] = 0.0 if found is None else found.confined
                border[index] = mask[[0, -1]].any() or mask[:, [0, -1]].any()
                tissue &= ~mask
                if np.isfinite(band[index, 0]):
                    always &= mask
            if self._network is not None and tissue.all():
                raise self._network.found_nothing(self._count)
            fill(
                file,
                "glottis",
                always=always,
                left_out=finder.left_out(~tissue),
                blur=np.array(finder.blur),
                least=band[:, 0],
                largest=band[:, 1],
                border=border,
                confined=confined,
                border_off=off,
                tissue=tissue,
            )

        self._results.change(add)

    def _sides(self) -> None:
        ends = self._settings.midline
        line = find_midline(self._results.masks()) if ends is None else Midline.between(ends)
        if ends is not None:
            self._require_both_sides(line)
        meeting = closing_in(self._results.coverages(), line, keep_ends=ends is not None)
        midline = meeting if ends is None else meeting.as_set
        (tissue,), lost = self._results.read("glottis/tissue"), self._drifted().lost
        folds = (tissue > 0) & midline.near(self._shape)
        light: list[tuple[float, ...]] = []
        right = midline.place(pixels(self._shape))[..., 1] > 0
        beside = [folds & ~right, folds & right]
        edges = fold_edges(self._results.coverages(), midline)
        profiles, across = EdgeProfiles(midline), MidlineGrey(midline, folds, edges)

        def seen() -> Iterator[Grey]:
            frames = self._watched("kymograms", self._steady().frames(), self._count)
            for frame, covered in zip(frames, self._results.coverages(), strict=True):
                light.append((*_light(frame, folds), *(float(frame[part].mean()) for part in beside)))
                profiles.add(frame, covered >= 0.5)
                across.add(frame, covered)
                yield frame

        half = max(0.25 * min(self._shape), midline.reach(tissue > 0))
        lines = kymogram(seen(), midline, self._settings.places, half)
        sharpness, saturated, *brightness = np.array(light).T
        denoising = float(self._results.read("glottis/blur")[0])
        blur = float(np.hypot(profiles.blur, denoising))
        area, inner = (
            areas(self._results.coverages(name), midline, blur if np.isfinite(blur) else 0.0)
            for name in ("coverage", "inner")
        )
        drawn = np.isin(np.arange(self._count), list(self._results.drawn()))
        unknown = lost & ~drawn
        sides = {
            f"{part}{name}": np.where(unknown, np.nan, values)
            for part, of in (("", area), ("inner_", inner.within(area)))
            for name, values in of.stored.items()
        }
        halfway = np.isfinite(denoising) & ~drawn & ~lost
        lost_of = lost_to_blur(across.lines(), blur, halfway, area.share_of_left)
        sides |= {
            f"{part}{name}": values
            for part, of in (("lost_", lost_of.outline), ("inner_lost_", lost_of.inner))
            for name, values in of.parts.items()
        }
        self._results.store(
            "sides",
            **sides,
            midline=midline.numbers,
            meeting=meeting.numbers,
            folds=folds,
            sharpness=sharpness,
            saturated=saturated,
            brightness=np.nanmean(brightness, axis=1),
            blur=np.array(profiles.blur),
            blur_band=lost_of.band,
            lost_most=lost_of.most,
            lost_shade=np.array(lost_of.shade),
            kymogram=lines.astype(np.float32),
        )

    def _flow(self) -> None:
        pairs = self._count - 1
        line, dark, taken = self._flow_line(), self._flow_dark(), self._flows.exists()
        if taken:  # what it took before, but where today's is another
            with Stored(self._flows, hint=HINT) as file:
                before, level = file.read("midline"), float(file.read("dark"))
            alike = before.shape == line.shape and np.abs(before - line).max() <= _SAME_LINE
            line = before if alike else line
            dark = level if abs(level - dark) <= _SAME_DARK else dark
        start = zlib.crc32(np.append(line, dark).tobytes())
        prints = [zlib.crc32(np.packbits(mask).tobytes(), start) for mask in self._results.masks()]
        asked = np.array([one << 32 | other for one, other in pairwise(prints)], dtype=np.uint64)
        origin, stale = FlowOrigin.of(self._settings.preset), np.arange(pairs)
        if taken:
            with Stored(self._flows, hint=HINT) as file:
                stale = np.flatnonzero(np.asarray(file.data("checksum")) != asked)  # guards itself
                if stale.size and origin.difference(FlowOrigin.read(file)):  # no flows of two programs in one
                    stale = np.arange(pairs)
        if stale.size == pairs:  # all, too, where the midline or the dark level is another
            self._lay_out_flow(pairs, line, dark, origin)
        with Stored(self._flows, "r+", hint=HINT) as file:
            done = file.data("checksum")
            folds = Midline.of(line.tolist()), dark
            for index, before, after in self._watched("flow", self._pairs(stale), stale.size):
                done[index] = 0  # until all of the pair is there
                file.file.flush()
                self._store_pair(file, index, before, after, folds)
                file.file.flush()
                done[index] = asked[index]
                file.file.flush()
        self._results.change(lambda results: put_text(results, "flow/file", self._flows.name))

    def _lay_out_flow(
        self, pairs: int, line: npt.NDArray[np.float64], dark: float, origin: FlowOrigin
    ) -> None:
        """In the place of what is there."""
        large = (pairs, *self._shape, 2)
        self._flows.unlink(missing_ok=True)
        require_space(self._flows.with_name("flow.h5.space"), 8 * int(np.prod(large)))

        def write(draft: Path) -> None:
            with create(draft) as file:
                lay_out(file, "uv", large, "f4", "px", None)
                lay_out(file, "round_trip", large, "f4", "px", None)
                lay_out(file, "residual", (pairs,), "f8", "grey levels", np.nan)
                lay_out(file, "warp_error", (pairs,), "f8", "grey levels", np.nan)
                lay_out(file, "brightness", (pairs,), "f8", "1", np.nan)
                lay_out(file, "unevenness", (pairs,), "f8", "1", np.nan)
                put(file, "midline", line, "px", "x, y of both ends, then its bow")
                put(file, "dark", dark, "grey levels")
                origin.write(file)
                meaning = "checksum of masks, midline and dark level; 0: not done"
                lay_out(file, "checksum", (pairs,), "u8", "1", 0, meaning, guarded=False)

        replaced(self._flows, write)

    def _flow_line(self) -> npt.NDArray[np.float64]:
        """The line in which the folds meet, as numbers. The flow is found again where it is over a pixel off
        the one that it took: a mask that is corrected moves it by less."""
        name = "sides/meeting" if "sides/meeting" in self._results else "sides/midline"  # of before
        return np.asarray(self._results.read(name)[0])

    def _flow_dark(self) -> float:
        """Grey level of the widest glottis. The flow is found again where this is over three grey levels off
        that which it took."""
        sizes = [int(mask.sum()) for mask in self._results.masks()]
        widest = int(np.argmax(sizes))
        frame, mask = next(self._steady().frames(widest)), next(self._results.masks(widest))
        return dark_level(frame, mask)

    def _pairs(self, wanted: npt.NDArray[np.int_]) -> Iterator[tuple[int, Seen, Seen]]:
        """Pairs of frames, and what they show."""
        begin = int(wanted[0]) if wanted.size else self._count
        before: Seen | None = None
        lost = self._drifted().lost
        frames = zip(self._steady().frames(begin), self._results.masks(begin), strict=True)
        for index, (frame, glottis) in enumerate(frames, start=begin):
            seen = Seen(frame, glottis, bool(lost[index]))
            if before is not None and index - 1 in wanted:
                yield index - 1, before, seen
            if index > wanted[-1]:
                return
            before = seen

    def _store_pair(
        self, file: Stored, index: int, before: Seen, after: Seen, folds: tuple[Midline, float]
    ) -> None:
        tissue = before.tissue
        if before.lost or after.lost or tissue.mean() < _BLIND:
            file.put_row("uv", index, 0.0)
            for name in ("round_trip", "residual", "warp_error", "brightness", "unevenness"):
                file.put_row(name, index, np.nan)
            return
        pair = flow(
            before.frame,
            after.frame,
            preset=self._settings.preset,
            mask=informing(before, after),
            intensity=(0.0, 255.0),
            round_trip=True,
            folds=Folds(before.glottis, after.glottis, *folds),
        )
        assert pair.round_trip is not None
        file.put_row("uv", index, pair.flow)
        file.put_row("round_trip", index, np.where(tissue[..., None], pair.round_trip, np.nan))
        left = pair.residual[tissue & np.isfinite(pair.residual)]
        file.put_row("residual", index, np.sqrt(np.mean(np.square(left, dtype=float))))
        file.put_row("brightness", index, pair.light.change)
        file.put_row("unevenness", index, np.ptp(pair.light.gain))
        file.put_row("warp_error", index, warp_error(before.frame, after.frame, pair.flow).rms)

    def _trust(self) -> None:
        (folds,) = self._results.read("sides/folds")
        pairs = self._count - 1
        mismatch, trusted = np.empty(pairs), np.zeros(self._shape)
        with Stored(self._flows, hint=HINT) as file:
            residual, ways = file.read("residual"), file.rows("round_trip")
            flows = iter(file.rows("uv"))
            edges = edge_agreement(flows, self._results.masks(), self._area(), self._midline())
            for k in self._watched("trust", range(pairs), pairs):
                missed = np.hypot(*np.moveaxis(ways[k], -1, 0))
                mismatch[k] = _median(missed[folds > 0])
                trusted += missed < _CLOSES
        self._results.store(
            "trust",
            mismatch=mismatch,
            confidence=(trusted / max(int(np.isfinite(residual).sum()), 1)).astype(np.float32),
            edges=np.array(astuple(edges)),
        )

    def _paths(self) -> None:
        height, width = self._shape
        y, x = np.mgrid[spacing : height - spacing : spacing, spacing : width - spacing : spacing]
        points = np.stack([x.ravel(), y.ravel()], axis=1)
        points = points[~next(self._results.masks())[points[:, 1], points[:, 0]]]
        with Stored(self._flows, hint=HINT) as file:
            paths = follow(iter(file.rows("uv")), points.astype(float))
        cycles = area_cycles(self._area())
        closing = paths.closing_error(cycles, np.arange(float(self._count)))
        self._results.store("paths", places=paths.places, closing=closing)

    def _modes(self) -> None:
        tissue, confidence = self._results.read("glottis/tissue", "trust/confidence")
        midline = self._midline()
        used = (tissue > 0) & (confidence >= _TRUSTED)
        if not used.any():
            raise VideoError(
                f"Modes: no pixel of tissue is seen well in {_TRUSTED:.0%} of the pairs of frames; must be "
                "some. Is the recording sharp, and its light steady? plica glottis needs no motion."
            )
        with Stored(self._flows, hint=HINT) as file:
            seen = np.isfinite(file.read("residual"))
            count = self._mode_count(int(seen.sum()), int(used.sum()))
            found = modes(file.whole("uv"), count, used, midline, seen)
            ways = file.rows("round_trip")
            error = np.array([np.tensordot(found.patterns, np.nan_to_num(way), 3) for way in ways])
        self._results.store(
            "modes",
            mean=found.mean.astype(np.float32),
            patterns=found.patterns.astype(np.float32),
            coefficients=found.coefficients,
            round_trip=_running_rms(error) / np.sqrt(2.0),
            share=found.share,
            symmetry=found.symmetry(midline),
            variance=np.array(found.variance),
            used=used,
            repeated=found.repeated,
            travelling=found.travelling,
        )

    def _waves(self) -> None:
        cycles = area_cycles(self._area())
        (used,), midline = self._results.read("modes/used"), self._midline()
        half = (self._results.shape("sides/kymogram")[2] - 1) // 2
        with Stored(self._flows, hint=HINT) as file:
            uv = file.rows("uv")
            across = (flow @ midline.across for flow in uv)
            lines = kymogram(across, midline, self._settings.places, half).astype(np.float32)
            seen = np.isfinite(file.read("residual"))
            flows = (uv[k] if seen[k] else np.full((*self._shape, 2), np.nan) for k in range(seen.size))
            found = fundamental(flows, cycles, np.arange(float(self._count)), used > 0, midline)
        if found is None:
            self._results.store("waves", known=False, kymogram=lines)
            return
        parts = {name: np.stack([values.real, values.imag]) for name, values in vars(found).items()}
        self._results.store(
            "waves",
            known=True,
            kymogram=lines,
            **{name: part.astype(np.float32) for name, part in parts.items()},
        )

    def _mode_count(self, pairs: int, pixels: int) -> int:
        """As many as were asked for; VideoError where there are not so many."""
        most, asked = min(pairs - 1, 2 * pixels), self._settings.modes
        if asked is not None and asked > most:
            raise VideoError(
                f"Modes: modes = {asked}; must be at most {most}: {pairs} pairs of frames show tissue, "
                f"which is seen well at {pixels} pixels. The motion found is kept."
            )
        return min(self._settings.mode_count, most)


def _light(frame: Grey, folds: Mask) -> tuple[float, float]:
    """On the folds: the mean square of the difference of neighbours in a row, and the share of highlights."""
    steps = np.square(np.diff(frame, axis=1), dtype=float)
    return float(np.mean(steps[folds[:, 1:]])), float(np.mean(frame[folds] >= bright))


def _median(values: npt.NDArray[np.floating]) -> float:
    """Of those that are a number; not a number without one."""
    there = values[np.isfinite(values)]
    return float(np.median(there)) if there.size else float("nan")


def _running_rms(values: npt.NDArray[np.float64], width: int = 9) -> npt.NDArray[np.float64]:
    """(N, k) root of the mean of the squares over nine rows about each."""
    from scipy import ndimage

    square = ndimage.uniform_filter1d(np.square(values), width, axis=0, mode="nearest")
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))
