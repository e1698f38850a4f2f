"""rrrobot: legless locomotion of round robots. See README.md.

The names at the top are what most scripts need; each room has its own, such as `rr.reduction`.
All load when they are first used. What is public stands in the stub, `__init__.pyi`.
"""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
