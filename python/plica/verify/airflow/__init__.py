"""The flow through the glottis and what it does to the tissue."""
