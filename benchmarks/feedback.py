"""Feedback on robots that differ from the model, and how surely a run tells what they are.

    python -m benchmarks.feedback fit|goals|eight|masses [trials]

Masses +-5 % (each by itself), radius +-2 %, damping +-50 %, a slope of 2 deg in any direction,
noise of 1 mm and 0.5 deg, a delay of one cycle. Writes benchmarks/results/feedback_<what>.json
after each trial, and goes on from what is there.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

import rrrobot as rr
from benchmarks.steering import goals
from rrrobot.drive.schedule import Schedule, stretch
from rrrobot.errors import RRRobotError
from rrrobot.steering import MeasuredRun, Sensor, Track, follow, identify, reach
from rrrobot.steering.shooting import gap
from rrrobot.steering.standing import rest_of

NOISE = (1e-3, np.deg2rad(0.5))


def other(seed: int) -> rr.RRRobotParameters:
    """A robot that differs; the servos, which fix the scale of all masses, differ too."""
    rng, p = np.random.default_rng(seed), rr.RRRobotParameters()

    def near(value: float, share: float) -> float:
        return float(value * (1 + rng.uniform(-share, share)))

    return rr.RRRobotParameters(
        leg_mass=(near(p.leg_mass, 0.05), near(p.leg_mass, 0.05)),
        servo_mass=(near(p.servo_mass, 0.05), near(p.servo_mass, 0.05)),
        battery_mass=near(p.battery_mass, 0.05),
        shell_radius=near(p.shell_radius, 0.02),
        damping=near(p.damping, 0.5),
    )


def model_of(p: rr.RRRobotParameters, slope: int | None = None) -> rr.FullModel:
    """The robot on level ground, or on a slope of 2 deg in the direction that a seed gives."""
    way = 0.0 if slope is None else np.random.default_rng(slope + 20_000).uniform(0, 2 * np.pi)
    steep = 0.0 if slope is None else np.tan(np.deg2rad(2.0))
    ground = rr.Plane(normal=(-steep * np.cos(way), -steep * np.sin(way), 1.0))
    return rr.FullModel(rr.Robot.from_parameters(p), ground=ground)


def trial_fit(seed: int) -> dict:
    """How many stated standard deviations the true values are away, each and all together."""
    true = other(seed)
    known = rr.RRRobotParameters(servo_mass=true.servo_mass)
    gait = Schedule(
        [
            stretch(10, offset=(0.3, 0.3), amplitude=0.4, phase=(0, 2.0)),
            stretch(10, offset=(1.57, 1.57), amplitude=0.5, phase=(0, 1.7)),
            stretch(10, offset=(2.8, 2.6), amplitude=(0.5, 0.3), phase=(0, 4.0)),
        ],
        angular_frequency=8.0, rest=(np.pi / 2,) * 2, blend=2.0,
    )  # fmt: skip
    model = model_of(true, seed)
    standing = rest_of(model, gait.rest)
    t = rr.simulate(model, gait, 33.0, 0.05, start="rest", euler=standing.euler, method="momentum")
    pose = np.column_stack((t.position, t.euler[:, 2]))
    pose += np.random.default_rng(seed + 10_000).normal(size=pose.shape) * (NOISE[0], *NOISE)
    found = identify(MeasuredRun(time=t.time, pose=pose, leg_angle=t.leg_angle), known)
    truth = true.to_dict()
    normal = model.ground.normal_vector
    truth["slope_x"], truth["slope_y"] = -normal[:2] / normal[2]
    truth["leg_mass_1"], truth["leg_mass_2"] = truth["leg_mass"]
    away = np.array([v - truth[name] for name, v in found.value.items()])
    apart = away / list(found.uncertainty.values())
    # Of all together, in the ellipsoid of the stated covariance.
    return dict(zip(found.value, apart.tolist(), strict=True)) | {
        "chi_square": float(away @ np.linalg.solve(found.covariance, away))
    }


def trial_goals(seed: int) -> dict:
    """A random goal on another robot, by `reach`."""
    goal = goals(seed + 1)[seed]
    sensor = Sensor(place=NOISE[0], yaw=NOISE[1], delay=1, seed=seed)
    try:
        found = reach(
            model_of(rr.RRRobotParameters()), goal, truth=model_of(other(seed), seed), sensor=sensor
        )
    except RRRobotError as error:
        return {"place": None, "turn": None, "why": str(error)}
    run = found.tries[0].trajectory
    alone = gap(np.array((*run.position[-1], run.euler[-1, 2])), goal)
    return {
        "place": float(np.hypot(*found.error[:2])), "turn": float(abs(found.error[2])),
        "alone_place": float(np.hypot(*alone[:2])), "alone_turn": float(abs(alone[2])),
        "tries": len(found.tries), "why": found.stopped,
        "seconds": sum(float(t.trajectory.time[-1]) for t in found.tries),
        "legs": sum(t.plan.gait.duration for t in found.tries),
        "bound": found.tries[0].plan.lower_bound,
    }  # fmt: skip


def trial_eight(seed: int) -> dict:
    """A figure eight of 0.5 m for ten minutes, on the slope too."""
    sensor = Sensor(place=NOISE[0], yaw=NOISE[1], delay=1, seed=seed)
    believed, real = model_of(rr.RRRobotParameters()), model_of(other(seed), seed)
    run = follow(believed, Track.eight(0.5), 600.0, truth=real, sensor=sensor)
    return run.to_dict()


def trial_masses(seed: int) -> dict:
    """The same eight, all masses 5 % too large or too small, each by itself, and nothing else."""
    # Every seed below 32 another pattern of signs.
    sign = np.array([-1.0 if 5 * seed >> k & 1 else 1.0 for k in range(5)])
    p = rr.RRRobotParameters()
    legs, servos, battery = 1 + 0.05 * sign[:2], 1 + 0.05 * sign[2:4], 1 + 0.05 * sign[4]
    real = replace(
        p, leg_mass=tuple(p.leg_mass * legs), servo_mass=tuple(p.servo_mass * servos),
        battery_mass=float(p.battery_mass * battery),
    )  # fmt: skip
    run = follow(model_of(p), Track.eight(0.5), 600.0, truth=model_of(real))
    return run.to_dict()


TRIALS = {"masses": trial_masses, "fit": trial_fit, "goals": trial_goals, "eight": trial_eight}


def main(what: str, n: int) -> None:
    target = Path(f"benchmarks/results/feedback_{what}.json")
    # What was done before goes on; remove the file to begin anew.
    rows = json.loads(target.read_text())["rows"] if target.exists() else []
    told = {"trials": len(rows), **_sum(what, rows)} if rows else {}
    for seed in range(len(rows), n):
        started = time.process_time()
        rows.append(TRIALS[what](seed) | {"seed": seed, "cpu": time.process_time() - started})
        told = {"trials": len(rows), **_sum(what, rows), "rows": rows}
        target.write_text(json.dumps(told, indent=1))
    print(json.dumps({k: v for k, v in told.items() if k != "rows"}, indent=1))


def _sum(what: str, rows: list[dict]) -> dict:
    if what == "fit":
        names = [name for name in rows[0] if name not in ("seed", "cpu", "chi_square")]
        within = {k: int(sum(abs(row[k]) < 2 for row in rows)) for k in names}
        most = chi2.ppf(0.95, len(names))
        return {
            "within_two_deviations": within,
            "within_the_95_%_ellipsoid": int(sum(row["chi_square"] < most for row in rows)),
        }
    if what == "goals":
        near = [r["place"] is not None and r["place"] < 0.01 and r["turn"] < np.deg2rad(3)
                for r in rows]  # fmt: skip
        return {"within_10_mm_and_3_deg": int(sum(near))}
    return {"rms": [row["rms"] for row in rows]}


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100)
