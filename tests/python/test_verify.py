"""`plica verify`: every row passes, and every row can fail."""

from __future__ import annotations

import csv
import importlib
import json
import math
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from plica import _engine
from plica.bench.body import SCHEMES
from plica.cli import main
from plica.identify import MarginalLikelihood, Noise
from plica.report.installation import this_installation
from plica.verify import text
from plica.verify.case import Case, Check, Row, judged, worst
from plica.verify.files import write
from plica.verify.subjects import SUBJECTS, cases

_DOCS = Path(__file__).parents[2] / "docs" / "verify.md"
_ALL = [(subject, case) for subject in SUBJECTS for case in cases(subject)]
FIELDS = {"name", "subject", "quantity", "unit", "value", "reference", "error", "tolerance", "source", "pass"}


@cache
def rows() -> dict[str, list[Row]]:
    """Of every case, computed once."""
    return {case.name: judged(subject, case) for subject, case in _ALL}


def check(**changes: Any) -> Check:
    given: dict[str, Any] = {"name": "a", "quantity": "a length", "unit": "m", "because": "rounding"}
    return Check(**given | {"value": 2.0, "reference": 2.0, "tolerance": 1e-3} | changes)


def one(*checks: Check) -> list[Row]:
    return judged("tissue", Case("case", "It holds.", "a formula", lambda: checks))


def test_there_is_enough_of_each_subject_and_no_name_twice() -> None:
    names = [case.name for _, case in _ALL]
    assert len(names) == len(set(names))
    for subject in SUBJECTS:
        assert len(cases(subject)) >= 4
    for _, case in _ALL:
        assert case.proves.endswith(".")
        assert case.source


@pytest.mark.slow
@pytest.mark.parametrize("name", [case.name for _, case in _ALL])
def test_every_row_passes(name: str) -> None:
    found = rows()[name]
    for row in found:
        assert row.passed, f"{row.name}: {row.value} of {row.reference}, {row.failure}"
        assert row.because
        assert row.quantity
    assert len({row.name for row in found}) == len(found)


@pytest.mark.slow
def test_there_are_more_than_forty_rows_and_no_name_twice() -> None:
    names = [row.name for found in rows().values() for row in found]
    assert len(names) == len(set(names)) >= 40


@pytest.mark.slow
@pytest.mark.parametrize(("subject", "case"), _ALL, ids=[case.name for _, case in _ALL])
def test_every_row_fails_where_its_value_is_off_by_more_than_its_tolerance(subject: str, case: Case) -> None:
    for row in rows()[case.name]:
        assert row.value is not None
        assert row.reference is not None
        assert row.tolerance is not None
        size = abs(row.reference) if row.error_of == "reference" else 1.0
        off = 1.1 * row.tolerance * size + 1e-12 * max(size, abs(row.reference))
        of: Any = row.error_of
        for wrong in (row.reference + off, row.reference - off, math.nan, math.inf):
            made = check(value=wrong, reference=row.reference, tolerance=row.tolerance, of=of)
            (again,) = judged(subject, replace(case, checks=lambda made=made: [made]))
            assert again.as_json()["pass"] is False


def test_a_value_within_its_tolerance_passes() -> None:
    (row,) = one(check(value=2.001))
    assert row.passed
    assert row.error == pytest.approx(5e-4)
    assert not one(check(value=2.003))[0].passed
    assert not one(check(value=2.0021, of="unit"))[0].passed
    assert one(check(value=2.0009, of="unit"))[0].passed


@pytest.mark.parametrize(
    "changes",
    [
        {"value": math.nan},
        {"value": math.inf},
        {"reference": math.nan},
        {"reference": 0.0, "value": math.nan, "of": "unit"},
        {"tolerance": math.inf, "value": 9.0},
        {"tolerance": math.nan},
    ],
)
def test_what_is_not_a_number_does_not_pass_and_is_strict_json(changes: dict[str, Any]) -> None:
    (row,) = one(check(**changes))
    made = row.as_json()
    assert made["pass"] is False
    assert json.loads(json.dumps(made, allow_nan=False)) == made


def test_a_case_that_stops_is_a_row_that_fails_with_its_reason() -> None:
    def stops() -> Any:
        yield check()
        raise RuntimeError("no such\nmesh")

    first, last = judged("tissue", Case("case", "It holds.", "a formula", stops))
    assert first.passed
    assert not last.passed
    assert last.failure == "RuntimeError: no such mesh"
    assert set(last.as_json()) >= FIELDS
    assert "FAIL  result: RuntimeError" in "\n".join(
        text.case_lines(Case("case", "It holds.", "a", stops), [last])
    )
    (nothing,) = one()
    assert not nothing.passed


