"""Rest and small oscillations; limit cycles, their stability, sensitivities and branches."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
