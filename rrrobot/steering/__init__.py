"""Plans that bring the robot where it shall be."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
