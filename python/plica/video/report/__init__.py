"""The page of an analysis, and of two beside each other."""
