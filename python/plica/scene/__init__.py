"""Scenes: their parts, validation, files and meshes."""
