"""Shells, grounds, and how the contact point moves on both."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
