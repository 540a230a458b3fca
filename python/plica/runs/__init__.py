"""Running a scene and storing its results."""
