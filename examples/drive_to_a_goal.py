"""Which leg motions bring the robot to a pose, past an obstacle, also if it differs a little?"""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)
model = rr.FullModel(rr.Robot.from_parameters())
goal = (0.35, 0.15, np.pi / 2)  # x [m], y [m], yaw [rad]

plan = rr.plan(model, goal, obstacles=[rr.steering.Disc((0.2, 0.0), 0.03)], margin=0.08)
print(f"{plan.gait}, off by {1000 * np.hypot(*plan.error[:2]):.3f} mm")
run = plan.execute(sample_interval=0.02)  # by the KKT form
print(f"executed: {1000 * np.hypot(*(run.position[-1] - goal[:2])):.3f} mm off")
print(f"motors: {plan.demands().torque:.3f} N m, {plan.demands().power:.2f} W")

# The same on a robot with a heavier leg and another radius: blind, then with what was seen.
real = rr.FullModel(
    rr.Robot.from_parameters(rr.RRRobotParameters(leg_mass=(0.0588, 0.0567), shell_radius=0.1215))
)
camera = rr.steering.Sensor(place=1e-3, yaw=np.deg2rad(0.5))
found = rr.steering.reach(model, goal, truth=real, sensor=camera)
blind = found.tries[0].trajectory.position[-1]
print(f"blind {1000 * np.hypot(*(blind - goal[:2])):.1f} mm off; "
      f"after {len(found.tries)} plans {1000 * np.hypot(*found.error[:2]):.2f} mm")  # fmt: skip

plan.plot(run).figure.savefig(out / "plan.png")
table = rr.gait_table(plan.gait, 50.0, duration=plan.gait.duration, joints=model.robot.legs)
table.to_csv(out / "legs.csv")
plan.save(out / "plan.json")
for name in ("plan.png", "legs.csv", "plan.json"):
    print(f"wrote {out / name}")
