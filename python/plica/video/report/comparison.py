"""Two analyses beside each other, as of one larynx before and after a treatment.

Unlike things are not compared: lengths in pixels, times in frames, left and right where it is not known which
is the patient's. Cautions of either side are repeated.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from plica.errors import InvalidInput
from plica.measures.catalogue import CATALOGUE, names
from plica.measures.comparison import Change, changes
from plica.measures.measure import Measures
from plica.video.analysis import Analysis, load
from plica.video.light import light_of
from plica.video.measures.waveforms import measures

__all__ = ["Comparison", "compare"]

_LENGTHS, _TIMES = frozenset({"m", "m^2", "m/s"}), frozenset({"s", "Hz", "1/s", "m/s"})
_UNEVEN = 1.25  # ratio of the frames a cycle, beyond which quotients differ by sampling alone


@dataclass(frozen=True)
class Comparison:
    """Two analyses.

    Attributes
    ----------
    before, after : Analysis
    """

    before: Analysis
    after: Analysis

    @property
    def both(self) -> tuple[tuple[str, Analysis], tuple[str, Analysis]]:
        """Each with what it is called."""
        return ("before", self.before), ("after", self.after)

    @cached_property
    def sides_known(self) -> bool:
        """Whether it was said of both which side of the image is the patient's left."""
        return all(found.settings.patient_left is not None for _, found in self.both)

    @cached_property
    def ends_known(self) -> bool:
        """Whether it was said of both which end of the midline is the anterior one."""
        return all(found.settings.anterior is not None for _, found in self.both)

    def mirrored(self, found: Analysis) -> bool:
        """Whether left and right are to change places so that left is the patient's."""
        return self.sides_known and found.settings.patient_left == "right"

    def upturned(self, found: Analysis) -> bool:
        """Whether the midline's ends are to change places so that the anterior one comes first."""
        return self.ends_known and found.settings.anterior == "lower"

    def measures(self, found: Analysis) -> Measures:
        """Of one of the two; left is the patient's where that is known of both."""
        if not self.mirrored(found):
            return found.measures
        area, settings = found.area, found.settings
        mirrored, _ = measures(
            area.mirrored,
            settings.fps,
            settings.mm_per_px,
            found.midline.length,
            (found.side("right"), found.side("left")),
            doubts=found.doubts,
            band=(found["glottis/least"], found["glottis/largest"]),
        )
        of_picture = [*mirrored.values(), *found.wave_measures(mirrored=True)]
        return Measures(found.signals.beside(of_picture), found.scale)

    @cached_property
    def changes(self) -> list[Change]:
        """Every measure, its difference or why there is none."""
        return changes(self.measures(self.before), self.measures(self.after), self._withheld)

    @cached_property
    def _withheld(self) -> dict[str, str]:
        """Measures that are not compared, each with the reason."""
        found = dict.fromkeys(names(recorded_from="record"), "of the recording, not of the voice")
        pixels = self._lacking("mm_per_px")
        frames = self._lacking("fps")
        for name, entry in CATALOGUE.items():
            if pixels and entry.unit in _LENGTHS:
                found[name] = f"the size of a pixel is not known {pixels} (--mm-per-px)"
            elif frames and entry.unit in _TIMES:
                found[name] = f"the frame rate is not known {frames} (--fps)"
            elif entry.side and not self.sides_known:
                lacking = self._lacking("patient_left")
                found[name] = f"which side is the patient's left is not known {lacking} (--patient-left)"
        return found

    def _lacking(self, name: str) -> str:
        """Of which of the two a setting is not known; empty where it is of both."""
        unknown = [side for side, found in self.both if getattr(found.settings, name) is None]
        return " and ".join(unknown)

    @cached_property
    def remarks(self) -> list[str]:
        """What is to be minded before the differences are, a sentence each."""
        before, after = self.before, self.after
        found = []
        if before.directory.resolve() == after.directory.resolve():
            found.append("Both are the same analysis: every difference is 0, and says nothing.")
        elif before.source == after.source:
            found.append(f"Both are of the same recording, {before.source}: only its analysis differs.")
        if before.recorded and after.recorded and before.recorded[:10] > after.recorded[:10]:
            found.append(
                f"BEFORE was recorded on {before.recorded[:10]}, AFTER on {after.recorded[:10]}, which is "
                "earlier. Are they the right way round?"
            )
        for side, one in self.both:
            light = light_of(one)
            if light.colour != "good":
                found.append(f"The light of the analysis {side} is {light.shown}: {light.said.strip()}")
        if (before.drawn == []) != (after.drawn == []):
            found.append("Masks were drawn by hand in one of the two: outlines may differ by that alone.")
        found += [
            text
            for text in (self._means(), self._flows(), self._sampling(), self._unknown(), self._kinds())
            if text
        ]
        return found

    def _means(self) -> str:
        """That the glottis was not found by one and the same."""
        if self.before.segmenter == self.after.segmenter:
            return ""
        said = [
            f"{side} by the network {Path(found.settings.segmenter or '').name}, {found.segmenter[:8]}"
            if found.segmenter
            else f"{side} by its edges and its darkness"
            for side, found in self.both
        ]
        means = "; ".join(said)
        return f"The glottis was found by different means ({means}): outlines may differ by that alone."

    def _flows(self) -> str:
        """That the motion was not found by one and the same."""
        if not (self.before.complete and self.after.complete):
            return ""
        here, there = self.before.flow_origin, self.after.flow_origin
        said = here.difference(there) if here and there else ""
        if not said:
            return ""
        return (
            f"The motion was found by different means ({said}): strain, waves, modes and paths may differ by "
            "that alone."
        )

    def _sampling(self) -> str:
        """That a cycle has more frames in one than in the other."""
        periods = [(found.settings.fps or 1.0) / found.cycles.frequency for _, found in self.both]
        if not all(period > 0 for period in periods) or max(periods) < _UNEVEN * min(periods):
            return ""
        return (
            f"A cycle has {periods[0]:.3g} frames before and {periods[1]:.3g} after: quotients, jitter and "
            "shimmer depend on that, so a difference of theirs may be one of the cameras."
        )

    def _unknown(self) -> str:
        """What the pictures do not say."""
        ends, sides = self._lacking("anterior"), self._lacking("patient_left")
        said = []
        if ends:
            said.append(f"which end of the glottis is the anterior one ({ends}; --anterior)")
        if sides:
            said.append(f"which side is the patient's left ({sides}; --patient-left)")
        if not said:
            return ""
        return f"Not known: {' and '.join(said)}. The pictures are as in each recording, and may be turned."

    def _kinds(self) -> str:
        """That the voices are of different kinds."""
        kinds = [found.cycles.verdict for _, found in self.both]
        if kinds[0] == kinds[1]:
            return ""
        said = [
            f"without cycles {side}" if kind == "none" else f"{kind} {side}"
            for kind, (side, _) in zip(kinds, self.both, strict=True)
        ]
        return f"The voice is {' and '.join(said)}: means over cycles are of different things."


def compare(before: str | Path | Analysis, after: str | Path | Analysis) -> Comparison:
    """Two analyses beside each other.

    Parameters
    ----------
    before, after : directory of an analysis, or Analysis
        May be one and the same, which is said.

    Raises
    ------
    VideoError
        Where one of them is no analysis, or is not finished.

    Examples
    --------
    >>> found = plica.video.compare("before", "after")  # doctest: +SKIP
    >>> for change in found.changes:  # doctest: +SKIP
    ...     if change.beyond_scatter:
    ...         print(change.name, change.difference, change.interval)
    """
    for name, given in (("before", before), ("after", after)):
        if not isinstance(given, (str, Path, Analysis)):
            raise InvalidInput(
                f"Compare: {name} is {type(given).__name__}; must be the directory of an analysis, or an "
                "Analysis."
            )
    first, second = (given if isinstance(given, Analysis) else load(given) for given in (before, after))
    return Comparison(first, second)
