"""The border to the file system, for whatever is stored."""
