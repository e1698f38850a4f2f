"""Shells and grounds for tests: the seven pairs of the reference values, and what they need."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import rrrobot as rr
from rrrobot import serial


@serial.register("test egg")
class Egg(rr.Surface):
    """h = r |u| + e u_x^3 / |u|^2: not even, so its two ends differ."""

    def __init__(self, radius: float = 0.12, odd: float = 0.03) -> None:
        self.radius, self.odd = radius, odd

    def support(self, u):
        return float(self.radius * np.linalg.norm(u) + self.odd * u[0] ** 3 / (u @ u))

    def contact(self, u):
        s, x = u @ u, u[0]
        bump = 3 * x**2 / s * np.eye(3)[0] - 2 * x**3 / s**2 * u
        return self.radius * u / np.sqrt(s) + self.odd * bump

    def hessian(self, u):
        s, x, e = u @ u, u[0], np.eye(3)[0]
        cross = np.outer(e, u) + np.outer(u, e)
        bump = 6 * x / s * np.outer(e, e) - 6 * x**2 / s**2 * cross
        bump += 8 * x**3 / s**3 * np.outer(u, u) - 2 * x**3 / s**2 * np.eye(3)
        return self.radius * (np.eye(3) - np.outer(u, u) / s) / np.sqrt(s) + self.odd * bump

    def to_dict(self):
        return {"type": "test egg", "radius": self.radius, "odd": self.odd}


def height(x, y):
    return 0.02 * np.sin(3 * x) * np.cos(2 * y) + 0.05 * x * y


def gradient(x, y):
    return (
        0.06 * np.cos(3 * x) * np.cos(2 * y) + 0.05 * y,
        -0.04 * np.sin(3 * x) * np.sin(2 * y) + 0.05 * x,
    )


def hessian(x, y):
    cross = -0.12 * np.cos(3 * x) * np.sin(2 * y) + 0.05
    return (
        (-0.18 * np.sin(3 * x) * np.cos(2 * y), cross),
        (cross, -0.08 * np.sin(3 * x) * np.cos(2 * y)),
    )


EL = rr.Ellipsoid((0.15, 0.13, 0.12))
SP = rr.Sphere(0.12)
BOX = rr.EllipsoidSum([(0.06, 0.06, 0.06), (0.06, 0.05, 0.06), (0.06, 0.06, 0.03)])
EGG = Egg()
LEVEL, SLOPE = rr.Plane(), rr.Plane(normal=(-0.05, 0.03, 1))
BOULDER = rr.Boulder(0.5)
GRAPH = rr.Graph(height, gradient, hessian, reach=0.5)
GAIT = rr.SinusoidalGait(
    offset=np.pi / 4, amplitude=0.3, angular_frequency=8.0, phase=(0.0, np.pi / 2)
)
START = (0.1, -0.05, 0.2)


def robot(shell: rr.Surface) -> rr.Robot:
    """RRRobot of Table 2 with another shell about its base's origin."""
    return replace(rr.Robot.from_parameters(), shell=shell)


def model(shell: rr.Surface, ground: rr.contact.Ground) -> rr.FullModel:
    """Its full model, with the paper's damping."""
    return rr.FullModel(robot(shell), ground=ground, damping=0.01)


PAIRS = {
    "A": (EL, LEVEL),
    "B": (EL, SLOPE),
    "C": (SP, BOULDER),
    "D": (BOX, LEVEL),
    "E": (EGG, LEVEL),
    "F": (EL, BOULDER),
    "G": (EL, GRAPH),
}
