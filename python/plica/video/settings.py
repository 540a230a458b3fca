"""What a recording is analysed with."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

from plica.errors import nearest, one_of
from plica.video.errors import VideoError
from plica.video.flow import PRESETS
from plica.video.midline import Midline

__all__ = ["Settings"]

_SAID = ("fps", "mm_per_px", "anterior", "patient_left")


@dataclass(frozen=True)
class Settings:
    """What a recording is analysed with; None is unknown, or found.

    The frame rate, the size of a pixel, the anterior end and the patient's left are said of the recording and
    compute nothing: they may be given, or changed, when the analysis is done.

    Raises
    ------
    VideoError
        For one that is out of range.
    """

    fps: float | None = None
    """True frames per second; None: times in frames."""
    mm_per_px: float | None = None
    """Millimetres a pixel; None: lengths in pixels."""
    rotation: float = 0.0
    """Degrees, anticlockwise as seen."""
    region: tuple[int, int, int, int] | None = None
    """x, y, width, height in px of the turned frames."""
    dataset: str | None = None
    """Of an HDF5 file that holds several."""
    midline: tuple[float, float, float, float] | None = None
    """x, y of one end and of the other, px of the region; None: found."""
    anterior: Literal["upper", "lower"] | None = None
    """End of the midline that is the anterior one."""
    patient_left: Literal["left", "right"] | None = None
    """Side of the image on which the patient's left fold is."""
    preset: str = "video"
    """Of the flow."""
    correct_drift: bool = True
    """Take the endoscope's motion out."""
    modes: int = 6
    """Principal modes."""
    kymogram: tuple[float, ...] = (0.25, 0.5, 0.75)
    """Places of the kymograms' lines: 0 at the midline's upper end, 1 at its lower."""

    def __post_init__(self) -> None:
        for name in ("fps", "mm_per_px", "rotation"):
            number = getattr(self, name)
            if number is None and name != "rotation":
                continue
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise VideoError(f"Video: {name} = {number!r}; must be a number.")
            if not (math.isfinite(number) and (number > 0 or name == "rotation")):
                must = "finite" if name == "rotation" else "> 0 and finite, or left out if unknown"
                raise VideoError(f"Video: {name} = {number:g}; must be {must}.")
        for name, value, known in (
            ("preset", self.preset, tuple(PRESETS)),
            ("anterior", self.anterior, ("upper", "lower")),
            ("patient_left", self.patient_left, ("left", "right")),
        ):
            if value is not None and value not in known:
                raise VideoError(
                    f'Video: {name} = "{value}"; must be {one_of(known)}.{nearest(value, known)}'
                )
        if self.midline is not None:
            Midline.between(self.midline)
        if self.modes < 1:
            raise VideoError(f"Video: modes = {self.modes}; must be 1 or more.")
        if not self.kymogram or not all(0 <= place <= 1 for place in self.kymogram):
            places = ", ".join(f"{place:g}" for place in self.kymogram)
            raise VideoError(
                f"Video: kymogram = {places}; must be places in [0, 1], from the midline's upper to its "
                "lower end."
            )

    def as_json(self) -> str:
        """All of them, as :meth:`from_json` reads them."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Settings:
        """Those that :meth:`as_json` wrote."""
        stored: dict[str, Any] = json.loads(text)
        for name, value in stored.items():
            stored[name] = tuple(value) if isinstance(value, list) else value
        return cls(**stored)

    def computing(self) -> dict[str, Any]:
        """Those on which the results depend."""
        return {name: value for name, value in asdict(self).items() if name not in _SAID}
