"""Scripts that hold plica against closed forms, or measure it; README.md says which there are."""
