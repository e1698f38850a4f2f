"""Which masses, radius, damping and slope does a measured run tell, and how surely?"""

from pathlib import Path

import numpy as np

import rrrobot as rr
from rrrobot.drive import Schedule, stretch
from rrrobot.steering import MeasuredRun, identify

out = Path("out")
out.mkdir(exist_ok=True)

# A robot that nobody knows, on a table that leans by a degree, driven by two gaits.
hidden = rr.RRRobotParameters(leg_mass=(0.0555, 0.0588), battery_mass=0.29, damping=0.013)
ground = rr.Plane(normal=(0.0, -np.tan(np.deg2rad(1.0)), 1.0))
model = rr.FullModel(rr.Robot.from_parameters(hidden), ground=ground)
gait = Schedule(
    [
        stretch(8, offset=(0.3, 0.3), amplitude=0.4, phase=(0, 2.0)),
        stretch(8, offset=(1.57, 1.57), amplitude=0.5, phase=(0, 1.7)),
    ],
    angular_frequency=8.0, rest=(np.pi / 2, np.pi / 2), blend=2.0,
)  # fmt: skip
start = rr.steering.standing.standing(model, gait.rest)
t = rr.simulate(model, gait, 22.0, 0.05, start="rest", euler=start, method="momentum")
noise = np.random.default_rng(0).normal(size=(len(t.time), 3)) * (1e-3, 1e-3, np.deg2rad(0.5))
pose = np.column_stack((t.position, t.euler[:, 2])) + noise

fit = identify(MeasuredRun(time=t.time, pose=pose, leg_angle=t.leg_angle))
for name, value in fit.value.items():
    print(f"{name:13s} {value:9.5f} +- {fit.uncertainty[name]:.5f}")
print(f"noise {1000 * fit.noise[0]:.2f} mm, {np.rad2deg(fit.noise[1]):.2f} deg")

head = "time [s],x [m],y [m],yaw [rad],leg_1 [rad],leg_2 [rad]"
rows = np.column_stack((t.time, pose, t.leg_angle))
np.savetxt(out / "run.csv", rows, delimiter=",", header=head, comments="")
print("the same by `rrrobot fit out/run.csv`")
print(f"wrote {out / 'run.csv'}")