def test_the_worst_of_many_is_the_one_furthest_off_its_own_size() -> None:
    assert worst([1.0, 2.2, 300.0], [1.0, 2.0, 310.0]) == (2.2, 2.0)
    value, _ = worst([1.0, math.nan, 9.0], [1.0, 2.0, 1.0])
    assert math.isnan(value)
    with pytest.raises(ValueError, match="2 values beside 1 references"):
        worst([1.0, 2.0], [1.0])


# What follows plants a fault in the engine or in what a case hands to it: the case must see it.


def law(patch: pytest.MonkeyPatch, **factors: float) -> None:
    """Material laws whose parameters are multiplied."""
    for name in ("Isotropic", "TransverselyIsotropic"):
        real = getattr(_engine, name)
        keys = list(real._defaults)

        def made(*values: Any, _real: Any = real, _keys: Any = keys, **named: Any) -> Any:
            given = dict(zip(_keys, values, strict=False)) | named
            off = {key: value * factors.get(key, 1.0) for key, value in given.items() if key in factors}
            if "nu" in factors and given.get("nu") == 0.0:
                off["nu"] = 0.05
            return _real(**given | off)

        patch.setattr(_engine, name, made)


def scaled(name: str, key: str, factor: float) -> Callable[[pytest.MonkeyPatch], None]:
    """A keyword of an engine's class multiplied."""

    def fault(patch: pytest.MonkeyPatch) -> None:
        real = getattr(_engine, name)
        keys = list(real._defaults) if hasattr(real, "_defaults") else []

        def made(*values: Any, **named: Any) -> Any:
            if name == "Material":
                named = dict(zip(("elasticity", "density", "viscosity"), values, strict=False)) | named
                values = ()
            given = named.get(key, real._defaults[key] if key in keys else None)
            if given is None:
                return real(*values, **named)
            product = tuple(factor * np.asarray(given)) if isinstance(given, tuple) else factor * given
            return real(*values, **named | {key: product})

        patch.setattr(_engine, name, made)

    return fault


def lumped(patch: pytest.MonkeyPatch) -> None:
    """The mass matrix is that of half the density at every other unknown."""
    real = _engine.Assembly.mass

    def mass(self: Any) -> Any:
        data, columns, starts = real(self)
        return np.where(columns % 6 < 3, 1.3, 1.0) * data, columns, starts

    patch.setattr(_engine.Assembly, "mass", mass)


def other_scheme(name: str, scheme: Any) -> Callable[[pytest.MonkeyPatch], None]:
    return lambda patch: patch.setitem(SCHEMES, name, scheme)


def booked(patch: pytest.MonkeyPatch) -> None:
    """Works and losses of the ledger are off by a thousandth of the energy."""
    real = _engine.Simulation

    class Simulation(real):  # type: ignore[misc,valid-type]
        def advance(self, steps: int) -> dict[str, Any]:
            found = super().advance(steps)
            off = 1e-3 * found["kinetic_energy"].max()
            return found | {key: found[key] + off * self.step_count for key in WORKS if key in found}

    patch.setattr(_engine, "Simulation", Simulation)


WORKS = ("load_work", "viscous_loss", "numerical_loss", "flow_work")


def started(patch: pytest.MonkeyPatch) -> None:
    """One side starts a hundredth faster."""
    real = _engine.Simulation

    def made(mesh: Any, *parts: Any, **named: Any) -> Any:
        velocity = named.get("velocity")
        if velocity is not None:
            named["velocity"] = velocity * np.where(np.asarray(mesh.points)[:, :1] > 0, 1.01, 1.0)
        return real(mesh, *parts, **named)

    patch.setattr(_engine, "Simulation", made)


def nudged(patch: pytest.MonkeyPatch) -> None:
    """A state is restored with one number off in its last bit."""
    real = _engine.Simulation.restore

    def restore(self: Any, state: dict[str, Any]) -> None:
        moved = np.array(state["displacement"])
        moved[100] = np.nextafter(moved[100], 1)
        real(self, state | {"displacement": moved})

    patch.setattr(_engine.Simulation, "restore", restore)


