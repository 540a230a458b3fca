"""The motion of the tissue between frames."""
