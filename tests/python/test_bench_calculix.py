"""CalculiX as a peer: the input it is given, what is read of its answer, and, where it is there, its run."""

from __future__ import annotations

from shutil import which

import numpy as np
import pytest

from plica.bench import calculix
from plica.bench.bars import PROBLEMS
from plica.bench.case import Method

PROBLEM = PROBLEMS["R3"](6)


def test_the_input_has_the_mesh_and_no_number_that_would_be_cut() -> None:
    lines = calculix.deck(PROBLEM, -0.3).splitlines()
    body, _ = PROBLEM.build(PROBLEM.bar)
    assert sum(line.split(", ")[-1] in ("S1", "S2", "S3", "S4") for line in lines) == 4  # two faces a side
    assert f"{len(body.mesh.cells)}, " + ", ".join(str(a + 1) for a in body.mesh.cells[-1]) in lines
    assert max(len(field.strip()) for line in lines if line[0] != "*" for field in line.split(",")) <= 20


def test_the_exact_motion_as_it_would_be_printed_has_no_error() -> None:
    bar, exact = PROBLEM.bar, PROBLEM.exact
    body, parts = PROBLEM.build(bar)
    x, own = np.asarray(body.mesh.points)[:, 0], parts["measured"]
    printed = []
    for t in np.linspace(0, PROBLEM.duration, 300)[1:]:
        moved = exact.displacement(np.abs(x), np.array([t]))[0] * np.where(own, 1, -1)
        force = exact.pressure(np.array([t]))[0] * bar.edge**2
        rows = "".join(f"{n:10d}  {u:.6E}  0.000000E+00  0.000000E+00\n" for n, u in enumerate(moved, 1))
        printed.append(
            f"\n displacements (vx,vy,vz) for set ALL and time  {t:.7E}\n\n{rows}\n"
            f" total internal energy for set BARS and time  {t:.7E}\n\n        0.000000E+00\n\n"
            f" total kinetic energy for set BARS and time  {t:.7E}\n\n"
            f"        {0.25 * bar.density * bar.length * bar.edge**2:.6E}\n\n"
            f" statistics for slave set STRIKES, master set STRUCK and time  {t:.7E}\n\n"
            f"   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)\n\n"
            f"   -{force:.6E}  0.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00\n\n"
        )
    found = calculix._judged(PROBLEM, "".join(printed))
    assert found["displacement"] < 1e-5  # six digits
    assert found["force"] < 1e-5
    assert found["impulse"] == pytest.approx(1, rel=5e-3)  # steps that end within the impact
    assert found["energy end"] == pytest.approx(1, rel=1e-5)
    assert found["penetration"] == 0


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
