"""A recording analysed, and the results read back (docs/recordings.md)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from plica.errors import Named, one_of
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure, Measures
from plica.measures.scale import Scale
from plica.measures.waveforms import RECORDED
from plica.storage.files import only_writer
from plica.storage.stored import Stored
from plica.video.chain import Chain
from plica.video.checks import corrected, drawn_masks, require_midline, require_modes
from plica.video.dataset import dataset_of
from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.corrections import Corrections
from plica.video.files.recording_date import FileDate
from plica.video.glottis.glottal_area import GlottalArea, read_area
from plica.video.glottis.midline import Midline
from plica.video.glottis.network import Network
from plica.video.glottis.vibrogram import vibrogram
from plica.video.light import light_of
from plica.video.measures.area_cautions import WholeGlottis, doubts
from plica.video.measures.frame_flags import flags
from plica.video.measures.frame_sequence import FrameSequence, frame_sequence
from plica.video.measures.wave_cautions import cautioned, unknown_waves
from plica.video.measures.wave_measures import wave_measures
from plica.video.measures.waveforms import area_cycles, measures, phases, scale_of
from plica.video.motion.drift import Drift, Steadied
from plica.video.motion.edge_agreement import EdgeAgreement
from plica.video.motion.flow_origin import FlowOrigin
from plica.video.motion.modes import Modes
from plica.video.motion.mucosal_wave import Fundamental, why_unknown
from plica.video.motion.trajectories import Paths
from plica.video.opening import open_recording
from plica.video.results import HINT, Results
from plica.video.settings import Settings
from plica.video.signals import Signals, renew_signals, signals_to_store, stored_signals, without_signals

if TYPE_CHECKING:
    import xarray

__all__ = ["Analysis", "Settings", "analyse", "load"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_UNTIL = {"glottis": "sides", "modes": "waves"}  # what is asked for, and the last step of it
_FEWEST = 4  # frames: three flows


def analyse(
    source: str | Path,
    directory: str | Path,
    settings: Settings | None = None,
    *,
    masks: str | Path | Corrections | Mapping[int, Mask] | None = None,
    until: str = "modes",
    progress: bool = True,
) -> Analysis:
    """Analyse a recording and store the results in `directory` as they come; goes on where it was stopped.

    Parameters
    ----------
    source : str or Path
        As for :meth:`Recording.open`.
    directory : str or Path
    settings : Settings, optional
    masks : folder, Corrections, or dict of frame to (h, w) bool, optional
        The glottis as drawn by hand, for some frames: they are taken for those, and the others are found by
        what they show. May be given when the analysis is done: what depends on them is done again. They are
        kept beside those drawn before; an empty dict drops all. `Corrections` correct settings, too.
    until : {"glottis", "modes"}
        The last step to do: "glottis" (masks, area, kymograms) or "modes", everything.
    progress : bool
        Bars on standard error.

    Raises
    ------
    VideoError
        For a recording, settings or masks that cannot be used, and where `directory` holds another analysis.
    StorageFailed
        Where the disk is too small.
    """
    if until not in _UNTIL:
        raise VideoError(f'Video: until = "{until}"; must be {one_of(_UNTIL)}.')
    chosen = corrected(settings or Settings(), masks)
    recording = open_recording(source, chosen)
    if until == "modes" and recording.count < _FEWEST:
        raise VideoError(
            f"Video: {source} has {recording.count} frames; must have {_FEWEST} or more for modes. For the "
            "glottis alone (plica glottis) fewer will do."
        )
    require_modes(chosen, recording)
    require_midline(chosen, recording)
    drawn = None if masks is None else drawn_masks(masks, Path(source), recording)
    network = None if chosen.segmenter is None else Network(chosen.segmenter)
    where = Path(directory)
    where.mkdir(parents=True, exist_ok=True)
    with only_writer(where):
        results = Results(where / "results.h5")
        chosen = without_signals(results.merged(Path(source), recording, chosen), chosen)
        if chosen.fps is None and recording.camera is not None:
            chosen = replace(chosen, fps=recording.camera.fps)
        chain = Chain(results, recording, chosen, network, shown=progress)
        chain.check(drawn)  # before anything is dropped
        signals = signals_to_store(results, chosen, recording.count)
        results.claim(Path(source), recording, chosen)
        renew_signals(results, signals)
        if drawn is not None:
            chain.correct(drawn)
        chain.run(_UNTIL[until])
    return load(where)


def load(directory: str | Path, *, needs: str = "sides") -> Analysis:
    """The analysis in a directory. Raises VideoError where there is none, or it has not come to the group
    `needs` of results.h5."""
    where = Path(directory)
    path = where / "results.h5"
    if not path.exists():
        raise VideoError(f"Video: {where} has no results.h5; must be the directory of an analysis.")
    with Stored(path, hint=HINT) as file:
        if file.attribute("/", "settings") is None:
            raise VideoError(f"Video: {path} is no analysis of a recording; must be. Take another directory.")
        if needs not in file:
            lacks = "is not finished. Start it again"
            if "sides" in file:
                lacks = f"stops at the glottis; must have {needs}. Run plica video with the same -o"
            raise VideoError(f"Video: the analysis in {where} {lacks}: it goes on.")
    return Analysis(where)


class Analysis:
    """What was found in a recording: the files in a directory, read where they are asked for.

    Attributes
    ----------
    directory : Path
    source : Path
        The recording.
    settings : Settings
    file_date : FileDate
        The day that the recording's file says it was made on, and the tag that does; empty where it says
        none.
    camera : Camera or None
        What the file of a high-speed camera, or of DICOM, said.
    segmenter : str
        Fingerprint of the network that found the glottis; empty where its edges and its darkness did.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.path = directory / "results.h5"
        self._results = Results(self.path)
        marks = self._results.marks_of_today()
        low, high = marks["scale"]
        self._scale = float(low), float(high)
        self.source = Path(marks["source"])
        self.settings = Settings.from_json(marks["settings"])
        self.file_date = FileDate(*json.loads(marks["file_date"]))
        self.segmenter = str(marks["segmenter"])
        camera = json.loads(marks["camera"])
        self.camera = None if camera is None else Camera(**camera)

    def __repr__(self) -> str:
        return f"<Analysis {self.directory}: {self.count} frames of {self.source.name}>"

    def __contains__(self, name: str) -> bool:
        """Whether results.h5 has a group or data set of this name."""
        return name in self._results

    def __getitem__(self, name: str) -> Any:
        """A data set of results.h5 by its name, ``"sides/left"``; VideoError where it is not there."""
        self._require(name)
        return self._results.read(name)[0]

    def _require(self, name: str) -> None:
        if name not in self._results:
            raise VideoError(f'Video: {self.path} has no "{name}"; must have it. Is the analysis done?')

    @property
    def label(self) -> str:
        """What the recording is called: its label, else the name of its file."""
        return self.settings.label or self.source.name

    @property
    def recorded(self) -> str:
        """When it was recorded, as it was told, else as its file says; empty where that is not known."""
        return self.settings.recorded or self.file_date.day

    @property
    def described(self) -> dict[str, str]:
        """Label, day of recording, and the file's tag that it is from; what is not known is not in it."""
        told = self.settings.recorded is not None
        found = {
            "label": self.settings.label or "",
            "recorded": self.recorded,
            "recorded_by": "" if told else self.file_date.tag,
        }
        return {name: text for name, text in found.items() if text}

    @property
    def complete(self) -> bool:
        """Whether the flow and its modes are there, not the glottis alone."""
        return "modes" in self

    @cached_property
    def area(self) -> GlottalArea:
        """px^2, px."""
        return read_area(lambda name: np.asarray(self[f"sides/{name}"]))

    @cached_property
    def count(self) -> int:
        """Frames."""
        return len(self["drift/motion"])

    @cached_property
    def time(self) -> Floats:
        """(frames) s, or frames where the frame rate is unknown."""
        return np.arange(self.count) / (self.settings.fps or 1.0)

    @cached_property
    def midline(self) -> Midline:
        """px of the frames as used."""
        return Midline.of(self["sides/midline"])

    @cached_property
    def _of_area(self) -> tuple[Measures, Cycles]:
        known = self.settings.fps, self.settings.mm_per_px
        sides = self.side("left"), self.side("right")
        band = self["glottis/least"], self["glottis/largest"]
        found, cycles = measures(
            self.area,
            *known,
            self.midline.length,
            sides,
            doubts=self._of_glottis,
            band=band,
            brightness=self["sides/brightness"],
        )
        sequence = self.frame_sequence
        (frequency,) = cautioned([found["fundamental_frequency"]], [sequence.caution()])
        items = [frequency if item.name == frequency.name else item for item in found.values()]
        return Measures(sequence.doubted(cautioned(items, sequence.doubts())), found.scale), cycles

    @cached_property
    def frame_sequence(self) -> FrameSequence:
        """Frames that are missing, or there twice, as far as the motion of the folds shows it."""
        cycles = self.cycles_in_frames
        starts = cycles.starts if cycles.verdict != "diplophonic" else np.zeros(0)
        return frame_sequence(self.vibrogram.sum(axis=0), starts)

    @cached_property
    def fundamental(self) -> Fundamental | None:
        """Complex amplitudes of displacement (px) and strain at the cycles' frequency; None where they are
        not known: without flow, without cycles."""
        if "waves/known" not in self or not self["waves/known"]:
            return None
        parts = (self[f"waves/{name}"] for name in ("displacement", "strain"))
        return Fundamental(*(real + 1j * imaginary for real, imaginary in parts))

    def wave_measures(self, *, mirrored: bool = False) -> list[Measure]:
        """Strain and mucosal waves, with what speaks against the area whose cycles they are of; `mirrored`
        with left and right changed. Empty without flow."""
        if "waves/known" not in self:
            return []
        cycles = self.cycles_in_frames
        if self.fundamental is None or cycles.no_period:
            return unknown_waves(why_unknown(cycles))
        period, rate = float(np.median(cycles.periods)), self.settings.fps or 1.0
        seen = self.fundamental, self.midline, self["sides/folds"] > 0
        found = wave_measures(*seen, period, self.pixel, rate, mirrored=mirrored)
        told = area_cycles(self.area.mirrored, self.settings.fps) if mirrored else self.cycles
        return cautioned(found, (told.note, *self.doubts))

    @cached_property
    def cycles_in_frames(self) -> Cycles:
        """Of the glottal area, in frames."""
        return area_cycles(self.area)

    @property
    def doubts(self) -> list[str]:
        """What speaks against the whole recording, a sentence each; empty where nothing does."""
        return [*self._of_glottis, *self.frame_sequence.doubts()]

    @cached_property
    def _of_glottis(self) -> list[str]:
        """What speaks against the glottal area."""
        drawn = ("glottis/border_off",) if "glottis/border_off" in self else ()  # else an earlier version's
        return doubts(
            WholeGlottis(
                self.area.total,
                self["glottis/always"] > 0,
                self["glottis/left_out"] > 0,
                self.midline,
                self["glottis/border"] > 0,
                self.settings.fps,
                self.settings.mm_per_px,
                float(self["sides/blur"]),
                self["glottis/confined"],
                *(self[name] for name in drawn),
            )
        )

    @property
    def scale(self) -> Scale:
        """Whether lengths and times are in m and s, or in px and frames."""
        return scale_of(self.settings.fps, self.settings.mm_per_px)[2]

    @property
    def pixel(self) -> float:
        """What a pixel is: m, or 1 px where that is not known."""
        return scale_of(self.settings.fps, self.settings.mm_per_px)[0]

    def side(self, name: str) -> str:
        """ "left" or "right" in the image, and whose it is where that is known."""
        patient_left = self.settings.patient_left
        if patient_left is None:
            return f"{name} in the image"
        return f"{name} in the image (the patient's {'left' if name == patient_left else 'right'})"

    @cached_property
    def measures(self) -> Measures:
        """In m where the size of a pixel is known, in Hz where the frame rate is; else in px and frames."""
        of_picture = [*self._of_area[0].values(), *self.wave_measures()]
        return Measures(self.signals.beside(of_picture), self.scale)

    @cached_property
    def signals(self) -> Signals:
        """Sound and electroglottogram beside the picture; empty where none was given."""
        return Signals(stored_signals(self._results, self.settings), self.area, self.cycles, self.settings)

    @property
    def cycles(self) -> Cycles:
        """Of the glottal area; in the unit of `time`."""
        return self._of_area[1]

    @cached_property
    def phase(self) -> list[str]:
        """Of each frame: "closed", "opening", "open", "closing", "" outside the cycles."""
        return phases(self.area, self.cycles, self.time)

    @cached_property
    def flags(self) -> list[str]:
        """Of each frame: what speaks against it, by commas; "" where nothing does."""
        return flags(
            self.area.total,
            Drift(self["drift/motion"], self["drift/likeness"]),
            self["sides/sharpness"],
            self["sides/saturated"],
            self["glottis/border"] > 0,
            self["flow/residual"] if self.complete else None,
            self.brightness if self.complete else None,
        )

    @cached_property
    def flow_origin(self) -> FlowOrigin | None:
        """What found the flow; None without flow."""
        if "flow/probe" not in self:
            return None
        with Stored(self._results.flows, hint=HINT) as file:
            return FlowOrigin.read(file)

    @cached_property
    def brightness(self) -> Floats:
        """(frames - 1) share by which the light makes the next frame brighter; not a number in a pair without
        flow."""
        return np.asarray(self["flow/brightness"])

    @cached_property
    def edges(self) -> EdgeAgreement:
        """The flow beside the folds' edges against the way of the edges."""
        slope, correlation, count = self["trust/edges"].tolist()
        return EdgeAgreement(slope, correlation, int(count))

    @cached_property
    def vibrogram(self) -> Floats:
        """(2, places, frames) px, distance of the left and of the right fold's edge from the midline, from
        its upper to its lower end; not a number where the area is not known."""
        blur = np.nan_to_num(np.hypot(self["sides/blur"], self["glottis/blur"]))
        known = np.isfinite(self.area.total)
        return vibrogram(self._results.coverages(), self.midline, known, blur=float(blur))

    @property
    def drawn(self) -> list[int]:
        """Frames whose mask was drawn by hand."""
        return sorted(self._results.drawn())

    def mask(self, frame: int) -> Mask:
        """(h, w) where the glottis is."""
        return np.asarray(self._entry("glottis/mask", frame) > 0)

    def flow(self, frame: int) -> npt.NDArray[np.float32]:
        """(h, w, 2) px, from this frame to the next."""
        return np.asarray(self._entry("flow/uv", frame))

    def round_trip(self, frame: int) -> npt.NDArray[np.float32]:
        """(h, w, 2) px, where one lands after going to the next frame and back; not a number where the frames
        say nothing."""
        return np.asarray(self._entry("flow/round_trip", frame))

    def _entry(self, name: str, frame: int) -> Any:
        self._require(name)
        count = self._results.shape(name)[0]
        if not -count <= frame < count:
            raise VideoError(f'Video: frame {frame} of "{name}"; must be in [0, {count}).')
        return self._results.row(name, frame % count)

    @cached_property
    def paths(self) -> Paths:
        """Of points on a grid, px."""
        return Paths(self["paths/places"])

    @cached_property
    def modes(self) -> Modes:
        """Of the tissue that is seen in every frame, and well in half of them or more."""
        names = ("mean", "patterns", "coefficients", "share", "repeated", "travelling")
        parts = {name: self[f"modes/{name}"] for name in names}
        return Modes(variance=float(self["modes/variance"]), mask=self["modes/used"] > 0, **parts)

    def frames(self) -> Steadied:
        """The recording as it was analysed: turned, cut, without the endoscope's motion.

        Raises
        ------
        VideoError
            Where the recording is not there any more, or has another number of frames.
        """
        return self._steadied

    @cached_property
    def _steadied(self) -> Steadied:
        recording = open_recording(self.source, self.settings, self._scale)
        if recording.count != self.count:
            raise VideoError(
                f"Video: {self.source} has {recording.count} frames; must have {self.count}, as when its "
                f"analysis in {self.directory} began."
            )
        return Steadied(recording, self["drift/motion"])

    @cached_property
    def waveforms(self) -> dict[str, npt.NDArray[Any]]:
        """What there is of every frame, by name; units in `units`. The last frame has no flow."""
        size = self.pixel
        area = self.area
        found: dict[str, npt.NDArray[Any]] = {
            "time": self.time,
            "area_total": size**2 * area.total,
            "area_left": size**2 * area.left,
            "area_right": size**2 * area.right,
            "area_least": size**2 * self["glottis/least"],
            "area_largest": size**2 * self["glottis/largest"],
            "edge_left": size * area.left_edge,
            "edge_right": size * area.right_edge,
            "phase": np.array(self.phase),
            "flags": np.array(self.flags),
        }
        if area.lost is not None:
            hidden = np.where(np.isfinite(area.total), area.lost.outline.total, np.nan)
            found["area_hidden"] = size**2 * hidden
        if area.inner is not None:
            found["inner_edge_left"] = size * area.inner.left_edge
            found["inner_edge_right"] = size * area.inner.right_edge
        motion = self["drift/motion"]
        found["drift_right"], found["drift_down"], found["drift_turn"] = motion[:, :3].T
        found["drift_zoom"] = np.exp(motion[:, 3])
        if self.complete:
            for name in ("flow/residual", "flow/warp_error", "trust/mismatch"):
                found[name.split("/")[1]] = np.append(self[name], np.nan)
            found["brightness"] = np.append(self.brightness, np.nan)
            for name in ("coefficients", "round_trip"):
                values = self[f"modes/{name}"]
                found[f"mode_{name}"] = np.vstack([values, np.full((1, values.shape[1]), np.nan)])
        return Named(f"Analysis {self.directory}", found.items())

    @property
    def units(self) -> dict[str, str]:
        """Unit of each waveform: SI where the scale is known, else px and frames; "" for words."""
        units = ((name, self.scale.unit(RECORDED[name].unit)) for name in self.waveforms)
        return Named(f"Analysis {self.directory}", units)

    def to_xarray(self) -> xarray.Dataset:
        """The waveforms as a data set over ``time`` (and ``mode``, from 1 on). Its attributes have the light,
        green, amber or red, and why; ``to_netcdf`` of xarray keeps them."""
        light = light_of(self)
        said = {"source": str(self.source), "light": light.shown, "light_reasons": light.said}
        return dataset_of(self.waveforms, self.units, said)
