"""fields.xdmf: index for ParaView of the frames in results.h5."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

from plica.runs.progress_record import ProgressRecord
from plica.storage.files import write_text
from plica.storage.stored import Stored

__all__ = ["write_xdmf", "xdmf_text"]

_TOPOLOGY = {4: "Tetrahedron", 10: "Tetrahedron_10"}


def write_xdmf(results: Path) -> Path | None:
    """Write the index of the frames stored so far beside the result file.

    Returns
    -------
    Path or None
        The file; None if the run stores no fields.
    """
    with Stored(results) as file:
        if "fields" not in file:
            return None
        frames = ProgressRecord.read(file, file.names("waveforms")).frames
        rows = file.rows("fields/time")
        times = [float(rows[frame]) for frame in range(frames)]
        nodes, total = file.data("mesh/points").shape[0], file.data("fields/time").shape[0]
        cells, corners = file.data("mesh/cells").shape
        has_pressure = "fields/contact_pressure" in file
    fields: list[tuple[str, str, tuple[int, ...]]] = [("displacement", "Vector", (nodes, 3))]
    if has_pressure:
        fields.append(("contact_pressure", "Scalar", (nodes,)))
    text = xdmf_text(results.name, times, total, nodes, (cells, corners), fields)
    return write_text(text, results.with_name("fields.xdmf"))


def xdmf_text(
    name: str,
    times: Sequence[float],
    stored: int,
    nodes: int,
    cells: tuple[int, int],
    fields: Sequence[tuple[str, str, tuple[int, ...]]],
) -> str:
    """The index of frames in the HDF5 file of this name, which lies beside it.

    Parameters
    ----------
    name : str
    times : sequence of float
        Of the frames.
    stored : int
        Number of rows of the fields, some of which may not be there yet.
    nodes : int
    cells : (number, nodes of each)
    fields : sequence of (name, "Vector" or "Scalar", shape)
        Nodal fields, in single precision under ``/fields``.
    """
    count, corners = cells
    source = quoteattr(name)[1:-1]
    lines = [
        '<?xml version="1.0"?>',
        '<Xdmf Version="3.0"><Domain>',
        '<Grid Name="frames" GridType="Collection" CollectionType="Temporal">',
    ]
    for frame, time in enumerate(times):
        lines += [
            f'<Grid Name="frame {frame}"><Time Value="{time:.9g}"/>',
            f'<Topology TopologyType="{_TOPOLOGY[corners]}" NumberOfElements="{count}">',
            f'<DataItem Dimensions="{count} {corners}" NumberType="Int" Precision="4" Format="HDF">'
            f"{source}:/mesh/cells</DataItem></Topology>",
            '<Geometry GeometryType="XYZ">',
            f'<DataItem Dimensions="{nodes} 3" NumberType="Float" Precision="8" Format="HDF">'
            f"{source}:/mesh/points</DataItem></Geometry>",
        ]
        for field, kind, shape in fields:
            lines += _attribute(field, kind, f"{source}:/fields/{field}", frame, stored, shape)
        for field in ("cell_layer", "cell_side"):
            lines += [
                f'<Attribute Name="{field}" AttributeType="Scalar" Center="Cell">',
                f'<DataItem Dimensions="{count}" NumberType="Int" Precision="4" Format="HDF">'
                f"{source}:/mesh/{field}</DataItem></Attribute>",
            ]
        lines.append("</Grid>")
    lines.append("</Grid></Domain></Xdmf>")
    return "\n".join(lines) + "\n"


def _attribute(name: str, kind: str, data: str, frame: int, frames: int, shape: tuple[int, ...]) -> list[str]:
    """One frame of a nodal field, as a hyperslab of the data set of all frames."""
    own = " ".join(str(extent) for extent in (1, *shape))
    start = " ".join(str(first) for first in (frame, *(0 for _ in shape)))
    stride = " ".join("1" for _ in (0, *shape))
    return [
        f'<Attribute Name="{name}" AttributeType="{kind}" Center="Node">',
        f'<DataItem ItemType="HyperSlab" Dimensions="{own}">',
        f'<DataItem Dimensions="3 {1 + len(shape)}" Format="XML">{start} {stride} {own}</DataItem>',
        f'<DataItem Dimensions="{" ".join(str(extent) for extent in (frames, *shape))}" NumberType="Float" '
        f'Precision="4" Format="HDF">{data}</DataItem></DataItem></Attribute>',
    ]
