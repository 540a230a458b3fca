"""Segmentation by a network of the user's own: an ONNX model (docs/recording_files.md)."""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plica._engine import threads
from plica.errors import library, nearest, one_of
from plica.video.errors import VideoError
from plica.video.glottis.frame_outline import Outline

__all__ = ["Network", "Placement", "fingerprint"]

Floats = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]

_MULTIPLE = 32  # px; a net that halves its picture five times takes such sides
_BAND = 0.1  # of probability, about the threshold
_ROUND_OFF = 1e-3  # by which a probability may be beyond 0 and 1, two may miss 1
_KEYS = {"plica.output": "probability", "plica.threshold": "0.5", "plica.resize": "fit"}
"""Of the model's metadata, with what is taken where one is not there."""
_TYPES = {"tensor(float)": np.float32, "tensor(float16)": np.float16, "tensor(uint8)": np.uint8}


@dataclass(frozen=True)
class Placement:
    """Where a frame lies in the network's picture: scaled to (h', w'), from (top, left), of (H, W) px.

    Both have their pixels' centres at (i + 1/2) / n of a side, so that nothing is shifted by scaling.
    """

    frame: tuple[int, int]
    inner: tuple[int, int]
    top: int
    left: int
    outer: tuple[int, int]

    @classmethod
    def of(cls, frame: tuple[int, int], outer: tuple[int, int] | None, resize: str) -> Placement:
        """In a picture of a fixed size: as large as it fits ("fit"), or filling it ("stretch"). None: the
        frame as it is, in the next larger picture whose sides are multiples of 32."""
        if outer is None:
            inner, outer = (
                frame,
                (-(-frame[0] // _MULTIPLE) * _MULTIPLE, -(-frame[1] // _MULTIPLE) * _MULTIPLE),
            )
        elif resize == "stretch":
            inner = outer
        else:
            scale = min(outer[0] / frame[0], outer[1] / frame[1])
            inner = max(1, round(scale * frame[0])), max(1, round(scale * frame[1]))
        return cls(frame, inner, (outer[0] - inner[0]) // 2, (outer[1] - inner[1]) // 2, outer)

    def into(self, frame: Floats) -> Floats:
        """(H, W) the picture of a frame (h, w): beyond its borders their grey goes on."""
        (h, w), (H, W) = self.inner, self.outer
        below, right = H - h - self.top, W - w - self.left
        return np.pad(_resized(frame, self.inner), ((self.top, below), (self.left, right)), mode="edge")

    def back(self, found: Floats) -> Floats:
        """(h, w) what was found in the picture, (H, W), at the frame's pixels."""
        (h, w) = self.inner
        return _resized(found[self.top : self.top + h, self.left : self.left + w], self.frame)


def _resized(image: Floats, shape: tuple[int, int]) -> Floats:
    """(h, w) by linear interpolation; where it becomes smaller, by means over what a pixel covers."""
    from PIL import Image

    if image.shape == shape:
        return np.asarray(image, np.float32)
    picture = Image.fromarray(np.ascontiguousarray(image, np.float32), mode="F")
    return np.asarray(picture.resize(shape[::-1], Image.Resampling.BILINEAR))


class Network:
    """An ONNX model that gives every pixel's probability of being glottis.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    threshold : float
        Probability from which a pixel is glottis.
    blur : float
        Not a number: a network draws no outline halfway from the dark to the tissue.

    Raises
    ------
    VideoError
        Where ONNX Runtime is not installed; for a file that is no model, or one whose input, output or
        metadata are others than stated in docs/recording_files.md.
    """

    blur = float("nan")

    def __init__(self, path: str | Path) -> None:
        self.name = Path(path).name
        self._session = _opened(Path(path), self.name)
        inputs, outputs = self._session.get_inputs(), self._session.get_outputs()
        for what, found in (("inputs", inputs), ("outputs", outputs)):
            if len(found) != 1:
                named = ", ".join(one.name for one in found)
                raise self._wrong(f"{len(found)} {what} ({named})", "one: a picture in, a map of it out")
        self._input = inputs[0].name
        if inputs[0].type not in _TYPES:
            raise self._wrong(f"an input of {inputs[0].type}", one_of(_TYPES))
        self._type = _TYPES[inputs[0].type]
        self._read_shape(list(inputs[0].shape))
        self._read_metadata(self._session.get_modelmeta().custom_metadata_map)

    def found_nothing(self, count: int) -> VideoError:
        """The error of a recording in none of whose frames it finds a glottis."""
        return VideoError(
            f"Segmenter: {self.name} finds no glottis in any of {count} frames: no pixel's probability is "
            f"{self.threshold:g} or more; must find it in some. Does it see frames as it was trained on "
            "(scale, turn, region)? See docs/recording_files.md."
        )

    def outline(self, frame: Floats, index: int) -> Outline:
        """The glottis of a frame, (h, w) grey, 0 to 255; where its threshold 0.1 lower or higher, its band.

        Raises
        ------
        VideoError
            Where the model fails, or what it gives is no probability; names the frame.
        """
        found = self.probability(frame, f"frame {index}")
        lower, higher = max(self.threshold - _BAND, 0.0), min(self.threshold + _BAND, 1.0)
        mask = found >= self.threshold
        least, largest = (float(np.sum(found >= level)) for level in (higher, max(lower, 1e-6)))
        whole = mask.astype(float)
        return Outline(mask, whole, whole, least, largest)

    def left_out(self, glottis: Mask) -> Mask:
        """Nothing: the model alone says what is glottis."""
        return np.zeros_like(glottis)

    def probability(self, frame: Floats, name: str = "the frame") -> Floats:
        """(h, w) of each pixel of a frame, (h, w) grey, 0 to 255. Raises as :meth:`outline`."""
        place = Placement.of((frame.shape[0], frame.shape[1]), self._size, self._resize)
        picture = np.clip(place.into(frame), 0, 255)
        given = np.round(picture).astype(np.uint8) if self._type is np.uint8 else picture / 255
        axis = 1 if self._channels_first else 3
        tensor = np.repeat(np.expand_dims(given[None], axis), self._channels, axis).astype(self._type)
        try:
            (raw,) = self._session.run(None, {self._input: tensor})
        except Exception as error:  # ONNX Runtime's have no base of their own
            raise VideoError(
                f"Segmenter: {self.name} fails on {name}, given {tensor.shape}: {_first_line(error)}"
            ) from None
        return place.back(self._probability(np.asarray(raw), place.outer, name))

    def _probability(self, raw: npt.NDArray[Any], size: tuple[int, int], name: str) -> Floats:
        """(H, W) what the model gave, as the probability of glottis."""
        axis = 1 if self._channels_first else 3
        given = np.expand_dims(raw, axis) if raw.ndim == 3 else raw
        if given.ndim == 4:
            given = np.moveaxis(given, axis, 3)
        if given.ndim != 4 or given.shape[:3] != (1, *size) or given.shape[3] not in (1, 2):
            order = (
                f"(1, C, {size[0]}, {size[1]})" if self._channels_first else f"(1, {size[0]}, {size[1]}, C)"
            )
            raise self._wrong(
                f"an output of shape {raw.shape} for {name}", f"{order} with C = 1 or 2, or that without C"
            )
        values = given[0].astype(np.float32)
        if not np.isfinite(values).all():
            y, x = np.argwhere(~np.isfinite(values))[0][:2]
            raise self._wrong(
                f"{values[y, x].tolist()} at ({x}, {y}) of its output for {name}", "finite numbers"
            )
        if self._logits:
            # Of two channels softmax is the logistic function of their difference.
            score = values[..., 0] if values.shape[-1] == 1 else values[..., 1] - values[..., 0]
            return np.asarray(0.5 * (1 + np.tanh(0.5 * score)), np.float32)
        hint = 'probabilities. Does it give logits? Then set its metadata "plica.output" to "logits"'
        if values.min() < -_ROUND_OFF or values.max() > 1 + _ROUND_OFF:
            raise self._wrong(f"outputs from {values.min():.3g} to {values.max():.3g} for {name}", hint)
        if values.shape[-1] == 2 and np.abs(values.sum(axis=-1) - 1).max() > _ROUND_OFF:
            raise self._wrong(f"two channels whose sums are not 1 for {name}", hint)
        return np.asarray(values[..., -1])

    def _read_shape(self, shape: list[Any]) -> None:
        shown = "(" + ", ".join(str(side) for side in shape) + ")"
        if len(shape) != 4 or (isinstance(shape[0], int) and shape[0] != 1):
            raise self._wrong(f"an input of shape {shown}", "(1, C, H, W) or (1, H, W, C)")
        if shape[1] in (1, 3):
            self._channels_first, self._channels, sides = True, int(shape[1]), shape[2:]
        elif shape[3] in (1, 3):
            self._channels_first, self._channels, sides = False, int(shape[3]), shape[1:3]
        else:
            raise self._wrong(f"an input of shape {shown}", "of 1 or 3 channels, second or last, fixed")
        fixed = [isinstance(side, int) for side in sides]
        if any(fixed) != all(fixed):
            raise self._wrong(f"an input of shape {shown}", "fixed in height and width, or free in both")
        self._size = (int(sides[0]), int(sides[1])) if all(fixed) else None

    def _read_metadata(self, found: dict[str, str]) -> None:
        for key in found:
            if key.startswith("plica.") and key not in _KEYS:
                raise self._wrong(f'metadata "{key}"', f"{one_of(_KEYS)}.{nearest(key, _KEYS)}")
        given = {**_KEYS, **{key: found[key] for key in _KEYS if key in found}}
        for key, known in (("plica.output", ("probability", "logits")), ("plica.resize", ("fit", "stretch"))):
            if given[key] not in known:
                raise self._wrong(f'metadata {key} = "{given[key]}"', one_of(known))
        self._logits, self._resize = given["plica.output"] == "logits", given["plica.resize"]
        try:
            self.threshold = float(given["plica.threshold"])
        except ValueError:
            self.threshold = float("nan")
        if not 0 < self.threshold < 1:
            raise self._wrong(f'metadata plica.threshold = "{given["plica.threshold"]}"', "in (0, 1)")

    def _wrong(self, what: str, must: str) -> VideoError:
        return VideoError(f"Segmenter: {self.name} has {what}; must be {must}. See docs/recording_files.md.")


def fingerprint(path: str | Path) -> str:
    """Of a model's content, with that of the files its weights are in: an analysis goes on with the same
    model alone."""
    model = _bytes(Path(path))
    whole = hashlib.sha256(model)
    for name in sorted(_named_in(model)):
        beside = os.path.join(Path(path).parent, name)
        if os.path.isfile(beside):
            whole.update(Path(beside).read_bytes())
    return whole.hexdigest()


def _named_in(model: bytes) -> set[str]:
    """Files that hold tensors of an ONNX model, whichever part of it they are of.

    Each tensor names its own in an entry "location" of its `external_data` (onnx.proto): a field 1 with the
    key, then a field 2 with the length of the name, as a varint, and the name.
    """
    found = set()
    for match in re.finditer(rb"\x0a\x08location\x12([\x80-\xff]{0,4}[\x00-\x7f])", model):
        length = sum((digit & 127) << 7 * k for k, digit in enumerate(match[1]))
        found.add(os.fsdecode(model[match.end() : match.end() + length]))
    return found


def _bytes(path: Path) -> bytes:
    if not path.is_file():
        raise VideoError(f"Segmenter: {path} is no file; must be an ONNX model.")
    return path.read_bytes()


def _opened(path: Path, name: str) -> Any:
    _bytes(path)
    onnxruntime = library("onnxruntime", "onnx", f"Segmenter: {name}", VideoError)
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4  # what is wrong is raised
    options.intra_op_num_threads = threads()
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # ONNX Runtime's have no base of their own
        raise VideoError(
            f"Segmenter: {name} cannot be read as an ONNX model: {_first_line(error)}; must be one (.onnx). "
            "Export the network to ONNX again (docs/recording_files.md)."
        ) from None


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