def drifting(patch: pytest.MonkeyPatch) -> None:
    """Every second simulation starts a millionth faster, as if threads mattered."""
    bits = importlib.import_module("plica.verify.dynamics.bits")
    count = iter(range(9))

    def made(scene: Any) -> Any:
        opening = -1.0 - 1e-6 * next(count)
        return larynx(scene.replace({"initial.opening_velocity": opening}))

    larynx = bits.larynx_simulation
    patch.setattr(bits, "larynx_simulation", made)


def leaking(patch: pytest.MonkeyPatch) -> None:
    """Contact surfaces keep their mass under the trapezoidal rule: impacts make energy."""
    laws = importlib.import_module("plica.verify.contact.laws")
    real = laws.blocks

    def blocks(combination: Any, *parts: Any) -> Any:
        return real(replace(combination, scheme="trapezoidal", mass="kept"), *parts)

    patch.setattr(laws, "blocks", blocks)


def patterns(patch: pytest.MonkeyPatch) -> None:
    """A pressure loads the nodes of one half a thousandth more."""
    real = _engine.pressure_patterns

    def made(mesh: Any, *parts: Any) -> Any:
        weights = np.where(np.asarray(mesh.points)[:, 0] > 0.01, 1.001, 1.0)
        return real(mesh, *parts) * np.repeat(weights, 3)[:, None]

    patch.setattr(_engine, "pressure_patterns", made)


def wrong(module: str, name: str, change: Callable[[Any], Any]) -> Callable[[pytest.MonkeyPatch], None]:
    """A function that a module calls gives back something else."""

    def fault(patch: pytest.MonkeyPatch) -> None:
        where = importlib.import_module(module)
        real = getattr(where, name)
        patch.setattr(where, name, lambda *parts, **named: change(real(*parts, **named)))

    return fault


def of_model(patch: pytest.MonkeyPatch) -> None:
    """The filter and the smoother take an evolution that is off by a thousandth."""
    where = importlib.import_module("plica.verify.identification.gaussian")
    for name in ("kalman_filter", "smooth"):
        real = getattr(where, name)

        def made(model: Any, *parts: Any, _real: Any = real) -> Any:
            return _real(replace(model, G=1.001 * model.G), *parts)

        patch.setattr(where, name, made)


def other_noise(patch: pytest.MonkeyPatch) -> None:
    """The likelihood takes unknown pressures for a hundredth larger."""
    where = importlib.import_module("plica.verify.identification.estimator")
    patch.setattr(
        where,
        "MarginalLikelihood",
        lambda model, n: MarginalLikelihood(model, Noise(1.01 * n.pressure, n.flow)),
    )


def other_gradient(patch: pytest.MonkeyPatch) -> None:
    """The gradient is a thousandth too large."""
    real = MarginalLikelihood.evaluate

    def evaluate(self: Any, x: Any) -> Any:
        found = real(self, x)
        return replace(found, gradient=1.001 * found.gradient)

    patch.setattr(MarginalLikelihood, "evaluate", evaluate)


def other_tissue(patch: pytest.MonkeyPatch) -> None:
    """The engine steps with a cover that is half as stiff again."""
    where = importlib.import_module("plica.verify.identification.recorded")
    real = where.build_simulation
    change = {"tissue.cover.E": 1.5e3, "tissue.cover.viscosity": 0.8}
    patch.setattr(where, "build_simulation", lambda scene, mesh: real(scene.replace(change), mesh))


def quicker(measures: Any) -> Any:
    """Found cycles a tenth too many."""
    found, cycles = measures
    return {
        name: replace(m, value=None if m.value is None else 1.1 * m.value) for name, m in found.items()
    }, cycles


def other_rule(patch: pytest.MonkeyPatch) -> None:
    """The trapezoidal rule damps a little."""
    real = _engine.Newmark
    patch.setattr(_engine, "Newmark", lambda: real(beta=0.26, gamma=0.51))


