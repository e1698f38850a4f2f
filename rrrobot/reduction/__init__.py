"""Kinematic reduction: what a motion of the legs is worth."""
