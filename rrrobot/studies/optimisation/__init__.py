"""The best gait for a goal."""
