"""Where does a symmetric gait stop going straight? Follow its cycle as the legs swing more."""

from pathlib import Path

import numpy as np

import rrrobot as rr

out = Path("out")
out.mkdir(exist_ok=True)

model = rr.FullModel(rr.Robot.from_parameters())
gait = rr.SinusoidalGait(offset=np.pi / 2, amplitude=0.3, angular_frequency=5.2)
line = rr.orbits.branch(rr.limit_cycle(model, gait), "amplitude", to=0.7)
print(line)

# From the first branch point on it rolls and turns, to one side or the other.
for side in (0.05, -0.05):
    print(line.switched("branch point", length=side))

line.plot("pitch_amplitude").figure.savefig(out / "branch.png")
print(f"wrote {out / 'branch.png'}")
