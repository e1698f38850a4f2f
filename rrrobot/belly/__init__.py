"""Bellies of real robots: what they are, the shell that stands for them, what a motion touches."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
