"""How does my robot roll on a round belly? Any URDF: solo12 of example-robot-data, legs in the air.

Needs the extra `robots`. Writes a film and a plot.
"""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)

# The belly is a sphere about the base; all joints but the four hips' swing are held folded up.
swinging = ("FL_HFE", "FR_HFE", "HL_HFE", "HR_HFE")
folded = {f"{leg}_{joint}": 0.0 for leg in ("FL", "FR", "HL", "HR") for joint in ("HAA", "KFE")}
robot = rr.Robot.from_example(
    "solo12", shell=rr.Sphere(0.25), shell_center=(0, 0, 0.12), legs=swinging, locked=folded
)
print(robot)

# Legs up, swinging: left against right by a quarter turn.
gait = rr.SinusoidalGait(
    offset=np.pi, amplitude=0.4, angular_frequency=6.0, phase=(0, np.pi / 2, 0, np.pi / 2)
)
model = rr.FullModel(robot, damping=rr.BodyRateDamping(0.2, 0.2, 0.2))
motion = rr.simulate(model, gait, duration=20.0)
print(motion)
print(f"speed {1000 * motion.steady_state().speed:.2f} mm/s, ", end="")
print(f"friction needed {motion.required_friction.max():.2f}")

motion.plot("path").figure.savefig(out / "solo12_path.png")
print(f"wrote {out / 'solo12_path.png'}")
print(f"wrote {rr.record(motion, out / 'solo12.html')}")
