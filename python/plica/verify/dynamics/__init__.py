"""Motion in time: schemes, energy and momentum, and results that are the same to the bit."""

from plica.verify.dynamics import bits, ledger, oscillator

__all__ = ["CASES"]

CASES = (*oscillator.CASES, *ledger.CASES, *bits.CASES)
