"""Files of modes of vibration, and of the onset of phonation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.runs.store import store_mesh
from plica.runs.xdmf import xdmf_text
from plica.stability.modes import Eigenmodes
from plica.stability.offset import Offset
from plica.stability.onset import Onset
from plica.storage.files import write_text
from plica.storage.hdf5 import put, write_image
from plica.storage.json_file import write_json
from plica.storage.table import write_table

__all__ = ["MODE_FILES", "ONSET_FILES", "growth_columns", "mode_columns", "write_modes", "write_onset"]

MODE_FILES = ("eigenmodes.csv", "eigenmodes.json", "eigenmodes.h5", "eigenmodes.xdmf")
ONSET_FILES = ("onset.json", "growth.csv", "growth.svg")

_LARGEST = 1e-3  # m, what the largest displacement of a stored shape is


def mode_columns(modes: Eigenmodes) -> dict[str, NDArray[Any]]:
    """Columns by heading, one row a mode."""
    return {
        "mode": np.arange(1, len(modes.frequency) + 1),
        "frequency (Hz)": modes.frequency,
        "damping_ratio": modes.damping_ratio,
        "residual": modes.residual,
        "modal_mass (kg)": modes.modal_mass,
        "left_right": np.array(modes.left_right),
        "front_back": np.array(modes.front_back),
    }


def write_modes(modes: Eigenmodes, mesh: _engine.TetMesh, directory: Path) -> None:
    """Write `MODE_FILES`: the table twice, and shapes for ParaView, where the time is the frequency."""
    columns = mode_columns(modes)
    write_table(directory / "eigenmodes.csv", columns)
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    names = [name.partition(" (")[0] for name in columns]
    units = {"frequency": "Hz", "modal_mass": "kg"}
    content = {"units": units, "modes": [dict(zip(names, row, strict=True)) for row in rows]}
    write_json(content, directory / "eigenmodes.json")

    def fill(file: Any) -> None:
        store_mesh(file, mesh)
        put(file, "fields/time", modes.frequency, "Hz", "frequency of each mode")
        shapes = (_LARGEST * modes.shape).astype(np.float32)
        put(file, "fields/displacement", shapes, "m", "largest displacement 1 mm", rows=True)

    write_image(directory / "eigenmodes.h5", fill)
    shape = modes.shape.shape
    text = xdmf_text(
        "eigenmodes.h5",
        modes.frequency.tolist(),
        shape[0],
        shape[1],
        np.asarray(mesh.cells).shape,
        [("displacement", "Vector", shape[1:])],
    )
    write_text(text, directory / "eigenmodes.xdmf")


def growth_columns(found: Onset) -> dict[str, NDArray[Any]]:
    """Columns by heading, one row a pressure."""
    columns = {
        "subglottal_pressure (Pa)": found.pressure,
        "growth (1/s)": found.least_stable.real,
        "frequency (Hz)": found.least_stable.imag / (2 * np.pi),
    }
    for k, pair in enumerate(found.pairs.T):
        columns[f"pair_{k + 1}_growth (1/s)"] = pair.real
        columns[f"pair_{k + 1}_frequency (Hz)"] = pair.imag / (2 * np.pi)
    columns["real_growth (1/s)"] = np.where(np.isfinite(found.fastest), found.fastest, np.nan)
    columns["minimum_area (m^2)"] = found.area
    columns["flow (m^3/s)"] = found.flow
    return columns


def write_onset(found: Onset, directory: Path, lowered: Offset | None = None) -> None:
    """Write `ONSET_FILES`, with an offset if it was sought."""
    from plica.stability.figure import growth_picture

    write_json({**_content(found), "offset": _offset(lowered)}, directory / "onset.json")
    write_table(directory / "growth.csv", growth_columns(found))
    write_text(growth_picture(found, lowered), directory / "growth.svg")


def _content(found: Onset) -> Mapping[str, Any]:
    first, rest = found.first, found.equilibrium
    content: dict[str, Any] = {
        "onset": None,
        "units": {"pressure": "Pa", "frequency": "Hz", "slope": "1/(s Pa)", "area": "m^2", "flow": "m^3/s"},
        "range": [float(found.pressure[0]), float(found.pressure[-1])],
        "damping": found.damping,
        "modes": found.modes,
        "symmetry": found.symmetry,
        "crossings": [asdict(one) for one in found.crossings],
        "end": found.end or None,
        "remarks": list(found.remarks),
    }
    if first is not None and rest is not None:
        content["onset"] = asdict(first) | {
            "pressure_error": found.pressure_error,
            "frequency_error": found.frequency_error,
            "participation": [
                {"mode": one.mode or None, "share": one.share, "phase": one.phase}
                | ({"frequency": one.frequency} if one.mode else {})
                for one in found.participation
            ],
            "minimum_area": float(rest.area.min()),
            "flow": rest.flow,
            "largest_displacement": float(np.linalg.norm(rest.displacement, axis=1).max()),
        }
    return content


def _offset(found: Offset | None) -> Mapping[str, Any] | None:
    if found is None:
        return None
    falls = [
        {
            "rate": fall.rate,
            "pressure": fall.pressure,
            "pressures": fall.pressures.tolist(),
            "amplitudes": fall.amplitudes.tolist(),
        }
        for fall in found.falls
    ]
    units = {"pressure": "Pa", "spread": "Pa", "frequency": "Hz", "rate": "Pa/s", "amplitudes": "m^2"}
    return {
        "pressure": found.pressure,
        "spread": found.spread,
        "frequency": found.frequency,
        "start": found.start,
        "falls": falls,
        "remarks": list(found.remarks),
        "units": units,
    }
