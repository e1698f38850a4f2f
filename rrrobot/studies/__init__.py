"""Many gaits: sweeps, optimisation, models side by side."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
