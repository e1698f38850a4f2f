"""Sweeps over gaits and robot parameters."""
