"""How a scene runs, and what is stored of it."""
