"""The range of each kind of quantity in a larynx, and the unit that may have been meant beyond it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["ADULT_LENGTH", "BOUNDS", "LENGTHS", "Bound", "shown"]

_PREFIXES = {-3: "n", -2: "u", -1: "m", 0: "", 1: "k", 2: "M"}


@dataclass(frozen=True)
class Bound:
    """The range of one kind of quantity in a larynx.

    Attributes
    ----------
    low, high : float
        In `unit`; a quantity of exactly zero is treated as absent.
    unit : str
        SI.
    whose : str
        Subject of the sentence, e.g. "Vocal folds have".
    reason : str
        Source of the bounds.
    others : dict of str to float
        Units that may have been meant, each in `unit`; the first that fits is suggested.
    """

    low: float
    high: float
    unit: str
    whose: str
    reason: str
    others: Mapping[str, float]

    def holds(self, value: float) -> bool:
        """Whether the magnitude of a value is within the bounds."""
        return value == 0 or self.low <= abs(value) <= self.high

    def span(self) -> str:
        """The bounds as text."""
        return f"{shown(self.low, self.unit)} to {shown(self.high, self.unit)}"

    def question(self, value: float) -> str:
        """A question about the unit that may have been meant."""
        for unit, size in self.others.items():
            if _PLAUSIBLE_NUMBERS[0] <= abs(value) <= _PLAUSIBLE_NUMBERS[1] and self.holds(value * size):
                return f"Is it {value:g} {unit}?"
        return "Is the unit right?"


_PLAUSIBLE_NUMBERS = (1e-3, 1e5)  # numbers that people write; others are not a wrong unit
ADULT_LENGTH = 15e-3  # m, length of adult vocal folds, to guess a unit
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}

BOUNDS: dict[str, Bound] = {
    "subglottal_pressure": Bound(
        200.0,
        4e3,
        "Pa",
        "Speech has",
        "Threshold of phonation at low pitch (Titze, J. Acoust. Soc. Am. 91, 1992) to loud speech (0.3 to "
        "4 kPa; shouting reaches 10 kPa: Snelleman, Versnel and Dejonckere, PEVOC 7, 2007).",
        {"kPa": 1e3, "cmH2O": 98.0665, "dyn/cm^2": 0.1},
    ),
    "air_density": Bound(
        0.15,
        7.0,
        "kg/m^3",
        "Breathing gas has",
        "Helium (0.16 at body temperature) to sulphur hexafluoride (6), by the ideal-gas law; air has 1.1 "
        "to 1.3.",
        {"g/cm^3": 1e3, "g/m^3": 1e-3},
    ),
    "air_viscosity": Bound(
        0.7e-5,
        4e-5,
        "Pa s",
        "Breathing gas has",
        "Butane (0.75e-5) to neon (3.2e-5), with a margin; air has 1.8e-5 to 1.9e-5, helium 2.0e-5, sulphur "
        "hexafluoride 1.5e-5.",
        {"poise": 0.1, "mPa s": 1e-3, "uPa s": 1e-6},
    ),
    "sound_speed": Bound(
        130.0,
        1.05e3,
        "m/s",
        "Sound in breathing gas has",
        "Sulphur hexafluoride (135) to helium at body temperature (1030); air has 343 to 353.",
        {"cm/s": 1e-2},
    ),
    "tube_length": Bound(
        0.02,
        2.0,
        "m",
        "Tracheas and vocal tracts have",
        "A third of a newborn child's vocal tract (7 cm) to twice the longest tube of experiments (1.1 m).",
        LENGTHS,
    ),
    "tube_area": Bound(
        5e-6,
        0.01,
        "m^2",
        "Tracheas and vocal tracts have",
        "Half the constriction of a fricative (10 mm^2) to a trumpet's bell (100 cm^2); a tract has 0.3 to "
        "15, a trachea 2 to 3 cm^2.",
        {"cm^2": 1e-4, "mm^2": 1e-6},
    ),
    "supply_volume": Bound(
        1e-6,
        0.02,
        "m^3",
        "Lungs and the vessels of rigs have",
        "A millilitre (below that the volume changes nothing) to three times the lungs of an adult (6 l).",
        {"l": 1e-3, "ml": 1e-6},
    ),
    "supplied_flow": Bound(
        5e-6,
        5e-3,
        "m^3/s",
        "Phonation has",
        "A tenth of a soft voice's flow (50 ml/s) to a forced breath (5 l/s).",
        {"ml/s": 1e-6, "l/s": 1e-3},
    ),
    "stiffness": Bound(
        100.0,
        2e6,
        "Pa",
        "Tissue of the larynx has",
        "Lamina propria has 1 kPa across the fibre, 30 kPa along it, and 10 to 15 times that where it is "
        "stretched (Alipour and Vigmostad, J. Voice 26, 2012); subjects differ by ten times (Chan and Titze, "
        "J. Acoust. Soc. Am. 106, 1999). Above 2 MPa there is cartilage, which does not vibrate.",
        {"kPa": 1e3, "MPa": 1e6, "dyn/cm^2": 0.1},
    ),
    "tissue_density": Bound(
        800.0,
        1.4e3,
        "kg/m^3",
        "Tissue has",
        "Fat (920) to cartilage (1100), silicone of models included, with a margin of a fifth.",
        {"g/cm^3": 1e3, "g/m^3": 1e-3},
    ),
    "viscosity": Bound(
        0.002,
        5.0,
        "Pa s",
        "Tissue that vibrates has",
        "Twice that of water (0.001) to five times the thesis's largest (0.4 to 1). Mucosa has more only at "
        "motions much slower than a voice (Chan and Titze, J. Acoust. Soc. Am. 106, 1999).",
        {"poise": 0.1, "mPa s": 1e-3},
    ),
    "fold_length": Bound(
        0.5e-3,
        0.12,
        "m",
        "Vocal folds have",
        "About 1 mm in a mouse, 3 mm in a newborn child (Sundberg, The Science of the Singing Voice, 1987), "
        "104 mm in an elephant (Herbst and others, Science 337, 2012).",
        LENGTHS,
    ),
    "layer_thickness": Bound(
        1e-5,
        7e-3,
        "m",
        "A layer of a fold has",
        "About 1 mm in adults, scaled by the length of the folds from a mouse to an elephant. A parametric "
        "larynx limits it to 0.3 of the tissue's depth, with a caution too.",
        LENGTHS,
    ),
    "mesh_size": Bound(
        1e-3,
        0.5,
        "m",
        "A larynx has",
        "Twice to four times the length of its folds, from a mouse to an elephant.",
        LENGTHS,
    ),
    "time_step": Bound(
        1e-7,
        0.2e-3,
        "s",
        "A time step of phonation has",
        "At 100 Hz the longest gives 50 steps per period, the shortest 100,000. At 0.4 ms the flow of a "
        "larynx was off by 11 % within 16 ms (docs/extremes.md).",
        {"ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    ),
    "duration": Bound(
        0.01,
        60.0,
        "s",
        "A run of phonation has",
        "One period at 100 Hz (measures need three) to more than a person phonates in one breath.",
        {"ms": 1e-3, "us": 1e-6},
    ),
    "initial_velocity": Bound(
        1e-6,
        5.0,
        "m/s",
        "Folds have",
        "2 pi f A of 1 mm at 800 Hz is 5 m/s, and waves in tissue are as fast (root of E over density); "
        "below 1e-6 m/s the folds move by less than an atom in a step of 50 us.",
        {"cm/s": 1e-2, "mm/s": 1e-3},
    ),
    "initial_displacement": Bound(
        1e-9,
        5e-3,
        "m",
        "Folds are displaced by",
        "A third of a fold of 15 mm; below 1 nm the displacement is negligible.",
        {"mm": 1e-3, "um": 1e-6},
    ),
    "gravity": Bound(
        1.5,
        15.0,
        "m/s^2",
        "Free fall has",
        "The Moon (1.62) to a climb in an aircraft (15); the Earth has 9.81.",
        {"cm/s^2": 1e-2, "mm/s^2": 1e-3, "g_0": 9.80665},
    ),
    "load": Bound(
        1.0,
        1e5,
        "Pa",
        "Loads on tissue have",
        "A thousandth of the pressure of speech to the stress of a contracted muscle (100 kPa and more tear "
        "mucosa).",
        {"kPa": 1e3, "MPa": 1e6, "dyn/cm^2": 0.1},
    ),
    "active_stress": Bound(
        500.0,
        2e5,
        "Pa",
        "Muscle of the larynx has",
        "Models of the thyroarytenoid have some 100 kPa at most (Titze and Story, J. Acoust. Soc. Am. 112, "
        "2002, second hand), twice that with a margin; the air alone presses with more than half a "
        "kilopascal.",
        {"kPa": 1e3, "MPa": 1e6, "dyn/cm^2": 0.1},
    ),
    "load_frequency": Bound(
        1.0,
        1e4,
        "Hz",
        "Periodic loads have",
        "Breathing is slower than the lower bound, a voice has no energy above the upper one; zero is a "
        "constant load.",
        {"kHz": 1e3},
    ),
}


def shown(value: float, unit: str) -> str:
    """The value with a suitable unit prefix."""
    if unit not in {"Pa", "s", "m", "Hz"}:
        return f"{value:g} {unit}"
    thousands = math.floor(math.log10(value) / 3 + 1e-9)
    return f"{value / 1000.0**thousands:.4g} {_PREFIXES[thousands]}{unit}"
