"""All results of a gait from a trajectory, as the engine has them of its last cycle."""

from __future__ import annotations

import numpy as np

from rrrobot.checks import Array
from rrrobot.results import completed
from rrrobot.simulation.heights import clearance
from rrrobot.simulation.steady import SteadyState
from rrrobot.simulation.trajectory import Trajectory


def measured(trajectory: Trajectory, state: SteadyState, samples: slice) -> dict[str, Array]:
    """Results by name, each (1,); see `rrrobot.results`.

    Args:
        trajectory: of a gait.
        state: its steady state.
        samples: of a whole number of cycles at the end, whose forces and heights count.
    """
    t = trajectory
    torque, rate = t.leg_torque[samples], t.leg_rate[samples]
    share = np.abs(torque).max(axis=0, initial=0.0) / t.robot.joints.effort
    found: dict[str, float] = {
        "speed": state.speed,
        "velocity_x": float(state.velocity[0]),
        "velocity_y": float(state.velocity[1]),
        "yaw_rate": state.yaw_rate,
        "variation": state.variation,
        "pitch": float(np.abs(t.euler[:, 1]).max()),
        "tilt": float(t.tilt[samples].max()),
        "normal_force": float(t.normal_force[samples].min()),
        "friction": float(t.required_friction[samples].max()) if t.has_contact else np.nan,
        "rms_torque": float(np.sqrt((torque**2).sum(axis=1).mean())),
        "peak_torque": float(np.abs(torque).max()),
        "torque_share": float(share.max(initial=0.0)),
        "power": float(np.abs(torque * rate).sum(axis=1).mean()),
        "clearance": clearance(t, samples),
        "status": 0.0,
    }
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        for what in ("amplitude", "phase", "mean"):
            found[f"{axis}_{what}"] = float(getattr(state, what)[i])
    return completed({name: np.array([value]) for name, value in found.items()})
