"""Robots: RRRobot from its parameters, any other from a URDF."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
