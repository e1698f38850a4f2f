"""Kinematic reduction: connection, height functions, the net turn of a cycle."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
