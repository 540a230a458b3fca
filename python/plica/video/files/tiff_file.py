"""TIFF files: how many pictures they hold, and the grey or colour that their numbers stand for."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, library
from plica.video.files.limits import MOST_FRAMES, MOST_PIXELS

if TYPE_CHECKING:
    from tifffile import TiffFile

__all__ = ["NotDecodedError", "count_pages", "is_tiff", "open_tiff", "page_pixels"]

_BEGINS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE = 0, 1, 2, 3  # PhotometricInterpretation
_SEPARATE = 2  # PlanarConfiguration: a plane a colour


class NotDecodedError(Exception):
    """tifffile lacks what a page is stored with: another reader is to be asked."""


def is_tiff(begin: bytes) -> bool:
    """Whether a file that begins with these four bytes is one."""
    return begin in _BEGINS


@contextmanager
def open_tiff(path: str | Path) -> Iterator[TiffFile]:
    """The file, open. What tifffile logs of it is not printed: it is raised where it matters."""
    tifffile = library("tifffile", "video", str(path))
    log, nowhere = logging.getLogger("tifffile"), logging.NullHandler()
    log.addHandler(nowhere)
    try:
        with _errors(str(path)):
            stack = tifffile.TiffFile(path)
        with stack:
            yield stack
    finally:
        log.removeHandler(nowhere)


@contextmanager
def _errors(where: str) -> Iterator[None]:
    """What tifffile raises for a broken file, which is of any kind, as InvalidInput."""
    try:
        yield
    except (InvalidInput, NotDecodedError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno:
            raise  # of the system
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InvalidInput(f"{where} cannot be read as TIFF: {reason}. Is it whole?") from None


def count_pages(stack: TiffFile, where: str) -> int:
    """Pages of an open file, each of them one picture.

    Raises
    ------
    InvalidInput
        Where pages are missing, lead back to one another or are too many, or do not follow one another in
        time: many pictures in one page, channels or slices between the frames.
    """
    with _errors(where):
        return _count(stack, where)


def _count(stack: TiffFile, where: str) -> int:
    _check_chain(stack, where)
    count = len(stack.pages)
    if _next_page(stack, stack.pages[count - 1].offset) != 0:
        raise InvalidInput(
            f"{where} ends after page {count} and states more of them. It is cut off: copy it again."
        )
    if not (stack.is_imagej or stack.is_ome or stack.is_shaped):
        return count
    series = stack.series[0]
    sizes = zip(series.axes, series.shape, strict=True)
    axes = {name: size for name, size in sizes if name not in "YXS" and size > 1}
    stated = int(np.prod(list(axes.values())))
    if count == 1 and stated > 1:
        raise InvalidInput(
            f"{where} holds {stated} pictures in 1 page; must have a page a picture. "
            "Store it anew, as an uncompressed TIFF below 4 GB, say."
        )
    if len(axes) > 1:
        named = ", ".join(f"{name} = {size}" for name, size in axes.items())
        raise InvalidInput(f"{where} has the axes {named}; must have one, time. Store one channel and slice.")
    return count


def _check_chain(stack: TiffFile, where: str) -> None:
    """Raise InvalidInput where the pages, each of which names the place of the next, never end."""
    at = stack.pages.first.offset
    found = {at}
    while (at := _next_page(stack, at)) != 0:
        if at in found:
            raise InvalidInput(
                f"{where}: page {len(found)} leads back to one before it; must lead to another. It is "
                "damaged: copy it again."
            )
        found.add(at)
        if len(found) > MOST_FRAMES:
            raise InvalidInput(
                f"{where} has {len(found)} pages or more; must be at most {MOST_FRAMES}. Store the part that "
                "is to be analysed in a file of its own."
            )


def _next_page(stack: TiffFile, place: int) -> int:
    """The place that the page at this one names for the next; 0 for none, or beyond the end."""
    form, file = stack.tiff, stack.filehandle
    order: Any = "little" if stack.byteorder == "<" else "big"
    if place >= file.size:
        return 0
    file.seek(place)
    entries = int.from_bytes(file.read(form.tagnosize), order)
    end = place + form.tagnosize + entries * form.tagsize
    if end >= file.size:
        return 0
    file.seek(end)
    return int.from_bytes(file.read(form.offsetsize), order)


def page_pixels(stack: TiffFile, index: int) -> NDArray[Any]:
    """(rows, columns), or that x colours: larger is brighter, whatever the file has it stored as.

    Raises
    ------
    InvalidInput
        Where it is broken, or larger than any picture.
    NotDecodedError
        For a compression or a colour space that is not read here.
    """
    with _errors(f"page {index}"):
        data = _page(stack.pages[index], index)
        if data.ndim not in (2, 3) or data.size == 0:
            raise InvalidInput(f"page {index} has shape {data.shape}; must be a picture.")
        return data


def _page(page: Any, index: int) -> NDArray[Any]:
    if math.prod(page.shape[:2]) > MOST_PIXELS or math.prod(page.shape) > 4 * MOST_PIXELS:
        size = " x ".join(map(str, page.shape))
        raise InvalidInput(f"page {index} states {size} px and colours; must be at most {MOST_PIXELS} px.")
    kind = int(page.photometric)
    if kind not in (_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE):
        raise NotDecodedError(f"photometric interpretation {kind}")
    try:
        data = np.asarray(page.asarray())
    except (ValueError, KeyError) as error:
        if "imagecodecs" not in str(error):
            raise
        raise NotDecodedError(str(error.args[0])) from None
    if data.ndim == 3 and page.planarconfig == _SEPARATE:
        data = np.moveaxis(data, 0, -1)
    if kind == _PALETTE:
        colours = (np.asarray(page.colormap) >> 8).astype(np.uint8)  # 16 bits by the format, 8 in use
        return np.moveaxis(colours[:, data], 0, -1)
    if kind != _RGB and data.ndim == 3 and page.extrasamples:
        data = data[..., 0]
    if kind != _WHITE_IS_ZERO:
        return data
    if data.dtype.kind == "b":
        return ~data
    return (1 << page.bitspersample) - 1 - data if data.dtype.kind == "u" else -data
