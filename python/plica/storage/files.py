"""The border to the file system: clear errors, atomic replacement, one writer a directory."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from plica.errors import InvalidInput, StorageFailed

__all__ = ["only_writer", "refuse_overwriting", "replaced", "require_space", "storage_errors"]


@contextmanager
def storage_errors(path: Path, action: str = "written") -> Iterator[None]:
    """Turn the system's errors into one sentence that names the file."""
    try:
        yield
    except StorageFailed:
        raise
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else " ".join(str(error).split())
        kept = action == "written" and error.errno  # HDF5's own complaint is of a file that is broken
        hint = " What was stored before is kept, and can be gone on with." if kept and _begun(path) else ""
        raise StorageFailed(f"{path}: cannot be {action}: {reason}.{hint}") from None


def _begun(path: Path) -> bool:
    """Whether something is there that a command goes on with: of a run, a recording or an identification."""
    try:
        directory = path if path.is_dir() else path.parent
        return any((directory / name).exists() for name in ("results.h5", "iterates.json"))
    except OSError:  # the directory cannot be looked at
        return False


def replaced(path: Path, write: Callable[[Path], None]) -> None:
    """Let `write` make a file beside `path`, put it on the disk and move it to `path` in one step."""
    draft = path.with_name(path.name + ".part")
    with storage_errors(path):
        try:
            write(draft)
            with draft.open("rb+") as file:
                os.fsync(file.fileno())
            os.replace(draft, path)
        finally:
            draft.unlink(missing_ok=True)
        directory = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)


def refuse_overwriting(paths: Sequence[Path], overwrite: bool) -> None:
    """Raises InvalidInput where one of the files is there, unless they are to be overwritten."""
    present = [str(path) for path in paths if path.exists()]
    if present and not overwrite:
        raise InvalidInput(
            f"{', '.join(present)} would be overwritten; must not be. Name another file, or ask for it: "
            "--overwrite, in Python overwrite=True."
        )


def require_space(path: Path, needed: int, hint: str = "") -> None:
    """Raise unless a file of `needed` bytes can be made at `path`: the disk, quotas and limits are asked."""
    try:
        with path.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, needed)
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        raise StorageFailed(
            f"{path.parent}: the results need {needed / 1e6:.1f} MB there: {reason}. Take another "
            f"directory{hint}."
        ) from None
    finally:
        path.unlink(missing_ok=True)


@contextmanager
def only_writer(directory: Path) -> Iterator[None]:
    """Hold the directory; the system lets go when the process ends, however it ends."""
    path = directory / ".lock"
    with storage_errors(directory):
        file = path.open("w")
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InvalidInput(f"{directory}: another process is computing this run.") from None
        yield
