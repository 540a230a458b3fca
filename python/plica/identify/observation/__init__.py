"""What a recording shows of the motion."""
