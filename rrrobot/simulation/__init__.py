"""A model and a drive in, a trajectory and its steady state out."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
