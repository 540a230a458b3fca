"""The table, warnings and page of an identification."""
