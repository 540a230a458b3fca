"""Laws of tissue: constant strains, rigid motion, moduli, creep, natural frequencies."""

from plica.verify.tissue import modes, moduli, patch

__all__ = ["CASES"]

CASES = (*patch.CASES, *moduli.CASES, *modes.CASES)
