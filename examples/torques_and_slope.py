"""What if motors drive the legs, on a slope? A feedback law lifts the legs and holds them."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)

slope = np.deg2rad(3.0)
hill = rr.Plane((np.sin(slope), 0.0, np.cos(slope)))
robot = rr.Robot.from_parameters()
model = rr.FullModel(robot, ground=hill, damping=rr.BodyRateDamping(0.01, 0.01, 0.01, legs=0.002))


def hold_up(state: rr.drive.MotionState) -> np.ndarray:
    """A spring and a damper towards straight up."""
    return -0.3 * (state.leg_angle - np.pi / 2) - 0.03 * state.leg_rate


motors = rr.LegTorques(hold_up, angle=(0.6, 1.0), feedback=True)
motion = rr.simulate(model, motors, duration=5.0, start="rest")
print(motion)
print(f"legs end at {np.rad2deg(motion.leg_angle[-1]).round(1)} deg")
print(f"largest torque {np.abs(motion.leg_torque).max():.3f} N m")

motion.plot("all").savefig(out / "slope.png")
print(f"wrote {out / 'slope.png'}")
print(f"wrote {motion.save(out / 'slope.npz')}")
