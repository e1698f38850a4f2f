"""Models of a robot: one file each."""
