"""How can a hanging robot turn on the spot? A plan of leg motions alone, from rest to rest."""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.figures.reduction import height_map

out = Path("out")
out.mkdir(exist_ok=True)
robot = rr.Robot.from_parameters()

# (yaw, leg 1, leg 2) from and to, within what the legs may do.
start, goal = (0.0, 1.2, 1.6), (np.pi / 4, 1.8, 1.0)
plan = rr.steering.plan_yaw(robot, start, goal, angle_range=(0.4, 2.7))
print(f"{plan.duration:.1f} s of leg motion")

motion = rr.simulate(rr.YawModel(robot), plan.gait, plan.duration, 0.05, start="rest")
end = (motion.euler[-1, 2], *motion.leg_angle[-1])
print(f"arrives at {np.round(end, 6).tolist()}, turning {motion.euler_rates[-1, 2]:.1e} rad/s")

# What a cycle turns the body by is the height function's integral over what it encloses.
cycle = rr.drive.out_of_phase_gait(offset=2.1, amplitude=0.5)
ways = {how: rr.reduction.net_yaw(robot, cycle, method=how) for how in ("line", "area", "simulate")}
print("net yaw of a cycle:", {how: f"{np.rad2deg(yaw):.6f} deg" for how, yaw in ways.items()})

height_map(robot, cycles={"cycle": cycle}).figure.savefig(out / "height.png")
motion.plot("angles").figure.savefig(out / "turn.png")
for name in ("height.png", "turn.png"):
    print(f"wrote {out / name}")
