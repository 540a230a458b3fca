"""Contact: impacts, rest, and what bodies keep through a collision."""

from plica.verify.contact import bounce, impact, laws, statics

__all__ = ["CASES"]

CASES = (*impact.CASES, *bounce.CASES, *statics.CASES, *laws.CASES)
