"""File system access: clear errors, atomic replacement, one writer per directory."""

from __future__ import annotations

import fcntl
import os
import stat
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from plica.errors import InvalidInput, StorageFailed

__all__ = [
    "being_written",
    "draft_of",
    "holds_nothing_but",
    "only_writer",
    "refuse_overwriting",
    "refuse_sweep",
    "replaced",
    "require_file",
    "require_space",
    "storage_errors",
    "write_text",
]

LOCK = ".lock"
PLAN = "plan.json"
"""The file that makes a directory that of a sweep."""
DRAFT = ".part"


@contextmanager
def storage_errors(path: Path, action: str = "written") -> Iterator[None]:
    """Convert system errors to StorageFailed with a message that names the file."""
    try:
        yield
    except StorageFailed:
        raise
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else " ".join(str(error).split())
        kept = action == "written" and error.errno  # without errno HDF5 reports a broken file
        hint = " Earlier results are kept and can be continued." if kept and _has_results(path) else ""
        raise StorageFailed(f"{path}: cannot be {action}: {reason}.{hint}") from None


def _has_results(path: Path) -> bool:
    """Whether there are results that a command can continue: of a run, a recording or an identification."""
    try:
        directory = path if path.is_dir() else path.parent
        return any((directory / name).exists() for name in ("results.h5", "iterates.json"))
    except OSError:  # the directory cannot be read
        return False


def draft_of(path: Path) -> Path:
    """Where a file is written before it replaces `path`: beside it."""
    return path.with_name(path.name + DRAFT)


def replaced(path: Path, write: Callable[[Path], None]) -> None:
    """Let `write` create a temporary file, sync it to disk and rename it to `path` atomically."""
    draft = draft_of(path)
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


def write_text(text: str, path: Path) -> Path:
    """Write text, replacing the file atomically, and return the path."""

    def fill(draft: Path) -> None:
        draft.write_text(text, encoding="utf-8")

    replaced(path, fill)
    return path


_KINDS: tuple[tuple[Callable[[int], bool], str], ...] = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def require_file(path: Path, where: str) -> None:
    """Raise InvalidInput for a pipe, which would wait for ever, a socket or a device, before it is opened.

    The message begins with `where`, which names the file. What is missing, or a directory, is left
    to whoever opens it.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        return
    for is_kind, kind in _KINDS:
        if is_kind(mode):
            raise InvalidInput(f"{where} is {kind}; must be a file. Store its content in one.")


def refuse_overwriting(paths: Sequence[Path], overwrite: bool) -> None:
    """Raises InvalidInput if one of the files exists, unless `overwrite`."""
    present = [str(path) for path in paths if path.exists()]
    if present and not overwrite:
        raise InvalidInput(
            f"{', '.join(present)} would be overwritten; must not exist. Use another file name, or "
            "--overwrite (in Python overwrite=True)."
        )


def refuse_sweep(directory: Path) -> None:
    """Raises InvalidInput if the directory is that of a sweep, whose files others would replace."""
    if (directory / PLAN).is_file():
        raise InvalidInput(f"{directory}: holds a sweep; must be a directory of its own. Use another.")


def require_space(path: Path, needed: int, hint: str = "") -> None:
    """Raise StorageFailed unless a file of `needed` bytes can be created at `path`."""
    try:
        with path.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, needed)
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        raise StorageFailed(
            f"{path.parent}: the results need {needed / 1e6:.1f} MB there: {reason}. Use another "
            f"directory{hint}."
        ) from None
    finally:
        path.unlink(missing_ok=True)


def holds_nothing_but(directory: Path, names: Collection[str] = ()) -> bool:
    """Whether a directory has at most what a command leaves there that was killed before it stored anything:
    its lock, unfinished drafts, and files of these names.

    False if it does not exist, or was not made by a command: it must have the lock.
    """
    if not (directory / LOCK).exists():
        return False
    with storage_errors(directory, "read"):
        found = {path.name for path in directory.iterdir()}
    return all(name in {LOCK, *names} or name.endswith(DRAFT) for name in found)


@contextmanager
def only_writer(directory: Path) -> Iterator[None]:
    """Lock the directory; the system releases the lock when the process ends."""
    path = directory / LOCK
    with storage_errors(directory):
        file = path.open("w")
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InvalidInput(f"{directory}: another process is writing to this directory.") from None
        yield


def being_written(directory: Path) -> bool:
    """Whether a process writes to the directory (`only_writer`); also where that cannot be told, as on some
    network drives, but not where there is no lock, as in a copy."""
    try:
        with (directory / LOCK).open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False
