"""Where a camera stands, and which point of a surface it sees at a pixel."""