_VIDEO, _FOUND = "plica.verify.video.glottis", "plica.verify.identification"
FAULTS: dict[str, Callable[[pytest.MonkeyPatch], None]] = {
    "patch-linear": lambda patch: law(patch, nu=1.01),
    "patch-quadratic": lambda patch: law(patch, nu=1.01),
    "patch-fibre": lambda patch: law(patch, nu=1.01),
    "rigid-motion": lambda patch: law(patch, nu=1.01),
    "moduli": lambda patch: law(patch, nu=1.01),
    "creep-0": scaled("Material", "viscosity", 1.01),
    "creep-0.45": lambda patch: law(patch, nu=1.01),
    "cantilever": lambda patch: law(patch, E=1.01),
    "shear-mode": lambda patch: law(patch, mu_fibre=1.01),
    "shear-order-linear": lumped,
    "shear-order-quadratic": lumped,
    "shear-damping": scaled("Material", "viscosity", 2.0),
    "block-isotropic": scaled("Material", "density", 0.95),
    "block-fibre": scaled("Material", "density", 0.95),
    "block-stiff-fibre": scaled("Material", "density", 0.95),
    "spectral-radius": scaled("HilberHughesTaylor", "alpha", 0.9),
    "free-vibration": other_rule,
    "order-trapezoidal": other_scheme("trapezoidal", _engine.Newmark(beta=0.3, gamma=0.6)),
    "order-hht": other_scheme("HHT(-0.3)", _engine.Newmark(beta=0.3, gamma=0.6)),
    "order-newmark": other_scheme("Newmark(1, 3/2)", _engine.Newmark()),
    "ledger-trapezoidal": booked,
    "ledger-hht": booked,
    "ledger-newmark": booked,
    "free-motion": scaled("Load", "traction", 1.001),
    "threads": drifting,
    "restore": nudged,
    "bernoulli": scaled("Airflow", "air_density", 1.001),
    "poiseuille": scaled("ViscousSlit", "air_viscosity", 1.01),
    "converging-slit": scaled("ViscousSlit", "air_viscosity", 1.1),
    "throat": scaled("ViscousSlit", "separation_ratio", 1.001),
    "closed-surface": patterns,
    "pressure-work": patterns,
    "flow-work": booked,
    "periodic-bar": lambda patch: law(patch, E=1.2),
    "bouncing-bar": lambda patch: law(patch, E=1.2),
    "equal-bars": lambda patch: law(patch, E=1.2),
    "stiff-bars": lambda patch: law(patch, E=1.2),
    "stiff-bars-0.3": lambda patch: law(patch, nu=1.2),
    "unequal-bars": lambda patch: law(patch, E=1.2),
    "contact-patch-matched": lambda patch: law(patch, nu=1.01),
    "contact-patch-linear": lambda patch: law(patch, nu=1.01),
    "contact-patch-mortar": lambda patch: law(patch, nu=1.01),
    "hertz": lambda patch: law(patch, E=1.1),
    "askew": leaking,
    "mirror": started,
    "friction": scaled("Contact", "friction", 1.2),
    "shift": wrong("plica.video.flow", "flow", lambda found: replace(found, flow=found.flow + 0.02)),
    "affine": wrong("plica.video.flow", "flow", lambda found: replace(found, flow=1.05 * found.flow)),
    "ellipse": wrong(_VIDEO, "segment", lambda g: replace(g, mask=ndimage.binary_dilation(g.mask))),
    "filmed": wrong(_VIDEO, "measures", quicker),
    "pulses": wrong(_VIDEO, "find_cycles", lambda cycles: replace(cycles, starts=1.01 * cycles.starts)),
    "sides": wrong(_VIDEO, "side_measures", lambda found: [replace(m, value=1.01 * m.value) for m in found]),
    "filter": of_model,
    "smoother": of_model,
    "evolution": wrong(f"{_FOUND}.evolution", "hht_evolution", lambda e: replace(e, G=e.G * (1 + 1e-9))),
    "evolution-engine": wrong(
        f"{_FOUND}.evolution",
        "scene_evolution",
        lambda made: (replace(made[0], G=made[0].G * (1 + 1e-8)), made[1]),
    ),
    "affine-form": wrong(
        "plica._engine", "stiffness_coefficients", lambda values: 1.001 * np.asarray(values)
    ),
    "responses": other_tissue,
    "likelihood": other_noise,
    "gradient": other_gradient,
    "planted-tissue": other_tissue,
}


