"""What is measured of a recording, and what speaks against it."""
