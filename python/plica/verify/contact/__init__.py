"""Contact: impacts, rest, and what bodies keep through a collision."""
