"""``plica bench impact`` and ``plica bench free``: contact by every method, against closed forms and laws."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, tolerance, whole

__all__ = ["add_commands"]

_IMPACT_HELP = """\
Elastic bars that strike a wall or each other, by every enforcement of contact, time scheme and mass of the
contact surfaces, against the exact motion:

  R1        periodic bar on a rigid obstacle (Dabaghi et al.)
  R2        bouncing bar under gravity (Doyen, Ern, Piperno)
  R3        two equal bars that meet at 1 m/s
  bars      two bars of 2.7 m, 2 GPa, 1000 kg/m^3, 7 mm apart, at +-35 m/s: 49.4975 MPa for 3.81838 ms
  bars-0.3  the same with Poisson's ratio 0.3 between rollers: 57.4289 MPa for 3.29103 ms

Columns. Relative errors (root mean square): displacement since first touch, force around the impact. Over
the exact value: impulse, duration from the first to the last step in contact, plateau (median pressure
while touching), peak, rebound (mean velocity afterwards). duty: share of the duration in contact; below 1
it chatters. energy: at the end, and its maximum, over that at the start. penetration: in edges. ledger:
what the energy balance leaves unexplained, over the largest energy. ms/step: processor time on this
machine, to compare rows. A run that fails has its message in the row. The last lines name the combination
for which the table speaks, and the rule.

examples:
  plica bench impact -o impact.csv                      everything, on 100 elements: some five minutes
  plica bench impact --problems R1 R3 --elements 50
  plica bench impact --problems R1 --periods 4 --contacts multipliers penalty
  plica bench impact --problems R3 --elements 50 100 200 400 --contacts multipliers \\
      --schemes "HHT(-0.3)" trapezoidal
"""

_FREE_HELP = """\
What free bodies must keep through collisions, by every enforcement of contact, time scheme and mass:

  box       a body that rattles in a frame, both free along x, kept going by an alternating force between
            them, over --steps steps
  blocks    two blocks without supports that turn and meet askew, 200 steps

Columns. momentum: largest change of the total, over that of one body. angular (about reference positions):
change in a step without contact; what the couples of the contact forces leave unexplained of it; its change
in all. force sum: of both sides, over the largest force. gain: the most by which energy and viscous loss
have outgrown the work done since first touch, over the largest energy; above zero, contact makes energy.
ledger, penetration: as in plica bench impact. s, ms/step: processor time
on this machine.

examples:
  plica bench free -o free.csv                          everything, 1e5 steps: some 20 minutes
  plica bench free --problems blocks
  plica bench free --contacts multipliers --schemes trapezoidal --masses redistributed
"""


def add_commands(benches: Any) -> None:
    """Add both to the benchmarks of ``plica bench``."""
    impact = add_command(benches, "impact", _impact, "bars that collide, against closed forms", _IMPACT_HELP)
    free = add_command(benches, "free", _free, "what free bodies keep through collisions", _FREE_HELP)
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
            sub.add_argument(option, metavar="NAME", nargs="+", help="default: all; a wrong one lists them")
        sub.add_argument(
            "--tolerance", metavar="T", type=tolerance, default=1e-8, help="of linear solves (default: 1e-8)"
        )
        sub.add_argument(
            "-o",
            "--output",
            dest="csv",
            metavar="FILE",
            type=Path,
            help="also write all figures as CSV",
        )
        sub.add_argument("--quiet", action="store_true", help="no progress")


def _impact(options: argparse.Namespace) -> int:
    from plica.bench import bars, impact
    from plica.bench.combinations import chosen, combinations
    from plica.bench.table import show

    names = chosen(options.problems, list(bars.PROBLEMS), "--problems")
    asked = combinations(options.contacts, options.schemes, options.masses)
    made = show(
        impact.rows(names, options.elements, asked, options.tolerance, options.periods),
        ("problem", "elements", "contact", "scheme", "mass", *impact.COLUMNS),
        total=len(names) * len(options.elements) * len(asked),
        csv=options.csv,
        progress=not options.quiet,
    )
    print(f"\n{impact.recommendation(made)}\n\n{impact.RULE}")
    return 0


def _free(options: argparse.Namespace) -> int:
    from plica.bench import free
    from plica.bench.combinations import chosen, combinations
    from plica.bench.table import show

    names = chosen(options.problems, free.PROBLEMS, "--problems")
    asked = combinations(options.contacts, options.schemes, options.masses)
    show(
        free.rows(names, asked, options.steps, options.tolerance),
        ("problem", "contact", "scheme", "mass", *free.COLUMNS),
        total=len(names) * len(asked),
        csv=options.csv,
        progress=not options.quiet,
    )
    return 0
