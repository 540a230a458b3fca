"""The engine at its limits: every probe must end right, with a caution, or refused."""
