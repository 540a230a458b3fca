"""Files as Phantom's and Photron's cameras write them, made from their formats' documents for the tests."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

SETUP_LENGTH = 0x163C + 4096  # bytes; every field that is read lies before


def cine(
    path: Path,
    frames: np.ndarray,
    *,
    bits: int = 8,
    used: int = 8,
    packing: int = 0,
    rate: int = 4000,
    taken_every: int | None = 1,
    taken: int | None = None,
    gap: tuple[int, float] = (0, 0.0),
    compression: int = 0,
    filters: int = 0,
    trigger: int = 1_700_000_000,
    annotation: bytes = b"",
) -> Path:
    """A .cine file of frames (n, h, w) or (n, h, w, 3) in red, green, blue.

    `taken_every` n-th frame of the camera's is stored, which the tagged block of times says; None: no block.
    `taken`: frames the camera took; None: as many as that comes to. `gap`: frame before which the camera
    waited, and for how many seconds.
    """
    count, height, width = frames.shape[:3]
    pictures = [_cine_pixels(frame, bits, packing) for frame in frames]
    setup = bytearray(SETUP_LENGTH)
    struct.pack_into("<HH", setup, 140, 0x5453, SETUP_LENGTH)  # "ST"
    struct.pack_into("<I", setup, 768, rate)
    struct.pack_into("<I", setup, 808, filters)
    struct.pack_into("<I", setup, 896, used)
    block = b""
    if taken_every is not None:
        seconds = np.arange(count) * taken_every / rate + gap[1] * (np.arange(count) >= gap[0])
        times = b"".join(struct.pack("<II", int((s % 1) * 2**32), trigger + int(s)) for s in seconds)
        block = struct.pack("<IHH", 8 + len(times), 1002, 0) + times
    taken = count * (taken_every or 1) if taken is None else taken
    picture_at, setup_at = 44, 84
    offsets_at = setup_at + SETUP_LENGTH + len(block)
    first = offsets_at + 8 * count
    note = struct.pack("<I", 8 + len(annotation)) + annotation
    size = len(note) + 4 + len(pictures[0])
    head = struct.pack("<2sHHHiIiI", b"CI", 44, compression, 1, 0, taken, 0, count)
    head += struct.pack("<IIIII", picture_at, setup_at, offsets_at, 0, trigger)
    picture = struct.pack("<IiiHHIIiiII", 40, width, height, 1, bits, packing, len(pictures[0]), 0, 0, 0, 0)
    places = struct.pack(f"<{count}q", *(first + k * size for k in range(count)))
    body = b"".join(note + struct.pack("<I", len(one)) + one for one in pictures)
    path.write_bytes(head + picture + bytes(setup) + block + places + body)
    return path


def _cine_pixels(frame: np.ndarray, bits: int, packing: int) -> bytes:
    if packing:
        return packed(frame, 10 if packing == 256 else 12)
    upward = frame[::-1, :, ::-1] if frame.ndim == 3 else frame[::-1]
    return upward.astype("u1" if bits in (8, 24) else "<u2").tobytes()


def packed(frame: np.ndarray, bits: int) -> bytes:
    """Without gaps, the most significant bit first, bit by bit."""
    text = "".join(format(int(value), f"0{bits}b") for value in frame.ravel())
    return bytes(int(text[k : k + 8], 2) for k in range(0, len(text), 8))


CIH = {
    "Date": "2024/3/5",
    "Time": "14:07",
    "Camera Type": "FASTCAM",
    "Record Rate(fps)": "4000",
    "Save Step": "1",
    "Color Type": "Mono",
    "File Format": "MRaw",
    "EffectiveBit Side": "Lower",
}


def mraw(path: Path, frames: np.ndarray, *, stored: int = 8, used: int = 8, **changed: Any) -> Path:
    """NAME.mraw with NAME.cih or NAME.cihx, as `path` ends, which is returned; `changed`: fields of the
    header, "_" for a blank, None to leave one out."""
    high = changed.get("EffectiveBit_Side") == "Higher"
    values = frames.astype(np.uint32) << (stored - used if high else 0)
    raw = b"".join(packed(one, stored) for one in values) if stored in (10, 12) else (
        values.astype("u1" if stored == 8 else "<u2").tobytes()
    )  # fmt: skip
    path.with_suffix(".mraw").write_bytes(raw)
    message = {
        **CIH,
        "Total Frame": len(frames),
        "Image Width": frames.shape[2],
        "Image Height": frames.shape[1],
        "Color Bit": stored,
        "EffectiveBit Depth": used,
        **{name.replace("_", " "): value for name, value in changed.items()},
    }
    message = {name: str(value) for name, value in message.items() if value is not None}
    if path.suffix == ".cih":
        lines = [f"{name} : {value}" for name, value in message.items()]
        path.write_text("\r\n".join(["#Camera Information Header", *lines, "END", ""]), newline="")
    else:
        path.write_bytes(b"\x00\x12binary\xff" + _cihx(message).encode() + b"\xfe\x00more")
    return path


def _cihx(message: dict[str, str]) -> str:
    def tag(name: str, *inside: str) -> str:
        return f"<{name}>{''.join(inside)}</{name}>"

    return tag(
        "cih",
        tag("fileInfo", tag("date", message["Date"]), tag("time", message["Time"])),
        tag("recordInfo", tag("recordRate", message["Record Rate(fps)"])),
        tag("frameInfo", tag("totalFrame", message["Total Frame"]), tag("skipFrame", message["Save Step"])),
        tag("imageFileInfo", tag("fileFormat", message["File Format"])),
        tag(
            "imageDataInfo",
            tag("resolution", tag("width", message["Image Width"]), tag("height", message["Image Height"])),
            tag("colorInfo", tag("type", message["Color Type"]), tag("bit", message["Color Bit"])),
            tag(
                "effectiveBit",
                tag("depth", message["EffectiveBit Depth"]),
                tag("side", message["EffectiveBit Side"]),
            ),
        ),
    )
