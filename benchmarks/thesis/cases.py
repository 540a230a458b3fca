"""The runs that the figures need: variations of the two scenes of the thesis, and how they are made.

P is examples/thesis.toml, the set-up as printed; B is examples/thesis_b.toml, half of its viscosity.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import plica
from plica.scene.parts import Contact

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LAST = 0.06
DURATION = 0.15  # s; the examples' 0.1 s leaves few cycles after the transient
LAST = 0.06  # s, the end of each run in which every step's fields are stored, and cycles are measured
SCENES = {"P": "thesis.toml", "B": "thesis_b.toml"}
PROBES = {  # cm, Paper A, Figs. 3 and 9: two nodes of the mid-coronal plane, one of the edge; opposites
    "6157": (0.025, 0.0, -0.1077),
    "6157 left": (-0.025, 0.0, -0.1077),
    "6390": (0.05, 0.0, -0.3519),
    "edge": (0.024, -0.136, -0.037),
    "edge left": (-0.024, -0.136, -0.037),
}
CONTACTS: dict[str, dict[str, Any] | None] = {
    "weighted": {"multipliers": {"position": "weighted"}},
    "multipliers": {"multipliers": {"position": "end_of_step"}},
    "1e7": {"volume_penalty": {"kappa": "1e7 dyn/cm^3"}},
    "1e6": {"volume_penalty": {"kappa": "1e6 dyn/cm^3"}},
    "1e5": {"volume_penalty": {"kappa": "1e5 dyn/cm^3"}},
    # Detected, and the flow stopped by it, but without a force to speak of: 1e-15 of the thesis's.
    "neglected": {"volume_penalty": {"kappa": "1e-8 dyn/cm^3"}},
    "none": None,  # no contact in the scene: nothing is detected, nothing stops the flow
    # Paper B, Sec. III; the number is the most augmentations a step.
    "augmented 1": {"augmented": {"max_augmentations": 1}},
    "augmented 2": {"augmented": {"max_augmentations": 2}},
    "augmented 4": {"augmented": {"max_augmentations": 4}},
    "augmented": {"augmented": {}},  # until the gaps are closed, or as many as the engine allows
}


@dataclass(frozen=True, order=True)
class Case:
    """One run: a base scene and what differs from it."""

    base: str = "B"  # of SCENES
    contact: str = "weighted"  # of CONTACTS; this one closes the gap as the thesis prints it
    pressure: float = 0.8  # kPa
    mesh: str = "thesis_medium"
    scheme: str = "hht"  # or newmark, the trapezoidal rule
    asymmetry: int = 0  # %, 100 (E'_right - E'_left) / E'_right of the cover, the right one stiffer

    @property
    def name(self) -> str:
        parts = [self.base, self.mesh, f"{self.pressure:g}kPa", self.contact.replace(" ", "_")]
        parts += ["newmark"] if self.scheme == "newmark" else []
        parts += [f"{self.asymmetry}percent"] if self.asymmetry else []
        return "_".join(parts)

    @property
    def kind(self) -> str | None:
        """The table of the scene that enforces contact; None without."""
        table = CONTACTS[self.contact]
        return None if table is None else next(iter(table))

    def scene(self, duration: float | None = None) -> plica.Scene:
        """The scene, for `duration` s or as long as the figures need."""
        data = tomllib.loads((EXAMPLES / SCENES[self.base]).read_text(encoding="utf-8"))
        data["mesh"] = {"larynx": self.mesh, "order": 1}
        data["airflow"]["subglottal_pressure"] = f"{self.pressure:g} kPa"
        data.pop("contact")
        table = CONTACTS[self.contact]
        if table is not None:
            data["contact"] = table
        if self.scheme == "newmark":
            data["time"]["scheme"] = "newmark"
        if self.asymmetry:
            stiff = 10e4 / (1 - self.asymmetry / 100)
            data["tissue"]["cover"]["right"] = {"E_fibre": f"{stiff!r} dyn/cm^2"}
        length = duration or DURATION
        step = 50e-6
        data["time"] |= {"step": step, "duration": length}
        start = max(round((length - LAST) / step), 1) * step
        probes = [[1e-2 * x for x in point] for point in PROBES.values()]
        data["output"] = {"every": step, "start": start, "probes": probes}
        return plica.Scene.model_validate(data)


PENALTIES = ("1e7", "1e6", "1e5")
PRESSURES = (0.6, 0.8, 1.0)
MISMATCHES = (0, 20, 40)
AUGMENTED = ("augmented 1", "augmented 2", "augmented 4", "augmented")


def table(meshes: tuple[str, ...] = ("thesis_medium", "thesis_coarse")) -> list[Case]:
    """All runs, the most wanted first. Enforcement, schemes and asymmetry are varied on the first mesh."""
    first = meshes[0]
    enforced = ("weighted", "1e7", "neglected", "1e6", "1e5", "multipliers", *AUGMENTED, "none")
    cases = [Case("B", contact, 0.8, first) for contact in enforced]
    cases += [
        Case("B", contact, pressure, first) for pressure in (0.6, 1.0) for contact in ("weighted", "1e7")
    ]
    cases += [Case("B", contact, 0.8, first, "newmark") for contact in ("weighted", "1e7")]
    cases += [Case("B", "weighted", 0.8, first, asymmetry=percent) for percent in MISMATCHES[1:]]
    cases += [Case("B", "neglected", 0.8, first, asymmetry=percent) for percent in MISMATCHES[1:]]
    cases += [Case("P", "weighted", pressure, first) for pressure in (0.8, 0.6, 1.0)]
    cases += [
        Case("B", contact, 0.6, first) for contact in ("1e6", "1e5", "neglected", "multipliers", *AUGMENTED)
    ]
    cases += [Case("P", contact, 0.8, first) for contact in ("neglected", "multipliers", *PENALTIES)]
    for mesh in meshes[1:]:
        cases += [Case(base, "weighted", pressure, mesh) for base in SCENES for pressure in (0.8, 0.6, 1.0)]
    return list(dict.fromkeys(cases))


def known(case: Case) -> bool:
    """Whether the installed package knows this way to enforce contact."""
    return case.kind is None or case.kind in Contact.kinds


def directory(case: Case, runs: Path) -> Path:
    return runs / case.name


def make(case: Case, runs: Path, duration: float | None) -> str:
    """Make a run or finish it; says how it stands. A run that failed stays as it is."""
    if not known(case):
        return f"skipped: this plica knows no [contact.{case.kind}]"
    where = directory(case, runs)
    made = (where / "results.h5").exists()
    if made and (status := plica.Run.load(where).status) in ("finished", "failed"):
        return f"{status} before"
    try:
        run = plica.run(case.scene(duration), where, resume=made, progress=False)
    except plica.SolveFailed as error:
        return f"failed: {error}"
    return f"{run.status}, {run.seconds:.0f} s"
