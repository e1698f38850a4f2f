"""What moves and brakes the joints: gaits, torques, damping; gaits as files."""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
