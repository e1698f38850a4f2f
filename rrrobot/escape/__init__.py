"""Get any robot free that lies on its belly: gaits for every way to go, confirmed."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