@pytest.mark.slow
@pytest.mark.parametrize(("subject", "case"), _ALL, ids=[case.name for _, case in _ALL])
def test_every_case_sees_a_fault(subject: str, case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    FAULTS[case.name](monkeypatch)
    found = judged(subject, case)
    assert not any(row.failure for row in found), found[-1].failure  # it computes, and something else
    assert [row.name for row in found if not row.as_json()["pass"]]


def test_the_command_prints_a_table_and_ends_with_what_it_found(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--subject", "airflow"]) == 0
    said = capsys.readouterr()
    lines = said.out.splitlines()
    assert lines[0] == "AIRFLOW"
    assert "pressure-work: The work of a pressure on a wall" in said.out
    assert sum(line.startswith("  pass") for line in lines) == int(lines[-2].split(" of ")[0])
    assert re.fullmatch(r"(\d+) of \1 pass, in \d+ s\.", lines[-2])
    assert lines[-1].startswith("plica ")
    assert _engine.build_info()["compiler"] in lines[-1]


def test_the_command_prints_strict_json(capsys: pytest.CaptureFixture[str]) -> None:
    def no(constant: str) -> None:
        raise AssertionError(constant)

    assert main(["verify", "--subject", "airflow", "--json"]) == 0
    made = json.loads(capsys.readouterr().out, parse_constant=no)
    assert len(made) > 10
    for row in made:
        assert set(row) >= FIELDS
        assert row["subject"] == "airflow"
        assert row["pass"] is True


def test_a_row_that_fails_is_told_by_the_exit_code(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    FAULTS["poiseuille"](monkeypatch)
    assert main(["verify", "--subject", "airflow", "-o", str(tmp_path / "proof")]) == 1
    said = capsys.readouterr().out
    assert "Failed: poiseuille.flow" in said
    assert "  FAIL  " in said
    assert "fail " in (tmp_path / "proof" / "verification.html").read_text(encoding="utf-8")
    assert main(["verify", "--subject", "airflow", "--json"]) == 1
    made = json.loads(capsys.readouterr().out)
    assert {row["name"] for row in made if not row["pass"]} >= {"poiseuille.flow"}


def test_what_is_proved_is_listed_without_computing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(_engine, "Simulation")
    assert main(["verify", "--list"]) == 0
    said = capsys.readouterr().out
    for subject, case in _ALL:
        assert f"{subject}: {SUBJECTS[subject]}" in said
        assert f"\n  {case.name} " in said
    assert main(["verify", "--list", "--json", "--subject", "video"]) == 0
    assert {one["subject"] for one in json.loads(capsys.readouterr().out)} == {"video"}


def test_a_subject_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--subject", "contcat"]) == 2
    said = capsys.readouterr().err
    assert 'verify: --subject = "contcat"; must be one of tissue, dynamics' in said
    assert 'Did you mean "contact"?' in said


def test_files_say_what_was_made_with_what(tmp_path: Path) -> None:
    case = Case("case", "It <holds>.", "a formula", lambda: [check(), check(name="b", value=math.nan)])
    made = [(case, judged("tissue", case))]
    page = write(made, this_installation(), 1.0, tmp_path / "proof").read_text(encoding="utf-8")
    assert "It &lt;holds&gt;." in page
    assert "http" not in page
    for value in (_engine.build_info()["compiler"], this_installation().processor):
        assert str(value) in page
    stored = json.loads((tmp_path / "proof" / "verification.json").read_text(encoding="utf-8"))
    assert [row["pass"] for row in stored] == [True, False]
    with (tmp_path / "proof" / "verification.csv").open(encoding="utf-8", newline="") as file:
        assert [row["value"] for row in csv.DictReader(file)] == ["2.0", ""]
    markdown = (tmp_path / "proof" / "verification.md").read_text(encoding="utf-8")
    assert "| case.a | a length | 2 m | 2 m | 0 rel. | 0.001 rel. | yes |" in markdown


@pytest.mark.slow
def test_the_documentation_has_the_rows_of_the_command() -> None:
    listed = re.findall(r"^\| ([\w.-]+\.[\w.-]+) \|", _DOCS.read_text(encoding="utf-8"), re.MULTILINE)
    assert listed == [row.name for found in rows().values() for row in found]


def test_importing_the_package_imports_no_verification() -> None:
    code = "import sys, plica, plica.cli; sys.exit(any(n.startswith('plica.verify') for n in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_verification_needs_neither_tests_nor_data_of_the_sources() -> None:
    package = Path(text.__file__).parent
    names = {path.stem for path in Path(__file__).parent.glob("*.py")}
    for file in package.rglob("*.py"):
        said = file.read_text(encoding="utf-8")
        imported = re.findall(r"^\s*(?:from|import) (\w+)", said, re.MULTILINE)
        assert not names.intersection(imported), file.name
        assert "shared/" not in said, file.name
