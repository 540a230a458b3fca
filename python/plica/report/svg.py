"""SVG made short, so that a page with many figures is read quickly: nothing that can be seen is lost."""

from __future__ import annotations

import base64
import io
import re

import numpy as np

__all__ = ["shortened"]

_PART = re.compile(r"([A-Za-z])([^A-Za-z]*)")
_COLOURS = 256  # of a picture with a palette
_PICTURE = re.compile(r'(?<="data:image/png;base64,)[^"]*')


def shortened(text: str) -> str:
    """The same drawing in about half as many characters.

    Coordinates of paths to a hundredth of a point, those of lines from one point to the next; pictures of at
    most 256 colours with a palette; styles without blanks.
    """
    text = re.sub(r'(?<= d=")[^"]*', lambda found: _path(found.group()), text)
    text = re.sub(r'(?<= style=")[^"]*', lambda found: re.sub(r"([:;]) ", r"\1", found.group()), text)
    return _PICTURE.sub(lambda found: _picture(found.group()), text)


def _path(path: str) -> str:
    words: list[str] = []
    here = begun = (0, 0)  # hundredths of a point
    last = ""
    for letter, rest in _PART.findall(path):
        at = [round(100 * float(number)) for number in rest.split()]
        if letter == "L":
            words += ["" if last == "L" else "l", _number(at[0] - here[0]), _number(at[1] - here[1])]
        else:
            words += [letter, *map(_number, at)]
        here = begun if letter == "z" else (at[-2], at[-1])
        begun = here if letter == "M" else begun
        last = letter
    return re.sub(r" (?=[-A-Za-z])|(?<=[A-Za-z]) ", "", " ".join(filter(None, words)))


def _number(hundredths: int) -> str:
    return f"{hundredths / 100:.2f}".rstrip("0").rstrip(".")


def _picture(encoded: str) -> str:
    """A picture (PNG, base64) with a palette, where it has few colours and none is transparent."""
    from PIL import Image

    with Image.open(io.BytesIO(base64.b64decode(encoded))) as opened:
        pixels = np.asarray(opened.convert("RGBA"))
    colours, index = np.unique(pixels.view(np.uint32)[..., 0], return_inverse=True)
    palette = colours.view(np.uint8).reshape(-1, 4)
    if colours.size > _COLOURS or (palette[:, 3] < 255).any():
        return encoded
    picture = Image.fromarray(index.reshape(pixels.shape[:2]).astype(np.uint8), "P")
    picture.putpalette(palette[:, :3].tobytes())
    buffer = io.BytesIO()
    picture.save(buffer, "png", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode()
