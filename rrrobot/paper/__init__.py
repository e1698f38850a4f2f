"""What is the paper's alone: tables, figures, claims, errata, closed forms."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
