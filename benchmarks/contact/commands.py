"""``impact`` and ``free``: contact methods against closed forms and conservation laws."""

from __future__ import annotations

import argparse
import itertools
from typing import Any

from benchmarks.harness.output import add_output, put
from plica.commands.arguments import add_command, tolerance, whole

__all__ = ["add_commands"]

_IMPACT_HELP = """\
Elastic bars that hit a wall or each other, with every contact enforcement, time scheme and mass of the
contact surfaces, compared with the exact motion:

  R1        periodic bar on a rigid obstacle (Dabaghi et al.)
  R2        bouncing bar under gravity (Doyen, Ern, Piperno)
  R3        two equal bars that meet at 1 m/s
  bars      two bars of 2.7 m, 2 GPa, 1000 kg/m^3, 7 mm apart, at +-35 m/s: 49.4975 MPa for 3.81838 ms
  bars-0.3  the same with Poisson's ratio 0.3 between rollers: 57.4289 MPa for 3.29103 ms

Columns. Relative errors (root mean square): displacement since first contact, force around the impact.
Divided by the exact value: impulse, duration from the first to the last step in contact, plateau (median
pressure during contact), peak, rebound (mean velocity afterwards). duty: share of the duration in contact;
below 1 the contact chatters. energy: at the end, and its maximum, divided by that at the start. penetration:
in edges. energy balance: its residual, divided by the largest energy. ms/step: processor time on
this machine, to compare rows. A run that fails has its message in the row. The last lines name the
recommended combination, and the rule.

examples:
  python -m benchmarks impact -o impact.csv      everything, with 100 elements: about five minutes
  python -m benchmarks impact --problems R1 R3 --elements 50
  python -m benchmarks impact --problems R1 --periods 4 --contacts multipliers penalty
  python -m benchmarks impact --problems R3 --elements 50 100 200 400 --contacts multipliers \\
      --schemes "HHT(-0.3)" trapezoidal
"""

_FREE_HELP = """\
Conserved quantities of free bodies in collisions, with every contact enforcement, time scheme and mass:

  box       a body that collides with a surrounding frame, both free along x, driven by an alternating force
            between them, over --steps steps
  blocks    two blocks without supports that rotate and collide at an angle, 200 steps

Columns. momentum: largest change of the total, divided by that of one body. angular (about reference
positions): change in a step without contact; the part not explained by couples of the contact forces; total
change. force sum: of both sides, divided by the largest force. gain: largest excess of energy and viscous
loss over the work since first contact, divided by the largest energy; above zero, contact creates energy.
energy balance, penetration: as in python -m benchmarks impact. s, ms/step: processor time on this machine.

examples:
  python -m benchmarks free -o free.csv          everything, 1e5 steps: about 20 minutes
  python -m benchmarks free --problems blocks
  python -m benchmarks free --contacts multipliers --schemes trapezoidal --masses redistributed
"""


def add_commands(benches: Any) -> None:
    """Add both to the commands."""
    impact = add_command(benches, "impact", _impact, "colliding bars against closed forms", _IMPACT_HELP)
    free = add_command(benches, "free", _free, "conservation laws of colliding free bodies", _FREE_HELP)
    impact.add_argument(
        "--elements", metavar="N", nargs="+", type=whole, default=[100], help="along a bar (default: 100)"
    )
    impact.add_argument("--periods", metavar="N", type=whole, default=1, help="of R1 to compute (default: 1)")
    free.add_argument(
        "--steps", metavar="N", type=whole, default=100_000, help="of the box (default: 100000)"
    )
    for sub in (impact, free):
        sub.add_argument("--problems", metavar="NAME", nargs="+", help="default: all")
        for option in ("--contacts", "--schemes", "--masses"):
            sub.add_argument(
                option, metavar="NAME", nargs="+", help="default: all; an unknown name lists them"
            )
        sub.add_argument(
            "--tolerance", metavar="T", type=tolerance, default=1e-8, help="of linear solves (default: 1e-8)"
        )
        add_output(sub)


def _combinations(options: argparse.Namespace) -> list[Any]:
    """All combinations of the requested names."""
    from plica.errors import selected
    from plica.verify.bodies.body import SCHEMES
    from plica.verify.bodies.combinations import ENFORCEMENTS, MASSES, Combination

    names = (
        selected(asked, list(known), f"benchmarks: --{option}")
        for option, asked, known in (
            ("contacts", options.contacts, ENFORCEMENTS),
            ("schemes", options.schemes, SCHEMES),
            ("masses", options.masses, MASSES),
        )
    )
    return [Combination(*parts) for parts in itertools.product(*names)]


def _impact(options: argparse.Namespace) -> int:
    from benchmarks.contact import impact
    from plica.errors import selected
    from plica.verify.bodies.bars import PROBLEMS

    names = selected(options.problems, list(PROBLEMS), "benchmarks: --problems")
    asked = _combinations(options)
    put(
        options,
        ("problem", "elements", "contact", "scheme", "mass", *impact.COLUMNS),
        impact.rows(names, options.elements, asked, options.tolerance, options.periods),
        len(names) * len(options.elements) * len(asked),
        impact.recommendation,
    )
    print(f"\n{impact.RULE}")
    return 0


def _free(options: argparse.Namespace) -> int:
    from benchmarks.contact import free
    from plica.errors import selected

    names = selected(options.problems, free.PROBLEMS, "benchmarks: --problems")
    asked = _combinations(options)
    put(
        options,
        ("problem", "contact", "scheme", "mass", *free.COLUMNS),
        free.rows(names, asked, options.steps, options.tolerance),
        len(names) * len(asked),
    )
    return 0
