"""What a contact simulator makes of the paper's gaits and a free rocking, and what rrrobot does."""

from __future__ import annotations

from typing import Any

import numpy as np

import rrrobot as rr
from benchmarks.common import PAPER_GAITS, Motion, engine, engine_motion, full_model, true_motion
from rrrobot.momentum.batch import lower


def contact_checks() -> list[dict[str, Any]]:
    """What each of MuJoCo's settings does to the circular gait and to a free rocking."""
    from benchmarks.mujoco_peer import CASES, rocking_loss, sweep

    true, found = true_motion(PAPER_GAITS.gaits()), []
    for case in (c for c in CASES if not c.free_joint):
        motion = sweep(case, PAPER_GAITS, threads=1).motion
        found.append(
            {
                "name": case.name,
                "lateral_speed_ratio": float(motion.speed[0] / true.speed[0]),
                "circular_speed_ratio": float(motion.speed[1] / true.speed[1]),
                "circular_yaw_rate_ratio": float(motion.yaw_rate[1] / true.yaw_rate[1]),
                "energy_lost_roll": rocking_loss(case, "roll"),
                "energy_lost_pitch": rocking_loss(case, "pitch"),
            }
        )
    found.append({"name": "rrrobot"} | own_checks(true))
    return found


def own_checks(true: Motion) -> dict[str, float]:
    """The same of the engine."""
    ours = engine_motion(engine(lower(full_model()), PAPER_GAITS.gaits()))
    result = {
        "lateral_speed_ratio": float(ours.speed[0] / true.speed[0]),
        "circular_speed_ratio": float(ours.speed[1] / true.speed[1]),
        "circular_yaw_rate_ratio": float(ours.yaw_rate[1] / true.yaw_rate[1]),
    }
    still = rr.StillLegs((np.pi / 2, np.pi / 2))
    model = rr.FullModel(rr.Robot.from_parameters(), damping=None)
    for name, euler in (("roll", (0.3, 0.0, 0.0)), ("pitch", (0.0, 0.3, 0.0))):
        t = rr.simulate(model, still, duration=30.0, start="rest", euler=euler, method="momentum")
        rest = rr.simulate(model, still, duration=0.01, start="rest").energy[0]
        result[f"energy_lost_{name}"] = float(1 - (t.energy[-1] - rest) / (t.energy[0] - rest))
    return result
