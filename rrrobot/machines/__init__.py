"""Other machines of legless locomotion and of rolling, each from a few parameters.

`rr.machines.snakeboard()` and its kin are `Machine`s: evaluated at a state, simulated, reduced.
"""

from rrrobot.lazy import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
