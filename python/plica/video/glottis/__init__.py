"""The glottis in frames: its outline, its midline, the edges of the folds."""
