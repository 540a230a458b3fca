"""Single pictures from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.video.grey import to_grey

__all__ = ["read_image"]

_GREY = {"L", "I", "F", "I;16", "I;16L", "I;16B"}


def read_image(path: str | Path) -> NDArray[np.float32]:
    """The picture of a file (PNG, TIFF, JPEG, BMP, ...) in grey, in the levels of the file.

    Raises
    ------
    InvalidInput
        Where the file is missing, is not a picture, is broken, or has more than one frame.
    """
    from PIL import Image, UnidentifiedImageError

    where = f"read_image: {path}"
    try:
        with Image.open(path) as image:
            frames = getattr(image, "n_frames", 1)
            if frames != 1:
                raise InvalidInput(f"{where} has {frames} frames; must have one.")
            if image.mode in _GREY:
                return to_grey(np.asarray(image))
            return to_grey(np.asarray(image.convert("L" if image.mode in ("1", "LA", "La") else "RGB")))
    except InvalidInput:
        raise
    except UnidentifiedImageError:
        raise InvalidInput(f"{where} is not a picture; must be PNG, TIFF, JPEG, BMP or the like.") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InvalidInput(f"{where} cannot be read: {reason}.") from None
