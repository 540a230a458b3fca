"""What a scene is: its parts, their checks, its file, its mesh."""
