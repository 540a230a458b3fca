"""Enforcement of contact by time scheme and mass of the surfaces: impacts with exact motion, and rattling."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from benchmarks.contact import calculix, free
from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import at_most, of_order
from plica.verify.bodies import impact
from plica.verify.bodies.bars import PROBLEMS
from plica.verify.bodies.combinations import MASSES, Combination

__all__ = ["CASES"]

ENFORCEMENTS = ("multipliers", "augmented", "Nitsche", "penalty", "volume penalty")
SCHEMES = ("HHT(-0.3)", "trapezoidal")
SOLVES = 1e-8
COMBINATIONS = tuple(
    Combination(contact, scheme, mass) for contact in ENFORCEMENTS for scheme in SCHEMES for mass in MASSES
)
DEFAULT = str(Combination("multipliers", "HHT(-0.3)", "kept"))


def _bars(combination: Combination, level: Level) -> Callable[[], dict[str, float]]:
    problem = PROBLEMS[str(level["problem"])](int(level["elements"]))
    return lambda: impact.measure(problem, combination, SOLVES)


def _calculix(level: Level) -> Callable[[], dict[str, float]]:
    problem = PROBLEMS[str(level["problem"])](int(level["elements"]))
    text = calculix.deck(problem, alpha=-0.3)
    return lambda: calculix.measure(problem, text)


def _bars_errors(level: Level, found: dict[str, float], truth: None) -> dict[str, float]:
    return {
        "displacement": found["displacement"],
        "force": found["force"],
        "impulse": abs(found["impulse"] - 1),
        "energy": abs(found["energy end"] - 1),
        "penetration": found["penetration"],
    }


def _box(combination: Combination, level: Level) -> Callable[[], dict[str, Any]]:
    return lambda: free.box(combination, int(level["steps"]), SOLVES)


def _box_errors(level: Level, found: dict[str, Any], truth: None) -> dict[str, float]:
    if not found["collisions"]:
        raise RuntimeError("the body never touches its frame: nothing is measured.")
    return {
        "gain": max(found["gain"], 0.0),
        "momentum": found["momentum"],
        "penetration": found["penetration"],
    }


def _bars_levels(*counts: int) -> tuple[Level, ...]:
    return tuple({"problem": name, "elements": n} for name in ("R1", "R3") for n in counts)


CASES = (
    Case(
        name="impact",
        does="A bar let go beside a wall (R1), and two equal bars that meet (R3).",
        reference="closed forms of the waves",
        errors={
            "displacement": "root mean square since first touch, relative",
            "force": "root mean square around the impact, relative",
            "impulse": "relative",
            "energy": "change of the total until the end, over the start's",
            "penetration": "deepest, in edges",
        },
        levels={"small": _bars_levels(10, 20), "full": _bars_levels(20, 40, 80)},
        methods=(
            *(Method(str(combination), partial(_bars, combination)) for combination in COMBINATIONS),
            Method(
                "CalculiX, penalty, HHT(-0.3)",
                _calculix,
                package="ccx",
                program=True,
                distribution="CalculiX",
                fits=lambda level: level["problem"] == "R3",
            ),
        ),
        truth=lambda level: None,
        judge=_bars_errors,
        problem=("problem",),
        claims=(
            Claim(
                "the default's displacement converges on R3",
                of_order(DEFAULT, "displacement", "elements", 0.5, problem="R3"),
            ),
            Claim("the default's penetration is below 1e-4 edges", at_most(DEFAULT, 1e-4, "penetration")),
        ),
        threads=(1,),
        own_process=False,
    ),
    Case(
        name="rattle",
        does="A body rattles in a frame, both free, an alternating force between them (R10).",
        reference="conservation of momentum, and energy against the work done",
        errors={
            "gain": "energy that contact made, over the largest energy",
            "momentum": "largest change of the total, over that of the body",
            "penetration": "deepest, in edges",
        },
        levels={"small": ({"steps": 300},), "full": ({"steps": 4000},)},
        methods=tuple(Method(str(combination), partial(_box, combination)) for combination in COMBINATIONS),
        truth=lambda level: None,
        judge=_box_errors,
        claims=(
            Claim("contact by the default makes no energy", at_most(DEFAULT, 1e-6, "gain")),
            Claim("the default keeps the momentum", at_most(DEFAULT, 1e-5, "momentum")),
        ),
        threads=(1,),
        own_process=False,
    ),
)
