"""Shapes of tubes: smooth vowels, and tables of distance and area."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.storage.files import require_file
from plica.units import read_quantity

__all__ = ["LONGEST", "VOWELS", "WIDEST", "Profile", "read_columns", "read_profile", "vowel_profile"]

Profile = tuple[tuple[float, ...], tuple[float, ...]]
"""Lengths (m) and areas (m^2) of the parts of a tube, from the glottis on."""

LONGEST = 10.0
"""m, of all parts of a tube together."""
WIDEST = 1.0
"""m^2"""

_PART = 2.5e-3
"""m, the longest part that a smooth shape is cut into."""

VOWELS: dict[str, tuple[float, tuple[float, ...]]] = {
    "schwa": (3e-4, (0.0, 0.0, 0.0)),
    "a": (3e-4, (-1.4, 0.6, 0.3)),
    "i": (3e-4, (1.0, -0.9, -0.3)),
    "u": (3e-4, (0.5, 0.9, 0.5)),
}
"""A (m^2) and b_n of A(x) = A exp(sum_n b_n cos((2 n - 1) pi x / L)), x from the glottis. To first order b_n
lowers the n-th formant alone, by half its share (Schroeder, J. Acoust. Soc. Am. 41, 1967)."""


def vowel_profile(name: str, length: float) -> Profile:
    """The parts of a smooth vowel of this length, m."""
    area, coefficients = VOWELS[name]
    count = math.ceil(length / _PART)
    middle = (np.arange(count) + 0.5) / count
    waves = sum(b * np.cos((2 * n + 1) * np.pi * middle) for n, b in enumerate(coefficients))
    return (length / count,) * count, tuple(float(a) for a in area * np.exp(waves))


def read_profile(path: Path) -> Profile:
    """The parts of a tube whose area is linear between the rows of a CSV file.

    Parameters
    ----------
    path : Path
        Two columns whose header has their units: ``distance (cm),area (cm^2)``; rows from the glottis on, the
        first at distance 0. Further columns are ignored.

    Raises
    ------
    InvalidInput
    """
    columns = {"distance": ("m", "distance (cm)"), "area": ("m^2", "area (cm^2)")}
    distance, area = read_columns(path, columns)
    _check(distance, area, f"{path}")
    return _parts(distance, area)


def read_columns(path: Path, columns: Mapping[str, tuple[str, str]]) -> list[NDArray[np.float64]]:
    """Columns of a CSV file whose header has their units, in SI; lines that begin with # are left out.

    Parameters
    ----------
    path : Path
    columns : mapping
        Name to SI unit and an example of its heading.

    Raises
    ------
    InvalidInput
    """
    where = f"{path}"
    header = ",".join(example for _, example in columns.values())
    require_file(path, where)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [(k, line) for k, line in enumerate(file, 1) if line.strip(" ,\t\r\n") and line[0] != "#"]
        rows = [(k, next(csv.reader([line]))) for k, line in lines]
    except UnicodeDecodeError:
        raise InvalidInput(f"{where}: must be text in UTF-8, a CSV file.") from None
    except (OSError, csv.Error) as error:
        raise InvalidInput(f"{where}: cannot be read: {error}.") from None
    if not rows:
        raise InvalidInput(f"{where}: is empty; must have the header {header}.")
    places = {name: _column(rows[0][1], name, *kind, where) for name, kind in columns.items()}
    return [_values(rows[1:], *place, name, where) for name, place in places.items()]


def _column(header: list[str], name: str, unit: str, example: str, where: str) -> tuple[int, float]:
    """Place of a column, and the size of its unit in SI."""
    wanted = f'the header must have "{name} (UNIT)", such as {example}'
    found = [(k, re.fullmatch(rf"\s*{name}\s*\((.+)\)\s*", cell)) for k, cell in enumerate(header)]
    matches = [(k, match[1]) for k, match in found if match]
    if len(matches) != 1:
        raise InvalidInput(f"{where}: the header is {','.join(header)}; {wanted}, once.")
    place, text = matches[0]
    try:
        return place, read_quantity(f"1 {text}", unit)
    except ValueError as error:
        raise InvalidInput(f'{where}: "{header[place].strip()}"; {wanted}: {error}') from None


def _values(
    rows: list[tuple[int, list[str]]], place: int, size: float, name: str, where: str
) -> NDArray[np.float64]:
    found = []
    for k, row in rows:
        try:
            value = float(row[place])
        except (IndexError, ValueError):
            shown = f'"{row[place]}"' if place < len(row) else "missing"
            raise InvalidInput(f"{where}, line {k}: {name} is {shown}; must be a number.") from None
        if not math.isfinite(value):
            raise InvalidInput(f"{where}, line {k}: {name} is {value}; must be finite.")
        found.append(value * size)
    return np.array(found)


def _check(distance: NDArray[np.float64], area: NDArray[np.float64], where: str) -> None:
    if len(distance) < 2:
        raise InvalidInput(f"{where}: has {len(distance)} rows below the header; must have 2 or more.")
    if distance[0] != 0:
        raise InvalidInput(
            f"{where}: the first distance is {distance[0]:g} m; must be 0, at the glottis. Are the rows "
            "the ends of sections? Begin with the area at the glottis."
        )
    steps = np.diff(distance)
    if (steps <= 0).any():
        k = int(np.argmax(steps <= 0)) + 1
        raise InvalidInput(
            f"{where}: distance {k + 1} of {len(distance)} is {distance[k]:g} m; must be > the one before, "
            f"{distance[k - 1]:g} m: rows go from the glottis to the far end."
        )
    if distance[-1] > LONGEST:
        raise InvalidInput(
            f"{where}: the last distance is {distance[-1]:g} m; must be <= {LONGEST:g} m. Is the unit right?"
        )
    if (area > WIDEST).any():
        k = int(np.argmax(area > WIDEST))
        raise InvalidInput(
            f"{where}: area {k + 1} of {len(area)} is {area[k]:g} m^2; must be <= {WIDEST:g} m^2. Is the "
            "unit right?"
        )
    if (area <= 0).any():
        k = int(np.argmax(area <= 0))
        raise InvalidInput(f"{where}: area {k + 1} of {len(area)} is {area[k]:g} m^2; must be > 0.")


def _parts(distance: NDArray[np.float64], area: NDArray[np.float64]) -> Profile:
    """Uniform parts, each with the mean area of the linear shape there."""
    lengths: list[float] = []
    areas: list[float] = []
    for k in range(len(distance) - 1):
        count = math.ceil((distance[k + 1] - distance[k]) / _PART * (1 - 1e-9))
        middle = (np.arange(count) + 0.5) / count
        lengths += [float((distance[k + 1] - distance[k]) / count)] * count
        areas += [float(a) for a in area[k] + middle * (area[k + 1] - area[k])]
    return tuple(lengths), tuple(areas)
