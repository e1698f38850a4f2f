"""Which friction does a gait need, and how near is the robot to jumping? Forces by frequency."""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.drawing import line, new_axes, tidy

out = Path("out")
out.mkdir(exist_ok=True)
model = rr.FullModel(rr.Robot.from_parameters())
weight = model.robot.mass * model.robot.gravity

frequencies = np.arange(4.0, 33.0, 2.0)
needed, lightest = [], []
for omega in frequencies:
    gait = rr.gait("circular", angular_frequency=omega)
    motion = rr.simulate(model, gait, duration=16.0, sample_interval=0.02, method="momentum")
    late = motion.time > 12.0
    needed.append(motion.required_friction[late].max())
    lightest.append(motion.normal_force[late].min() / weight)
    jumps = "" if motion.lift_off_time is None else f", lifts off at {motion.lift_off_time:.2f} s"
    print(f"{omega:4.0f} rad/s: friction {needed[-1]:.3f}, ", end="")
    print(f"least load {lightest[-1]:.2f} of the weight{jumps}")

ax = new_axes()
ax.plot(frequencies, needed, label="friction coefficient needed", **line(0))
ax.plot(frequencies, lightest, label="least normal force over weight", **line(1))
tidy(ax, "leg frequency [rad/s]", "ratio")
ax.legend()
ax.figure.savefig(out / "friction.png")
print(f"wrote {out / 'friction.png'}")
