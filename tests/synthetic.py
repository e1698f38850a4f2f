"""Trajectories that no model made: known arrays around a real robot."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import rrrobot as rr


@cache
def robot() -> rr.Robot:
    return rr.Robot.from_parameters()


def trajectory(n: int = 50, duration: float = 1.0, **fields: Any) -> rr.Trajectory:
    """A trajectory of n samples; random arrays where none are given."""
    rng = np.random.default_rng(3)
    one, model = robot(), robot().model
    columns = {"euler": 3, "euler_rates": 3, "position": 2, "leg_angle": 2, "leg_rate": 2,
               "contact_force": 3, "leg_torque": 2, "configuration": model.nq,
               "velocity": model.nv, "state": 9}  # fmt: skip
    made: dict[str, Any] = {
        "time": np.linspace(0, duration, n),
        "metadata": {},
        "robot": one,
        "ground": rr.Plane(),
    }
    made |= {name: rng.normal(size=(n, k)) for name, k in columns.items()}
    made |= {name: rng.normal(size=n) for name in ("energy", "slip", "height_error")}
    return rr.Trajectory(**(made | fields))
