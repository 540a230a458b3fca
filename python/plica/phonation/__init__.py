"""A run from a scene: what is simulated, how it is stored and resumed, and what is measured on it."""
