"""Leg trajectories: phi(t) with its first and second derivative.

A gait is called with a time or an array of times and answers the legs' angles [rad] (or positions
[m] of prismatic joints), rates and accelerations. Analytic derivatives make the prescribed-leg
dynamics exact; a gait of your own is checked against finite differences.
"""

from rrrobot.drive.gaits.base import Gait, Harmonics, LegMotion
from rrrobot.drive.gaits.batch import GaitBatch
from rrrobot.drive.gaits.fourier import FourierGait
from rrrobot.drive.gaits.own import CallableGait
from rrrobot.drive.gaits.rest import RampIn, StillLegs
from rrrobot.drive.gaits.sinusoidal import SinusoidalGait, gait

__all__ = [
    "CallableGait",
    "FourierGait",
    "Gait",
    "GaitBatch",
    "Harmonics",
    "LegMotion",
    "RampIn",
    "SinusoidalGait",
    "StillLegs",
    "gait",
]
