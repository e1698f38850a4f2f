"""What an optimiser may vary: bounds on a gait's numbers <-> points of a box <-> gaits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rrrobot.checks import Array
from rrrobot.errors import ParameterError
from rrrobot.gaits import FourierGait, Gait, SinusoidalGait

COLUMNS = (
    "speed", "yaw_rate", "variation", "pitch", "normal_force", "friction", "rms_torque",
    "peak_torque", "power", "clearance", "status",
)  # fmt: skip


class Population(NamedTuple):
    """Gaits of one family, one a row: offset + sum over j of sine_j sin(j w t) + cosine_j cos."""

    offset: Array
    """(n, legs) [rad]"""
    sine: Array
    """(n, harmonics, legs) [rad]"""
    cosine: Array
    """(n, harmonics, legs) [rad]"""
    angular_frequency: Array
    """(n,) [rad/s]"""
