"""What the catalogue says of a measure."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import inf
from typing import Literal

from plica.measures.scale import SI, Scale, shown_unit

__all__ = ["SHARE", "OfSignal", "Quantity", "RecordedFrom", "Side", "Source"]

Source = Literal["run", "video", "both"]
RecordedFrom = Literal["", "record", "marks", "area", "edges", "midline", "motion", "signal"]
OfSignal = Literal["", "flow", "sound", "egg"]
Side = Literal["", "left", "right", "ratio", "difference"]

SHARE = (0.0, 1.0)
"""Bounds of a share."""


@dataclass(frozen=True)
class Quantity:
    """One entry of the catalogue.

    Attributes
    ----------
    name : str
        Name in the API and in measures.json.
    label : str
        Name in reports and tables.
    unit : str
        SI, "1" for a pure number; in a recording without a scale it is `Scale.unit` of this.
    meaning : str
        The definition with its level, averaging time and sign; empty if the label is sufficient.
    group : str
        Heading in reports.
    source : {"run", "video", "both"}
        Kind of record that has it.
    symbol : str
        Common abbreviation.
    shown : str
        Unit in reports, if it is not the usual one for `unit`.
    no_limit : str
        Why it does not converge as the step falls, and what to use instead; empty if it does. Such a measure
        is no headline, and has this as a caution.
    no_limit_of : {"every run", "surfaces with mass"}
        The runs of which that is true.
    diagnostic : bool
        Whether it is of the accuracy of the solution or its effort, not of the voice; no headline either.
    recorded_from : {"", "record", "marks", "area", "edges", "midline", "motion", "signal"}
        What of a recording tells it: the record as such, not the voice; the marks at which cycles begin, the
        glottal area, the folds' edges, the midline, the tissue's motion, a signal beside the picture; empty
        for what only runs have.
    signal : {"", "flow", "sound", "egg"}
        The signal that alone tells it, so that all of these are absent together: the glottal flow as a source
        of sound, the sound, an electroglottogram; empty for other measures.
    side : {"", "left", "right", "ratio", "difference"}
        The fold it is of, or how it compares both: a ratio is 1 and a difference 0 where they move alike.
    extreme : bool
        Whether the largest or least sample of a cycle alone tells it.
    perturbation : {"", "amplitude", "decibels"}
        Of what adds to the differences of cycles, by squares: a mean difference, or a ratio to them in dB.
    angle : bool
        Whether it is known up to 2 pi.
    of_ends : bool
        Whether the first and the last cycle tell it, so that errors fall with the number of cycles.
    bounds : (float, float)
        Between which its definition leaves it.
    """

    name: str
    label: str
    unit: str
    meaning: str = ""
    _: KW_ONLY
    group: str
    source: Source
    symbol: str = ""
    shown: str = ""
    no_limit: str = ""
    no_limit_of: Literal["every run", "surfaces with mass"] = "every run"
    diagnostic: bool = False
    recorded_from: RecordedFrom = ""
    signal: OfSignal = ""
    side: Side = ""
    extreme: bool = False
    perturbation: Literal["", "amplitude", "decibels"] = ""
    angle: bool = False
    of_ends: bool = False
    bounds: tuple[float, float] = (-inf, inf)

    @property
    def described(self) -> str:
        """Label, definition, and why it has no limit, as text without a full stop."""
        limit = f". Caution: {self.no_limit}" if self.no_limit else ""
        return f"{self.label}: {self.meaning}".rstrip(": ") + limit

    def people(self, scale: Scale = SI) -> tuple[float, str]:
        """Factor to the unit used in reports, and that unit, for a record with this scale."""
        unit = scale.unit(self.unit)
        return shown_unit(unit, self.shown if unit == self.unit else "")
