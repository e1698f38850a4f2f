"""How do I keep a result, and go on from it later? Save, load, continue, plot."""

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

# Whole cycles were simulated, so the gait begins again where it stopped.
second = rr.simulate(model, gait, 10 * period, period / 60, state=first.final_state)
at_once = rr.simulate(model, gait, 20 * period, period / 60)
gap = np.abs(second.position[-1] - at_once.position[-1]).max()
print(f"in two parts and in one: {gap:.1e} m apart")

second.plot("force").figure.savefig(out / "force.png")
print(f"wrote {out / 'force.png'}")
