"""Rest, small oscillations about it, and their periods."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
