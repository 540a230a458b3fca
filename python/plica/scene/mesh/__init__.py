"""The mesh of a scene: presets, blocks, files."""
