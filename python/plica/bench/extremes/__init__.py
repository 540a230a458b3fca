"""The engine at its limits: ``plica bench extremes``; every probe must end right, with a caution, or refused."""
