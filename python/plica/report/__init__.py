"""How figures and numbers are shown to people, in the reports of runs and of recordings."""
