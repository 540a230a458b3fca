"""Single pictures from files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.storage.files import require_file
from plica.video.files.grey import to_grey
from plica.video.files.tiff_file import NotDecodedError, count_pages, is_tiff, open_tiff, page_pixels

if TYPE_CHECKING:
    from PIL import Image
    from tifffile import TiffFile

__all__ = ["PICTURES", "is_picture", "read_image", "read_page", "read_pixels", "whole_pictures"]

PICTURES = {".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".tif", ".tiff"}
"""Suffixes of files that are one picture."""

_AS_THEY_ARE = {"1", "L", "I", "F", "I;16", "I;16L", "I;16B", "RGB", "RGBA"}
_GREY_AND_ALPHA = {"LA", "La"}


def is_picture(path: Path) -> bool:
    """Whether a file of a folder is a frame, by its name."""
    return path.suffix.lower() in PICTURES and not path.name.startswith(".")


def read_image(path: str | Path) -> NDArray[np.float32]:
    """The picture of a file (PNG, TIFF, JPEG, BMP, ...) in grey, in the levels of the file (one bit: 0, 255).

    Raises
    ------
    InvalidInput
        As :func:`read_pixels`.
    """
    pixels = read_pixels(path)
    return to_grey(255 * pixels.astype(np.uint8) if pixels.dtype == np.bool_ else pixels)


def read_pixels(path: str | Path) -> NDArray[Any]:
    """The picture of a file as it is stored: (rows, columns), or that x 3 or 4 colours, of the file's type.

    Raises
    ------
    InvalidInput
        Where the file is missing, is not a picture, is broken, has more than one picture, or has colours of
        a depth that would be lost.
    """
    where = f"read_image: {path}"
    with _errors(where):
        require_file(Path(path), where)
        with open(path, "rb") as file:
            begin = file.read(4)
        if not begin:
            raise InvalidInput(f"{where} is empty: 0 bytes; must be a picture.")
        if is_tiff(begin):
            return _of_tiff(path, where)
        from PIL import Image

        with Image.open(path) as image:
            frames = getattr(image, "n_frames", 1)
            if frames != 1:
                raise InvalidInput(f"{where} has {frames} frames; must have one.")
            return _of_pillow(image, where)


def read_page(stack: TiffFile, path: str | Path, index: int) -> NDArray[Any]:
    """A page of an open TIFF file, as :func:`read_pixels` gives a picture."""
    from PIL import Image

    try:
        return page_pixels(stack, index)
    except NotDecodedError:
        where = f"read_image: {path}"
        with _errors(where), Image.open(path) as image:
            image.seek(index)
            return _of_pillow(image, where)


def _of_tiff(path: str | Path, where: str) -> NDArray[Any]:
    with open_tiff(path) as stack:
        count = count_pages(stack, where)
        if count != 1:
            raise InvalidInput(f"{where} has {count} frames; must have one.")
        try:
            return read_page(stack, path, 0)
        except InvalidInput as error:
            raise InvalidInput(f"{where}: {str(error).removeprefix(f'{where}: ')}") from None


def _of_pillow(image: Image.Image, where: str) -> NDArray[Any]:
    # Pillow keeps 8 bits of a colour: of twelve used of sixteen, four.
    deep = image.mode in ("RGB", "RGBA", *_GREY_AND_ALPHA) and ";16" in str(getattr(image, "tile", ""))
    if deep:
        raise InvalidInput(f"{where} has 16 bits a colour; must be grey, or have 8, or be a TIFF.")
    if image.mode in _AS_THEY_ARE:
        return np.asarray(image)
    return np.asarray(image.convert("L" if image.mode in _GREY_AND_ALPHA else "RGB"))


@contextmanager
def whole_pictures() -> Iterator[None]:
    """Pillow refuses pictures that are cut off, also where another library (WeasyPrint) had it not."""
    from PIL import ImageFile

    before = ImageFile.LOAD_TRUNCATED_IMAGES
    ImageFile.LOAD_TRUNCATED_IMAGES = False
    try:
        yield
    finally:
        ImageFile.LOAD_TRUNCATED_IMAGES = before


@contextmanager
def _errors(where: str) -> Iterator[None]:
    """What the readers of pictures raise, as one sentence."""
    from PIL import Image, UnidentifiedImageError

    try:
        with whole_pictures():
            yield
    except InvalidInput:
        raise
    except UnidentifiedImageError:
        raise InvalidInput(f"{where} is not a picture; must be PNG, TIFF, JPEG, BMP or the like.") from None
    except (
        OSError,
        SyntaxError,
        ValueError,
        IndexError,
        EOFError,
        Image.DecompressionBombError,
    ) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise InvalidInput(f"{where} cannot be read: {reason}.") from None
