"""Motion between frames, the glottis in them, and what is measured of it."""
