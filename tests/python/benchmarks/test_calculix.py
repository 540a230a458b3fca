"""CalculiX as a peer: the input it is given, what is read of its answer, and, where it is there, its run."""

from __future__ import annotations

from shutil import which

import numpy as np
import pytest

from benchmarks.contact import calculix
from benchmarks.harness.case import Method
from plica.verify.bodies import impact
from plica.verify.bodies.bars import PROBLEMS

PROBLEM = PROBLEMS["R3"](6)
SIDES = {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)}
"""Nodes of the faces of C3D4, by the manual of CalculiX."""


def test_the_input_has_the_mesh_and_no_number_that_would_be_cut() -> None:
    lines = calculix.deck(PROBLEM, -0.3).splitlines()
    body, _ = PROBLEM.build(PROBLEM.bar)
    faces = [line.split(", ") for line in lines if line.split(", ")[-1] in SIDES]
    assert len(faces) == 4  # two a side
    for number, side in faces:
        corners = np.asarray(body.mesh.cells)[int(number) - 1, list(SIDES[side])]
        np.testing.assert_allclose(np.asarray(body.mesh.points)[corners, 0], 0, atol=1e-15)
    assert f"{len(body.mesh.cells)}, " + ", ".join(str(a + 1) for a in body.mesh.cells[-1]) in lines
    assert max(len(field.strip()) for line in lines if line[0] != "*" for field in line.split(",")) <= 20


def test_the_input_has_the_speeds_the_scheme_and_the_penalty() -> None:
    bar = PROBLEM.bar
    lines = calculix.deck(PROBLEM, -0.3).splitlines()
    _, parts = PROBLEM.build(bar)
    first = lines.index("*INITIAL CONDITIONS, TYPE=VELOCITY") + 1
    rows = np.array([line.split(",") for line in lines[first : first + len(parts["velocity"])]], float)
    np.testing.assert_array_equal(rows[:, 1], 1)
    np.testing.assert_allclose(rows[:, 2], parts["velocity"][:, 0], rtol=1e-11)
    assert rows[:, 2].min() < 0 < rows[:, 2].max()
    assert "*DYNAMIC, ALPHA=-0.3" in lines
    stiffness = float(lines[lines.index("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR") + 1])  # Pa/m
    assert stiffness * bar.edge == pytest.approx(impact.PENALTY * bar.modulus)


def as_printed(deeper: float = 0.0, until: float = 1.0) -> str:
    """The exact motion, the struck faces so much deeper (m) in each other, until a share of the duration."""
    bar, exact = PROBLEM.bar, PROBLEM.exact
    body, parts = PROBLEM.build(bar)
    x, own = np.asarray(body.mesh.points)[:, 0], parts["measured"]
    printed = []
    brought = 0.25 * bar.density * bar.length * bar.edge**2
    for t in np.linspace(0, until * PROBLEM.duration, 300)[1:]:
        moved = exact.displacement(np.abs(x), np.array([t]))[0] * np.where(own, 1, -1)
        moved -= deeper * (own & (np.abs(x) < 1e-9 * bar.length))
        force = exact.pressure(np.array([t]))[0] * bar.edge**2
        rows = "".join(f"{n:10d}  {u:.6E}  0.000000E+00  0.000000E+00\n" for n, u in enumerate(moved, 1))
        printed.append(
            f"\n displacements (vx,vy,vz) for set ALL and time  {t:.7E}\n\n{rows}\n"
            f" total internal energy for set BARS and time  {t:.7E}\n\n        {0.4 * brought:.6E}\n\n"
            f" total kinetic energy for set BARS and time  {t:.7E}\n\n"
            f"        {0.6 * brought:.6E}\n\n"
            f" statistics for slave set STRIKES, master set STRUCK and time  {t:.7E}\n\n"
            f"   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)\n\n"
            f"   -{force:.6E}  0.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00\n\n"
        )
    return "".join(printed)


def test_the_exact_motion_as_it_would_be_printed_has_no_error() -> None:
    found = calculix._judged(PROBLEM, as_printed())
    assert found["displacement"] < 1e-5  # six digits
    assert found["force"] < 1e-5
    assert found["impulse"] == pytest.approx(1, rel=5e-3)  # steps that end within the impact
    assert found["energy end"] == pytest.approx(1, rel=1e-5)
    assert found["duty"] == pytest.approx(1)
    assert found["penetration"] == 0


def test_faces_in_each_other_and_a_run_cut_short_are_seen() -> None:
    edge = PROBLEM.bar.edge
    assert calculix._judged(PROBLEM, as_printed(0.1 * edge))["penetration"] == pytest.approx(0.1, rel=1e-5)
    with pytest.raises(RuntimeError, match="ccx ended before t = "):
        calculix._judged(PROBLEM, as_printed(until=0.9))


def test_short_steps_count_no_more_than_they_last() -> None:
    depth, middle, end = np.linspace(0, PROBLEM.bar.length, 7), 0.5 * PROBLEM.duration, PROBLEM.duration
    errors = []
    for early in (500, 5000):
        time = np.concatenate([np.linspace(0, middle, early)[1:], np.linspace(middle, end, 500)[1:]])
        exact = PROBLEM.exact.displacement(depth, time) + PROBLEM.offset
        moved = exact + 1e-5 * (time < middle)[:, None]
        errors.append(impact.displacement_error(PROBLEM, depth, time, moved))
    assert errors[0] > 0
    assert errors[1] == pytest.approx(errors[0], rel=0.01)


def test_a_program_is_a_peer_where_it_is_on_the_path() -> None:
    assert not Method("none", lambda level: dict, package="no-such-program", program=True).installed
    shell = Method("shell", lambda level: dict, package="bash", program=True)
    assert shell.installed


@pytest.mark.skipif(which("ccx") is None, reason="ccx is not on the PATH (Debian: calculix-ccx)")
def test_calculix_finds_the_motion_of_the_closed_form() -> None:
    found = calculix.measure(PROBLEM, calculix.deck(PROBLEM, -0.3))
    assert found["displacement"] < 0.1
    assert found["impulse"] == pytest.approx(1, abs=0.1)
    with pytest.raises(RuntimeError, match="ccx ended"):
        calculix.measure(PROBLEM, "*NODE\n1, 0, 0\n")
