"""The exceptions of Plica. Messages have the form ``Where: name = value unit; must be relation. Hint.``"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from importlib import import_module
from typing import Any, TypeVar

from plica._engine import InvalidInput, SolveFailed

Item = TypeVar("Item")

__all__ = [
    "CautionWarning",
    "Damaged",
    "InvalidInput",
    "Named",
    "SceneError",
    "SolveFailed",
    "StepFailed",
    "StorageFailed",
    "UnknownName",
    "library",
    "nearest",
    "one_of",
    "selected",
]


class CautionWarning(UserWarning):
    """A caution of a run: what to check before trusting its numbers (``Run.cautions``, docs/cautions.md).

    `plica.run` warns of each once, with the directory of the run, so that none of a sweep is taken for one
    that was shown before. ``warnings.filterwarnings("ignore", category=plica.CautionWarning)`` hides them.
    """


class SceneError(InvalidInput):
    """A scene, or its mesh file, is invalid.

    Attributes
    ----------
    problems : tuple of str
        One line per error; the message consists of these lines.
    """

    def __init__(self, problems: str | Iterable[str]) -> None:
        self.problems = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems))


class Damaged(InvalidInput):
    """A file that plica wrote is not as it wrote it: a checksum fails, or the file is cut off."""


class StepFailed(SolveFailed):
    """A step of a simulation has no solution; the simulation is at the end of the previous step.

    Attributes
    ----------
    waveforms : mapping of ndarray
        Waveforms of the completed steps of the call, as ``Simulation.advance`` returns them; without rows if
        its first step failed.
    """

    def __init__(self, message: str, waveforms: Mapping[str, Any]) -> None:
        self.waveforms = waveforms
        super().__init__(message)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.waveforms)


class StorageFailed(OSError):  # noqa: N818 (a pair with SolveFailed)
    """Results cannot be written or read: the message has the file, the system's reason and what to do."""


def nearest(name: str, known: Iterable[str], cutoff: float = 0.5) -> str:
    """`` Did you mean "..."?`` for the closest known name of at least this similarity (difflib), by all of it
    or by one of its words, or nothing."""
    candidates = list(known)
    lowered: dict[str, str] = {}
    for candidate in candidates:
        for word in candidate.lower().replace(".", "_").split("_"):
            lowered.setdefault(word, candidate)
    lowered |= {candidate.lower(): candidate for candidate in candidates}
    close = get_close_matches(name.lower(), lowered, n=1, cutoff=cutoff)
    return f' Did you mean "{lowered[close[0]]}"?' if close else ""


def one_of(known: Iterable[object]) -> str:
    """The known names as text for a message."""
    names = ", ".join(str(name) for name in known)
    return f"one of {names}" if names else "left out: there are none"


def selected(requested: Iterable[str] | None, known: Sequence[str], where: str) -> list[str]:
    """The known names that are requested, all for none, in their order.

    Raises InvalidInput, ``where = "x"; must be one of ...``, for a name that is not known.
    """
    asked = list(requested or known)
    for name in asked:
        if name not in known:
            raise InvalidInput(f'{where} = "{name}"; must be {one_of(known)}.{nearest(name, known)}')
    return [name for name in known if name in asked]


class UnknownName(InvalidInput, KeyError):  # noqa: N818 (what it is, as the others)
    """A mapping has no such key: the message has the nearest and all known names.

    Parameters
    ----------
    where : str
        Name of the mapping in the message.
    name : str
    known : iterable of str
    meant : iterable of str
        Known names for which `name` is a common name.
    """

    def __init__(self, where: str, name: object, known: Iterable[str], meant: Iterable[str] = ()) -> None:
        names = list(known)
        near = [f' Did you mean "{one}"?' for one in meant if one in names] or [nearest(str(name), names)]
        super().__init__(f'{where}: "{name}"; must be {one_of(names)}.{near[0]}')

    def __str__(self) -> str:
        return str(self.args[0])  # without the quotes of KeyError


class Named(dict[str, Item]):
    """A dict whose missing keys raise `UnknownName`.

    Parameters
    ----------
    where : str
        Name of the mapping in the message.
    items : iterable of pairs
    """

    def __init__(self, where: str, items: Iterable[tuple[str, Item]]) -> None:
        super().__init__(items)
        self._where = where

    def __missing__(self, name: str) -> Item:
        raise UnknownName(self._where, name, self)


_CALLED = {"av": "PyAV", "onnxruntime": "ONNX Runtime", "pycine": "pycine-lite", "weasyprint": "WeasyPrint"}
"""Names of libraries, where they are not those of what is imported."""


def library(name: str, extra: str, user: str, kind: type[Exception] = InvalidInput) -> Any:
    """A library of an extra, loaded where it is used.

    Parameters
    ----------
    name : str
        What is imported.
    extra : str
        Of pyproject.toml, or several with commas.
    user : str
        What needs it: "Recording: x.avi".
    kind : type
        Of the exception that is raised without it.
    """
    base = name.partition(".")[0]
    try:
        return import_module(name)
    except ImportError as error:
        if error.name is not None and error.name.partition(".")[0] != base:
            raise  # the library is there, and lacks something
        called = _CALLED.get(base, base)
        raise kind(
            f"{user} needs {called}, which is not installed; must be: pip install 'plica[{extra}]'."
        ) from None
