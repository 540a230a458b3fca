"""The plan of a sweep: what it is of, the keys that change, and their values in each case."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, nearest, one_of
from plica.measures.waveforms import STORED
from plica.scene.scene import Scene
from plica.sweep.needed import needed
from plica.sweep.scene_cases import SceneCases
from plica.sweep.subject import RECORDING, ChoiceKey, Key, Subject, loaded
from plica.sweep.values import Range, Values, read_values

__all__ = ["DESIGNS", "Design", "Plan"]

Design = Literal["grid", "list", "latin_hypercube", "sobol", "morris"]
DESIGNS: tuple[Design, ...] = get_args(Design)
DRAWN = ("latin_hypercube", "sobol", "morris")
"""Designs whose cases are drawn from ranges."""

_MOST = 1_000_000  # cases
_SAMPLES = {
    "latin_hypercube": "cases",
    "sobol": "points, each of which has as many cases as keys are varied and two more",
    "morris": "paths, each of which has as many cases as keys are varied and one more",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A fixed plan, made by `Plan.make`.

    Attributes
    ----------
    subject : Subject
        What cases are of: `SceneCases`, `Recordings` or `Identifications`.
    design : {"grid", "list", "latin_hypercube", "sobol", "morris"}
    varied : tuple of Values or Range
        Each key with what was given for it; of several recordings these first.
    values : (cases, keys)
        In SI; of words their positions.
    samples, seed : int or None
        Of a design that is drawn.
    waveforms : tuple of str
        Kept of each case, besides its measures.
    keep : {"measures", "runs"}
        Whether whole folders of results are kept.
    """

    subject: Subject
    design: Design
    varied: tuple[Values | Range, ...]
    values: NDArray[np.float64] = field(repr=False)
    samples: int | None = None
    seed: int | None = None
    waveforms: tuple[str, ...] = ()
    keep: Literal["measures", "runs"] = "measures"

    @classmethod
    def make(
        cls,
        subject: Subject | Scene | str | Path,
        vary: Mapping[str, object],
        *,
        design: Design = "grid",
        samples: int | None = None,
        seed: int | None = None,
        waveforms: Sequence[str] = (),
        keep: Literal["measures", "runs"] = "measures",
        where: str = "sweep",
    ) -> Plan:
        """The plan of a sweep.

        Parameters
        ----------
        subject : Scene, path, Recordings or Identifications
            A scene, or its file; or recordings, which are analysed, or asked for the tissue.
        vary : mapping
            Key of a number of the scene, ``"tissue.cover.E"``, to its values: ``"0.4:1.2:9 kPa"`` (nine,
            evenly from end to end), ``"1, 2, 4 kPa"``, or a list; or to its range, ``"0.4:1.2 kPa"``, for
            a design that is drawn. Of several recordings it may be empty, in a grid or a list.
        design : str
            ``"grid"``: all combinations. ``"list"``: case k has the k-th value of every key. Each of several
            recordings has all cases.
            ``"latin_hypercube"``: `samples` cases spread over the ranges. ``"sobol"`` (Saltelli) and
            ``"morris"``: those of sensitivity indices.
        samples : int, optional
            Of a design that is drawn: cases (``latin_hypercube``), points (``sobol``, a power of 2), or paths
            (``morris``).
        seed : int, optional
            Of a design that is drawn; default: 1.
        waveforms : sequence of str
            To keep of each run: those with one number a step.
        keep : {"measures", "runs"}
            ``"runs"``: also the folder of each case, as ``plica run``, ``video`` or ``identify`` has it.
        where : str
            Prefix of messages.

        Raises
        ------
        InvalidInput
        """
        if isinstance(subject, Scene | str | Path):
            subject = SceneCases(loaded(subject))
        several = len(subject.recordings) > 1
        if design not in DESIGNS:
            raise InvalidInput(f'{where}: design = "{design}"; must be {one_of(DESIGNS)}.')
        if keep not in ("measures", "runs"):
            raise InvalidInput(f'{where}: keep = "{keep}"; must be one of measures, runs.')
        if not vary and (not several or design in DRAWN):
            raise InvalidInput(f"{where}: no key is varied; must be one or more, e.g. tissue.cover.E.")
        if several and design in ("sobol", "morris"):
            raise InvalidInput(
                f'{where}: design = "{design}" with {len(subject.recordings)} recordings; must be of one: '
                "sensitivity indices are of one voice."
            )
        _require_waveforms(subject, waveforms, vary, where)
        varied = tuple(read_values(subject.key(key, where), given, where) for key, given in vary.items())
        drawn = design in DRAWN
        for one in varied:
            if isinstance(one, Range) != drawn:
                must = 'a range, e.g. "0.4:1.2 kPa"' if drawn else 'values, e.g. "0.4:1.2:9 kPa"'
                raise InvalidInput(f'{where}: {one.key.key}; must have {must}, in a design "{design}".')
        if drawn:
            samples = _required_samples(samples, design, where)
            seed = 1 if seed is None else seed
            values = _drawn(design, [one for one in varied if isinstance(one, Range)], samples, seed, where)
        else:
            for name, number in (("samples", samples), ("seed", seed)):
                if number is not None:
                    raise InvalidInput(
                        f'{where}: {name} = {number}; must be left out: a design "{design}" is not drawn.'
                    )
            values = _given(design, [one for one in varied if isinstance(one, Values)], where)
        if several:
            named = Values.of_words(ChoiceKey(RECORDING, subject.recordings), subject.recordings)
            varied, values = (named, *varied), _of_each(named, values, where)
        return cls(
            subject=subject,
            design=design,
            varied=varied,
            values=values,
            samples=samples,
            seed=seed,
            waveforms=tuple(waveforms),
            keep=keep,
        )

    @property
    def keys(self) -> tuple[Key, ...]:
        """The keys that change."""
        return tuple(one.key for one in self.varied)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each key of a grid; else of cases."""
        if self.design != "grid":
            return (len(self),)
        return tuple(len(one.values) for one in self.varied if isinstance(one, Values))

    def __len__(self) -> int:
        return len(self.values)

    def changes(self, case: int) -> dict[str, float | int | str]:
        """What case number `case`, from 0, changes, and its recording, if there are several."""
        return {
            one.key.key: _changed(one, float(value))
            for one, value in zip(self.varied, self.values[case], strict=True)
        }

    def case_digest(self, case: int) -> str:
        """What a case is of: files, version and changes, as 16 hexadecimal digits."""
        return _digest([self._common, self.changes(case)])[:16]

    @cached_property
    def record(self) -> dict[str, Any]:
        """All that must be the same to go on with it, as JSON; `values` by their digest."""
        return {
            "design": self.design,
            "samples": self.samples,
            "seed": self.seed,
            "keys": [{"key": key.key, "unit": key.unit} for key in self.keys],
            "ranges": [[one.low, one.high] for one in self.varied if isinstance(one, Range)],
            "cases": len(self),
            "values": _digest(self.values.tolist()),
            "waveforms": list(self.waveforms),
            "keep": self.keep,
            **self._words,
            **self._of_all,
        }

    @property
    def _words(self) -> dict[str, Any]:
        words = {one.key.key: one.words for one in self.varied if isinstance(one, Values) and one.words}
        return {"words": {key: list(found) for key, found in words.items()}} if words else {}

    @cached_property
    def _of_all(self) -> dict[str, Any]:
        return self.subject.record()

    @cached_property
    def _common(self) -> str:
        return _digest(self._of_all)


def _changed(one: Values | Range, value: float) -> float | int | str:
    """What a case has for a key."""
    if isinstance(one.key, ChoiceKey):
        assert isinstance(one, Values)
        return one.words[round(value)]
    return round(value) if one.key.whole else value


def _of_each(recordings: Values, values: NDArray[np.float64], where: str) -> NDArray[np.float64]:
    """The cases of a design for each of these recordings, which are the first column."""
    count = len(recordings.values)
    _require_few(count * len(values), where)
    first = np.repeat(np.array(recordings.values), len(values))
    return np.column_stack([first, np.tile(values, (count, 1))])


def _require_waveforms(
    subject: Subject, waveforms: Sequence[str], vary: Mapping[str, object], where: str
) -> None:
    if waveforms and subject.kind != "run":
        raise InvalidInput(
            f"{where}: waveforms of recordings; must be left out: cases have no times in common. With keep = "
            '"runs" the folder of each case has its own.'
        )
    known = [name for name, one in STORED.items() if one.per == "step" and name != "time"]
    for name in waveforms:
        if name not in known:
            raise InvalidInput(
                f'{where}: waveforms: "{name}"; must be one with a number a step (plica keys waveforms).'
                f"{nearest(name, known)}"
            )
    moved = [key for key in vary if key.startswith("time.")]
    if waveforms and moved:
        raise InvalidInput(
            f"{where}: waveforms with {moved[0]}; must be left out: cases have no times in common."
        )


def _required_samples(samples: int | None, design: Design, where: str) -> int:
    if samples is None or samples < 1:
        shown = "left out" if samples is None else f"{samples}"
        raise InvalidInput(f"{where}: samples is {shown}; must be the number of {_SAMPLES[design]}.")
    if design == "sobol" and samples & (samples - 1):
        raise InvalidInput(f"{where}: samples = {samples}; must be a power of 2 in a Sobol design.")
    return samples


def _require_few(cases: int, where: str) -> None:
    if cases > _MOST:
        raise InvalidInput(f"{where}: the plan has {cases} cases; must be at most {_MOST}.")


def _given(design: Design, varied: Sequence[Values], where: str) -> NDArray[np.float64]:
    """The cases of values that are given."""
    if not varied:
        return np.zeros((1, 0))
    columns = [one.values for one in varied]
    lengths = {one.key.key: len(one.values) for one in varied}
    if design == "list":
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{key} {count}" for key, count in lengths.items())
            raise InvalidInput(f"{where}: numbers of values: {found}; must be equal in a list.")
        return np.array(columns, dtype=float).T
    for one in varied:
        if len(set(one.values)) < len(one.values):
            raise InvalidInput(
                f"{where}: {one.key.key} has a value twice; must be different values in a grid."
            )
    _require_few(int(np.prod([float(count) for count in lengths.values()])), where)
    return np.array(list(itertools.product(*columns)), dtype=float)


def _drawn(
    design: Design, ranges: Sequence[Range], samples: int, seed: int, where: str
) -> NDArray[np.float64]:
    """The cases of a design that is drawn, by SALib."""
    for one in ranges:
        if one.key.whole:
            raise InvalidInput(
                f"{where}: {one.key.key} is a whole number; must be varied in a grid or a list."
            )
    many = {"latin_hypercube": samples, "sobol": samples * (len(ranges) + 2)}
    _require_few(many.get(design, samples * (len(ranges) + 1)), where)
    problem = {
        "num_vars": len(ranges),
        "names": [one.key.key for one in ranges],
        "bounds": [[one.low, one.high] for one in ranges],
    }
    make: Callable[..., Any] = needed(
        f"SALib.sample.{'latin' if design == 'latin_hypercube' else design}"
    ).sample
    options = {"calc_second_order": False} if design == "sobol" else {}
    return np.asarray(make(problem, samples, seed=seed, **options), dtype=float)


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
