"""Results that do not depend on the number of threads, nor on where a run was interrupted."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import plica
from plica import _engine as engine
from plica.verify.case import Case, Check
from plica.verify.larynx import larynx_scene, larynx_simulation

__all__ = ["CASES"]

STEPS = 150


def phonating() -> plica.Scene:
    """Folds that are blown open, swing back and collide within 150 steps."""
    return larynx_scene(
        airflow=plica.Airflow(), contact=plica.Multipliers(), initial=plica.Initial(opening_velocity=-1.3)
    )


def differing(first: dict[str, Any], second: dict[str, Any]) -> int:
    """How many numbers differ in a bit, of arrays and of scalars."""
    count = len(set(first) ^ set(second))
    for name in set(first) & set(second):
        one, other = (np.asarray(found[name]) for found in (first, second))
        if one.shape != other.shape or one.dtype != other.dtype:
            count += max(one.size, other.size)
            continue
        pairs = zip(one.ravel().tolist(), other.ravel().tolist(), strict=True)
        count += sum(repr(a) != repr(b) for a, b in pairs)  # repr tells every bit but those of a NaN
    return count


def counted(name: str, quantity: str, count: int) -> Check:
    return Check(
        name=name,
        quantity=quantity,
        unit="1",
        value=float(count),
        reference=0.0,
        tolerance=0.0,
        because="bits are the same or not",
        of="unit",
    )


def threads() -> Iterator[Check]:
    """The same run on one thread and on two."""
    before = engine.threads()
    found = []
    try:
        for count in (1, 2):
            plica.set_threads(count)
            _, simulation = larynx_simulation(phonating())
            found.append((simulation.advance(STEPS), simulation.state()))
    finally:
        plica.set_threads(before)
    (waves, state), (other_waves, other_state) = found
    yield counted(
        "waveforms", f"numbers that differ in all waveforms of {STEPS} steps", differing(waves, other_waves)
    )
    yield counted("state", "numbers that differ in the state at the end", differing(state, other_state))
    yield touching(waves)


def restore() -> Iterator[Check]:
    """A run in one go, and one that a new simulation takes up in the middle."""
    _, whole = larynx_simulation(phonating())
    waves = whole.advance(STEPS)
    half = STEPS // 2
    _, first = larynx_simulation(phonating())
    first.advance(half)
    _, second = larynx_simulation(phonating())
    second.restore(first.state())
    rest = second.advance(STEPS - half)
    expected = {name: np.asarray(values)[half:] for name, values in waves.items()}
    yield counted(
        "waveforms", "numbers that differ in all waveforms after the middle", differing(expected, rest)
    )
    yield counted(
        "state", "numbers that differ in the state at the end", differing(whole.state(), second.state())
    )
    yield touching(waves)


def touching(waves: dict[str, Any]) -> Check:
    """That the folds collided, or the others would say less."""
    closed = int((np.asarray(waves["contact_rows"]) > 0).any())
    return Check(
        name="collision",
        quantity="whether the folds collided in the run (1: they did)",
        unit="1",
        value=float(closed),
        reference=1.0,
        tolerance=0.0,
        because="yes or no",
    )


CASES = (
    Case(
        "threads",
        "Phonation with collisions has the same bits on one thread and on two.",
        "a second run",
        threads,
    ),
    Case(
        "restore",
        "A run that another simulation takes up from its state has the bits of the run in one go.",
        "a run in one go",
        restore,
    ),
)
