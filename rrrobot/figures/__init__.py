"""Plots of any result: data in, axes out."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
