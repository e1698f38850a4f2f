"""How do I keep a result, share it, and go on from it later? Save, load, CSV, continue, plot."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)

model, gait = rr.FullModel(rr.Robot.from_parameters()), rr.gait("circular")
period = gait.period
saved = rr.simulate(model, gait, 10 * period, period / 60).save(out / "first_half.npz")
print(f"wrote {saved}")

# Another day: the robot, the model and the gait are in the file.
first = rr.Trajectory.load(saved)
print(first, first.metadata["gait"])

# For a colleague with a spreadsheet, one with MATLAB, one with xarray.
print(f"wrote {first.to_csv(out / 'run.csv')} and {first.to_mat(out / 'run.mat')}")
print(first.to_dataset().leg_torque.attrs)

# The time, the phase of the gait and whole turns go on.
second = rr.simulate(model, gait, 10 * period, period / 60, state=first.final_state)
at_once = rr.simulate(model, gait, 20 * period, period / 60)
gap = np.abs(second.position[-1] - at_once.position[-1]).max()
print(f"in two parts and in one: {gap:.1e} m apart")

second.plot("force").figure.savefig(out / "force.png")
print(f"wrote {out / 'force.png'}")
