"""File system access: storage errors, atomic replacement, tables and result files."""
