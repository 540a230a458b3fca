"""Pictures and files of them, good and bad, for the tests of what reads them."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image

from plica.commands.main import main

SHAPE = (32, 48)


def frame(time: float) -> np.ndarray:
    """A pattern that moves 1.5 px to the left in one unit of time."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return (127 + 100 * np.sin(0.2 * x + 0.3 * time) * np.cos(0.3 * y)).astype(np.uint8)


A, B = frame(0), frame(1)


def encoded(
    file: Path | io.BytesIO,
    frames: np.ndarray,
    codec: str,
    pixels: str,
    container: str | None = None,
    **tags: str,
) -> Any:
    """A video of frames, grey (n, h, w) of 8 or 16 bits or coloured (n, h, w, 3), with these tags."""
    import av

    with av.open(str(file) if isinstance(file, Path) else file, "w", format=container) as made:
        made.metadata.update(tags)
        stream: Any = made.add_stream(codec, rate=30)
        stream.height, stream.width, stream.pix_fmt = *frames.shape[1:3], pixels
        kind = "rgb24" if frames.ndim == 4 else "gray16le" if frames.dtype == np.uint16 else "gray"
        for picture in frames:
            made.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format=kind)))
        made.mux(stream.encode())
    return file


def stored(path: Path, picture: np.ndarray) -> Path:
    if path.suffix == ".tif":
        tifffile.imwrite(path, picture, photometric="minisblack")
    else:
        Image.fromarray(picture).save(path)
    return path


def deep(picture: np.ndarray) -> np.ndarray:
    return picture.astype(np.uint16) * 257


def colour_png(path: Path, picture: np.ndarray) -> Path:
    """PNG of 16 bits a colour, which Pillow does not write."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in np.repeat(picture[..., None], 3, axis=2))
    head = struct.pack(">IIBBBBB", picture.shape[1], picture.shape[0], 16, 2, 0, 0, 0)
    ends = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + ends)
    return path


NAN = B.astype(np.float32)
NAN[3, 4] = np.nan


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The error message: one line, exit code 2."""
    assert main(arguments) == 2
    message = capsys.readouterr()
    assert message.out == ""
    assert message.err.startswith("plica: ")
    assert message.err.count("\n") == 1
    return message.err


def two_pages(path: Path) -> Path:
    tifffile.imwrite(path, np.stack([A, B]), photometric="minisblack")
    return path


def one_page_of_many(path: Path) -> Path:
    """As ImageJ stores what is above 4 GB."""
    tifffile.imwrite(path, np.stack([A, B, A]), photometric="minisblack", truncate=True)
    return path


def cut_pages(path: Path) -> Path:
    with tifffile.TiffWriter(path) as file:
        for _ in range(6):
            file.write(A, photometric="minisblack", contiguous=False)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return path


def cut_after_the_first(path: Path) -> Path:
    with tifffile.TiffWriter(path) as file:
        for _ in range(2):
            file.write(A, photometric="minisblack", contiguous=False)
    path.write_bytes(path.read_bytes()[:-2000])
    return path


def text(path: Path) -> Path:
    path.write_text("no picture")
    return path


def nothing(path: Path) -> Path:
    path.write_bytes(b"")
    return path


def truncated(path: Path) -> Path:
    stored(path, A)
    path.write_bytes(path.read_bytes()[:300])
    return path


def animated(path: Path) -> Path:
    Image.fromarray(A).save(path, save_all=True, append_images=[Image.fromarray(B)])
    return path


def tiff(path: Path, picture: np.ndarray, **options: Any) -> Path:
    tifffile.imwrite(path, picture, **options)
    return path


MAP = np.arange(256)[::-1] * 257 * np.ones((3, 1))  # bright where the index is small
