"""Recordings in files, or in streams, that FFmpeg reads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy.typing as npt

from plica.errors import library
from plica.video.errors import VideoError
from plica.video.files.camera_metadata import Camera
from plica.video.files.limits import MOST_FRAMES, MOST_PIXELS, check

__all__ = ["Video"]


class Video:
    """A file that FFmpeg reads. Opening decodes it once: containers often state a wrong count.

    Parameters
    ----------
    path : Path
    stream : function, optional
        Opens the video that lies inside the file, where the file is of another kind.
    """

    camera: Camera | None = None

    def __init__(self, path: Path, stream: Callable[[], BinaryIO] | None = None) -> None:
        self.name, self._path, self._stream = path.name, path, stream
        self.count, self.shape = 0, (0, 0)
        stated, seconds, end = 0, 0.0, 0.0
        for index, (frame, of_container, length) in enumerate(self._decoded()):
            stated, seconds = of_container, length
            end = max(end, 0.0 if frame.time is None else frame.time)
            size = (frame.height, frame.width)
            if index and size != self.shape:
                raise self._broken(
                    index, f"is {frame.width} x {frame.height} px, frame 0 {self.shape[1]} x {self.shape[0]}"
                )
            self.count, self.shape = index + 1, size
            if max(self.count, stated) > MOST_FRAMES:
                check(self.name, max(self.count, stated), size)
        if stated and self.count < stated:
            raise VideoError(
                f"Recording: {self.name} ends after {self.count} frames; must have the {stated} that it "
                "states. It is cut off: copy it again, or store what there is of it in a file of its own"
                f"{self._by_ffmpeg('-c copy')}."
            )
        # A whole file's last frame begins one interval before its end.
        if self.count > 1 and seconds - end > 2.5 * end / (self.count - 1):
            raise VideoError(
                f"Recording: {self.name} ends after {self.count} frames, at {end:.3g} s of the "
                f"{seconds:.3g} s that it states. It is cut off: copy it again, or store what there is of it "
                f"in a file of its own{self._by_ffmpeg('-c copy')}."
            )
        check(self.name, self.count, self.shape)

    def pixels(self, begin: int, end: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        for index, (frame, _, _) in enumerate(islice(self._decoded(), end)):
            if index < begin:
                continue
            deep = max(part.bits for part in frame.format.components) > 8
            if frame.format.name.startswith("gray"):
                kind = "gray16le" if deep else "gray"
            else:
                kind = "rgb48le" if deep else "rgb24"
            yield f"{self.name}: frame {index}", frame.to_ndarray(format=kind)

    def _decoded(self) -> Iterator[tuple[Any, int, float]]:
        """Frames, each with the count and the seconds that the container states (0: none)."""
        av = library("av", "video", f"Recording: {self.name}", VideoError)
        index = -1
        try:
            with (
                nullcontext(str(self._path)) if self._stream is None else self._stream() as opened,
                av.open(opened, mode="r", metadata_errors="replace") as container,
            ):
                if not container.streams.video:
                    raise VideoError(f"Recording: {self.name} has no video.")
                stream = container.streams.video[0]
                stated = stream.codec_context
                if stated is None:
                    raise VideoError(f"Recording: {self.name} has no video that can be decoded. Is it whole?")
                if stated.width * stated.height > MOST_PIXELS:  # before one of them takes all memory
                    check(self.name, 2, (stated.height, stated.width))
                stream.thread_type = "AUTO"
                # Matroska states its length and no count; with sound beside, whose length it is is not said.
                alone = "matroska" in container.format.name and len(container.streams) == 1
                seconds = (container.duration or 0) / av.time_base if alone else 0.0
                for index, frame in enumerate(container.decode(stream)):
                    if frame.is_corrupt:
                        raise self._broken(index, "is damaged")
                    yield frame, stream.frames, seconds
        except av.FFmpegError as error:
            if index < 0:
                raise VideoError(
                    f"Recording: {self.name} cannot be read as a video ({error.strerror}). Is it whole?"
                ) from None
            raise self._broken(index + 1, f"cannot be decoded ({error.strerror})") from None

    def _broken(self, index: int, what: str) -> VideoError:
        return VideoError(
            f"Recording: {self.name}: frame {index} {what}. The {index} frames before it are whole: "
            f"store them in a file of their own{self._by_ffmpeg(f'-frames:v {index}')}."
        )

    def _by_ffmpeg(self, options: str) -> str:
        return "" if self._stream else f" (ffmpeg -i {self.name} {options} whole.mkv)"
