"""Heights of the legs over the ground in a trajectory, and their least, the clearance.

See `rrrobot.momentum.heights`, which gives the same of the fast form, for what it means.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rrrobot.checks import Array
from rrrobot.simulation.trajectory import Trajectory


def leg_heights(trajectory: Trajectory, samples: slice = slice(None)) -> Array:
    """Distances of the moving links' centres of mass from the ground (n, links) [m].

    They are along its normal to the tangent plane at the contact. Links without mass are at
    infinity.
    """
    model = trajectory.robot.model
    data, links = model.createData(), range(2, model.njoints)
    position = trajectory.position[samples]
    heights: Array = np.full((len(position), len(links)), np.inf)
    rows = zip(
        trajectory.configuration[samples], trajectory.ground_normal[samples], position, strict=True
    )
    for i, (q, normal, place) in enumerate(rows):
        contact = trajectory.ground.point(place)
        pin.forwardKinematics(model, data, q)
        for k, joint in enumerate(links):
            body = model.inertias[joint]
            if body.mass > 0:
                heights[i, k] = normal @ (data.oMi[joint].act(body.lever) - contact)
    return heights


def clearance(trajectory: Trajectory, samples: slice = slice(None)) -> float:
    """The least of `leg_heights` [m]; infinite if no leg has a mass."""
    return float(leg_heights(trajectory, samples).min(initial=np.inf))
